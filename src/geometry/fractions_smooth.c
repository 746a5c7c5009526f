/// Parts by a profile of the signed distance: sums over the grid of what is smooth have almost no aliasing
/// (docs/theory/fractions.md).
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

#define HALF_WIDTH 1.2    ///< of the smooth profile, in cells
#define GRADIENT_STEP 0.5 ///< of cells

double lth_fraction_half_width(const LthFractionDef *def) {
  return def->half_width > 0 ? def->half_width : HALF_WIDTH;
}

LthSmoother lth_fraction_smoother(const LthProbe *probe, const LthFractionDef *def, int dim,
                                  const double h[3]) {
  double smallest = h[0], largest = h[0];
  for (int a = 1; a < dim; a++) {
    smallest = fmin(smallest, h[a]);
    largest = fmax(largest, h[a]);
  }
  return (LthSmoother){.probe = probe,
                       .width = lth_fraction_half_width(def) * largest,
                       .step = GRADIENT_STEP * smallest,
                       .dim = dim};
}

double lth_fraction_profile(double s) {
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

static double smooth_part(const void *smoother, const LthFractionFrame *f, const double low[3],
                          const int at[3]) {
  const LthSmoother *s = smoother;
  double x[3] = {0, 0, 0};
  for (int a = 0; a < f->dim; a++) x[a] = low[a] + 0.5 * f->h[a] * (at[a] + 0.5);
  return lth_fraction_profile(lth_probe_distance(s->probe, x, f->dim, s->step) / s->width);
}

LitheStatus lth_fraction_fill_smooth(const void *smoother, LitheCtx *ctx, const LthFractionFrame *f,
                                     const LthFractionRow *row) {
  const LthSmoother *s = smoother;
  const LthShape *shape = s->probe->shape;
  LthFractionFiller filler = {.self = smoother, .side = lth_fraction_smooth_side};
  bool is_surface = (shape->kind == LTH_SHAPE_MESH && shape->bvh) || shape->kind == LTH_SHAPE_WRAP;
  if (is_surface && f->dim == 3) return lth_fraction_fill_near(s, ctx, f, row);
  for (LitheIndex m = 0; m < row->n; m++) {
    double low[3];
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    lth_fraction_halve(&filler, smooth_part, 2, f, low,
                       row->part + (LitheCount)m * f->block_cells * f->n_parts);
  }
  return LITHE_OK;
}
