/// Fronts of cuts: edges that a pair of cut faces alone has. Ways lead over one edge or two, each passed where the way is
/// shortest.
#include "embed/visibility.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "geometry/face_polygon.h"
#include "geometry/polygon.h"
#include "mesh/cut_edges.h"
#include "mesh/topology.h"

#include <stdlib.h>
#include <string.h>

#define OPPOSITE 1e-9 ///< of the normals of the two faces of a pair
#define TURN 1e-3     ///< sine of the least angle of a bend that hides anything
#define AWAY 1e-6     ///< of a cell's size: how far beside an edge ways pass
#define NARROW                                                                                     \
  0.02         ///< of a cell's size: faces beside a bend that are no wider are steps, not facets
#define WAYS 3 ///< most edges that are tried, those of the shortest ways
#define LONG_WAYS 2  ///< and as the first of two
#define STACK 128    ///< of nodes that wait: twice the depth of any tree
#define ON_EDGE 1e-9 ///< of a triangle: what passes its edge as close as that passes it

// ------------------------------------------------------------------ fronts

/// A front has one pair of faces that look at each other, a bend several faces in different planes; edges that other boundary
/// faces have are where a cut comes to the surface.
static bool is_way_edge(const LthMesh *m, const LthCutEdge *edge, LitheCount n, bool *is_front) {
  const double *first = m->face_normal + 3 * (size_t)edge[0].face;
  double least = 1, most = -1;
  bool is_narrow = false;
  double length =
      lth_v3_distance(m->points + 3 * (size_t)edge->low, m->points + 3 * (size_t)edge->high);
  for (LitheCount i = 0; i < n; i++) {
    if (!lth_is_cut_face(m, edge[i].face)) return false;
    is_narrow = is_narrow || m->face_area[edge[i].face] < NARROW * m->cell_size * length;
    double along = lth_v3_dot(first, m->face_normal + 3 * (size_t)edge[i].face);
    if (fabs(along) < least) least = fabs(along);
    if (-along > most) most = -along;
  }
  *is_front = n == 2 && most > 1 - OPPOSITE;
  return *is_front || (n == 4 && !is_narrow && least < sqrt(1 - TURN * TURN));
}

static LitheStatus add_edge(LitheCtx *ctx, const LthMesh *m, const LthCutEdge *edge, LitheCount n,
                            LthVisibility *v) {
  double middle[3], d[3] = {0, 0, 0};
  LTH_RESERVE(ctx, v->edges, v->cap_edges, (LitheCount)v->n_edges + 1);
  LthWayEdge *e = v->edges + v->n_edges++;
  lth_v3_copy(m->points + 3 * (size_t)edge->low, e->end[0]);
  lth_v3_copy(m->points + 3 * (size_t)edge->high, e->end[1]);
  lth_v3_sub(e->end[1], e->end[0], e->along);
  e->length = lth_v3_normalize(e->along);
  for (LitheCount i = 0; i < n; i++) {
    lth_v3_sub(e->end[0], m->face_centroid + 3 * (size_t)edge[i].face, middle);
    lth_v3_axpy(-lth_v3_dot(middle, e->along), e->along, middle);
    lth_v3_normalize(middle);
    lth_v3_axpy(1, middle, d);
  }
  lth_v3_normalize(d);
  lth_v3_scale(AWAY * m->cell_size, d);
  lth_v3_copy(d, e->away);
  return LITHE_OK;
}

/// Edges of one pair of points, which begin at `first`.
static LitheCount end_of_run(const LthCutEdge *edges, LitheCount first, LitheCount n) {
  LitheCount end = first + 1;
  while (end < n && edges[end].low == edges[first].low && edges[end].high == edges[first].high)
    end++;
  return end;
}

/// Do two cuts go on from each other here? Each has one pair of faces that look at each other.
static bool is_continued(const LthMesh *m, const LthCutEdge *edge, LitheCount n) {
  int n_first = 0;
  if (n != 4) return false;
  for (int i = 0; i < 4; i++) {
    int n_same = 0, n_opposite = 0;
    if (!lth_is_cut_face(m, edge[i].face)) return false;
    for (int k = 0; k < 4; k++) {
      if (m->face_tag[edge[k].face] != m->face_tag[edge[i].face]) continue;
      n_same++;
      n_opposite += lth_v3_dot(m->face_normal + 3 * (size_t)edge[i].face,
                               m->face_normal + 3 * (size_t)edge[k].face) < 0;
    }
    if (n_same != 2 || n_opposite != 1) return false;
    n_first += m->face_tag[edge[i].face] == m->face_tag[edge[0].face];
  }
  return n_first == 2;
}

