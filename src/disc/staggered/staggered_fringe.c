/// Unknowns near the boundary: how the fractions that their rows read fall towards it, and where it is.
#include "disc/staggered/staggered_fringe.h"

#include "geometry/shape_foot.h"

#define FACING 0.7 // cosine: fractions fall towards a boundary
#define BEYOND 2   // cells

bool lth_fringe_is_inside(const LthStaggered *s, const LitheCount *slot, const int stride[3]) {
  int deep = s->dim == 3;
  for (int z = -deep; z <= deep; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++) {
        LitheCount cell = slot[x * stride[0] + y * stride[1] + z * stride[2]];
        if (cell < 0 || s->fractions->cell[cell] != LTH_CELL_FULL) return false;
      }
  return true;
}

static double sample_fraction(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                              int e) {
  if (!(lth_level_value(&s->level, s->level.shear[e], *slot) > 0)) return 0;
  return lth_staggered_edge_fraction(s, slot, stride, e);
}

bool lth_fringe_is_on_roller(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                             int a, int b) {
  LitheCount next = slot[-stride[a]];
  const uint8_t *state = s->level.state[b];
  if (*slot < 0 || next < 0) return false;
  if (lth_level_value(&s->level, s->level.shear[3 - a - b], *slot) > 0) return false;
  return state[*slot] == LTH_UNKNOWN_HELD && state[next] == LTH_UNKNOWN_HELD;
}

bool lth_fringe_slope(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                      LthFringe *rim, double side[3]) {
  const int a = rim->a;
  double *slope = rim->slope;
  const double *h = s->grid->h;
  LitheCount low = slot[-stride[a]];
  for (int b = 0; b < 3; b++) slope[b] = side[b] = 0;
  slope[a] = (lth_level_value(&s->level, s->level.volume, low) -
              lth_level_value(&s->level, s->level.volume, *slot)) /
             h[a];
  for (int b = 0; b < s->dim; b++) {
    if (b == a) continue;
    double V[2];
    for (int k = 0; k < 2; k++) {
      const LitheCount *sample = slot + (k ? stride[b] : 0);
      V[k] = sample_fraction(s, sample, stride, 3 - a - b);
      if (!lth_fringe_is_on_roller(s, sample, stride, a, b)) continue;
      V[k] = fmin(1, 2 * lth_staggered_edge_fraction(s, sample, stride, 3 - a - b));
      side[b] = (k ? V[k] : -V[k]) / h[b];
    }
    slope[b] = (V[0] - V[1]) / h[b];
  }
  return slope[0] != 0 || slope[1] != 0 || slope[2] != 0;
}

/// The boundary nearest to x, flat in the plane.
static bool find_foot(const LthStaggered *s, const double x[3], LthFoot *foot) {
  const double *h = s->grid->h;
  double scale = fmin(h[0], s->dim == 3 ? fmin(h[1], h[2]) : h[1]);
  if (!s->shape || !lth_shape_foot(s->shape, x, scale, foot)) return false;
  if (s->dim == 2) foot->normal[2] = 0, foot->point[2] = 0;
  return lth_v3_normalize(foot->normal) > 0.5;
}

void lth_fringe_nearest(const LthStaggered *s, const double at[3], LthFringe *rim) {
  LthFoot foot;
  if (find_foot(s, at, &foot)) {
    lth_v3_copy(foot.point, rim->point);
    lth_v3_copy(foot.normal, rim->normal);
    return;
  }
  lth_v3_copy(at, rim->point);
  lth_v3_copy(rim->slope, rim->normal);
  lth_v3_normalize(rim->normal);
}

void lth_fringe_boundary(const LthStaggered *s, const double at[3], LthFringe *rim) {
  LthFringe other = *rim;
  double out[3], beyond[3];
  lth_fringe_nearest(s, at, rim);
  lth_v3_copy(rim->slope, out);
  lth_v3_normalize(out);
  if (lth_v3_dot(rim->normal, out) >= FACING) return;
  lth_v3_copy(at, beyond);
  for (int a = 0; a < s->dim; a++) beyond[a] += BEYOND * s->grid->h[a] * out[a];
  lth_fringe_nearest(s, beyond, &other);
  if (lth_v3_dot(other.normal, out) > lth_v3_dot(rim->normal, out)) *rim = other;
}

LthFringe lth_fringe_of_roller(const LthStaggered *s, LitheIndex func, int a, int b, double slope) {
  LthFringe rim = {.a = a};
  lth_staggered_place(s, func, a, rim.point);
  rim.point[b] += copysign(0.5 * s->grid->h[b], slope);
  rim.normal[b] = copysign(1, slope);
  rim.slope[b] = slope;
  return rim;
}
