/// Cracks of a part: fans of cells around points, sheets of cut faces that hang together on one side, and the pairs of sheets that
/// lie face to face.
#include "scene/cracks.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "embed/visibility.h"
#include "geometry/bvh.h"
#include "mesh/cut_edges.h"
#include "mesh/topology.h"

#include <stdlib.h>

#define OPPOSITE 0.99 ///< minus least cosine of the two faces at a front
#define FACING 0.9    ///< minus largest cosine of triangles that lie face to face
#define TOGETHER 0.02 ///< of a cell: how far apart they may be, for short edges were contracted
#define FRONT 0.02    ///< of a cell: triangles so near a front are not touched ...
#define BEFORE 0.5    ///< ... and those so near do not touch: their foot would slip off.
#define SHALLOW                                                                                    \
  0.5 ///< Of the depth of a sheet that is all near: places so near the front do not touch

static LitheStatus copy_fronts(LitheCtx *ctx, const LthVisibility *v, LthCracks *cracks) {
  cracks->n_fronts = v->n_fronts;
  LTH_NEW(ctx, cracks->fronts, 6 * (LitheCount)v->n_fronts);
  for (LitheIndex i = 0; i < v->n_fronts; i++)
    memcpy(cracks->fronts + 6 * (size_t)i, v->edges[i].end, 6 * sizeof(double));
  return LITHE_OK;
}

static LitheStatus find_fronts(LitheCtx *ctx, LthCracks *cracks) {
  LthVisibility v;
  LITHE_TRY(lth_visibility_find_edges(ctx, cracks->mesh, &v));
  LitheStatus status = copy_fronts(ctx, &v, cracks);
  lth_visibility_free(ctx, &v);
  return status;
}

LitheStatus lth_cracks_count(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *n_fronts) {
  LthVisibility v;
  LITHE_TRY(lth_visibility_find_edges(ctx, mesh, &v));
  *n_fronts = v.n_fronts;
  lth_visibility_free(ctx, &v);
  return LITHE_OK;
}

// --- fans ---

static int compare_corners(const void *a, const void *b) {
  const LthCrackCorner *p = a, *q = b;
  if (p->point != q->point) return p->point < q->point ? -1 : 1;
  return (p->cell > q->cell) - (p->cell < q->cell);
}

static LitheIndex find_corner(const LthCracks *c, LitheIndex point, LitheIndex cell) {
  const LthCrackCorner wanted = {point, cell};
  const LthCrackCorner *found =
      bsearch(&wanted, c->corner, (size_t)c->n_corners, sizeof wanted, compare_corners);
  return found ? (LitheIndex)(found - c->corner) : -1;
}

LitheIndex lth_cracks_corner(const LthCracks *c, LitheIndex point, LitheIndex cell) {
  return lth_sets_root(c->fan, find_corner(c, point, cell));
}

/// All cells at points of the boundary.
static LitheStatus list_corners(LitheCtx *ctx, LthCracks *c) {
  const LthMesh *m = c->mesh;
  LitheStatus status = LITHE_OK;
  LitheCount cap = 0, n = 0;
  bool *is_boundary = NULL;
  LTH_NEW_OR(done, ctx, is_boundary, m->n_points);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    LthFaceView v = lth_mesh_face(m, f);
    for (LitheIndex k = v.loop_off[0]; m->face_cell[2 * f + 1] < 0 && k < v.loop_off[v.n_loops];
         k++)
      is_boundary[v.loop_point[k]] = true;
  }
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    LthFaceView v = lth_mesh_face(m, f);
    for (LitheIndex k = v.loop_off[0]; k < v.loop_off[v.n_loops]; k++)
      for (int s = 0; is_boundary[v.loop_point[k]] && s < 2; s++) {
        if (m->face_cell[2 * f + s] < 0) continue;
        LTH_RESERVE_OR(done, ctx, c->corner, cap, n + 1);
        c->corner[n++] = (LthCrackCorner){v.loop_point[k], m->face_cell[2 * f + s]};
      }
  }
  if (n > 0) qsort(c->corner, (size_t)n, sizeof *c->corner, compare_corners);
  for (LitheCount i = 0; i < n; i++)
    if (i == 0 || compare_corners(c->corner + i - 1, c->corner + i) != 0)
      c->corner[c->n_corners++] = c->corner[i];
