/// Time integrators: each prepares an implicit stage, and takes its solution over (docs/theory/stepping.md).
///
/// Implicit Euler as Kaufmann et al. 2009, sections 4.2 and 6; BDF2 with variable steps as Hairer, Norsett,
/// Wanner, Solving Ordinary Differential Equations I, III.5; Newmark 1959 with beta = 1/4, gamma = 1/2.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// Velocity of held unknowns at t1, of second order, from three places of their prescribed motion in the step.
/// Other entries stay.
static LitheStatus held_velocity(LthSimulation *s, double t1, double h, double *v) {
  static const double weight[] = {3, -4, 1};
  const LthSystem *system = s->system;
  if (!system->has_held) return LITHE_OK;
  for (LitheCount i = 0; i < s->n; i++)
    if (system->held[i]) v[i] = 0;
  for (int k = 0; k < 3; k++) {
    memcpy(s->scratch, s->x, sizeof *s->x * (size_t)s->n);
    LITHE_TRY(lth_system_prescribe(system, t1 - 0.5 * k * h, s->scratch));
    for (LitheCount i = 0; i < s->n; i++)
      if (system->held[i]) v[i] += weight[k] / h * s->scratch[i];
  }
  return LITHE_OK;
}

static void prepare_euler(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  g->H = dt;
  g->is_second_order = false;
  memcpy(g->x_hat, s->x, sizeof *s->x * (size_t)s->n);
  memcpy(g->v_hat, s->v, sizeof *s->v * (size_t)s->n);
  memcpy(s->solution, s->v, sizeof *s->v * (size_t)s->n);
}

/// x1 = x0 + a (x0 - x_old) + H v1 with w = h / h_old, a = w^2 / (1 + 2 w), H = h (1 + w) / (1 + 2 w).
static void prepare_bdf2(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  double w = dt / g->h_old, a = w * w / (1 + 2 * w);
  g->H = dt * (1 + w) / (1 + 2 * w);
  g->ahead = a * g->h_old; // nearly
  g->is_second_order = true;
  for (LitheCount i = 0; i < s->n; i++) {
    g->x_hat[i] = s->x[i] + a * (s->x[i] - g->x_old[i]);
    g->v_hat[i] = s->v[i] + a * (s->v[i] - g->v_old[i]);
    s->solution[i] = s->v[i] + w * (s->v[i] - g->v_old[i]);
  }
}

/// The trapezoidal rule: a half step with the rates of the start, a half step with those of the end. Contact acts
/// with the forces of the end for the whole step: half of those of the start would throw bodies off.
static void prepare_newmark(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  g->H = g->ahead = 0.5 * dt;
  g->contact_weight = 2;
  g->is_second_order = true;
  for (LitheCount i = 0; i < s->n; i++) {
    g->x_hat[i] = s->x[i] + g->H * s->v[i];
    g->v_hat[i] = s->v[i];
    s->solution[i] = s->v[i] + (s->mass[i] > 0 ? dt * g->f_old[i] / s->mass[i] : 0);
  }
}

