/// Parts by a profile of the signed distance: sums over the grid of what is smooth have almost no aliasing
/// (docs/theory/fractions.md).
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

#define ROUNDING 1e-9     ///< of a distance
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

/// From part to part of a row: the last distance bounds the next one.
typedef struct Walk {
  const LthSmoother *smoother;
  double place[3], distance;
} Walk;

/// Signed distance of a surface, looked for no farther than it can be.
static double walk_distance(Walk *w, const LthBvh *tree, const double x[3]) {
  LthBvhPoint closest;
  double reach = (w->distance + lth_v3_distance(x, w->place)) * (1 + ROUNDING);
  if (!lth_bvh_closest(tree, x, reach, NULL, NULL, &closest) &&
      !lth_bvh_closest(tree, x, INFINITY, NULL, NULL, &closest))
    return INFINITY;
  lth_v3_copy(x, w->place);
  w->distance = closest.distance;
  return lth_bvh_gap(tree, x, &closest, NULL);
}

static LthSide walk_side(const void *walk, const double center[3], const double half[3]) {
  const Walk *w = *(Walk *const *)walk;
  return lth_fraction_smooth_side(w->smoother, center, half);
}

static double smooth_part(const void *walk, const LthFractionFrame *f, const double low[3],
                          const int at[3]) {
  Walk *w = *(Walk *const *)walk;
  const LthSmoother *s = w->smoother;
  const LthShape *shape = s->probe->shape;
  double x[3] = {0, 0, 0};
  for (int a = 0; a < f->dim; a++) x[a] = low[a] + 0.5 * f->h[a] * (at[a] + 0.5);
  double d = shape->kind == LTH_SHAPE_MESH && shape->bvh
                 ? walk_distance(w, shape->bvh, x)
                 : lth_probe_distance(s->probe, x, f->dim, s->step);
  return lth_fraction_profile(d / s->width);
}

LitheStatus lth_fraction_fill_smooth(const void *smoother, LitheCtx *ctx, const LthFractionFrame *f,
                                     const LthFractionRow *row) {
  Walk walk = {.smoother = smoother, .distance = INFINITY}, *self = &walk;
  LthFractionFiller filler = {.self = &self, .side = walk_side};
  (void)ctx;
  for (LitheIndex m = 0; m < row->n; m++) {
    double low[3];
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    lth_fraction_halve(&filler, smooth_part, 2, f, low,
                       row->part + (LitheCount)m * f->block_cells * f->n_parts);
  }
  return LITHE_OK;
}
