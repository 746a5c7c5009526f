/// What all discretisations share: point forces, sampling of vector fields, loads on boundary that is held in part.
#include "disc/disc.h"

#include <math.h>
#include <string.h>

void lth_disc_destroy(LitheCtx *ctx, LthDisc **disc) {
  if (*disc) (*disc)->table->destroy(ctx, *disc);
  *disc = NULL;
}

void lth_disc_spread(int n, int width, double *values) {
  for (int i = n - 1; i >= 0; i--)
    for (int a = 2; a >= 0; a--)
      memmove(values + (3 * i + a) * width, values + i * width, sizeof *values * (size_t)width);
}

void lth_disc_turn(const LthDisc *disc, int axis, const double *x, double *y) {
  if (disc->table->turn) {
    disc->table->turn(disc, axis, x, y);
    return;
  }
  int b = (axis + 1) % 3, c = (axis + 2) % 3;
  for (LitheCount i = 0; i < disc->n_dofs; i += 3) {
    double xb = x[i + b], xc = x[i + c];
    y[i + axis] = 0;
    y[i + b] = -xc;
    y[i + c] = xb;
  }
}

void lth_places_destroy(LitheCtx *ctx, LthPlaces **places) {
  if (!*places) return;
  lth_free(ctx, (*places)->at);
  lth_free(ctx, (*places)->cell_off);
  lth_free(ctx, (*places)->cell);
  lth_free(ctx, *places);
  *places = NULL;
}

/// f_i += F phi_i(at) / n, for each of the n cells at a place.
static void add_point_force(const LthDisc *disc, const LthLoad *load, LitheIndex place, double t,
                            double *f) {
  const LthPlaces *p = load->places;
  const double *at = p->at + 3 * (LitheCount)place;
  LitheIndex first = p->cell_off[place], end = p->cell_off[place + 1];
  for (LitheIndex k = first; k < end; k++) {
    LitheIndex func[LTH_DISC_MAX_FUNCS];
    double phi[3 * LTH_DISC_MAX_FUNCS];
    int n = disc->table->eval(disc, p->cell[k], at, func, phi);
    for (int a = 0; a < 3; a++) {
      double force = lth_value_at(&load->value[a], at, t) / (end - first);
      for (int i = 0; i < n; i++) f[3 * (LitheCount)func[i] + a] += force * phi[3 * i + a];
    }
  }
}

LitheStatus lth_disc_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                              const double *x, double *f) {
  if (load->kind != LTH_LOAD_POINT_FORCE) return disc->table->add_load(ctx, disc, load, t, x, f);
  for (LitheIndex i = 0; i < load->places->n; i++) add_point_force(disc, load, i, t, f);
  return LITHE_OK;
}

void lth_disc_sample(const LthDisc *disc, LitheIndex cell, const double *coef, const double x[3],
                     double value[3]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double phi[3 * LTH_DISC_MAX_FUNCS];
  int n = disc->table->eval(disc, cell, x, func, phi);
  memset(value, 0, 3 * sizeof *value);
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) value[a] += phi[3 * i + a] * coef[3 * (LitheCount)func[i] + a];
}

static void add_gradients(int n, const LitheIndex *func, const double *dphi, const double *coef,
                          double gradient[9]) {
  memset(gradient, 0, 9 * sizeof *gradient);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 9; k++)
      gradient[k] += coef[3 * (LitheCount)func[i] + k / 3] * dphi[9 * i + k];
}

void lth_disc_sample_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                              const double x[3], double gradient[9]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double dphi[9 * LTH_DISC_MAX_FUNCS];
  int n = disc->table->eval_gradient(disc, cell, x, func, dphi);
  add_gradients(n, func, dphi, coef, gradient);
}

void lth_disc_mean_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                            double gradient[9]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double dphi[9 * LTH_DISC_MAX_FUNCS];
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
