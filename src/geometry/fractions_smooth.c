/// Parts by a profile of the signed distance: sums over the grid of what is smooth have almost no aliasing
/// (docs/theory/fractions.md).
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

/// From 1 at s = -1 to 0 at s = 1.
static double profile(double s) {
  if (s <= -1) return 1;
  return s >= 1 ? 0 : 0.5 * (1 - s - sin(M_PI * s) / M_PI);
}

/// Is the box, and all within the width of it, on one side?
LthSide lth_fraction_smooth_side(const void *smoother, const double center[3],
                                 const double half[3]) {
  const LthSmoother *s = smoother;
  double wider[3];
  for (int a = 0; a < 3; a++) wider[a] = half[a] + (a < s->dim ? s->width : 0);
  return lth_probe_side(s->probe, center, wider);
}

static double smooth_part(const void *self, const LthFractionFrame *f, const double low[3],
                          const int at[3]) {
  const LthSmoother *s = self;
  double x[3] = {0, 0, 0};
  for (int a = 0; a < f->dim; a++) x[a] = low[a] + 0.5 * f->h[a] * (at[a] + 0.5);
  return profile(lth_probe_distance(s->probe, x, f->dim, s->step) / s->width);
}

LitheStatus lth_fraction_fill_smooth(const void *smoother, LitheCtx *ctx, const LthFractionFrame *f,
                                     const LthFractionRow *row) {
  LthFractionFiller filler = {.self = smoother, .side = lth_fraction_smooth_side};
  (void)ctx;
  for (LitheIndex m = 0; m < row->n; m++) {
    double low[3];
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    lth_fraction_halve(&filler, smooth_part, f, low,
                       row->part + (LitheCount)m * f->block_cells * f->n_parts);
  }
  return LITHE_OK;
}
