/// Element matrices from the derivatives of the orthogonal basis; no integration is left to do.
#include "disc/dg/dg_priv.h"

/// Coefficients c of a polynomial sum_q w_q m_q = sum_l c_l phi_l: solve c^T basis = w^T. w is used up.
static void to_basis(const double *basis, int nb, int nl, double *w, double *c, int stride) {
  for (int l = nl - 1; l >= 0; l--) {
    double cl = w[l] / basis[l * nb + l];
    for (int q = 0; q < l; q++) w[q] -= cl * basis[l * nb + q];
    c[l * stride] = cl;
  }
}

void lth_dg_cell_slope(LthDgOperator *op, LitheIndex cell) {
  const LthDgSpace *space = op->space;
  const int(*exponent)[3] = lth_monomial3_exponents();
  const double *basis = space->basis[cell], *axes = space->axes + 9 * (LitheCount)cell;
  int nb = lth_dg_funcs(space, cell), nl = lth_dg_lower(space, cell);
  double *slope = op->slope[cell];

  for (int b = 0; b < 3; b++)
    for (int j = 0; j < nb; j++) {
      double w[LTH_DG_MAX_LOWER] = {0};
      for (int q = 1; q <= j; q++)
        for (int a = 0; a < 3; a++) {
          int e[3] = {exponent[q][0], exponent[q][1], exponent[q][2]};
          double factor = e[a] * axes[3 * a + b];
          if (factor == 0) continue;
          e[a]--;
          w[lth_monomial3_index(e[0], e[1], e[2])] += factor * basis[j * nb + q];
        }
      to_basis(basis, nb, nl, w, slope + (b * nb + j) * nl, 1);
    }
}

/// K_ij = lambda G^ab + mu G^ba + mu delta_ab tr G,  G^ab_ij = int d_a phi_i d_b phi_j
///      = |K| sum_l slope_a[i][l] slope_b[j][l].
static void element_matrix(const LthDgOperator *op, LitheIndex cell, double *block) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  const double *slope = lth_dg_slope(op, cell);
  double volume = op->space->mesh->cell_volume[cell];
  double lambda = op->lambda[cell], mu = op->mu[cell];

  for (int i = 1; i < nb; i++)
    for (int j = 1; j < nb; j++) {
      double G[3][3];
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          double sum = 0;
          for (int l = 0; l < nl; l++)
            sum += slope[(a * nb + i) * nl + l] * slope[(b * nb + j) * nl + l];
          G[a][b] = volume * sum;
        }
      double trace = G[0][0] + G[1][1] + G[2][2];
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
          block[((i * 3 + a) * 3 + b) * nb + j] +=
              lambda * G[a][b] + mu * G[b][a] + (a == b ? mu * trace : 0);
    }
}

/// kappa int grad phi_i, what the shape at rest holds: the mean of each gradient is its coefficient of phi_0.
static void element_load(const LthDgOperator *op, LitheIndex cell, double *load) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  double kappa = 3 * op->lambda[cell] + 2 * op->mu[cell];
  for (int i = 0; i < nb; i++)
    for (int b = 0; b < 3; b++)
      load[3 * i + b] =
          kappa * op->space->mesh->cell_volume[cell] * lth_dg_slope(op, cell)[(b * nb + i) * nl];
}

void lth_dg_add_own_flux(const LthDgOperator *op, LitheIndex cell, double w, const double n[3],
                         const double *mass, double *block) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  const double *slope = lth_dg_slope(op, cell);
  double lambda = -w * op->lambda[cell], mu = -w * op->mu[cell];

  for (int i = 0; i < nb; i++)
    for (int j = 1; j < nb; j++) {
      double g[3] = {0};
      for (int b = 0; b < 3; b++)
        for (int l = 0; l < nl; l++) g[b] += mass[i * nb + l] * slope[(b * nb + j) * nl + l];
      double ng = lth_v3_dot(n, g);
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
          block[((i * 3 + a) * 3 + b) * nb + j] +=
              lambda * n[a] * g[b] + mu * (g[a] * n[b] + (a == b ? ng : 0));
    }
}

