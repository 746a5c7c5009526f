/// Winding numbers change by one at triangles and else hardly where they are nearly whole: one is enough for a small ball.
#include "geometry/wrap_local.h"

#include "base/tensor.h"

#define WHOLE 0.15  ///< as far from a whole number as maps allow, too
#define OPENING 2.0 ///< of groups

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

void lth_wrap_local_find(const LthWrapMap *map, const double center[3], double radius,
                         LthWrapLocal *local) {
  double bound, wider = radius * 1.05;
  Listing l = {.local = local, .radius = wider};
  local->map = map;
  local->n = 0;
  for (int a = 0; a < 3; a++) local->center[a] = center[a] + aside[a] * radius;
  lth_bvh_visit(map->wrap->bvh, local->center, wider, list, &l);
  double number = lth_winding_number(map->wrap->winding, local->center, OPENING, &bound);
  local->number = (int)round(number);
  local->is_sure = !l.is_full && fabs(number - local->number) + bound < WHOLE;
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
  if (!l->is_sure) return lth_wrap_map_inside(l->map, x);
  int number = l->number;
  double d[3];
  for (int i = 0; i < 3; i++)
    if (!(x[i] >= w->box[i] && x[i] <= w->box[3 + i])) return false;
  lth_v3_sub(x, l->center, d);
  for (int i = 0; i < l->n; i++)
    number += pass(l->center, d, corner(w->raw, l->tri[i], 0), corner(w->raw, l->tri[i], 1),
                   corner(w->raw, l->tri[i], 2));
  return number > 0;
}
