/// Faces as simple polygons, for file formats and pictures that know no holes.
///
/// A hole is joined to the loop around it by a bridge from the hole's rightmost point to a point of the
/// loop that it sees, as Eberly's "Triangulation by ear clipping" does; the resulting polygon, which
/// touches itself along the bridges, is cut into triangles ear by ear. Quadratic in the points of a face
/// with holes; such faces are few.
#include "geometry/face_polygon.h"

#include "base/tensor.h"

#include <stdbool.h>

/// A loop in the plane of its face.
typedef struct Loop {
  LitheIndex begin, n; ///< in Flat's arrays
  double area;         ///< positive: outer
  LitheIndex owner;    ///< outer loop a hole lies in
} Loop;

/// A face in coordinates (s, t) of its plane, centred on its first point.
typedef struct Flat {
  LitheIndex n, n_loops;
  LitheIndex *point; ///< mesh point                (n)
  double (*at)[2];   ///< its place                 (n)
  Loop *loops;       ///< (n_loops)
  LitheIndex *ring;  ///< the polygon being built, as indices into point and at (n + 2 n_loops)
  LitheIndex n_ring;
} Flat;

void lth_polygon_list_free(LitheCtx *ctx, LthPolygonList *list) {
  lth_free(ctx, list->items);
  *list = (LthPolygonList){0};
}

static LitheStatus append(LitheCtx *ctx, LthPolygonList *list, LitheIndex n,
                          const LitheIndex *point) {
  LTH_RESERVE(ctx, list->items, list->cap, list->n + n + 1);
  list->items[list->n++] = n;
  for (LitheIndex i = 0; i < n; i++) list->items[list->n++] = point[i];
  list->n_polygons++;
  return LITHE_OK;
}

