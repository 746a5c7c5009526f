/// Stiffness, mass and rest load: every row of the matrix is written by one thread, which goes through the
/// elements around its node. The warped stiffness of an isotropic element is that of turned gradients.
#include "disc/cg/cg_priv.h"

#include "base/clones.h"
#include "base/quad.h"
#include "material/rotation.h"

/// rows[a][b][j] += lambda G_ab + mu (G_ba + delta_ab tr G), G of row i laid out likewise.
LTH_QUAD_INLINE void plain_rows(int n, const double *restrict G, double lambda, double mu,
                                double *restrict rows) {
  const double one[3] = {1, 1, 1};
  double trace[LTH_CG_MAX];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      lth_row_add2(n, lambda, G + (3 * a + b) * n, mu, G + (3 * b + a) * n, rows + (3 * a + b) * n);
  lth_row_combine3(n, one, G, 4 * n, trace);
  for (int a = 0; a < 3; a++) lth_row_add(n, mu, trace, rows + 4 * a * n);
}

/// The same for G' = R G R^T.
LTH_QUAD_INLINE void turned_rows(int n, const double *restrict G, const double R[9], double lambda,
                                 double mu, double *restrict rows) {
  double half[9 * LTH_CG_MAX], turned[9 * LTH_CG_MAX];
  for (int a = 0; a < 3; a++)
    for (int d = 0; d < 3; d++)
      lth_row_combine3(n, R + 3 * a, G + d * n, 3 * n, half + (3 * a + d) * n);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      lth_row_combine3(n, R + 3 * b, half + 3 * a * n, n, turned + (3 * a + b) * n);
  plain_rows(n, turned, lambda, mu, rows);
}

LTH_QUAD_INLINE void any_rows(int n, bool turned, const double *G, const double R[9], double lambda,
                              double mu, double *rows) {
  if (turned)
    turned_rows(n, G, R, lambda, mu, rows);
  else
    plain_rows(n, G, lambda, mu, rows);
}

/// The common sizes are compiled with constant trip counts.
LTH_CLONES
static void element_rows(int n, bool turned, const double *G, const double R[9], double lambda,
                         double mu, double *rows) {
  switch (n) {
  case 4:
    any_rows(4, turned, G, R, lambda, mu, rows);
    break;
  case 8:
    any_rows(8, turned, G, R, lambda, mu, rows);
    break;
  case 10:
    any_rows(10, turned, G, R, lambda, mu, rows);
    break;
  case 20:
    any_rows(20, turned, G, R, lambda, mu, rows);
    break;
  default:
    any_rows(n, turned, G, R, lambda, mu, rows);
  }
}

/// Block of a row by its place there; a part of a larger matrix has other blocks between them.
static double *row_block(const LthBlockMatrix *K, LitheIndex row, uint16_t slot) {
  return K->values + K->value_off[K->block_off[row] + slot];
}

/// Rows of node `local` of an element into the matrix.
static void add_element(const LthCgDisc *d, LitheIndex e, int local, const LthBlockMatrix *K,
                        LitheIndex row) {
  double rows[9 * LTH_CG_MAX] = {0};
  int n = lth_cg_kind(d, e)->n;
  LthCgTables t = lth_cg_tables(d, d->class_of[e]);
  element_rows(n, d->warped, t.stiffness + 9 * n * local, d->rotation + 9 * (LitheCount)e,
               d->lambda[e], d->mu[e], rows);
  if (d->hold_off[e] < d->hold_off[e + 1]) {
    const double *held = d->hold_matrix + d->hold_matrix_off[e] + 9 * n * local;
    for (int k = 0; k < 9 * n; k++) rows[k] += held[k];
  }
  const uint16_t *slot = d->slot + d->slot_off[e] + (LitheCount)local * n;
  for (int j = 0; j < n; j++) {
    double *block = row_block(K, row, slot[j]);
    for (int ab = 0; ab < 9; ab++) block[ab] += rows[ab * n + j];
  }
}

