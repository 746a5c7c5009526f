/// Mass and gravity: both diagonal, V rho of the box around a face.
#include "disc/staggered/staggered_priv.h"

/// Mass of an unknown [kg]; in 2D that of z is x's, so that every component weighs the whole body.
static double mass_of(const LthStaggered *s, LitheCount k) {
  int a = (int)(k % 3);
  double density = s->level.mass[a < s->dim ? a : 0][lth_level_at(&s->level, s->slot[k / 3])];
  return density * lth_sparse_grid_cell_volume(s->grid);
}

void lth_staggered_add_mass(const LthDisc *disc, double c, LthBlockMatrix *K) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    double *block = K->values + K->value_off[K->diagonal[row]];
    for (int a = 0; a < 3; a++) block[4 * a] += c * mass_of(s, 3 * (LitheCount)row + a);
  }
}

void lth_staggered_apply_mass(const LthDisc *disc, const double *v, double *y) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheCount k = 0; k < disc->n_dofs; k++) y[k] = mass_of(s, k) * v[k];
}

void lth_staggered_mass_diagonal(const LthDisc *disc, double *mass) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheCount k = 0; k < disc->n_dofs; k++) mass[k] = mass_of(s, k);
}

void lth_staggered_add_gravity(const LthDisc *disc, const double gravity[3], double *f) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheCount k = 0; k < disc->n_dofs; k++) f[k] += mass_of(s, k) * gravity[k % 3];
}
