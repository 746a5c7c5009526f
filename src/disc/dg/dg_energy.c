/// Elastic energy with jumps and constraints, reactions, and stress at a point.
#include "disc/dg/dg_priv.h"

#include "material/stress.h"

/// u = x - X0 of a cell (nb x 3): jumps of x and of u are the same, and u does not lose digits far away.
static void cell_displacement(const LthDgOperator *op, LitheIndex cell, const double *x,
                              double *u) {
  LitheCount first = 3 * (LitheCount)op->space->func_off[cell];
  int n = 3 * lth_dg_funcs(op->space, cell);
  for (int i = 0; i < n; i++) u[i] = x[first + i] - op->rest[first + i];
}

/// 1/2 int sigma : grad y = |K|/2 sum_l S_l : H_l, by the inverse law  eps = S / 2 mu - lambda' tr S I.
static double element_energy(const LthDgOperator *op, LitheIndex cell, const double *S) {
  double lambda = op->lambda[cell], mu = op->mu[cell], sum = 0;
  double bulk = lambda / (2 * mu * (3 * lambda + 2 * mu));
  for (int l = 0; l < lth_dg_lower(op->space, cell); l++) {
    double trace = S[9 * l] + S[9 * l + 4] + S[9 * l + 8], square = 0;
    for (int i = 0; i < 9; i++) square += S[9 * l + i] * S[9 * l + i];
    sum += square / (2 * mu) - bulk * trace * trace;
  }
  return 0.5 * sum * op->space->mesh->cell_volume[cell];
}

/// y = A^T x or A x of the (nu x nv) table, by columns of 3; y += factor ...
static void add_product(int nu, int nv, const double *A, bool transposed, double factor,
                        const double *x, double *y) {
  for (int i = 0; i < nu; i++)
    for (int j = 0; j < nv; j++) {
      if (transposed)
        lth_v3_axpy(factor * A[i * nv + j], x + 3 * i, y + 3 * j);
      else
        lth_v3_axpy(factor * A[i * nv + j], x + 3 * j, y + 3 * i);
    }
}

static double quadratic(const double M[9], const double v[3], const double w[3]) {
  double Mw[3];
  lth_m3_apply(M, w, Mw);
  return lth_v3_dot(v, Mw);
}

/// -w sum_l J_l . R S_l n: work of the traction on the jump's moments with the functions of one side.
static double flux_energy(const LthDgOperator *op, LitheIndex cell, double w, const double n[3],
                          const double *S, const double *jump) {
  double sum = 0;
  for (int l = 0; l < lth_dg_lower(op->space, cell); l++) {
    double traction[3], turned[3];
    lth_m3_apply(S + 9 * l, n, traction);
    lth_m3_apply(op->rotation + 9 * (LitheCount)cell, traction, turned);
    sum += lth_v3_dot(jump + 3 * l, turned);
  }
  return -w * sum;
}

/// jump[s] = int [u] phi^s from masses of traces; `mixed` carries a minus sign.
static void jump_moments(const int nb[2], const LthDgJump *t, double u[2][3 * LTH_DG_MAX_FUNCS],
                         double jump[2][3 * LTH_DG_MAX_FUNCS]) {
  for (int s = 0; s < 2; s++) memset(jump[s], 0, sizeof(double) * 3 * (size_t)nb[s]);
  add_product(nb[0], nb[0], t->mass[0], false, 1, u[0], jump[0]);
  add_product(nb[0], nb[1], t->mixed, false, 1, u[1], jump[0]);
  add_product(nb[1], nb[1], t->mass[1], false, -1, u[1], jump[1]);
  add_product(nb[0], nb[1], t->mixed, true, -1, u[0], jump[1]);
}

/// 1/2 int [u] . M [u]
static double jump_energy(const int nb[2], const double M[9], double u[2][3 * LTH_DG_MAX_FUNCS],
                          double jump[2][3 * LTH_DG_MAX_FUNCS]) {
  double sum = 0;
  for (int i = 0; i < nb[0]; i++) sum += 0.5 * quadratic(M, u[0] + 3 * i, jump[0] + 3 * i);
  for (int i = 0; i < nb[1]; i++) sum -= 0.5 * quadratic(M, u[1] + 3 * i, jump[1] + 3 * i);
  return sum;
}

/// Displacements of the two cells of a face and the turned normals.
static void face_state(const LthDgOperator *op, const LthDgFace *face, const double *x, int nb[2],
                       double u[2][3 * LTH_DG_MAX_FUNCS], double n[2][3]) {
  for (int s = 0; s < 2; s++) {
    nb[s] = lth_dg_funcs(op->space, face->cell[s]);
    cell_displacement(op, face->cell[s], x, u[s]);
    lth_m3_apply(op->rotation + 9 * (LitheCount)face->cell[s], face->normal, n[s]);
  }
}

