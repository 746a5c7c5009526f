/// Winding numbers change by one at triangles and else hardly where they are nearly whole: one is enough for a small ball.
#include "geometry/wrap_local.h"

#include "base/tensor.h"
#include "geometry/box_overlap.h"

#define OPENING 2.0       ///< of groups
#define OPENING_WIDER 4.0 ///< where that does not decide
#define FLAT 0.95         ///< cosine between triangles that count as one plane
#define BESIDE 1e-3       ///< of a box's size: where the sides of a triangle are asked
#define STEEP 0.35        ///< change of the number over a box that still counts as linear
#define PLACES_SURE 8     ///< along a box that one number is enough for
#define PLACES 4          ///< where each place takes its own

static const double aside[3] = {0.0123, -0.0171,
                                0.0089}; ///< of the radius: centres of boxes lie on triangles

static const double *corner(const LthSurface *s, LitheIndex tri, int k) {
  return s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
}

typedef struct Listing {
  LthWrapLocal *local;
  double radius;
  bool is_full;
} Listing;

static bool list(void *self, LitheIndex tri) {
  Listing *l = self;
  const LthSurface *s = l->local->map->wrap->raw;
  double q[3];
  lth_closest_on_triangle(corner(s, tri, 0), corner(s, tri, 1), corner(s, tri, 2), l->local->center,
                          q);
  if (lth_v3_distance(q, l->local->center) > l->radius) return true;
  l->is_full = l->local->n == LTH_WRAP_LOCAL_TRIS;
  if (!l->is_full) l->local->tri[l->local->n++] = tri;
  return !l->is_full;
}

/// The number at the centre, and whether it is nearest to the same whole one in all of the ball, but for jumps.
static bool find_number(LthWrapLocal *local, double radius) {
  const LthWrap *w = local->map->wrap;
  double bound, change = 2 * radius * lth_rim_slope(w->rim, local->center, radius);
  if (!(change < 0.5)) return false;
  for (double opening = OPENING; opening <= OPENING_WIDER; opening *= 2) {
    double number = lth_winding_number(w->winding, local->center, opening, &bound);
    local->number = (int)round(number);
    if (fabs(number - local->number) + bound + change < 0.5) return true;
  }
  return false;
}

void lth_wrap_local_find(const LthWrapMap *map, const double center[3], double radius,
                         LthWrapLocal *local) {
  double wider = radius * 1.05;
  Listing l = {.local = local, .radius = wider};
  local->map = map;
  local->near = NULL;
  local->n = 0;
  for (int a = 0; a < 3; a++) local->center[a] = center[a] + aside[a] * radius;
  lth_bvh_visit(map->wrap->bvh, local->center, wider, list, &l);
  local->is_sure = !l.is_full && find_number(local, wider);
}

/// 1 where the way from a along d goes in through the triangle, -1 where it comes out, 0 where it misses it.
static int pass(const double a[3], const double d[3], const double *p, const double *q,
                const double *r) {
  double e[3], f[3], g[3], n[3], c[3];
  lth_v3_sub(q, p, e);
  lth_v3_sub(r, p, f);
  lth_v3_sub(p, a, g);
  lth_v3_cross(e, f, n);
  double below = lth_v3_dot(n, d);
  if (below == 0) return 0;
  double t = lth_v3_dot(n, g) / below;
  if (!(t > 0 && t < 1)) return 0;
  lth_v3_cross(g, d, c);
  double u = lth_v3_dot(c, f) / below, v = -lth_v3_dot(c, e) / below;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return 0;
  return below < 0 ? 1 : -1;
}

bool lth_wrap_local_inside(const LthWrapLocal *l, const double x[3]) {
  const LthWrap *w = l->map->wrap;
  if (!l->is_sure && !l->near) return lth_wrap_map_inside(l->map, x);
  int number = l->number;
  double d[3];
  for (int i = 0; i < 3; i++)
    if (!(x[i] >= w->box[i] && x[i] <= w->box[3 + i])) return false;
  if (!l->is_sure) return lth_winding_near_number(l->near, x) > 0.5;
  lth_v3_sub(x, l->center, d);
  for (int i = 0; i < l->n; i++)
    number += pass(l->center, d, corner(w->raw, l->tri[i], 0), corner(w->raw, l->tri[i], 1),
                   corner(w->raw, l->tri[i], 2));
  return number > 0;
}

/// --- boxes ---

