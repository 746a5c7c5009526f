/// Between levels of the mixed form: displacements linearly, pressures as constants
/// times mu; restriction is the transpose.
#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_slot.h"

/// Coarse faces that an axis' fine face at a slot is interpolated from, and their weights; returns how many.
static int sources(const LthMixedLevel *fine, const LthMixedLevel *coarse, int a, LitheIndex f,
                   LitheIndex *from, double *weight) {
  LitheIndex c[3];
  int n = 1;
  lth_cell_of(fine->grid, f, c);
  from[0] = fine->parent[f];
  weight[0] = 1;
  for (int b = 0; b < fine->dim; b++) {
    const int odd = c[b] & 1, n_before = n;
    if (b == a && !odd) continue;
    const int to = b == a || odd ? 2 * b + 1 : 2 * b;
    const double near = b == a ? 0.5 : 0.75;
    for (int k = 0; k < n_before; k++) {
      from[n] = coarse->next[to][from[k]];
      weight[n++] = weight[k] * (1 - near);
      weight[k] *= near;
    }
  }
  return n;
}

void lth_mixed_weigh(LthMixedLevel *fine, const LthMixedLevel *coarse) {
  for (LitheIndex f = 0; f < fine->n; f++)
    for (int a = 0; a < fine->dim; a++) {
      LitheIndex from[8];
      double weight[8], sum = 0;
      fine->weight[a][f] = 0;
      if (!(fine->flags[f] & LTH_MIXED_FREE << a)) continue;
      int n = sources(fine, coarse, a, f, from, weight);
      for (int k = 0; k < n; k++)
        if (coarse->flags[from[k]] & (LTH_MIXED_FREE | LTH_MIXED_HELD) << a) sum += weight[k];
      fine->weight[a][f] = sum > 0 ? (float)(1 / sum) : 0;
    }
  for (LitheIndex f = 0; f < fine->n; f++) {
    const LitheIndex to = fine->parent[f];
    if (!(fine->flags[f] & LTH_MIXED_PRESSURE)) continue;
    fine->share[f] = (float)(fine->mu[f] / fine->volume[f] * coarse->volume[to] / coarse->mu[to]);
  }
}

void lth_mixed_prolong(LthMixedLevel *fine, const LthMixedLevel *coarse, int threads) {
  const LitheCount pressure = fine->dim * fine->stride, from_pressure = fine->dim * coarse->stride;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex f = 0; f < fine->n; f++) {
    if (!fine->flags[f]) continue;
    for (int a = 0; a < fine->dim; a++) {
      LitheIndex from[8];
      double weight[8], sum = 0;
      if (!(fine->weight[a][f] > 0)) continue;
      int n = sources(fine, coarse, a, f, from, weight);
      for (int k = 0; k < n; k++) sum += weight[k] * coarse->x[a * coarse->stride + from[k]];
      fine->x[a * fine->stride + f] += fine->weight[a][f] * sum;
    }
    if (fine->flags[f] & LTH_MIXED_PRESSURE)
      fine->x[pressure + f] += fine->share[f] * coarse->x[from_pressure + fine->parent[f]];
  }
}

/// Weight of a fine face with bit `high` of a coarse cell at offset d (-1..1) from the coarse face's along an axis.
static inline double gather_weight(bool along, int d, int high) {
  static const double across[3][2] = {{0, 0.25}, {0.75, 0.75}, {0.25, 0}};
  static const double down[3][2] = {{0, 0.5}, {1, 0.5}, {0, 0}};
  return along ? down[d + 1][high] : across[d + 1][high];
}

static LitheIndex step_along(const LthMixedLevel *l, LitheIndex c, int axis, int d) {
  return d == 0 ? c : l->next[2 * axis + (d > 0)][c];
}

/// Transposed interpolation of axis a's residuals to one coarse face.
static double gather(const LthMixedLevel *fine, const LthMixedLevel *coarse, int a, LitheIndex c) {
  const int dim = fine->dim, parts = 1 << dim;
  const double *r = fine->r + a * fine->stride;
  double sum = 0;
  for (int dz = dim == 3 ? -1 : 0; dz <= (dim == 3); dz++)
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++) {
        const int d[3] = {dx, dy, dz};
        if (d[a] > 0) continue;
        LitheIndex at = c;
        for (int b = 0; b < dim; b++) at = step_along(coarse, at, b, d[b]);
        for (int q = 0; q < parts; q++) {
          double w = 1;
          for (int b = 0; b < dim; b++) w *= gather_weight(a == b, d[b], q >> b & 1);
          if (w > 0) sum += w * r[coarse->child[(LitheCount)at * parts + q]];
        }
      }
  return sum / parts;
}

void lth_mixed_restrict(LthMixedLevel *fine, LthMixedLevel *coarse, int threads) {
  const int dim = fine->dim, parts = 1 << dim;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex f = 0; f < fine->n; f++)
    for (int a = 0; a < dim && fine->flags[f]; a++)
      fine->r[a * fine->stride + f] *= fine->weight[a][f];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < coarse->n; c++) {
    if (!coarse->flags[c]) continue;
    for (int a = 0; a < dim; a++)
      coarse->b[a * coarse->stride + c] =
          coarse->flags[c] & LTH_MIXED_FREE << a ? gather(fine, coarse, a, c) : 0;
    double sum = 0;
    for (int q = 0; q < parts; q++) {
      const LitheIndex f = coarse->child[(LitheCount)c * parts + q];
      sum += fine->share[f] * fine->r[dim * fine->stride + f];
    }
    coarse->b[dim * coarse->stride + c] = coarse->flags[c] & LTH_MIXED_PRESSURE ? sum / parts : 0;
  }
}