done:
  lth_free(ctx, is_boundary);
  return status;
}

/// Cells hang together around a point by inner faces there, and around what an edge of theirs was contracted into.
static LitheStatus unite_corners(LitheCtx *ctx, LthCracks *c, const LitheIndex *stands_for) {
  const LthMesh *m = c->mesh;
  LTH_NEW(ctx, c->fan, c->n_corners);
  lth_sets_reset(c->fan, c->n_corners);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    const LitheIndex *cell = m->face_cell + 2 * (size_t)f;
    LthFaceView v = lth_mesh_face(m, f);
    for (LitheIndex l = 0; l < v.n_loops; l++)
      for (LitheIndex k = v.loop_off[l]; k < v.loop_off[l + 1]; k++) {
        LitheIndex p = v.loop_point[k],
                   q = v.loop_point[k + 1 < v.loop_off[l + 1] ? k + 1 : v.loop_off[l]];
        LitheIndex at = find_corner(c, p, cell[0]);
        if (at >= 0 && cell[1] >= 0) lth_sets_unite(c->fan, at, find_corner(c, p, cell[1]));
        if (cell[1] < 0 && stands_for[p] == stands_for[q])
          lth_sets_unite(c->fan, at, find_corner(c, q, cell[0]));
      }
  }
  return LITHE_OK;
}

// --- sheets ---

/// The boundary face that ends the walk through cells around an edge from a boundary face; -1 where it leads nowhere.
static LitheIndex walk_around(const LthMesh *m, const LthCutEdge *edge, LitheCount n,
                              LitheIndex from) {
  LitheIndex face = from, cell = m->face_cell[2 * (size_t)from];
  for (LitheCount steps = 0; steps < n; steps++) {
    LitheIndex next = -1;
    for (LitheCount i = 0; i < n; i++) {
      const LitheIndex *of = m->face_cell + 2 * (size_t)edge[i].face;
      if (edge[i].face != face && (of[0] == cell || of[1] == cell)) next = edge[i].face;
    }
    if (next < 0) return -1;
    const LitheIndex *of = m->face_cell + 2 * (size_t)next;
    if (of[1] < 0) return next;
    cell = of[of[0] == cell];
    face = next;
  }
  return -1;
}

/// Faces of one cut that meet in an edge of one piece of solid are of one sheet, but at a front.
static void unite_around(const LthMesh *m, const LthCutEdge *edge, LitheCount n,
                         LitheIndex *sheet) {
  for (LitheCount i = 0; i < n; i++) {
    const LitheIndex face = edge[i].face;
    if (!lth_is_cut_face(m, face)) continue;
    const LitheIndex other = walk_around(m, edge, n, face);
    if (other < 0 || m->face_tag[other] != m->face_tag[face]) continue;
    double along =
        lth_v3_dot(m->face_normal + 3 * (size_t)face, m->face_normal + 3 * (size_t)other);
    if (along > -OPPOSITE) lth_sets_unite(sheet, face, other);
  }
}

static LitheStatus find_sheets(LitheCtx *ctx, LthCracks *c) {
  const LthMesh *m = c->mesh;
  LitheStatus status = LITHE_OK;
  LthCutEdge *edges = NULL;
  LitheCount n = 0;
  LTH_NEW_OR(done, ctx, c->sheet, m->n_faces);
  lth_sets_reset(c->sheet, m->n_faces);
  LITHE_TRY_OR(done, lth_list_cut_edges(ctx, m, false, &edges, &n));
  for (LitheCount i = 0, end; i < n; i = end) {
    end = lth_cut_edge_end(edges, i, n);
    unite_around(m, edges + i, end - i, c->sheet);
  }
  for (LitheIndex f = 0; f < m->n_faces; f++)
    c->sheet[f] = lth_is_cut_face(m, f) ? lth_sets_root(c->sheet, f) : -1; // roots are lowest
done:
  lth_free(ctx, edges);
  return status;
}

