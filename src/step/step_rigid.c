/// Bodies that nothing holds: which they are, and mass damping that leaves their rigid motions alone
/// (docs/theory/stepping.md).
#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

#define RESISTS 1e-11 // force of a translation over the forces that cancel in it

/// What a row of bodies' matrix K does to translations of everything: T^T K T, and the sum of the absolute
/// terms.
static void resist_translation(const LthSimulation *s, LitheIndex row, double E[9], double *size) {
  const LthBlockMatrix *A = s->A;
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    const double *B = A->values + A->value_off[e];
    LitheCount r = A->row_off[row], c = A->row_off[A->block_col[e]];
    LitheCount m = A->row_off[row + 1] - r, n = A->row_off[A->block_col[e] + 1] - c;
    for (LitheCount i = 0; i < m * n; i++) {
      LitheCount p = r + i / n, q = c + i % n;
      double value = s->system->one[p / 3] * s->system->one[q / 3] * B[i];
      E[3 * (p % 3) + q % 3] += value;
      *size += fabs(value);
    }
  }
}

/// True where no constraint resists translations of a body together with those that it is tied to.
static bool is_free(const LthSimulation *s, LitheIndex b) {
  const LthSystem *system = s->system;
  double E[9] = {0}, size = 0, rest = 0;
  for (LitheCount i = system->dof_first[b]; system->has_held && i < system->dof_first[b + 1]; i++)
    if (system->held[i] == LTH_HELD) return false;
  if (s->own) return system->bodies[b].disc->n_weak == 0;
  for (LitheIndex row = system->row_first[b]; row < system->row_first[b + 1]; row++) {
    resist_translation(s, row, E, &size);
  }
  for (int k = 0; k < 9; k++) rest = fmax(rest, fabs(E[k]));
  return rest <= RESISTS * size;
}

/// group[b]: the first of the bodies that b is tied to by blocks of the matrix.
static void find_groups(LthSimulation *s) {
  const LthSystem *system = s->system;
  LthRigid *r = &s->rigid;
  lth_sets_reset(r->group, system->n_bodies);
  for (LitheIndex row = 0; !s->own && row < system->n_rows; row++)
    for (LitheCount e = s->A->block_off[row]; e < s->A->block_off[row + 1]; e++)
      lth_sets_unite(r->group, system->row_body[row], system->row_body[s->A->block_col[e]]);
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    r->group[b] = lth_sets_root(r->group, b);
    if (r->group[b] != b) r->is_alone[b] = r->is_alone[r->group[b]] = false;
  }
}

static LitheStatus allocate(LitheCtx *ctx, LthSimulation *s) {
  LthRigid *r = &s->rigid;
  if (r->group) return LITHE_OK;
  LTH_NEW(ctx, r->is_free, s->system->n_bodies);
  LTH_NEW(ctx, r->is_alone, s->system->n_bodies);
  LTH_NEW(ctx, r->group, s->system->n_bodies);
  return LITHE_OK;
}

void lth_rigid_free(LitheCtx *ctx, LthRigid *r) {
  lth_free(ctx, r->is_free);
  lth_free(ctx, r->is_alone);
  lth_free(ctx, r->group);
  for (int k = 0; k < 6; k++) lth_free(ctx, r->mode[k]);
}

static bool is_spared(const LthSimulation *s, LitheIndex b) {
  return s->rigid.is_free[b] && s->system->bodies[b].damping_mass > 0;
}

LitheStatus lth_rigid_find(LitheCtx *ctx, LthSimulation *s) {
  const LthSystem *system = s->system;
  LthRigid *r = &s->rigid;
  if (r->group) return LITHE_OK;
  LITHE_TRY(allocate(ctx, s));
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    r->is_alone[b] = true;
    r->is_free[b] = is_free(s, b);
  }
  find_groups(s);
  for (LitheIndex b = 0; b < system->n_bodies; b++) r->is_free[r->group[b]] &= r->is_free[b];
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    r->is_free[b] = r->is_free[r->group[b]];
    r->spares |= is_spared(s, b);
  }
  for (int k = 0; k < 6 && r->spares; k++) LTH_NEW(ctx, r->mode[k], s->n);
  return LITHE_OK;
}

void lth_rigid_measure(LthSimulation *s, LitheIndex b, const double *x, LthInertia *inertia) {
  const LthSystem *system = s->system;
  double mass[3] = {0};
  *inertia = (LthInertia){0};
  for (LitheCount i = system->dof_first[b] / 3; i < system->dof_first[b + 1] / 3; i++) {
    for (int a = 0; a < 3; a++) {
      mass[a] += system->one[i] * s->row_mass[3 * i + a];
      inertia->center[a] += s->row_mass[3 * i + a] * x[3 * i + a];
    }
  }
  for (int a = 0; a < 3; a++) {
    inertia->center[a] = mass[a] > 0 ? inertia->center[a] / mass[a] : 0;
    inertia->mass = fmax(inertia->mass, mass[a]);
  }
}