/// Faces at an edge belong to one sheet where they are of one cut, or of two that go on from each other.
static void unite_faces(const LthMesh *m, const LthCutEdge *edge, LitheCount n, LitheIndex *sheet) {
  bool is_all = is_continued(m, edge, n);
  for (LitheCount i = 0; i < n; i++)
    for (LitheCount k = i + 1; k < n; k++) {
      LitheIndex tag = m->face_tag[edge[i].face];
      if (!lth_is_cut_face(m, edge[i].face) || !lth_is_cut_face(m, edge[k].face)) continue;
      if (is_all || tag == m->face_tag[edge[k].face])
        lth_sets_unite(sheet, edge[i].face, edge[k].face);
    }
}

/// Fronts first, then bends of sheets that have a front: around one that has none no way leads to its other side.
static LitheStatus find_edges(LitheCtx *ctx, const LthMesh *m, const LthCutEdge *edges,
                              LitheCount n, LthVisibility *v) {
  LitheStatus status = LITHE_OK;
  LitheIndex *sheet = NULL;
  bool *has_front = NULL;
  LTH_NEW_OR(done, ctx, sheet, m->n_faces);
  LTH_NEW_OR(done, ctx, has_front, m->n_faces);
  lth_sets_reset(sheet, m->n_faces);
  for (LitheCount i = 0, end; i < n; i = end) {
    end = end_of_run(edges, i, n);
    unite_faces(m, edges + i, end - i, sheet);
  }
  for (int pass = 0; pass < 2; pass++) {
    for (LitheCount i = 0, end; i < n; i = end) {
      bool is_front = false;
      end = end_of_run(edges, i, n);
      if (!is_way_edge(m, edges + i, end - i, &is_front) || is_front != (pass == 0)) continue;
      bool *has = has_front + lth_sets_root(sheet, edges[i].face);
      *has = *has || is_front;
      if (*has) LITHE_TRY_OR(done, add_edge(ctx, m, edges + i, end - i, v));
    }
    if (pass == 0) v->n_fronts = v->n_edges;
    if (v->n_fronts == 0) goto done;
  }
done:
  lth_free(ctx, sheet);
  lth_free(ctx, has_front);
  return status;
}

// ------------------------------------------------------------------ faces

static LitheStatus add_triangles(LitheCtx *ctx, const LthMesh *m, LitheIndex face,
                                 LthPolygonList *list, LthPolygonWork *work, LthVisibility *v) {
  LthFaceView view = lth_mesh_face(m, face);
  LitheIndex *corner = NULL;
  LitheStatus status = LITHE_OK;
  list->n = list->n_polygons = 0;
  LITHE_TRY(lth_face_polygons(ctx, &view, list));
  LTH_NEW(ctx, corner, 3 * list->n);
  for (LitheCount at = 0; at < list->n; at += list->items[at] + 1) {
    LitheIndex n = list->items[at];
    if (n < 3) continue;
    LITHE_TRY_OR(done,
                 lth_polygon_triangulate(ctx, work, view.points, n, list->items + at + 1, corner));
    LTH_RESERVE_OR(done, ctx, v->tri, v->cap_tri, 9 * ((LitheCount)v->n_tris + n));
    for (LitheIndex k = 0; k < 3 * (n - 2); k++)
      lth_v3_copy(view.points + 3 * (size_t)corner[k], v->tri + 9 * (size_t)v->n_tris + 3 * k);
    v->n_tris += n - 2;
  }
done:
  lth_free(ctx, corner);
  return status;
}