/// Penalty energy of an inner face, and the moments of the jump.
static double face_penalty(const LthDgFace *face, const LthDgFaceTables *t, const int nb[2],
                           double u[2][3 * LTH_DG_MAX_FUNCS], double n[2][3],
                           double jump[2][3 * LTH_DG_MAX_FUNCS]) {
  double M[9], sum = 0;
  const LthDgPenalty *p = &face->penalty;
  for (int q = 0; q < t->n_low; q++) {
    lth_dg_penalty_matrix(p->low_iso[q], p->low_normal[q], n[0], n[1], M);
    jump_moments(nb, &t->low[q], u, jump);
    sum += jump_energy(nb, M, u, jump);
  }
  lth_dg_penalty_matrix(p->full_iso, p->full_normal, n[0], n[1], M);
  jump_moments(nb, &t->full, u, jump);
  return sum + jump_energy(nb, M, u, jump);
}

/// Flux and penalty energy of an inner face.
static double face_energy(const LthDgOperator *op, const LthDgFace *face, const double *x) {
  LthDgFaceTables t = lth_dg_face_tables(op, face);
  double u[2][3 * LTH_DG_MAX_FUNCS], jump[2][3 * LTH_DG_MAX_FUNCS], n[2][3];
  int nb[2];
  face_state(op, face, x, nb, u, n);
  double sum = face_penalty(face, &t, nb, u, n, jump);
  for (int s = 0; s < 2 && op->flux == LTH_FLUX_IP; s++) {
    double S[9 * LTH_DG_MAX_LOWER];
    lth_dg_stress_coefficients(op, face->cell[s], x, S);
    sum += flux_energy(op, face->cell[s], face->weight[s], face->normal, S, jump[s]);
  }
  return sum;
}

double lth_dg_face_penalty_energy(const LthDgOperator *op, const LthDgFace *face, const double *x) {
  LthDgFaceTables t = lth_dg_face_tables(op, face);
  double u[2][3 * LTH_DG_MAX_FUNCS], jump[2][3 * LTH_DG_MAX_FUNCS], n[2][3];
  int nb[2];
  face_state(op, face, x, nb, u, n);
  return face_penalty(face, &t, nb, u, n, jump);
}

/// int u phi_i - data over a group (nb x 3), projected by P.
static void hold_jump(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                      const double *u, const double *data, double *jump) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  double moments[3 * LTH_DG_MAX_FUNCS] = {0};
  add_product(nb, nb, op->group_data + group->table, false, 1, u, moments);
  for (int i = 0; i < nb; i++) {
    double v[3];
    lth_v3_sub(moments + 3 * i, data + 3 * i, v);
    lth_m3_apply(hold->P, v, jump + 3 * i);
  }
}

/// int q(P (u - d)) = sum over u, u and u, d by the moments, d, d by `square`.
static double hold_penalty(const LthDgHold *hold, int nb, const double M[9], const double *u,
                           const double *jump, const double *data, const double square[9]) {
  double PM[9], PMP[9], sum = 0;
  lth_m3_mul(hold->P, M, PM);
  lth_m3_mul(PM, hold->P, PMP);
  for (int i = 0; i < nb; i++) sum += quadratic(PM, u + 3 * i, jump + 3 * i);
  for (int i = 0; i < nb; i++) sum -= quadratic(PMP, u + 3 * i, data + 3 * i);
  for (int ab = 0; ab < 9; ab++) sum += PMP[ab] * square[ab];
  return sum;
}

static void group_matrices(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                           double full[9], double mean[9]) {
  static const double zero[3] = {0};
  const LthDgPenalty *p = &group->penalty;
  double n[3];
  lth_m3_apply(op->rotation + 9 * (LitheCount)hold->cell, group->normal, n);
  lth_dg_penalty_matrix(p->full_iso, p->full_normal, n, zero, full);
  lth_dg_penalty_matrix(p->low_iso[0], p->low_normal[0], n, zero, mean);
}

/// Flux (with the stress S, NULL: without) and penalty energy of a hold.
static double hold_energy(const LthDgOperator *op, const LthDgHold *hold, double t, const double *u,
                          const double *S) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  double sum = 0;
  for (LitheIndex g = 0; g < hold->n_groups; g++) {
    const LthDgGroup *group = &op->groups[hold->first_group + g];
    double data[3 * LTH_DG_MAX_FUNCS], jump[3 * LTH_DG_MAX_FUNCS], square[9], full[9], mean[9];
    lth_dg_group_data(op, hold, group, t, false, data, square);
    hold_jump(op, hold, group, u, data, jump);
    if (S && op->flux == LTH_FLUX_IP) sum += flux_energy(op, hold->cell, 1, group->normal, S, jump);
    group_matrices(op, hold, group, full, mean);
    sum += 0.5 * hold_penalty(hold, nb, full, u, jump, data, square);
    sum += 0.5 * quadratic(mean, jump, jump) / group->area;
  }
  return sum;
}

