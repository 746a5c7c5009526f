/// Elastic energy, and stress at a place, of linear bodies.
#include "disc/staggered/staggered_priv.h"

/// Position of the unknown of component a at a slot.
static double value_of(const LthStaggered *s, LitheCount slot, int a, const double *x) {
  return x[3 * (LitheCount)s->func[slot] + a];
}

/// Normal strains of the live cell at slot[0].
static void normal_strain(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                          const double *x, double e[3]) {
  for (int a = 0; a < 3; a++) e[a] = 0;
  for (int a = 0; a < s->dim; a++)
    e[a] = (value_of(s, slot[stride[a]], a, x) - value_of(s, slot[0], a, x)) / s->grid->h[a] - 1;
}

/// Shear of the sample at slot[0] in the plane of axes a, b: that of the rest places is zero.
static double shear_strain(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                           int a, int b, const double *x) {
  const double *h = s->grid->h;
  return (value_of(s, slot[0], a, x) - value_of(s, slot[-stride[b]], a, x)) / h[b] +
         (value_of(s, slot[0], b, x) - value_of(s, slot[-stride[a]], b, x)) / h[a];
}

/// Energy per volume of what stands at a slot.
static double slot_energy(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                          const double *x) {
  const LthStaggeredLevel *level = &s->level;
  double sum = 0;
  if (lth_level_is_live(level, *slot)) {
    double e[3];
    normal_strain(s, slot, stride, x, e);
    double trace = e[0] + e[1] + e[2];
    const LitheCount at = lth_level_at(level, *slot);
    sum += level->mu[at] * lth_v3_dot(e, e) + 0.5 * level->lambda[at] * trace * trace;
  }
  for (int k = lth_staggered_first_edge(s); k < 3; k++) {
    const double mu = lth_level_value(level, level->shear[k], *slot);
    if (!(mu > 0)) continue;
    double g = shear_strain(s, slot, stride, (k + 1) % 3, (k + 2) % 3, x);
    sum += 0.5 * mu * g * g;
  }
  return sum;
}

double lth_staggered_energy(LthDisc *disc, double t, const double *x) {
  LthStaggered *s = lth_staggered_of(disc);
  const LthSparseGrid *g = s->grid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    s->partial[block] = 0;
    for (LitheIndex local = 0; local < g->block_cells; local++)
      s->partial[block] += slot_energy(s, halo.slot + lth_halo_at(g, &halo, local), halo.stride, x);
  }
  double sum = 0;
  for (LitheIndex block = 0; block < g->n_blocks; block++) sum += s->partial[block];
  return sum * lth_sparse_grid_cell_volume(g) + lth_mixed_energy(s, x) +
         lth_rollers_energy(s, t, x);
}

/// The slots within one cell of a slot, as strides of a small halo of its own.
static void around(const LthSparseGrid *g, LitheCount slot, LitheCount near[27]) {
  int deep = g->dim == 3;
  for (int k = 0; k < 27; k++) {
    int d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
    near[k] = d[2] != 0 && !deep ? -1 : lth_sparse_grid_step(g, slot, d);
  }
}

static const int near_stride[3] = {1, 3, 9};

/// Normal stresses of the live cell at slot[0] [Pa], whose high neighbours stand at slot[near_stride[a]].
static void normal_stress(const LthStaggered *s, const LitheCount *slot, const double *x,
                          double stress[3]) {
  const LitheCount at = lth_level_at(&s->level, *slot);
  double e[3], V = s->level.volume[at];
  double lambda = s->level.lambda[at] / V, mu = s->level.mu[at] / V;
  double p = lth_mixed_pressure(s, *slot);
  normal_strain(s, slot, near_stride, x, e);
  for (int a = 0; a < 3; a++) stress[a] = 2 * mu * e[a] + lambda * (e[0] + e[1] + e[2]) + p;
}

/// Weight of what stands d half cells (one cell, that is 2, apart) from the cell's centre, at place r in
/// (-1/2, 1/2) of the cell's width: linear between the two on both sides.
static double hat(double r, int d) {
  const double w = 1 - fabs(r - 0.5 * d);
  return w > 0 ? w : 0; // fmax() would be a call
}

/// Place in a cell from its centre, in cells, within it.
static void local_place(const LthStaggered *s, LitheCount slot, const double at[3], double r[3]) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(s->grid, slot, cell);
  for (int a = 0; a < 3; a++) {
    r[a] = (at[a] - s->grid->origin[a]) / s->grid->h[a] - cell[a] - 0.5;
    r[a] = a < s->dim ? fmin(fmax(r[a], -0.5), 0.5) : 0;
  }
}

static void mix_normal(const LthStaggered *s, const LitheCount near[27], const double r[3],
                       const double *x, double stress[3]) {
  double sum = 0;
  for (int a = 0; a < 3; a++) stress[a] = 0;
  for (int k = 0; k < 27; k++) {
    int d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
    double w = hat(r[0], 2 * d[0]) * hat(r[1], 2 * d[1]) * hat(r[2], 2 * d[2]), normal[3];
    if (w == 0 || !lth_level_is_live(&s->level, near[k])) continue;
    const bool high = d[0] > 0 || d[1] > 0 || d[2] > 0; // its high neighbours are not near
    LitheCount own[27];
    if (high) around(s->grid, near[k], own);
    normal_stress(s, high ? own + 13 : near + k, x, normal);
    lth_v3_axpy(w, normal, stress);
    sum += w;
  }
  if (sum > 0) lth_v3_scale(1 / sum, stress);
}

/// Shear stress, linear between the edges along axis e of the cell and of its neighbours along them, over those that
/// have weight; 0 where none has.
static double mix_shear(const LthStaggered *s, const LitheCount near[27], const double r[3], int e,
                        const double *x) {
  int a = (e + 1) % 3, b = (e + 2) % 3;
  double sum = 0, stress = 0;
  for (int k = 0; k < 12; k++) {
    int da = k & 1, db = k >> 1 & 1, de = (k >> 2) - 1;
    const LitheCount *slot =
        near + 13 + da * near_stride[a] + db * near_stride[b] + de * near_stride[e];
    double w = hat(r[a], 2 * da - 1) * hat(r[b], 2 * db - 1) * hat(r[e], 2 * de);
    const double mu = w == 0 ? 0 : lth_level_value(&s->level, s->level.shear[e], *slot);
    if (!(mu > 0)) continue;
    double V = lth_staggered_edge_fraction(s, slot, near_stride, e); // its low neighbours are near
    sum += w;
    stress += w * (mu / V) * shear_strain(s, slot, near_stride, a, b, x);
  }
  return sum > 0 ? stress / sum : 0;
}

void lth_staggered_stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                          double stress[6]) {
  const LthStaggered *s = lth_staggered_const(disc);
  LitheCount near[27];
  double r[3];
  around(s->grid, s->cell_slot[cell], near);
  local_place(s, s->cell_slot[cell], at, r);
  mix_normal(s, near, r, x, stress);
  for (int e = 0; e < 3; e++)
    stress[3 + e] = e < lth_staggered_first_edge(s) ? 0 : mix_shear(s, near, r, e, x);
}
