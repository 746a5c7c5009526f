/// Elastic energy with weak constraints, their reactions, and stress at a place.
#include "disc/cg/cg_priv.h"

#include "material/stress.h"

/// y = R^T (x - x_0) - (X - X_0) of an element (n x 3): deformation in its own frame, about its node 0.
static void element_deformation(const LthCgDisc *d, LitheIndex e, const double *x, double *y) {
  const LitheIndex *node = lth_cg_nodes(d, e);
  const double *R = d->rotation + 9 * (LitheCount)e;
  for (int i = 0; i < lth_cg_kind(d, e)->n; i++) {
    double edge[3], rest[3];
    lth_v3_sub(x + 3 * (LitheCount)node[i], x + 3 * (LitheCount)node[0], edge);
    lth_v3_sub(lth_cg_node(d, node[i]), lth_cg_node(d, node[0]), rest);
    lth_m3_apply_t(R, edge, y + 3 * i);
    lth_v3_sub(y + 3 * i, rest, y + 3 * i);
  }
}

/// 1/2 sum_ij y_i . K_ij y_j in the element's frame.
static double element_energy(const LthCgDisc *d, LitheIndex e, const double *y) {
  int n = lth_cg_kind(d, e)->n;
  const double *G = lth_cg_tables(d, d->class_of[e]).stiffness;
  double lambda = d->lambda[e], mu = d->mu[e], sum = 0;
  for (int i = 0; i < n; i++) {
    double H[9] = {0}; // sum_j G_ij[a][b] y_jc for b, c: the force's parts
    double force[3] = {0};
    for (int a = 0; a < 3; a++) {
      memset(H, 0, sizeof H);
      for (int b = 0; b < 3; b++)
        for (int j = 0; j < n; j++)
          lth_v3_axpy(G[((i * 3 + a) * 3 + b) * n + j], y + 3 * j, H + 3 * b);
      force[a] += lambda * (H[0] + H[4] + H[8]);
      for (int b = 0; b < 3; b++) {
        force[b] += mu * H[3 * b + a]; // G_ba y_b
        force[b] += mu * H[3 * a + b]; // the trace
      }
    }
    sum += lth_v3_dot(y + 3 * i, force);
  }
  return 0.5 * sum;
}

/// Jump x - x_D at a hold, projected, and the traction R sigma(y) n.
static void hold_state(const LthCgDisc *d, LitheIndex e, const LthCgHold *hold, double t,
                       const double *x, const double *y, double jump[3], double traction[3]) {
  const LitheIndex *node = lth_cg_nodes(d, e);
  int n = lth_cg_kind(d, e)->n;
  const double *phi = d->hold_data + hold->table, *dphi = phi + n, *nu = hold->normal;
  double u[3], v[3] = {0}, H[9] = {0}, s[3];
  lth_cg_hold_data(d, hold, t, u);
  lth_v3_scale(-1, u);
  for (int i = 0; i < n; i++) {
    double ui[3];
    lth_v3_sub(x + 3 * (LitheCount)node[i], lth_cg_node(d, node[i]), ui);
    lth_v3_axpy(phi[i], ui, u);
    for (int k = 0; k < 9; k++) H[k] += y[3 * i + k / 3] * dphi[3 * i + k % 3];
  }
  lth_m3_apply(hold->P, u, jump);
  double trace = hold->lambda * (H[0] + H[4] + H[8]);
  lth_m3_apply(H, nu, v);
  lth_m3_apply_t(H, nu, s);
  for (int a = 0; a < 3; a++) s[a] = hold->mu * (s[a] + v[a]) + trace * nu[a];
  lth_m3_apply(d->rotation + 9 * (LitheCount)e, s, traction);
}

/// M jump, M = P (iso I + stiff n n^T) P with the turned normal.
static void penalty_force(const LthCgDisc *d, LitheIndex e, const LthCgHold *hold,
                          const double jump[3], double force[3]) {
  double n[3], v[3];
  lth_m3_apply(d->rotation + 9 * (LitheCount)e, hold->normal, n);
  lth_v3_copy(jump, v);
  lth_v3_scale(hold->iso, v);
  lth_v3_axpy(hold->stiff * lth_v3_dot(n, jump), n, v);
  lth_m3_apply(hold->P, v, force);
}

double lth_cg_energy(LthDisc *disc, double t, const double *x) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex n = d->elements->n_elements;
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex e = 0; e < n; e++) {
    double y[3 * LTH_CG_MAX];
    element_deformation(d, e, x, y);
    d->partial[e] = element_energy(d, e, y);
    for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
      const LthCgHold *hold = &d->holds[h];
      double jump[3], traction[3], force[3];
      hold_state(d, e, hold, t, x, y, jump, traction);
      penalty_force(d, e, hold, jump, force);
      d->partial[e] += hold->weight * (0.5 * lth_v3_dot(jump, force) - lth_v3_dot(jump, traction));
    }
  }
  double energy = 0;
  for (LitheIndex e = 0; e < n; e++) energy += d->partial[e];
  return energy;
}

void lth_cg_reactions(LthDisc *disc, double t, const double *x, double *reaction) {
  const LthCgDisc *d = lth_cg_of(disc);
  memset(reaction, 0, sizeof *reaction * 3 * (size_t)disc->n_weak);
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    double y[3 * LTH_CG_MAX];
    if (d->hold_off[e] < d->hold_off[e + 1]) element_deformation(d, e, x, y);
    for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
      const LthCgHold *hold = &d->holds[h];
      double jump[3], traction[3], force[3], held[3];
      hold_state(d, e, hold, t, x, y, jump, traction);
      penalty_force(d, e, hold, jump, force);
      lth_m3_apply(hold->P, traction, held);
      lth_v3_sub(held, force, held);
      lth_v3_axpy(hold->weight, held, reaction + 3 * (LitheCount)hold->constraint);
    }
  }
}

void lth_cg_stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                   double stress[6]) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex e = lth_cg_element(d, cell);
  double phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], y[3 * LTH_CG_MAX];
  double H[9] = {0};
  lth_cg_eval_local(d, e, at, phi, dphi);
  element_deformation(d, e, x, y);
  for (int i = 0; i < lth_cg_kind(d, e)->n; i++)
    for (int k = 0; k < 9; k++) H[k] += y[3 * i + k / 3] * dphi[3 * i + k % 3];
  lth_turned_stress(d->rotation + 9 * (LitheCount)e, H, d->cell_lambda[cell], d->cell_mu[cell],
                    stress);
}