double lth_dg_hold_penalty_energy(const LthDgOperator *op, const LthDgHold *hold, double t,
                                  const double *x) {
  double u[3 * LTH_DG_MAX_FUNCS];
  cell_displacement(op, hold->cell, x, u);
  return hold_energy(op, hold, t, u, NULL);
}

/// Energy of jumps (with constraints), with that of the inside of elements or without.
static double sum_energy(LthDgOperator *op, double t, const double *x, bool insides) {
  LitheIndex n_cells = op->space->n_cells;
#pragma omp parallel for schedule(static) num_threads(lth_dg_threads(op))
  for (LitheIndex cell = 0; cell < n_cells; cell++) {
    double S[9 * LTH_DG_MAX_LOWER], u[3 * LTH_DG_MAX_FUNCS];
    lth_dg_stress_coefficients(op, cell, x, S);
    cell_displacement(op, cell, x, u);
    double sum = insides ? element_energy(op, cell, S) : 0;
    for (LitheIndex f = op->own_face_off[cell]; f < op->own_face_off[cell + 1]; f++)
      sum += face_energy(op, &op->faces[f], x);
    for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++)
      sum += hold_energy(op, &op->holds[h], t, u, S);
    op->partial[cell] = sum;
  }
  double energy = 0;
  for (LitheIndex cell = 0; cell < n_cells; cell++) energy += op->partial[cell];
  return energy;
}

double lth_dg_energy(LthDgOperator *op, double t, const double *x) {
  return sum_energy(op, t, x, !op->faces_only);
}

double lth_dg_jump_energy(LthDgOperator *op, double t, const double *x) {
  return sum_energy(op, t, x, false);
}

/// Force of a hold on the body: minus its internal force tested with constants,
/// int P sigma n - int P q'(P (u - d)).
static void hold_reaction(const LthDgOperator *op, const LthDgHold *hold, double t, const double *x,
                          double reaction[3]) {
  int nl = lth_dg_lower(op->space, hold->cell);
  const double *R = op->rotation + 9 * (LitheCount)hold->cell;
  double S[9 * LTH_DG_MAX_LOWER], u[3 * LTH_DG_MAX_FUNCS];
  lth_dg_stress_coefficients(op, hold->cell, x, S);
  cell_displacement(op, hold->cell, x, u);
  for (LitheIndex g = 0; g < hold->n_groups; g++) {
    const LthDgGroup *group = &op->groups[hold->first_group + g];
    const double *mass = op->group_data + group->table;
    double data[3 * LTH_DG_MAX_FUNCS], jump[3 * LTH_DG_MAX_FUNCS], full[9], mean[9];
    double force[3] = {0}, v[3], w[3];
    for (int l = 0; l < nl && op->flux == LTH_FLUX_IP; l++) {
      lth_m3_apply(S + 9 * l, group->normal, v);
      lth_m3_apply(R, v, w);
      lth_v3_axpy(mass[l], w, force);
    }
    lth_dg_group_data(op, hold, group, t, false, data, NULL);
    hold_jump(op, hold, group, u, data, jump);
    group_matrices(op, hold, group, full, mean);
    lth_m3_apply(full, jump, v);
    lth_v3_axpy(-1, v, force);
    lth_m3_apply(mean, jump, v);
    lth_v3_axpy(-1, v, force); // mean of the jump times the area: jump[0]
    lth_m3_apply(hold->P, force, v);
    lth_v3_axpy(1, v, reaction);
  }
}

void lth_dg_reactions(LthDgOperator *op, double t, const double *x, double *reaction) {
  memset(reaction, 0, sizeof *reaction * 3 * (size_t)op->n_weak);
  for (LitheIndex h = 0; h < op->n_holds; h++)
    hold_reaction(op, &op->holds[h], t, x, reaction + 3 * (LitheCount)op->holds[h].constraint);
}

void lth_dg_stress(const LthDgOperator *op, LitheIndex cell, const double *x, const double at[3],
                   double stress[6]) {
  const double *R = op->rotation + 9 * (LitheCount)cell;
  double F[9], H[9], Rt[9];
  lth_dg_sample_gradient(op->space, cell, x, at, F);
  lth_m3_transpose(R, Rt);
  lth_m3_mul(Rt, F, H);
  for (int i = 0; i < 9; i += 4) H[i] -= 1;
  lth_turned_stress(R, H, op->lambda[cell], op->mu[cell], stress);
}