/// Where all triangles in the box are about in one plane, that plane is taken, by the answers on both sides of it.
static bool triangle_plane(const LthWrapLocal *local, const double center[3], const double half[3],
                           double *share) {
  const LthBvh *tree = local->map->wrap->bvh;
  LthBvhPoint closest;
  double reach = lth_v3_norm(half), from[3], side[2][3];
  if (local->n == 0 || !lth_bvh_closest(tree, center, reach, NULL, NULL, &closest)) return false;
  const double *normal = tree->tri_normal + 3 * (size_t)closest.tri;
  for (int i = 0; i < local->n; i++)
    if (fabs(lth_v3_dot(tree->tri_normal + 3 * (size_t)local->tri[i], normal)) < FLAT) return false;
  for (int k = 0; k < 2; k++) {
    lth_v3_copy(closest.point, side[k]);
    lth_v3_axpy((k ? BESIDE : -BESIDE) * reach, normal, side[k]);
  }
  bool behind = lth_wrap_local_inside(local, side[0]),
       before = lth_wrap_local_inside(local, side[1]);
  if (behind == before) return false;
  lth_v3_sub(center, closest.point, from);
  double below = lth_box_overlap_plane(half, normal, lth_v3_dot(from, normal));
  *share = behind ? below : 1 - below;
  return true;
}

/// In a hole, away from all triangles, the number changes slowly, and the surface is where it passes one half.
static bool hole_plane(const LthWrapLocal *local, const double center[3], const double half[3],
                       double *share) {
  const LthWrap *w = local->map->wrap;
  double radius = lth_v3_norm(half), n[3], mean = 0;
  if (local->n > 0 || !(radius * lth_rim_slope(w->rim, center, radius) < STEEP)) return false;
  for (int a = 0; a < 3; a++) {
    double value[2];
    for (int k = 0; k < 2; k++) {
      double x[3];
      lth_v3_copy(center, x);
      x[a] += k ? half[a] : -half[a];
      value[k] = local->near ? lth_winding_near_number(local->near, x)
                             : lth_winding_number(w->winding, x, OPENING_WIDER, NULL);
      mean += value[k] / 6;
    }
    n[a] = (value[0] - value[1]) / (2 * half[a]);
  }
  double slope = lth_v3_normalize(n);
  if (!(slope > 0)) return false;
  *share = lth_box_overlap_plane(half, n, (0.5 - mean) / slope);
  return true;
}

/// Share of a box that lies in another.
static double share_within(const double box[6], const double center[3], const double half[3]) {
  double share = 1;
  for (int a = 0; a < 3; a++)
    share *= fmax(0, fmin(box[3 + a], center[a] + half[a]) - fmax(box[a], center[a] - half[a])) /
             (2 * half[a]);
  return fmin(share, 1);
}

static double places_share(const LthWrapLocal *local, const double center[3], const double half[3],
                           int n) {
  int count = 0;
  for (int s = 0; s < n * n * n; s++) {
    int place[3] = {s % n, s / n % n, s / (n * n)};
    double x[3];
    for (int a = 0; a < 3; a++) x[a] = center[a] + half[a] * ((2 * place[a] + 1.0) / n - 1);
    count += lth_wrap_local_inside(local, x);
  }
  return (double)count / (n * n * n);
}

/// Where one number is not enough, those of the box are made ready.
static void find(const LthWrapMap *map, const LthWindingNear *larger, const double center[3],
                 const double half[3], LthWrapLocal *local, LthWindingNear *near) {
  lth_wrap_local_find(map, center, lth_v3_norm(half), local);
  if (!local->is_sure && lth_winding_near(map->wrap->winding, larger, center, half, near))
    local->near = near;
}

double lth_wrap_local_share(const LthWrapMap *map, const LthWindingNear *larger,
                            const double center[3], const double half[3]) {
  LthWrapLocal local;
  LthWindingNear near;
  double share;
  find(map, larger, center, half, &local, &near);
  if (triangle_plane(&local, center, half, &share)) return share;
  if (!local.is_sure && hole_plane(&local, center, half, &share))
    return fmin(share, share_within(map->wrap->box, center, half));
  return places_share(&local, center, half, local.is_sure ? PLACES_SURE : PLACES);
}

double lth_wrap_local_samples(const LthWrapMap *map, const LthWindingNear *larger,
                              const double center[3], const double half[3], int n) {
  LthWrapLocal local;
  LthWindingNear near;
  find(map, larger, center, half, &local, &near);
  return places_share(&local, center, half, n);
}
