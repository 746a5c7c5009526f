/// Residuals of the mixed form.
#include "disc/staggered/staggered_mixed.h"

double lth_mixed_diagonal(const LthMixedLevel *l, int a, LitheIndex c) {
  const double per_a = l->per_h[a];
  double sum = 2 * (l->mu[c] + l->mu[l->next[2 * a][c]]) * per_a * per_a;
  for (int b = 0; b < l->dim; b++)
    if (b != a) {
      const double *shear = l->shear[3 - a - b], per_b = l->per_h[b];
      sum += (shear[c] + shear[l->next[2 * b + 1][c]]) * per_b * per_b;
    }
  return l->mass[a] ? sum + l->mass[a][c] : sum;
}

static inline void residual_at(const LthMixedLevel *l, LitheIndex c, const double *b,
                               const double *x, double *r) {
  const LitheCount pressure = l->dim * l->stride + c;
  for (int a = 0; a < l->dim; a++) {
    const LitheCount at = a * l->stride + c;
    r[at] = 0;
    if (l->flags[c] & LTH_MIXED_FREE << a) r[at] = (b ? b[at] : 0) - lth_mixed_momentum(l, a, c, x);
  }
  r[pressure] = 0;
  if (l->flags[c] & LTH_MIXED_PRESSURE)
    r[pressure] = (b ? b[pressure] : 0) - l->volume[c] * lth_mixed_divergence(l, c, x) +
                  l->compliance[c] * x[pressure];
}

void lth_mixed_residual(const LthMixedLevel *l, int threads, const double *b, const double *x,
                        double *r) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < l->n; c++)
    if (l->flags[c]) residual_at(l, c, b, x, r);
}
