/// Ways around the fronts of cuts and their bends: over one edge or two, each passed where the way is shortest.
#include "embed/visibility.h"

#include "base/tensor.h"
#include "geometry/face_polygon.h"
#include "geometry/polygon.h"
#include "mesh/cut_edges.h"

#include <stdlib.h>
#include <string.h>

#define WAYS 3       ///< most edges that are tried, those of the shortest ways
#define LONG_WAYS 2  ///< and as the first of two
#define STACK 128    ///< of nodes that wait: twice the depth of any tree
#define ON_EDGE 1e-9 ///< of a triangle: what passes its edge as close as that passes it

// ------------------------------------------------------------------ faces

static LthHidingTriangle make_triangle(const double *points, const LitheIndex corner[3]) {
  LthHidingTriangle t;
  lth_v3_copy(points + 3 * (size_t)corner[0], t.corner);
  for (int i = 0; i < 2; i++) lth_v3_sub(points + 3 * (size_t)corner[i + 1], t.corner, t.side[i]);
  lth_v3_cross(t.side[0], t.side[1], t.normal);
  t.normal2 = lth_v3_dot(t.normal, t.normal);
  return t;
}

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
    LTH_RESERVE_OR(done, ctx, v->tri, v->cap_tri, (LitheCount)v->n_tris + n);
    for (LitheIndex k = 0; k < n - 2; k++)
      v->tri[v->n_tris++] = make_triangle(view.points, corner + 3 * k);
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
      const LthHidingTriangle *t = v->tri + i;
      box[6 * (size_t)i + a] = t->corner[a] + fmin(0, fmin(t->side[0][a], t->side[1][a]));
      box[6 * (size_t)i + 3 + a] = t->corner[a] + fmax(0, fmax(t->side[0][a], t->side[1][a]));
    }
  status = lth_bvh_create_boxes(ctx, v->n_tris, box, &v->bvh);
