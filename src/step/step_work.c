/// Work that constraints do on bodies as they move with time, and the forces that hold unknowns.
#include "step/simulation_priv.h"

#include <math.h>

/// force -= M a + damping, with velocity and acceleration of the last stage: a = (v1 - v^) / H.
static void subtract_inertia(const LitheCtx *ctx, LthSimulation *s) {
  const LthStage *g = &s->stage;
  const LthSystem *system = s->system;
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->rhs[i] =
          (s->solution[i] - g->v_hat[i]) / g->H + system->bodies[b].damping_mass * s->solution[i];
  lth_system_apply_mass(system, s->rhs, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->force[i] -= s->scratch[i];
  if (!lth_stage_has_stiffness_damping(system)) return;
  lth_step_apply(s, lth_threads(ctx), s->solution, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->force[i] -= system->bodies[b].damping_stiffness * s->scratch[i];
  lth_stage_add_damped_load(s, 1 / g->H, s->t, s->f0, s->force);
  lth_stage_add_damped_load(s, -1 / g->H, s->t - g->H, NULL, s->force);
}

LitheStatus lth_simulation_imbalance(LitheCtx *ctx, LthSimulation *s, const double **force) {
  *force = s->force;
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  if (s->stage.has_old) subtract_inertia(ctx, s);
  return LITHE_OK;
}

static bool has_moving(const LthSystem *system) {
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    const LthDisc *disc = system->bodies[b].disc;
    for (LitheIndex w = 0; w < disc->n_weak; w++)
      if (disc->weak[w].moves) return true;
  }
  return false;
}

// The energy depends on time through the constraints alone: dE = f dx + (dE/dt) dt.
double lth_work_of_weak(LthSimulation *s, double t0, const double *x0) {
  LthSystem *system = s->system;
  if (!has_moving(system)) return 0;
  return 0.5 * (lth_system_energy(system, s->t, x0) - lth_system_energy(system, t0, x0) +
                lth_system_energy(system, s->t, s->x) - lth_system_energy(system, t0, s->x));
}

double lth_work_of_held(LthSimulation *s, const double *x0, double share) {
  const LthSystem *system = s->system;
  double work = 0, *last = s->held_force;
  for (LitheCount i = 0; system->has_held && i < s->n; i++) {
    if (!system->held[i]) continue;
    double force = -s->force[i];
    work += (force + share * (*last - force)) * (s->x[i] - x0[i]);
    *last++ = force;
  }
  return work;
}

LitheStatus lth_work_of_step(LitheCtx *ctx, LthSimulation *s, double t0, double share) {
  const LthStage *g = &s->stage;
  const double *x0 = g->x_start, *unused;
  double way = 0;
  s->report.work += lth_work_of_weak(s, t0, x0);
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++)
    if (s->system->held[i]) way = fmax(way, fabs(s->x[i] - x0[i]));
  if (way == 0) return LITHE_OK;
  LITHE_TRY(lth_simulation_imbalance(ctx, s, &unused));
  s->report.work += lth_work_of_held(s, x0, share);
  lth_step_combine(ctx, s, 1, g->H * g->H, g->H); // the matrix that owners look at
  if (!s->own) lth_system_hold(ctx, s->system, s->A);
  return LITHE_OK;
}