void lth_rigid_motion(const LthSimulation *s, LitheIndex b, const LthInertia *inertia, int k,
                      const double *x, double *y) {
  const LthSystem *system = s->system;
  const LitheCount first = system->dof_first[b], last = system->dof_first[b + 1];
  double *d = s->u; // free between calls
  for (LitheCount i = first; i < last; i++)
    if (k < 3)
      d[i] = x[i] - system->one[i / 3] * inertia->center[i % 3];
    else
      y[i] = i % 3 == k - 3 ? system->one[i / 3] : 0;
  if (k < 3) lth_disc_turn(system->bodies[b].disc, k, d + first, y + first);
}

void lth_rigid_add_moment(const LthSimulation *s, LitheIndex b, double weight, const double *x,
                          const double *y, double sum[3]) {
  const LitheCount first = s->system->dof_first[b], n = s->system->dof_first[b + 1] - first;
  for (int k = 0; k < 3; k++) { // e_k . (x x y) = (e_k x x) . y
    lth_disc_turn(s->system->bodies[b].disc, k, x + first, s->u + first);
    sum[k] += weight * lth_dot(1, n, s->u + first, y + first);
  }
}

void lth_rigid_inertia(LthSimulation *s, LitheIndex b, const double *x, double *motion,
                       double *momentum, LthInertia *inertia) {
  const LitheCount first = s->system->dof_first[b], n = s->system->dof_first[b + 1] - first;
  lth_rigid_measure(s, b, x, inertia);
  for (int k = 0; k < 3; k++) {
    lth_rigid_motion(s, b, inertia, k, x, motion);
    lth_system_apply_body_mass(s->system, b, motion, momentum);
    for (int l = 0; l <= k; l++) {
      lth_rigid_motion(s, b, inertia, l, x, motion);
      double value = lth_dot(1, n, motion + first, momentum + first);
      inertia->tensor[3 * k + l] = inertia->tensor[3 * l + k] = value;
    }
  }
}

bool lth_rigid_turn(const LthInertia *inertia, const double momentum[3], double turn[3]) {
  double inverse[9];
  if (!(lth_m3_det(inertia->tensor) > 0)) return false;
  lth_m3_inverse(inertia->tensor, inverse);
  lth_m3_apply(inverse, momentum, turn);
  return true;
}

/// M times the rigid motions of a body, orthonormal in M: translations over sqrt(mass), and turns about the centre
/// combined by the Cholesky factor of the inertia.
static void find_modes(LthSimulation *s, LitheIndex b, const double *x) {
  const LitheCount first = s->system->dof_first[b], last = s->system->dof_first[b + 1];
  LthInertia inertia;
  double L[9] = {0};
  lth_rigid_inertia(s, b, x, s->scratch, s->rhs, &inertia);
  for (int k = 0; k < 6; k++) {
    lth_rigid_motion(s, b, &inertia, k, x, s->scratch);
    lth_system_apply_body_mass(s->system, b, s->scratch, s->rigid.mode[k]);
  }
  for (int k = 0; k < 3; k++)
    for (int l = 0; l <= k; l++) {
      double sum = inertia.tensor[3 * k + l];
      for (int j = 0; j < l; j++) sum -= L[3 * k + j] * L[3 * l + j];
      L[3 * k + l] = k == l ? sqrt(fmax(sum, 0)) : L[4 * l] > 0 ? sum / L[4 * l] : 0;
    }
  for (LitheCount i = first; i < last; i++)
    for (int k = 0; k < 3; k++) {
      double value = s->rigid.mode[k][i];
      for (int j = 0; j < k; j++) value -= L[3 * k + j] * s->rigid.mode[j][i];
      s->rigid.mode[k][i] = L[4 * k] > 0 ? value / L[4 * k] : 0;
      s->rigid.mode[3 + k][i] /= sqrt(inertia.mass);
    }
}

void lth_rigid_prepare(LthSimulation *s, const double *x) {
  for (LitheIndex b = 0; b < s->system->n_bodies && s->rigid.spares; b++)
    if (is_spared(s, b)) find_modes(s, b, x);
}

void lth_rigid_spare(const LthSimulation *s, double weight, const double *v, double *y) {
  const LthSystem *system = s->system;
  for (LitheIndex b = 0; b < system->n_bodies && s->rigid.spares; b++) {
    LitheCount first = system->dof_first[b], n = system->dof_first[b + 1] - first;
    if (!is_spared(s, b)) continue;
    for (int k = 0; k < 6; k++) {
      const double *mode = s->rigid.mode[k] + first;
      double part = weight * system->bodies[b].damping_mass * lth_dot(1, n, mode, v + first);
      for (LitheCount i = 0; i < n; i++) y[first + i] += part * mode[i];
    }
  }
}
