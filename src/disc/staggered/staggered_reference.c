/// The staggered operator and its transfers, one unknown at a time: what the fast kernels are held against.
#include "disc/staggered/staggered_hierarchy.h"
#include "disc/staggered/staggered_walls.h"

#include <math.h>
#include <string.h>

static double value_at(const double *v, LitheCount slot) { return slot < 0 ? 0 : v[slot]; }

static void shift(const LitheIndex cell[3], int axis, LitheIndex by, LitheIndex to[3]) {
  for (int a = 0; a < 3; a++) to[a] = cell[a] + (a == axis ? by : 0);
}

static double value_along(const LthSparseGrid *g, const double *v, const LitheIndex cell[3],
                          int axis, LitheIndex by) {
  return value_at(v, lth_sparse_grid_along(g, cell, axis, by));
}

/// V s_aa at a cell: 2 mu e_aa + lambda tr e.
static double normal_stress(const LthStaggeredLevel *l, const double *const u[3],
                            const LitheIndex cell[3], int a) {
  const LthSparseGrid *g = l->grid;
  LitheCount s = lth_sparse_grid_slot(g, cell[0], cell[1], cell[2]);
  const double mu = lth_level_value(l, l->mu, s), lambda = lth_level_value(l, l->lambda, s);
  if (mu == 0 && lambda == 0) return 0;
  double trace = 0, own = 0;
  for (int b = 0; b < g->dim; b++) {
    double e = (value_along(g, u[b], cell, b, 1) - u[b][s]) / g->h[b];
    trace += e;
    if (b == a) own = e;
  }
  return 2 * mu * own + lambda * trace;
}

/// V mu g_ab at the low edge of a cell.
static double shear_stress(const LthStaggeredLevel *l, const double *const u[3],
                           const LitheIndex cell[3], int a, int b) {
  const LthSparseGrid *g = l->grid;
  LitheCount s = lth_sparse_grid_slot(g, cell[0], cell[1], cell[2]);
  double mu = lth_level_value(l, l->shear[3 - a - b], s);
  if (mu == 0) return 0;
  return mu * ((u[a][s] - value_along(g, u[a], cell, b, -1)) / g->h[b] +
               (u[b][s] - value_along(g, u[b], cell, a, -1)) / g->h[a]);
}

static double row(const LthStaggeredLevel *l, double cm, double ck, const double *const u[3], int a,
                  LitheCount s) {
  const LthSparseGrid *g = l->grid;
  LitheIndex cell[3], other[3];
  lth_sparse_grid_cell(g, s, cell);
  shift(cell, a, -1, other);
  double f = -(normal_stress(l, u, cell, a) - normal_stress(l, u, other, a)) / g->h[a];
  for (int b = 0; b < g->dim; b++) {
    if (b == a) continue;
    shift(cell, b, 1, other);
    f -= (shear_stress(l, u, other, a, b) - shear_stress(l, u, cell, a, b)) / g->h[b];
  }
  return lth_sparse_grid_cell_volume(g) * (ck * f + cm * l->mass[a][lth_level_at(l, s)] * u[a][s]);
}

void lth_staggered_apply_ref(LitheCtx *ctx, const LthStaggeredLevel *l, double cm, double ck,
                             const double *const u[3], double *const y[3]) {
  for (int a = 0; a < l->grid->dim; a++) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
    for (LitheCount s = 0; s < l->grid->n_slots; s++)
      y[a][s] = l->state[a][s] == LTH_UNKNOWN_FREE ? row(l, cm, ck, u, a, s) : 0;
  }
}

static double diagonal_entry(const LthStaggeredLevel *l, double cm, double ck, int a,
                             LitheCount s) {
  const LthSparseGrid *g = l->grid;
  LitheIndex cell[3];
  lth_sparse_grid_cell(g, s, cell);
  LitheCount before = lth_sparse_grid_along(g, cell, a, -1);
  const LitheCount at = lth_level_at(l, s);
  double d = (2 * l->mu[at] + l->lambda[at] + 2 * lth_level_value(l, l->mu, before) +
              lth_level_value(l, l->lambda, before)) /
             (g->h[a] * g->h[a]);
  for (int b = 0; b < g->dim; b++) {
    if (b == a) continue;
    const double *shear = l->shear[3 - a - b];
    LitheCount after = lth_sparse_grid_along(g, cell, b, 1);
    d += (shear[at] + lth_level_value(l, shear, after)) / (g->h[b] * g->h[b]);
  }
  return lth_sparse_grid_cell_volume(g) * (ck * d + cm * l->mass[a][at]);
}

void lth_staggered_diagonal_ref(LitheCtx *ctx, const LthStaggeredLevel *l, double cm, double ck,
                                double *const diagonal[3]) {
  for (int a = 0; a < l->grid->dim; a++) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
    for (LitheCount s = 0; s < l->grid->n_slots; s++)
      diagonal[a][s] = l->state[a][s] == LTH_UNKNOWN_FREE ? diagonal_entry(l, cm, ck, a, s) : 0;
  }
}

double lth_staggered_modulus_unit(const LthStaggeredLevel *l) {
  double greatest = 0;
  for (LitheCount s = 0; l->volume && s < (LitheCount)l->n_rows * l->grid->side; s++) {
    if (!(l->volume[s] > 0 && l->mu[s] > 0)) continue;
    greatest = fmax(greatest, l->mu[s] / l->volume[s]);
  }
  return greatest;
}

