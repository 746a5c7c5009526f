/// Momentum and angular momentum of free bodies are known before a step is solved.
#include "base/tensor.h"
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// A translation of all bodies of a group takes away what the solution misses of P1 = P^ + H F. `missing` is
/// M v^ + H F - M v1, per unknown.
static void balance_momentum(LthSimulation *s, LitheIndex group, const double *missing) {
  const LthSystem *system = s->system;
  double sum[3] = {0}, mass[3] = {0}, shift[3];
  for (LitheIndex b = group; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b] / 3; i < system->dof_first[b + 1] / 3; i++) {
      if (s->rigid.group[b] != group || system->one[i] == 0) continue;
      lth_v3_axpy(system->one[i], missing + 3 * i, sum);
      lth_v3_axpy(system->one[i], s->row_mass + 3 * i, mass);
    }
  for (int a = 0; a < 3; a++) shift[a] = mass[a] > 0 ? sum[a] / mass[a] : 0;
  for (LitheIndex b = group; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b] / 3; i < system->dof_first[b + 1] / 3; i++)
      if (s->rigid.group[b] == group) lth_v3_axpy(system->one[i], shift, s->solution + 3 * i);
}

/// Moment of an external force, but for what holds new functions back: that has none where it was found, and the
/// rounding and tolerance of where that was are no impulse.
static void add_moment(const LthSimulation *s, LitheIndex b, double weight, const double *x,
                       const double *force, const double *faded, double sum[3]) {
  lth_rigid_add_moment(s, b, weight, x, force, sum);
  if (faded) lth_rigid_add_moment(s, b, -weight, x, faded, sum);
}

/// Moment of the external forces over the step: of their end for Euler, the mean of both ends for the others.
static void add_impulse(const LthSimulation *s, LitheIndex b, double dt, double sum[3]) {
  const LthStage *g = &s->stage;
  if (!g->is_second_order) {
    add_moment(s, b, dt, g->x_start, s->f_ext, s->faded, sum);
    return;
  }
  add_moment(s, b, 0.5 * dt, g->x_start, g->f_start, s->faded_start, sum);
  add_moment(s, b, 0.5 * dt, g->x_hat, s->f_ext, s->faded, sum); // x1 = x^ + H v1
  add_moment(s, b, 0.5 * dt * g->H, s->solution, s->f_ext, s->faded, sum);
}

/// A turn takes away what the solution misses of L1 = L0 + moment of the external forces. Frozen rotations leave a
/// moment of the inner forces, and only the trapezoidal rule keeps products of x and v. L1 = x^ x M v1, as v1 x M v1
/// sums up to nothing.
static void balance_angular(LthSimulation *s, LitheIndex b, double dt) {
  const LthSystem *system = s->system;
  const LthStage *g = &s->stage;
  LthInertia inertia;
  double missing[3] = {0}, turn[3];
  lth_rigid_inertia(s, b, g->x_hat, s->scratch, s->rhs, &inertia);
  lth_system_apply_body_mass(system, b, s->v, s->rhs);
  lth_rigid_add_moment(s, b, 1, g->x_start, s->rhs, missing);
  lth_system_apply_body_mass(system, b, s->solution, s->rhs);
  lth_rigid_add_moment(s, b, -1, g->x_hat, s->rhs, missing);
  add_impulse(s, b, dt, missing);
  if (!lth_rigid_turn(&inertia, missing, turn)) return;
  for (int k = 0; k < 3; k++) {
    lth_rigid_motion(s, b, &inertia, k, g->x_hat, s->scratch);
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->solution[i] += turn[k] * s->scratch[i];
  }
}

/// Some contact pushes a body from outside: what the step's impulse is only the solution tells.
static bool is_pushed(const LthSimulation *s) {
  for (LitheIndex c = 0; s->contact_on && c < s->system->n_contacts; c++) {
    const LthContact *contact = s->system->contacts[c];
    if (lth_contact_acted(contact) && !lth_contact_is_within(contact)) return true;
  }
  return false;
}

void lth_stage_balance(LthSimulation *s, double dt) {
  const LthSystem *system = s->system;
  const LthStage *g = &s->stage;
  if (is_pushed(s)) return;
  double *missing = s->scratch;
  lth_system_apply_mass(system, s->solution, s->rhs);
  for (LitheCount i = 0; i < s->n; i++) missing[i] = g->p[i] + g->H * s->f_ext[i] - s->rhs[i];
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (s->rigid.is_free[b] && s->rigid.group[b] == b) balance_momentum(s, b, missing);
  if (s->contact_on) return;
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (s->rigid.is_free[b] && s->rigid.is_alone[b] && system->bodies[b].warped)
      balance_angular(s, b, dt);
}