/// Twice the signed area of triangle a b c.
static double turn(const double a[2], const double b[2], const double c[2]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double loop_area(const Flat *flat, const Loop *loop) {
  double sum = 0;
  const double(*at)[2] = (const double(*)[2])flat->at + loop->begin;
  for (LitheIndex i = 1; i + 1 < loop->n; i++) sum += turn(at[0], at[i], at[i + 1]);
  return sum / 2;
}

static void free_flat(LitheCtx *ctx, Flat *flat) {
  lth_free(ctx, flat->point);
  lth_free(ctx, flat->at);
  lth_free(ctx, flat->loops);
  lth_free(ctx, flat->ring);
}

static LitheStatus flatten(LitheCtx *ctx, const LthFaceView *face, Flat *flat) {
  double t1[3], t2[3], d[3];
  LitheIndex first = face->loop_off[0];
  *flat = (Flat){.n = face->loop_off[face->n_loops] - first, .n_loops = face->n_loops};
  LTH_NEW(ctx, flat->point, flat->n);
  LTH_NEW(ctx, flat->at, flat->n);
  LTH_NEW(ctx, flat->loops, flat->n_loops);
  LTH_NEW(ctx, flat->ring, flat->n + 2 * flat->n_loops);

  lth_face_frame(face->normal, t1, t2);
  const double *origin = face->points + 3 * (LitheCount)face->loop_point[first];
  for (LitheIndex i = 0; i < flat->n; i++) {
    flat->point[i] = face->loop_point[first + i];
    lth_v3_sub(face->points + 3 * (LitheCount)flat->point[i], origin, d);
    flat->at[i][0] = lth_v3_dot(d, t1);
    flat->at[i][1] = lth_v3_dot(d, t2);
  }
  for (LitheIndex l = 0; l < flat->n_loops; l++) {
    Loop *loop = flat->loops + l;
    loop->begin = face->loop_off[l] - first;
    loop->n = face->loop_off[l + 1] - face->loop_off[l];
    loop->area = loop_area(flat, loop);
  }
  return LITHE_OK;
}

/// Crossings of the ray from p to the right with a loop are odd.
static bool is_inside(const Flat *flat, const Loop *loop, const double p[2]) {
  bool inside = false;
  const double(*at)[2] = (const double(*)[2])flat->at + loop->begin;
  for (LitheIndex i = 0, j = loop->n - 1; i < loop->n; j = i++) {
    if ((at[i][1] > p[1]) == (at[j][1] > p[1])) continue;
    double x = at[j][0] + (p[1] - at[j][1]) / (at[i][1] - at[j][1]) * (at[i][0] - at[j][0]);
    if (p[0] < x) inside = !inside;
  }
  return inside;
}

/// The smallest outer loop that holds most of a hole's points (single ones may lie on its border).
static LitheIndex find_owner(const Flat *flat, const Loop *hole) {
  LitheIndex best = -1;
  for (LitheIndex l = 0; l < flat->n_loops; l++) {
    const Loop *outer = flat->loops + l;
    if (outer->area <= 0 || outer->area < -hole->area) continue;
    LitheIndex n_inside = 0;
    for (LitheIndex i = 0; i < hole->n; i++)
      n_inside += is_inside(flat, outer, flat->at[hole->begin + i]);
    if (2 * n_inside >= hole->n && (best < 0 || outer->area < flat->loops[best].area)) best = l;
  }
  return best;
}

static LitheIndex rightmost(const Flat *flat, const Loop *loop) {
  LitheIndex best = 0;
  for (LitheIndex i = 1; i < loop->n; i++)
    if (flat->at[loop->begin + i][0] > flat->at[loop->begin + best][0]) best = i;
  return best;
}

/// Where the ray from m to the right first meets the ring: the ring edge and the place x. -1: nowhere.
static LitheIndex cast_ray(const Flat *flat, const double m[2], double *x) {
  LitheIndex hit = -1;
  for (LitheIndex i = 0; i < flat->n_ring; i++) {
    const double *a = flat->at[flat->ring[i]], *b = flat->at[flat->ring[(i + 1) % flat->n_ring]];
    // the ring has its inside to the left: seen from inside, edges to the right run upwards
    if (!(a[1] <= m[1] && m[1] <= b[1] && a[1] < b[1])) continue;
    double at = a[0] + (m[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    if (at >= m[0] && (hit < 0 || at < *x)) hit = i, *x = at;
  }
  return hit;
}

/// Inside or on the border of triangle a b c, whichever way round it is.
static bool in_triangle(const double a[2], const double b[2], const double c[2],
                        const double p[2]) {
  double u = turn(a, b, p), v = turn(b, c, p), w = turn(c, a, p);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

/// Position in the ring of a point that m, inside, can see: an end of the edge that the ray to the right
/// meets, or what stands in front of it.
static LitheIndex find_visible(const Flat *flat, const double m[2]) {
  double x = 0;
  LitheIndex hit = cast_ray(flat, m, &x);
  if (hit < 0) return 0;
  LitheIndex next = (hit + 1) % flat->n_ring;
  const double *a = flat->at[flat->ring[hit]], *b = flat->at[flat->ring[next]];
  LitheIndex best = a[0] > b[0] ? hit : next;
  const double place[2] = {x, m[1]},
               corner[2] = {flat->at[flat->ring[best]][0], flat->at[flat->ring[best]][1]};

  // of the ring's reflex points in the triangle m, place, corner: the one nearest to the ray's direction
  double best_slope = fabs(corner[1] - m[1]) / fmax(corner[0] - m[0], 1e-300);
  for (LitheIndex i = 0; i < flat->n_ring; i++) {
    const double *p = flat->at[flat->ring[i]];
    if (i == best || !(p[0] > m[0]) || !in_triangle(m, place, corner, p)) continue;
    const double *before = flat->at[flat->ring[(i + flat->n_ring - 1) % flat->n_ring]];
    const double *after = flat->at[flat->ring[(i + 1) % flat->n_ring]];
    double slope = fabs(p[1] - m[1]) / (p[0] - m[0]);
    if (turn(before, p, after) < 0 && slope < best_slope) best = i, best_slope = slope;
  }
  return best;
}

/// Splice a hole into the ring: ... p, hole from its rightmost point all round, that point, p, ...
static void bridge(Flat *flat, const Loop *hole) {
  LitheIndex start = rightmost(flat, hole), p = find_visible(flat, flat->at[hole->begin + start]);
  LitheIndex shift = hole->n + 2;
  for (LitheIndex i = flat->n_ring - 1; i > p; i--) flat->ring[i + shift] = flat->ring[i];
  for (LitheIndex i = 0; i <= hole->n; i++)
    flat->ring[p + 1 + i] = hole->begin + (start + i) % hole->n;
  flat->ring[p + shift] = flat->ring[p];
  flat->n_ring += shift;
}

/// The hole of `owner` not yet taken that reaches farthest to the right, or -1: bridges to the right
/// then never cross a hole that is still to come.
static LitheIndex next_hole(const Flat *flat, LitheIndex owner) {
  LitheIndex best = -1;
  double best_x = 0;
  for (LitheIndex l = 0; l < flat->n_loops; l++) {
    const Loop *hole = flat->loops + l;
    if (hole->area > 0 || hole->owner != owner) continue;
    double x = flat->at[hole->begin + rightmost(flat, hole)][0];
    if (best < 0 || x > best_x) best = l, best_x = x;
  }
  return best;
}

static bool is_ear(const Flat *flat, LitheIndex i) {
  LitheIndex n = flat->n_ring;
  LitheIndex ia = flat->ring[(i + n - 1) % n], ib = flat->ring[i], ic = flat->ring[(i + 1) % n];
  const double *a = flat->at[ia], *b = flat->at[ib], *c = flat->at[ic];
  if (turn(a, b, c) <= 0) return false;
  for (LitheIndex k = 0; k < n; k++) {
    LitheIndex q = flat->ring[k];
    if (q != ia && q != ib && q != ic && in_triangle(a, b, c, flat->at[q])) return false;
  }
  return true;
}

/// An ear, or what comes nearest to one where rounding leaves none: the point of least turn.
static LitheIndex find_ear(const Flat *flat) {
  LitheIndex n = flat->n_ring, flattest = 0;
  double least = HUGE_VAL;
  for (LitheIndex i = 0; i < n; i++) {
    if (is_ear(flat, i)) return i;
    double area = fabs(turn(flat->at[flat->ring[(i + n - 1) % n]], flat->at[flat->ring[i]],
                            flat->at[flat->ring[(i + 1) % n]]));
    if (area < least) least = area, flattest = i;
  }
  return flattest;
}

static LitheStatus clip_ears(LitheCtx *ctx, Flat *flat, LthPolygonList *list) {
  while (flat->n_ring >= 3) {
    LitheIndex n = flat->n_ring, i = find_ear(flat);
    const LitheIndex triangle[3] = {flat->point[flat->ring[(i + n - 1) % n]],
                                    flat->point[flat->ring[i]],
                                    flat->point[flat->ring[(i + 1) % n]]};
    LITHE_TRY(append(ctx, list, 3, triangle));
    for (LitheIndex k = i; k + 1 < n; k++) flat->ring[k] = flat->ring[k + 1];
    flat->n_ring--;
  }
  return LITHE_OK;
}

static LitheStatus append_outer(LitheCtx *ctx, Flat *flat, LitheIndex l, LthPolygonList *list) {
  const Loop *outer = flat->loops + l;
  LitheIndex hole = next_hole(flat, l);
  if (hole < 0) return append(ctx, list, outer->n, flat->point + outer->begin);

  flat->n_ring = outer->n;
  for (LitheIndex i = 0; i < outer->n; i++) flat->ring[i] = outer->begin + i;
  for (; hole >= 0; hole = next_hole(flat, l)) {
    bridge(flat, flat->loops + hole);
    flat->loops[hole].owner = -1;
  }
  return clip_ears(ctx, flat, list);
}

LitheStatus lth_face_polygons(LitheCtx *ctx, const LthFaceView *face, LthPolygonList *list) {
  if (face->n_loops == 1)
    return append(ctx, list, face->loop_off[1] - face->loop_off[0],
                  face->loop_point + face->loop_off[0]);

  LitheStatus status = LITHE_OK;
  Flat flat = {0};
  LITHE_TRY_OR(done, flatten(ctx, face, &flat));
  for (LitheIndex l = 0; l < flat.n_loops; l++)
    flat.loops[l].owner = flat.loops[l].area > 0 ? -1 : find_owner(&flat, flat.loops + l);
  for (LitheIndex l = 0; l < flat.n_loops; l++)
    if (flat.loops[l].area > 0) LITHE_TRY_OR(done, append_outer(ctx, &flat, l, list));

done:
  free_flat(ctx, &flat);
  return status;
}