double lth_staggered_pull(const LthStaggeredLevel *l, double unit, int a, LitheCount s) {
  if (l->state[a][s] == LTH_UNKNOWN_DEAD) return 0;
  if (unit == 0) return 1;
  LitheIndex cell[3];
  lth_sparse_grid_cell(l->grid, s, cell);
  LitheCount before = lth_sparse_grid_along(l->grid, cell, a, -1);
  double mu = l->mu[lth_level_at(l, s)] + lth_level_value(l, l->mu, before);
  double V = l->volume[lth_level_at(l, s)] + lth_level_value(l, l->volume, before);
  return V > 0 && mu > 0 ? fmin(1, 2 * V) * mu / (V * unit) : 1;
}

/// Parents of a free fine unknown with weights that are not scaled yet; returns how many.
static int find_parents(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine, double unit,
                        int a, const LitheIndex cell[3], LitheCount slot[8], double weight[8]) {
  LitheIndex near[3], far[3];
  double w[3][2];
  for (int b = 0; b < 3; b++) {
    bool odd = cell[b] & 1, flat = b >= fine->grid->dim;
    near[b] = far[b] = flat ? 0 : cell[b] >> 1;
    w[b][0] = flat || (b == a && !odd) ? 1 : b == a ? 0.5 : 0.75;
    w[b][1] = 1 - w[b][0];
    if (!flat) far[b] += b == a || odd ? 1 : -1;
  }
  int n = 0;
  for (int q = 0; q < 8; q++) {
    double p = w[0][q & 1] * w[1][q >> 1 & 1] * w[2][q >> 2];
    if (p == 0) continue;
    LitheCount s = lth_sparse_grid_slot(coarse->grid, q & 1 ? far[0] : near[0],
                                        q & 2 ? far[1] : near[1], q & 4 ? far[2] : near[2]);
    if (s < 0 || coarse->state[a][s] == LTH_UNKNOWN_DEAD) continue;
    slot[n] = s;
    weight[n++] = p * lth_staggered_pull(coarse, unit, a, s);
  }
  return n;
}

/// As lth_staggered_wall_scale(), from the parents.
static double wall_scale(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine, int a,
                         const LitheIndex cell[3], int n, const LitheCount slot[8],
                         const double weight[8]) {
  double sum = 0;
  bool any = false;
  for (int i = 0; i < n; i++) any |= coarse->state[a][slot[i]] == LTH_UNKNOWN_HELD;
  if (!any) return 0;
  for (int i = 0; i < n; i++) {
    LitheIndex at[3];
    if (coarse->state[a][slot[i]] == LTH_UNKNOWN_HELD) continue;
    lth_sparse_grid_cell(coarse->grid, slot[i], at);
    const double distance = 2 * lth_staggered_wall_distance(coarse, a, at);
    if (distance == 0) return 0;
    sum += weight[i] * distance;
  }
  return sum > 0 ? lth_staggered_wall_distance(fine, a, cell) / sum : 0;
}

double lth_staggered_wall_scale(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine,
                                double unit, int a, const LitheIndex cell[3]) {
  LitheCount slot[8];
  double weight[8];
  const int n = find_parents(coarse, fine, unit, a, cell, slot, weight);
  return wall_scale(coarse, fine, a, cell, n, slot, weight);
}

int lth_staggered_parents(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine,
                          double unit, int a, const LitheIndex cell[3], LitheCount slot[8],
                          double weight[8]) {
  const int n = find_parents(coarse, fine, unit, a, cell, slot, weight);
  double scale = wall_scale(coarse, fine, a, cell, n, slot, weight), sum = 0;
  for (int i = 0; i < n; i++) sum += weight[i];
  for (int i = 0; i < n; i++) weight[i] *= scale > 0 ? scale : 1 / sum;
  return n;
}

void lth_staggered_prolong_ref(LitheCtx *ctx, const LthStaggeredLevel *coarse,
                               const LthStaggeredLevel *fine, const double *const u_coarse[3],
                               double *const u_fine[3]) {
  const double unit = lth_staggered_modulus_unit(coarse);
  for (int a = 0; a < fine->grid->dim; a++) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
    for (LitheCount s = 0; s < fine->grid->n_slots; s++) {
      u_fine[a][s] = 0;
      if (fine->state[a][s] != LTH_UNKNOWN_FREE) continue;
      LitheIndex cell[3];
      LitheCount slot[8];
      double weight[8];
      lth_sparse_grid_cell(fine->grid, s, cell);
      int n = lth_staggered_parents(coarse, fine, unit, a, cell, slot, weight);
      for (int i = 0; i < n; i++) u_fine[a][s] += weight[i] * u_coarse[a][slot[i]];
    }
  }
}

void lth_staggered_restrict_ref(LitheCtx *ctx, const LthStaggeredLevel *coarse,
                                const LthStaggeredLevel *fine, const double *const r_fine[3],
                                double *const r_coarse[3]) {
  (void)ctx; // serial: sums in the order of the fine slots
  const double unit = lth_staggered_modulus_unit(coarse);
  for (int a = 0; a < fine->grid->dim; a++) {
    memset(r_coarse[a], 0, sizeof *r_coarse[a] * (size_t)coarse->grid->n_slots);
    for (LitheCount s = 0; s < fine->grid->n_slots; s++) {
      if (fine->state[a][s] != LTH_UNKNOWN_FREE) continue;
      LitheIndex cell[3];
      LitheCount slot[8];
      double weight[8];
      lth_sparse_grid_cell(fine->grid, s, cell);
      int n = lth_staggered_parents(coarse, fine, unit, a, cell, slot, weight);
      for (int i = 0; i < n; i++)
        if (coarse->state[a][slot[i]] == LTH_UNKNOWN_FREE)
          r_coarse[a][slot[i]] += weight[i] * r_fine[a][s];
    }
  }
}