done:
  lth_free(ctx, box);
  lth_polygon_list_free(ctx, &list);
  lth_polygon_work_free(ctx, &work);
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
static bool passes(const LthHidingTriangle *t, const double a[3], const double b[3]) {
  double d[3], x[3], c[3];
  lth_v3_sub(a, t->corner, d);
  double ha = lth_v3_dot(t->normal, d);
  lth_v3_sub(b, t->corner, c);
  double hb = lth_v3_dot(t->normal, c);
  if (!((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) || !(t->normal2 > 0)) return false;
  double s = ha / (ha - hb);
  for (int i = 0; i < 3; i++) x[i] = d[i] + s * (c[i] - d[i]);
  lth_v3_cross(x, t->side[1], c);
  double u = lth_v3_dot(c, t->normal) / t->normal2;
  lth_v3_cross(t->side[0], x, c);
  double w = lth_v3_dot(c, t->normal) / t->normal2;
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
    if (!passes(v->tri + hiders->tri[k], a, b)) continue;
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
      if (!passes(v->tri + tree->item[i], a, b)) continue;
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

/// Enter the way over an edge if it is one of the shortest and below `limit`.
static int add_passage(const LthVisibility *v, LitheIndex edge, const double a[3],
                       const double b[3], double limit, Passage list[WAYS], int n) {
  Passage p = {.edge = edge};
  p.length = find_passage(v->edges + edge, a, b, p.at);
  return p.length < limit && (n < WAYS || is_before(&p, list + WAYS - 1))
             ? insert_passage(list, n, &p)
             : n;
}

/// Over which of the two faces at an edge a place is, but not over the other: 1, 2; 3: so close to a plane that it may be
/// either; 0: over both or none.
static int side_of(const LthWayEdge *e, const double x[3]) {
  double d[3];
  lth_v3_sub(x, e->end[0], d);
  double h0 = lth_v3_dot(d, e->normal[0]), h1 = lth_v3_dot(d, e->normal[1]),
         near = ON_EDGE * e->length;
  return (h0 >= -near && h1 <= near) + 2 * (h0 <= near && h1 >= -near);
}

/// The shortest of the ways over one edge that are shorter than `limit`, whether they are hidden or not, in order: over those
/// edges that are outlines from a and, the other way round, from b; `sight` NULL: over all.
static int list_passages(const LthVisibility *v, const LthSight *sight, const double a[3],
                         const double b[3], double limit, Passage list[WAYS]) {
  int n = 0;
  for (LitheIndex i = 0; !sight && i < v->n_edges; i++) n = add_passage(v, i, a, b, limit, list, n);
  for (LitheIndex i = 0; sight && i < sight->n; i++) {
    const LthOutline *o = sight->outline + i;
    if (o->distance >= (n < WAYS ? limit : list[WAYS - 1].length)) break;
    int side = side_of(v->edges + o->edge, b);
    if ((o->side & 1 && side & 2) || (o->side & 2 && side & 1))
      n = add_passage(v, o->edge, a, b, limit, list, n);
  }
  return n;
}

/// The shortest way over one edge.
static double find_way(const LthVisibility *v, LthHiders *hiders, const LthSight *sight,
                       const double a[3], const double b[3], double limit) {
  Passage list[WAYS];
  int n = list_passages(v, sight, a, b, limit, list);
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
  int n = list_passages(v, NULL, a, b, limit, list);
  for (int i = 0; i < n && i < LONG_WAYS; i++) {
    if (lth_visibility_is_hidden(v, hiders, a, list[i].at)) continue;
    double first = lth_v3_distance(a, list[i].at);
    double second = find_way(v, NULL, NULL, list[i].at, b, best - first);
    if (first + second < best) best = first + second;
  }
  return best < limit ? best : INFINITY;
}

double lth_visibility_way(const LthVisibility *v, LthHiders *hiders, const LthSight *sight,
                          const double a[3], const double b[3], double limit) {
  bool is_few = lth_visibility_has_few(v);
  double way = find_way(v, hiders, sight, a, b, limit);
  return way < INFINITY || !is_few ? way : find_long_way(v, hiders, a, b, limit);
}

// ------------------------------------------------------------------ outlines

/// Looking around from a place.
typedef struct Look {
  LitheCtx *ctx;
  const LthVisibility *v;
  const double *from;
  double reach;
  LthSight *sight;
  LitheStatus status;
} Look;

static LitheStatus look_at(Look *k, LitheIndex edge) {
  const LthWayEdge *e = k->v->edges + edge;
  LthSight *sight = k->sight;
  double d[3];
  int side = side_of(e, k->from);
  if (side == 0) return LITHE_OK;
  lth_v3_sub(k->from, e->end[0], d);
  lth_v3_axpy(-1, e->away, d);
  double z = lth_v3_dot(d, e->along);
  lth_v3_axpy(z < 0 ? 0 : z > e->length ? -e->length : -z, e->along, d);
  double distance = lth_v3_norm(d);
  if (distance >= k->reach) return LITHE_OK;
  LTH_RESERVE(k->ctx, sight->outline, sight->cap, (LitheCount)sight->n + 1);
  sight->outline[sight->n++] = (LthOutline){edge, side, distance};
  return LITHE_OK;
}

static bool visit_edge(void *self, LitheIndex edge) {
  Look *k = self;
  k->status = look_at(k, edge);
  return k->status == LITHE_OK;
}

static int compare_outlines(const void *a, const void *b) {
  const LthOutline *p = a, *q = b;
  if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
  return (p->edge > q->edge) - (p->edge < q->edge);
}

LitheStatus lth_visibility_look(LitheCtx *ctx, const LthVisibility *v, const double from[3],
                                double reach, LthSight *sight) {
  Look k = {.ctx = ctx, .v = v, .from = from, .reach = reach, .sight = sight};
  sight->n = 0;
  lth_bvh_visit(v->edge_bvh, from, reach, visit_edge, &k);
  if (sight->n > 0)
    qsort(sight->outline, (size_t)sight->n, sizeof *sight->outline, compare_outlines);
  return k.status;
}