/// All forces but contact's that a run starts with.
static LitheStatus find_start_force(LitheCtx *ctx, LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  const LthSystem *system = s->system;
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  memcpy(g->f_start, s->f_ext, sizeof *s->f_ext * (size_t)s->n);
  lth_fade_begin(s);
  lth_rigid_prepare(s, s->x);
  lth_system_apply_mass(system, s->v, s->rhs);
  lth_step_apply(s, lth_threads(ctx), s->v, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      g->f_old[i] = s->force[i] - system->bodies[b].damping_mass * s->rhs[i] -
                    system->bodies[b].damping_stiffness * s->scratch[i];
  lth_rigid_spare(s, 1, s->v, g->f_old);
  if (lth_stage_has_stiffness_damping(system)) { // + b f0', by differences within the first step
    lth_stage_add_damped_load(s, -3 / dt, s->t, s->f0, g->f_old);
    lth_stage_add_damped_load(s, 4 / dt, s->t + 0.5 * dt, NULL, g->f_old);
    lth_stage_add_damped_load(s, -1 / dt, s->t + dt, NULL, g->f_old);
  }
  lth_system_zero_held(system, g->f_old);
  return LITHE_OK;
}

/// Inertia of held unknowns, where it reaches free ones, is that of their true velocity at the end: what the stage
/// calls v1 only leads to the right place.
static LitheStatus correct_held_inertia(LitheCtx *ctx, LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  if (!g->is_second_order || !s->system->has_held) return LITHE_OK;
  LITHE_TRY(lth_step_drive(ctx, s, g->t1, g->H, g->x_hat));
  LITHE_TRY(held_velocity(s, g->t1, dt, g->v_last));
  for (LitheCount i = 0; i < s->n; i++)
    if (s->system->held[i]) g->v_hat[i] += s->driven[i] - g->v_last[i];
  return LITHE_OK;
}

static LitheStatus prepare(LitheCtx *ctx, LthSimulation *s, LthIntegrator kind, double dt) {
  LthStage *g = &s->stage;
  g->t1 = s->t + dt;
  g->contact_weight = 1;
  g->ahead = 0;
  g->iterates = kind != LTH_IMPLICIT_EULER;
  if (kind == LTH_NEWMARK && !g->has_old) LITHE_TRY(find_start_force(ctx, s, dt));
  if (kind == LTH_NEWMARK)
    prepare_newmark(s, dt);
  else if (kind == LTH_BDF2 && g->has_old)
    prepare_bdf2(s, dt);
  else
    prepare_euler(s, dt);
  LITHE_TRY(correct_held_inertia(ctx, s, dt));
  lth_system_apply_mass(s->system, g->v_hat, g->p);
  for (LitheCount i = 0; kind == LTH_NEWMARK && i < s->n; i++) g->p[i] += g->H * g->f_old[i];
  return LITHE_OK;
}

/// What the next step needs of this one, before v is replaced.
static void remember(LitheCtx *ctx, LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  if (s->options.integrator == LTH_BDF2) {
    memcpy(g->x_old, g->x_start, bytes);
    memcpy(g->v_old, s->v, bytes);
  }
  if (s->options.integrator == LTH_NEWMARK) { // H F1 = M v1 - p + (base - A v1)
    lth_step_defect(ctx, s, s->scratch);
    lth_system_apply_mass(s->system, s->solution, s->rhs);
    for (LitheCount i = 0; i < s->n; i++)
      g->f_old[i] = (s->rhs[i] - g->p[i] + s->scratch[i]) / g->H;
    lth_system_zero_held(s->system, g->f_old);
  }
  g->h_old = dt;
  g->has_old = true;
}

/// x1 = x^ + H v1, and the work of the external forces on the way: the end's forces for Euler, which is of
/// first order, the mean of both ends for the others.
static LitheStatus move(LthSimulation *s, double dt) {
  const LthStage *g = &s->stage;
  double work = 0, share = g->is_second_order ? 0.5 : 0;
  for (LitheCount i = 0; i < s->n; i++) {
    s->v[i] = s->solution[i];
    s->x[i] = g->x_hat[i] + g->H * s->v[i];
    double f = s->f_ext[i] + share * (g->f_start[i] - s->f_ext[i]);
    work += f * (s->x[i] - g->x_start[i]);
  }
  s->report.work += work;
  return g->is_second_order ? held_velocity(s, g->t1, dt, s->v) : LITHE_OK;
}

/// Where rotations do not settle, as in elements that are pressed flat and whose rotation jumps, the step is that of
/// implicit Euler: one linear system, which always has a solution, and loses energy. Newmark's rule begins anew after it.
static LitheStatus take_frozen(LitheCtx *ctx, LthSimulation *s, double dt) {
  LitheIndex linear = s->report.linear_iterations;
  bool ended;
  if (s->report.frozen_steps++ == 0)
    lth_warn(
        ctx,
        "the iteration over the elements' rotations does not end in the step that begins at t = "
        "%.6g s: this and others like it are taken with the rotations of their start, as by "
        "`implicit-euler`; `solver.frozen_steps` in result.json counts them",
        s->t);
  memcpy(s->x, s->stage.x_start, sizeof *s->x * (size_t)s->n);
  lth_step_contact_begin_again(s);
  LITHE_TRY(prepare(ctx, s, LTH_IMPLICIT_EULER, dt));
  LITHE_TRY(lth_stage_solve(ctx, s, &ended));
  s->report.linear_iterations += linear;
  return LITHE_OK;
}

LitheStatus lth_simulation_step(LitheCtx *ctx, LthSimulation *s, double dt) {
  bool ended;
  if (!(dt > 0) || !isfinite(dt))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "time.step: expected a positive number of seconds, got %g",
               dt);
  if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
  LITHE_TRY(lth_stage_begin(ctx, s));
  LitheStatus status =
      prepare(ctx, s, s->stage.settles ? LTH_NEWTON_EULER : s->options.integrator, dt);
  if (status == LITHE_OK) status = lth_stage_solve(ctx, s, &ended);
  if (status == LITHE_OK && !ended) status = take_frozen(ctx, s, dt);
  if (status != LITHE_OK) {
    memcpy(s->x, s->stage.x_start, sizeof *s->x * (size_t)s->n);
    return status;
  }
  lth_stage_balance(s, dt);
  remember(ctx, s, dt);
  s->stage.settles = !ended && s->options.integrator == LTH_NEWMARK;
  LITHE_TRY(move(s, dt));
  double t0 = s->t;
  s->t = s->stage.t1;
  LITHE_TRY(lth_work_of_step(ctx, s, t0, s->stage.is_second_order ? 0.5 : 0));
  lth_step_contact_report(s);
  return LITHE_OK;
}