static LitheStatus make_tree(LitheCtx *ctx, const LthMesh *m, LthVisibility *v) {
  LitheStatus status = LITHE_OK;
  LthPolygonList list = {0};
  LthPolygonWork work = {0};
  double *box = NULL;
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (lth_is_cut_face(m, f)) LITHE_TRY_OR(done, add_triangles(ctx, m, f, &list, &work, v));
  LTH_NEW_OR(done, ctx, box, 6 * (LitheCount)v->n_tris);
  for (LitheIndex i = 0; i < v->n_tris; i++)
    for (int a = 0; a < 3; a++) {
      const double *x = v->tri + 9 * (size_t)i + a;
      box[6 * (size_t)i + a] = fmin(x[0], fmin(x[3], x[6]));
      box[6 * (size_t)i + 3 + a] = fmax(x[0], fmax(x[3], x[6]));
    }
  status = lth_bvh_create_boxes(ctx, v->n_tris, box, &v->bvh);
done:
  lth_free(ctx, box);
  lth_polygon_list_free(ctx, &list);
  lth_polygon_work_free(ctx, &work);
  return status;
}

LitheStatus lth_visibility_find_edges(LitheCtx *ctx, const LthMesh *mesh, LthVisibility *v) {
  LthCutEdge *edges = NULL;
  LitheCount n = 0;
  *v = (LthVisibility){0};
  LitheStatus status = lth_list_cut_edges(ctx, mesh, true, &edges, &n);
  if (status == LITHE_OK) status = find_edges(ctx, mesh, edges, n, v);
  lth_free(ctx, edges);
  if (status != LITHE_OK) lth_visibility_free(ctx, v);
  return status;
}

/// Boxes of the places where ways pass, which are a little beside the edges.
static LitheStatus make_edge_tree(LitheCtx *ctx, LthVisibility *v) {
  double *box = NULL;
  LTH_NEW(ctx, box, 6 * (LitheCount)v->n_edges);
  for (LitheIndex i = 0; i < v->n_edges; i++)
    for (int a = 0; a < 3; a++) {
      const LthWayEdge *e = v->edges + i;
      box[6 * (size_t)i + a] = fmin(e->end[0][a], e->end[1][a]) + e->away[a];
      box[6 * (size_t)i + 3 + a] = fmax(e->end[0][a], e->end[1][a]) + e->away[a];
    }
  LitheStatus status = lth_bvh_create_boxes(ctx, v->n_edges, box, &v->edge_bvh);
  lth_free(ctx, box);
  return status;
}

LitheStatus lth_visibility_create(LitheCtx *ctx, const LthMesh *mesh, LthVisibility *v) {
  LITHE_TRY(lth_visibility_find_edges(ctx, mesh, v));
  LitheStatus status = v->n_fronts > 0 ? make_tree(ctx, mesh, v) : LITHE_OK;
  if (status == LITHE_OK && v->n_fronts > 0) status = make_edge_tree(ctx, v);
  if (status != LITHE_OK) lth_visibility_free(ctx, v);
  return status;
}

void lth_visibility_free(LitheCtx *ctx, LthVisibility *v) {
  lth_bvh_destroy(ctx, &v->bvh);
  lth_bvh_destroy(ctx, &v->edge_bvh);
  lth_free(ctx, v->tri);
  lth_free(ctx, v->edges);
  *v = (LthVisibility){0};
}

double lth_visibility_front(const LthVisibility *v, const double box[6]) {
  double best = INFINITY;
  for (LitheIndex i = 0; i < v->n_fronts; i++) {
    double d2 = 0;
    for (int a = 0; a < 3; a++) {
      double p = v->edges[i].end[0][a], q = v->edges[i].end[1][a];
      double d = fmax(0, fmax(box[a] - fmax(p, q), fmin(p, q) - box[3 + a]));
      d2 += d * d;
    }
    best = fmin(best, d2);
  }
  return sqrt(best);
}

// ------------------------------------------------------------------ ways

