/// Edges that ways lead around: fronts of cuts, which a pair of cut faces alone has, and bends of sheets that have a front.
#include "embed/visibility.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "mesh/cut_edges.h"

#define OPPOSITE 1e-9 ///< of the normals of the two faces of a pair
#define TURN 1e-3     ///< sine of the least angle of a bend that hides anything
#define AWAY 1e-6     ///< of a cell's size: how far beside an edge ways pass
#define NARROW                                                                                     \
  0.02 ///< of a cell's size: faces beside a bend that are no wider are steps, not facets

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

/// Turn about the edge from a face into the body: 1 or -1.
static double turn_of(const LthMesh *m, const LthWayEdge *e, LitheIndex face) {
  double into[3], c[3];
  lth_v3_sub(m->face_centroid + 3 * (size_t)face, e->end[0], into);
  lth_v3_cross(m->face_normal + 3 * (size_t)face, into, c);
  return lth_v3_dot(c, e->along) < 0 ? -1 : 1;
}

/// The planes of the two faces at the edge that one side of the cut has, away from what they bound.
static void find_planes(const LthMesh *m, const LthCutEdge *edge, LitheCount n, LthWayEdge *e) {
  const double *first = m->face_normal + 3 * (size_t)edge[0].face;
  LitheCount other = 1;
  double least = 2;
  for (LitheCount i = 1; i < n; i++) {
    const double *normal = m->face_normal + 3 * (size_t)edge[i].face;
    double along = fabs(lth_v3_dot(first, normal));
    bool is_same_side = turn_of(m, e, edge[i].face) != turn_of(m, e, edge[0].face);
    if (n > 2 && (!is_same_side || along >= least)) continue;
    least = along;
    other = i;
  }
  for (int k = 0; k < 3; k++) {
    e->normal[0][k] = -first[k];
    e->normal[1][k] = -m->face_normal[3 * (size_t)edge[other].face + (size_t)k];
  }
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
  find_planes(m, edge, n, e);
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
    end = lth_cut_edge_end(edges, i, n);
    unite_faces(m, edges + i, end - i, sheet);
  }
  for (int pass = 0; pass < 2; pass++) {
    for (LitheCount i = 0, end; i < n; i = end) {
      bool is_front = false;
      end = lth_cut_edge_end(edges, i, n);
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
