/// What all discretisations share: sampling of vector fields, loads on boundary that is held in part.
#include "disc/disc.h"

#include <math.h>
#include <string.h>

void lth_disc_destroy(LitheCtx *ctx, LthDisc **disc) {
  if (*disc) (*disc)->table->destroy(ctx, *disc);
  *disc = NULL;
}

void lth_disc_sample(const LthDisc *disc, LitheIndex cell, const double *coef, const double x[3],
                     double value[3]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double phi[LTH_DISC_MAX_FUNCS];
  int n = disc->table->eval(disc, cell, x, func, phi);
  memset(value, 0, 3 * sizeof *value);
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) value[a] += phi[i] * coef[3 * (LitheCount)func[i] + a];
}

static void add_gradients(int n, const LitheIndex *func, const double *dphi, const double *coef,
                          double gradient[9]) {
  memset(gradient, 0, 9 * sizeof *gradient);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 9; k++)
      gradient[k] += coef[3 * (LitheCount)func[i] + k / 3] * dphi[3 * i + k % 3];
}

void lth_disc_sample_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                              const double x[3], double gradient[9]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double dphi[3 * LTH_DISC_MAX_FUNCS];
  int n = disc->table->eval_gradient(disc, cell, x, func, dphi);
  add_gradients(n, func, dphi, coef, gradient);
}

void lth_disc_mean_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                            double gradient[9]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double dphi[3 * LTH_DISC_MAX_FUNCS];
  int n = disc->table->mean_gradient(disc, cell, func, dphi);
  add_gradients(n, func, dphi, coef, gradient);
}

void lth_load_release(const LthLoad *load, const double n[3], double force[3]) {
  double m[3], size = 0, along = 0;
  for (int a = 0; a < 3; a++) {
    if (load->blocked[a]) force[a] = 0;
    m[a] = load->blocked_normal && !load->blocked[a] ? n[a] : 0;
    size += m[a] * m[a];
    along += m[a] * force[a];
  }
  if (size < 1e-24) return; // the normal lies among the blocked components
  for (int a = 0; a < 3; a++) force[a] -= along / size * m[a];
}