LitheStatus lth_cracks_find(LitheCtx *ctx, const LthMesh *mesh, const LitheIndex *stands_for,
                            LthCracks *cracks) {
  *cracks = (LthCracks){.mesh = mesh};
  LitheStatus status = find_fronts(ctx, cracks);
  if (status == LITHE_OK && cracks->n_fronts == 0) return LITHE_OK;
  if (status == LITHE_OK) status = list_corners(ctx, cracks);
  if (status == LITHE_OK) status = unite_corners(ctx, cracks, stands_for);
  if (status == LITHE_OK) status = find_sheets(ctx, cracks);
  if (status != LITHE_OK) lth_cracks_free(ctx, cracks);
  return status;
}

void lth_cracks_free(LitheCtx *ctx, LthCracks *cracks) {
  lth_free(ctx, cracks->fronts);
  lth_free(ctx, cracks->corner);
  lth_free(ctx, cracks->fan);
  lth_free(ctx, cracks->sheet);
  *cracks = (LthCracks){0};
}

// --- sides ---

/// A search for what lies face to face with a triangle.
typedef struct Opposite {
  const LthCracks *cracks;
  const LthSurface *surface;
  const LthBvh *bvh;
  LitheIndex tri;
} Opposite;

static bool is_opposite(const void *self, LitheIndex tri) {
  const Opposite *o = self;
  const LitheIndex mine = o->surface->tri_poly[o->tri], other = o->surface->tri_poly[tri];
  const LthMesh *m = o->cracks->mesh;
  if (!lth_is_cut_face(m, other) || m->face_tag[other] != m->face_tag[mine]) return false;
  if (o->cracks->sheet[other] == o->cracks->sheet[mine]) return false;
  return lth_v3_dot(o->bvh->tri_normal + 3 * (size_t)o->tri, o->bvh->tri_normal + 3 * (size_t)tri) <
         -FACING;
}

static const double *corner_of(const LthSurface *s, LitheIndex tri, int k) {
  return s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
}

static void middle_of(const LthSurface *s, LitheIndex tri, double x[3]) {
  x[0] = x[1] = x[2] = 0;
  for (int k = 0; k < 3; k++) lth_v3_axpy(1.0 / 3, corner_of(s, tri, k), x);
}

static int compare_mates(const void *a, const void *b) {
  const LitheIndex *p = a, *q = b;
  if (p[0] != q[0]) return p[0] < q[0] ? -1 : 1;
  return (p[1] > q[1]) - (p[1] < q[1]);
}

/// Sheets that look at each other, once each way.
static LitheStatus find_mates(LitheCtx *ctx, Opposite *o, LthCrackSides *sides) {
  LitheCount cap = 0;
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < o->surface->n_tris; t++) {
    double x[3];
    LthBvhPoint closest;
    if (sides->sheet[t] < 0) continue;
    o->tri = t;
    middle_of(o->surface, t, x);
    if (!lth_bvh_closest(o->bvh, x, TOGETHER * o->cracks->mesh->cell_size, is_opposite, o,
                         &closest))
      continue;
    const LitheIndex pair[2] = {sides->sheet[t], sides->sheet[closest.tri]};
    LTH_RESERVE(ctx, sides->mates, cap, 2 * ((LitheCount)n + 2));
    for (int way = 0; way < 2; way++, n++)
      sides->mates[2 * n] = pair[way], sides->mates[2 * n + 1] = pair[1 - way];
  }
  if (n > 0) qsort(sides->mates, (size_t)n, 2 * sizeof *sides->mates, compare_mates);
  for (LitheIndex i = 0; i < n; i++) {
    const LitheIndex *pair = sides->mates + 2 * (size_t)i;
    if (i > 0 && compare_mates(pair - 2, pair) == 0) continue;
    memmove(sides->mates + 2 * (size_t)sides->n_mates++, pair, 2 * sizeof *pair);
  }
  return LITHE_OK;
}

static double to_segment(const double ends[6], const double x[3]) {
  double along[3], d[3];
  lth_v3_sub(ends + 3, ends, along);
  lth_v3_sub(x, ends, d);
  double length2 = lth_v3_dot(along, along), t = length2 > 0 ? lth_v3_dot(d, along) / length2 : 0;
  lth_v3_axpy(-fmin(fmax(t, 0), 1), along, d);
  return lth_v3_norm(d);
}