/// Stress of the map x -> x, which corotated elements pull back to: (3 lambda + 2 mu) R int grad phi_i.
static void add_rest_load(const LthCgDisc *d, LitheIndex e, int local, double f0[3]) {
  LthCgTables tables = lth_cg_tables(d, d->class_of[e]);
  double turned[3];
  lth_m3_apply(d->rotation + 9 * (LitheCount)e, tables.mean + 3 * local, turned);
  lth_v3_axpy(3 * d->lambda[e] + 2 * d->mu[e], turned, f0);
  if (d->hold_off[e] < d->hold_off[e + 1])
    lth_v3_add(f0, d->hold_load + 3 * (LitheCount)(d->elements->element_off[e] + local), f0);
}

static void add_loads(const LthCgDisc *d, double *f0) {
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex row = 0; row < d->disc.n_rows; row++) {
    double *f = f0 + 3 * (LitheCount)row;
    memset(f, 0, 3 * sizeof *f);
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++)
      add_rest_load(d, d->node_element[k], d->node_local[k], f);
  }
}

void lth_cg_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0) {
  const LthCgDisc *d = lth_cg_of(disc);
  lth_cg_sum_holds(d, t, true);
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    for (LitheCount b = K->block_off[row]; b < K->block_off[row + 1]; b++)
      memset(K->values + K->value_off[b], 0, 9 * sizeof *K->values);
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++)
      add_element(d, d->node_element[k], d->node_local[k], K, row);
  }
  add_loads(d, f0);
}

void lth_cg_assemble_load(LthDisc *disc, double t, double *f0) {
  const LthCgDisc *d = lth_cg_of(disc);
  lth_cg_sum_holds(d, t, false);
  add_loads(d, f0);
}

void lth_cg_update_rotations(LthDisc *disc, const double *x) {
  LthCgDisc *d = disc->self;
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    double *R = d->rotation + 9 * (LitheCount)e, F[9] = {0};
    lth_m3_identity(R);
    if (!x || !d->warped) continue;
    const LthCgClass *class = &d->classes[d->class_of[e]];
    LthCgTables t = lth_cg_tables(d, d->class_of[e]);
    const LitheIndex *node = lth_cg_nodes(d, e);
    const double *x0 = x + 3 * (LitheCount)node[0];
    for (int i = 1; i < lth_cg_kind(d, e)->n; i++) {
      double edge[3];
      lth_v3_sub(x + 3 * (LitheCount)node[i], x0, edge);
      for (int k = 0; k < 9; k++) F[k] += edge[k / 3] * t.mean[3 * i + k % 3] / class->volume;
    }
    lth_rotation_nearest(F, R);
  }
}

void lth_cg_add_mass(const LthDisc *disc, double c, LthBlockMatrix *K) {
  const LthCgDisc *d = lth_cg_of(disc);
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++) {
      LitheIndex e = d->node_element[k];
      int n = lth_cg_kind(d, e)->n, local = d->node_local[k];
      const double *mass = lth_cg_tables(d, d->class_of[e]).mass + n * local;
      const uint16_t *slot = d->slot + d->slot_off[e] + (LitheCount)local * n;
      for (int j = 0; j < n; j++) {
        double *block = row_block(K, row, slot[j]);
        for (int a = 0; a < 3; a++) block[4 * a] += c * (d->density[e] * mass[j]);
      }
    }
  }
}

void lth_cg_apply_mass(const LthDisc *disc, const double *v, double *y) {
  const LthCgDisc *d = lth_cg_of(disc);
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    double sum[3] = {0};
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++) {
      LitheIndex e = d->node_element[k];
      int n = lth_cg_kind(d, e)->n;
      const double *mass = lth_cg_tables(d, d->class_of[e]).mass + n * d->node_local[k];
      for (int j = 0; j < n; j++)
        lth_v3_axpy(d->density[e] * mass[j], v + 3 * (LitheCount)lth_cg_nodes(d, e)[j], sum);
    }
    lth_v3_copy(sum, y + 3 * (LitheCount)row);
  }
}

void lth_cg_mass_diagonal(const LthDisc *disc, double *mass) {
  const LthCgDisc *d = lth_cg_of(disc);
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    mass[row] = 0;
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++) {
      LitheIndex e = d->node_element[k];
      mass[row] += d->density[e] * lth_cg_tables(d, d->class_of[e]).lumped[d->node_local[k]];
    }
  }
  lth_disc_spread(disc->n_funcs, 1, mass);
}