/// block[i][a][b][j] += flux[i][a][b][j] + flux[j][b][a][i]
static void add_symmetrised(int nb, const double *flux, double *block) {
  for (int i = 0; i < nb; i++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        for (int j = 0; j < nb; j++)
          block[((i * 3 + a) * 3 + b) * nb + j] +=
              flux[((i * 3 + a) * 3 + b) * nb + j] + flux[((j * 3 + b) * 3 + a) * nb + i];
}

/// Flux terms whose both functions belong to the cell, with their share of f0: they turn with the cell.
static void own_flux(LthDgOperator *op, LitheIndex cell, double *flux, double *load) {
  int nb = lth_dg_funcs(op->space, cell);
  double kappa = 3 * op->lambda[cell] + 2 * op->mu[cell];
  for (LitheIndex s = op->side_off[cell]; s < op->side_off[cell + 1]; s++) {
    const LthDgFace *face = &op->faces[op->sides[s].face];
    int side = op->sides[s].side;
    double sign = side == 0 ? 1 : -1;
    double n[3] = {sign * face->normal[0], sign * face->normal[1], sign * face->normal[2]};
    const double *mass = lth_dg_face_tables(op, face).full.mass[side];
    double weight = face->weight[side];
    lth_dg_add_own_flux(op, cell, weight, n, mass, flux);
    for (int i = 0; i < nb; i++) lth_v3_axpy(-weight * kappa * mass[i], n, load + 3 * i);
  }
}

/// flux and penalty of a hold's groups, unrotated and before the projector.
static void hold_matrices(const LthDgOperator *op, const LthDgHold *hold, double *flux,
                          double *penalty) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  static const double zero[3] = {0};
  for (LitheIndex g = 0; g < hold->n_groups; g++) {
    const LthDgGroup *group = &op->groups[hold->first_group + g];
    const double *mass = op->group_data + group->table;
    if (op->flux == LTH_FLUX_IP) lth_dg_add_own_flux(op, hold->cell, 1, group->normal, mass, flux);
    double full[9], mean[9];
    const LthDgPenalty *p = &group->penalty;
    lth_dg_penalty_matrix(p->full_iso, p->full_normal, group->normal, zero, full);
    lth_dg_penalty_matrix(p->low_iso[0], p->low_normal[0], group->normal, zero, mean);
    for (int i = 0; i < nb; i++)
      for (int ab = 0; ab < 9; ab++)
        for (int j = 0; j < nb; j++)
          penalty[(i * 9 + ab) * nb + j] +=
              full[ab] * mass[i * nb + j] + mean[ab] * mass[i] * mass[j] / group->area;
  }
}

void lth_dg_cell_holds(LthDgOperator *op, LitheIndex cell) {
  int nb = lth_dg_funcs(op->space, cell);
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++) {
    const LthDgHold *hold = &op->holds[h];
    double *flux = op->hold_data + hold->table;
    if (!hold->roller) hold_matrices(op, hold, flux, flux + 9 * nb * nb);
  }
}

void lth_dg_cell_matrix(LthDgOperator *op, LitheIndex cell) {
  int nb = lth_dg_funcs(op->space, cell);
  double *block = op->cell_data[cell];
  double *load = op->cell_load + 3 * (LitheCount)op->space->func_off[cell];
  double flux[9 * LTH_DG_MAX_FUNCS * LTH_DG_MAX_FUNCS];
  memset(flux, 0, sizeof *flux * 9 * (size_t)(nb * nb));

  if (!op->faces_only) {
    element_load(op, cell, load);
    element_matrix(op, cell, block);
  }
  if (op->flux == LTH_FLUX_IP) own_flux(op, cell, flux, load);
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++) {
    const LthDgHold *hold = &op->holds[h];
    const double *hold_flux = op->hold_data + hold->table, *penalty = hold_flux + 9 * nb * nb;
    for (int i = 0; i < 9 * nb * nb && hold->whole; i++)
      flux[i] += hold_flux[i], block[i] += penalty[i];
  }
  add_symmetrised(nb, flux, block);
}

void lth_dg_stress_coefficients(const LthDgOperator *op, LitheIndex cell, const double *x,
                                double *S) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  const double *slope = lth_dg_slope(op, cell), *R = op->rotation + 9 * (LitheCount)cell;
  LitheCount first = 3 * (LitheCount)op->space->func_off[cell];
  double H[LTH_DG_MAX_LOWER][9] = {0};

  // H = R^T grad x - I, coefficient by coefficient
  for (int j = 1; j < nb; j++) {
    double y[3];
    lth_m3_apply_t(R, x + first + 3 * j, y);
    for (int a = 0; a < 3; a++) y[a] -= op->rest[first + 3 * j + a];
    for (int b = 0; b < 3; b++)
      for (int l = 0; l < nl; l++)
        for (int a = 0; a < 3; a++) H[l][3 * a + b] += y[a] * slope[(b * nb + j) * nl + l];
  }
  for (int l = 0; l < nl; l++) {
    double trace = op->lambda[cell] * (H[l][0] + H[l][4] + H[l][8]);
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        S[9 * l + 3 * a + b] =
            op->mu[cell] * (H[l][3 * a + b] + H[l][3 * b + a]) + (a == b ? trace : 0);
  }
}