static double place_to_front(const LthCracks *c, const double x[3]) {
  double least = INFINITY;
  for (LitheIndex i = 0; i < c->n_fronts; i++)
    least = fmin(least, to_segment(c->fronts + 6 * (size_t)i, x));
  return least;
}

/// How far the corners of a triangle are from the front.
typedef struct Distance {
  double corner[3], nearest, farthest;
} Distance;

static Distance to_front(const LthCracks *c, const LthSurface *s, LitheIndex tri) {
  Distance d = {.nearest = INFINITY};
  for (int k = 0; k < 3; k++) {
    d.corner[k] = place_to_front(c, corner_of(s, tri, k));
    d.nearest = fmin(d.nearest, d.corner[k]);
    d.farthest = fmax(d.farthest, d.corner[k]);
  }
  return d;
}

/// Of a sheet that is one element deep all triangles reach to the front: their places on its far side touch.
static uint8_t far_places(const Distance *d, double depth) {
  uint8_t places = 0;
  double middle = (d->corner[0] + d->corner[1] + d->corner[2]) / 3;
  for (int k = 0; k < 3; k++)
    if (d->corner[k] > SHALLOW * depth) places |= (uint8_t)(1 << k);
  return places | (uint8_t)(middle > SHALLOW * depth ? 8 : 0);
}

static LitheStatus mark(LitheCtx *ctx, const LthCracks *c, const LthSurface *s,
                        LthCrackSides *sides) {
  const double cell = c->mesh->cell_size;
  double *depth = NULL; // of each sheet; a deep one has triangles that are not near a front
  bool *is_deep = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, depth, c->mesh->n_faces);
  LTH_NEW_OR(done, ctx, is_deep, c->mesh->n_faces);
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    const LitheIndex sheet = sides->sheet[t];
    if (sheet < 0) continue;
    const Distance d = to_front(c, s, t);
    depth[sheet] = fmax(depth[sheet], d.farthest);
    is_deep[sheet] |= d.nearest > BEFORE * cell;
  }
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    const LitheIndex sheet = sides->sheet[t];
    if (sheet < 0) continue;
    const Distance d = to_front(c, s, t);
    if (is_deep[sheet]) {
      sides->touches[t] = d.nearest > BEFORE * cell ? 15 : 0;
      if (d.nearest <= FRONT * cell) sides->sheet[t] = -1;
    } else {
      sides->touches[t] = far_places(&d, depth[sheet]);
    }
  }
done:
  lth_free(ctx, depth);
  lth_free(ctx, is_deep);
  return status;
}

void lth_crack_sides_free(LitheCtx *ctx, LthCrackSides *sides) {
  lth_free(ctx, sides->sheet);
  lth_free(ctx, sides->touches);
  lth_free(ctx, sides->mates);
  *sides = (LthCrackSides){0};
}

LitheStatus lth_cracks_find_sides(LitheCtx *ctx, const LthCracks *cracks, const LthSurface *surface,
                                  LthCrackSides *sides) {
  LitheStatus status = LITHE_OK;
  LthBvh *bvh = NULL;
  LitheIndex n = 0;
  *sides = (LthCrackSides){0};
  LTH_NEW_OR(done, ctx, sides->sheet, surface->n_tris);
  LTH_NEW_OR(done, ctx, sides->touches, surface->n_tris);
  for (LitheIndex t = 0; t < surface->n_tris; t++)
    n += (sides->sheet[t] = cracks->sheet[surface->tri_poly[t]]) >= 0;
  if (n == 0) goto done;
  LITHE_TRY_OR(done, lth_bvh_create_surface(ctx, surface, &bvh));
  Opposite opposite = {.cracks = cracks, .surface = surface, .bvh = bvh};
  LITHE_TRY_OR(done, find_mates(ctx, &opposite, sides));
  status = mark(ctx, cracks, surface, sides);
done:
  lth_bvh_destroy(ctx, &bvh);
  if (status != LITHE_OK || sides->n_mates == 0) lth_crack_sides_free(ctx, sides);
  return status;
}