/// Does the segment pass the triangle, edges included? Ends in its plane do not.
static bool passes(const double tri[9], const double a[3], const double b[3]) {
  double e[3], f[3], n[3], d[3], x[3], c[3];
  lth_v3_sub(tri + 3, tri, e);
  lth_v3_sub(tri + 6, tri, f);
  lth_v3_cross(e, f, n);
  lth_v3_sub(a, tri, d);
  double ha = lth_v3_dot(n, d);
  lth_v3_sub(b, tri, c);
  double hb = lth_v3_dot(n, c), nn = lth_v3_dot(n, n);
  if (!((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) || !(nn > 0)) return false;
  double s = ha / (ha - hb);
  for (int i = 0; i < 3; i++) x[i] = d[i] + s * (c[i] - d[i]);
  lth_v3_cross(x, f, c);
  double u = lth_v3_dot(c, n) / nn;
  lth_v3_cross(e, x, c);
  double w = lth_v3_dot(c, n) / nn;
  return u >= -ON_EDGE && w >= -ON_EDGE && u + w <= 1 + ON_EDGE;
}

/// A segment from a to b, for boxes.
typedef struct Segment {
  const double *a, *b;
  double inverse[3]; ///< of b - a; large where that is 0
} Segment;

static bool meets_box(const double box[6], const Segment *at) {
  double low = 0, high = 1 + ON_EDGE;
  for (int i = 0; i < 3; i++) {
    double s = (box[i] - at->a[i]) * at->inverse[i], t = (box[3 + i] - at->a[i]) * at->inverse[i];
    double first = s < t ? s : t, last = s < t ? t : s;
    if (first > low) low = first;
    if (last < high) high = last;
  }
  return low <= high + ON_EDGE;
}

/// Put a triangle to the front, at place k of what there was.
static void note_hider(LthHiders *hiders, int k, LitheIndex tri) {
  if (k == hiders->n && hiders->n < LTH_HIDERS) hiders->n++;
  if (k == LTH_HIDERS) k--;
  for (; k > 0; k--) hiders->tri[k] = hiders->tri[k - 1];
  hiders->tri[0] = tri;
}

static bool is_hidden_again(const LthVisibility *v, LthHiders *hiders, const double a[3],
                            const double b[3]) {
  for (int k = 0; k < hiders->n; k++) {
    if (!passes(v->tri + 9 * (size_t)hiders->tri[k], a, b)) continue;
    note_hider(hiders, k, hiders->tri[k]);
    return true;
  }
  return false;
}

bool lth_visibility_is_hidden(const LthVisibility *v, LthHiders *hiders, const double a[3],
                              const double b[3]) {
  const LthBvh *tree = v->bvh;
  LitheIndex waiting[STACK], n = 0;
  Segment segment = {.a = a, .b = b};
  if (!tree || tree->n_nodes == 0) return false;
  if (hiders && is_hidden_again(v, hiders, a, b)) return true;
  for (int i = 0; i < 3; i++) segment.inverse[i] = b[i] != a[i] ? 1 / (b[i] - a[i]) : 1e300;
  waiting[n++] = 0;
  while (n > 0) {
    LitheIndex node = waiting[--n];
    if (!meets_box(tree->box + 6 * (size_t)node, &segment)) continue;
    if (tree->right[node] >= 0) {
      LITHE_ASSERT(n + 2 <= STACK);
      waiting[n++] = tree->right[node];
      waiting[n++] = node + 1;
      continue;
    }
    for (LitheIndex i = tree->first[node]; i < tree->first[node] + tree->count[node]; i++) {
      if (!passes(v->tri + 9 * (size_t)tree->item[i], a, b)) continue;
      if (hiders) note_hider(hiders, hiders->n, tree->item[i]);
      return true;
    }
  }
  return false;
}

/// Where the way from a to b over an edge is shortest: straight once the planes through the edge are unfolded. Its length.
static double find_passage(const LthWayEdge *e, const double a[3], const double b[3],
                           double at[3]) {
  double d[3], f[3];
  lth_v3_sub(a, e->end[0], d);
  double za = lth_v3_dot(d, e->along), aa = lth_v3_dot(d, d) - za * za;
  lth_v3_sub(b, e->end[0], f);
  double zb = lth_v3_dot(f, e->along), bb = lth_v3_dot(f, f) - zb * zb;
  double ha = aa > 0 ? sqrt(aa) : 0, hb = bb > 0 ? sqrt(bb) : 0;
  double z = ha + hb > 0 ? (za * hb + zb * ha) / (ha + hb) : za;
  z = z < 0 ? 0 : z > e->length ? e->length : z;
  for (int i = 0; i < 3; i++) at[i] = e->end[0][i] + z * e->along[i] + e->away[i];
  return lth_v3_distance(a, at) + lth_v3_distance(at, b);
}

/// A way over an edge.
typedef struct Passage {
  double length, at[3];
  LitheIndex edge;
} Passage;

/// By length, the same by number: whatever the order in which they are come upon.
static bool is_before(const Passage *p, const Passage *q) {
  return p->length != q->length ? p->length < q->length : p->edge < q->edge;
}

static int insert_passage(Passage list[WAYS], int n, const Passage *p) {
  int k = n < WAYS ? n++ : WAYS - 1;
  for (; k > 0 && is_before(p, list + k - 1); k--) list[k] = list[k - 1];
  list[k] = *p;
  return n;
}

/// A way through a box is no shorter than from both ends to it.
static double least_length(const double box[6], const double a[3], const double b[3]) {
  double p = 0, q = 0;
  for (int i = 0; i < 3; i++) {
    double da = a[i] < box[i] ? box[i] - a[i] : a[i] > box[3 + i] ? a[i] - box[3 + i] : 0;
    double db = b[i] < box[i] ? box[i] - b[i] : b[i] > box[3 + i] ? b[i] - box[3 + i] : 0;
    p += da * da;
    q += db * db;
  }
  return sqrt(p) + sqrt(q);
}

/// Enter the ways over the edges of a leaf.
static int list_leaf(const LthVisibility *v, LitheIndex node, const double a[3], const double b[3],
                     double limit, Passage list[WAYS], int n) {
  const LthBvh *tree = v->edge_bvh;
  for (LitheIndex i = tree->first[node]; i < tree->first[node] + tree->count[node]; i++) {
    Passage p = {.edge = tree->item[i]};
    p.length = find_passage(v->edges + p.edge, a, b, p.at);
    if (p.length < limit && (n < WAYS || is_before(&p, list + WAYS - 1)))
      n = insert_passage(list, n, &p);
  }
  return n;
}

/// The shortest of the ways over one edge that are shorter than `limit`, whether they are hidden or not, in order. The nearer
/// half of the tree first, so that little of the other is looked at.
static int list_passages(const LthVisibility *v, const double a[3], const double b[3], double limit,
                         Passage list[WAYS]) {
  const LthBvh *tree = v->edge_bvh;
  LitheIndex waiting[STACK], n_waiting = 0;
  double least[STACK];
  int n = 0;
  if (tree->n_nodes > 0) least[0] = least_length(tree->box, a, b), waiting[n_waiting++] = 0;
  while (n_waiting > 0) {
    const LitheIndex node = waiting[--n_waiting];
    const double most = n < WAYS ? limit : list[WAYS - 1].length;
    if (least[n_waiting] > most) continue;
    if (tree->right[node] < 0) {
      n = list_leaf(v, node, a, b, limit, list, n);
      continue;
    }
    LitheIndex half[2] = {tree->right[node], node + 1};
    double at[2];
    LITHE_ASSERT(n_waiting + 2 <= STACK);
    for (int k = 0; k < 2; k++) at[k] = least_length(tree->box + 6 * (size_t)half[k], a, b);
    for (int k = 0; k < 2; k++) {
      int next = at[0] < at[1] ? 1 - k : k; // the nearer one is taken next
      if (at[next] > most) continue;
      least[n_waiting] = at[next];
      waiting[n_waiting++] = half[next];
    }
  }
  return n;
}

/// The shortest way over one edge.
static double find_way(const LthVisibility *v, LthHiders *hiders, const double a[3],
                       const double b[3], double limit) {
  Passage list[WAYS];
  int n = list_passages(v, a, b, limit, list);
  for (int i = 0; i < n; i++)
    if (!lth_visibility_is_hidden(v, hiders, a, list[i].at) &&
        !lth_visibility_is_hidden(v, NULL, list[i].at, b))
      return list[i].length;
  return INFINITY;
}

/// Over a bend and a second edge, where one does not do.
static double find_long_way(const LthVisibility *v, LthHiders *hiders, const double a[3],
                            const double b[3], double limit) {
  Passage list[WAYS];
  double best = limit;
  int n = list_passages(v, a, b, limit, list);
  for (int i = 0; i < n && i < LONG_WAYS; i++) {
    if (lth_visibility_is_hidden(v, hiders, a, list[i].at)) continue;
    double first = lth_v3_distance(a, list[i].at);
    double second = find_way(v, NULL, list[i].at, b, best - first);
    if (first + second < best) best = first + second;
  }
  return best < limit ? best : INFINITY;
}

double lth_visibility_way(const LthVisibility *v, LthHiders *hiders, const double a[3],
                          const double b[3], double limit) {
  double way = find_way(v, hiders, a, b, limit);
  return way < INFINITY || v->n_edges > LTH_WAY_FEW_EDGES ? way
                                                          : find_long_way(v, hiders, a, b, limit);
}
