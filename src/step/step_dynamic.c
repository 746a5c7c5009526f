/// Time integrators: each prepares an implicit stage, and takes its solution over (docs/theory/stepping.md).
///
/// Implicit Euler as Kaufmann et al. 2009, sections 4.2 and 6; BDF2 with variable steps as Hairer, Norsett,
/// Wanner, Solving Ordinary Differential Equations I, III.5; Newmark 1959 with beta = 1/4, gamma = 1/2.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// Velocity (order 1) or acceleration (order 2) of held unknowns at t1, of second order, from three or four places
/// of their prescribed motion in [t1 - h, t1]; h < 0: in [t1, t1 - h]. Other entries stay.
static LitheStatus held_rate(LthSimulation *s, double t1, double h, int order, double *rate) {
  static const double first[] = {1.5, -2, 0.5}, second[] = {2, -5, 4, -1};
  const LthSystem *system = s->system;
  const int n = order == 1 ? 3 : 4;
  const double *weight = order == 1 ? first : second, step = h / (n - 1);
  if (!system->has_held) return LITHE_OK;
  for (LitheCount i = 0; i < s->n; i++)
    if (system->held[i]) rate[i] = 0;
  for (int k = 0; k < n; k++) {
    memcpy(s->scratch, s->x, sizeof *s->x * (size_t)s->n);
    LITHE_TRY(lth_system_prescribe(system, t1 - k * step, s->scratch));
    for (LitheCount i = 0; i < s->n; i++)
      if (system->held[i]) rate[i] += weight[k] / (order == 1 ? step : step * step) * s->scratch[i];
  }
  return LITHE_OK;
}

/// Start values of the step's own unknowns: v1 as it would come out if nothing happened.
static void guess(LthSimulation *s, double weight, const double *rate) {
  for (LitheCount i = 0; i < s->n; i++) s->solution[i] = s->v[i] + (rate ? weight * rate[i] : 0);
}

static void prepare_euler(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  g->H = dt;
  g->is_second_order = false;
  memcpy(g->x_hat, s->x, sizeof *s->x * (size_t)s->n);
  memcpy(g->v_hat, s->v, sizeof *s->v * (size_t)s->n);
  guess(s, 0, NULL);
}

/// x1 = x0 + a (x0 - x_old) + H v1 with w = h / h_old, a = w^2 / (1 + 2 w), H = h (1 + w) / (1 + 2 w).
static void prepare_bdf2(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  double w = dt / g->h_old, a = w * w / (1 + 2 * w);
  g->H = dt * (1 + w) / (1 + 2 * w);
  g->is_second_order = true;
  for (LitheCount i = 0; i < s->n; i++) {
    g->x_hat[i] = s->x[i] + a * (s->x[i] - g->x_old[i]);
    g->v_hat[i] = s->v[i] + a * (s->v[i] - g->v_old[i]);
    s->solution[i] = s->v[i] + w * (s->v[i] - g->v_old[i]);
  }
}

/// The trapezoidal rule: a half step with the rates of the start, a half step with those of the end.
static void prepare_newmark(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  g->H = 0.5 * dt;
  g->is_second_order = true;
  for (LitheCount i = 0; i < s->n; i++) {
    g->x_hat[i] = s->x[i] + g->H * s->v[i];
    g->v_hat[i] = s->v[i] + g->H * g->v_old[i];
  }
  guess(s, dt, g->v_old);
}

static void apply_mass(const void *self, int threads, const double *x, double *y) {
  const LthSimulation *s = self;
  (void)threads;
  lth_system_apply_mass(s->system, x, y);
  if (s->system->has_held) lth_system_zero_held(s->system, y);
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++)
    if (s->system->held[i]) y[i] = x[i];
}

/// The acceleration that a run starts with: M a = F(x, v), contact not among the forces.
static LitheStatus start_acceleration(LitheCtx *ctx, LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  const LthSystem *system = s->system;
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  memcpy(g->f_start, s->f_ext, sizeof *s->f_ext * (size_t)s->n);
  lth_rigid_prepare(s, s->x);
  lth_system_apply_mass(system, s->v, s->rhs);
  lth_block_matrix_apply(s->A, lth_threads(ctx), s->v, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->rhs[i] = s->force[i] - system->bodies[b].damping_mass * s->rhs[i] -
                  system->bodies[b].damping_stiffness * s->scratch[i];
  lth_rigid_spare(s, 1, s->v, s->rhs);
  if (lth_stage_has_stiffness_damping(system)) { // + b f0', by differences within the first step
    lth_stage_add_damped_load(s, -3 / dt, s->t, s->f0, s->rhs);
    lth_stage_add_damped_load(s, 4 / dt, s->t + 0.5 * dt, NULL, s->rhs);
    lth_stage_add_damped_load(s, -1 / dt, s->t + dt, NULL, s->rhs);
  }
  memset(g->v_old, 0, sizeof *g->v_old * (size_t)s->n);
  LITHE_TRY(held_rate(s, s->t, -dt, 2, g->v_old));
  lth_system_apply_mass(system, g->v_old, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->rhs[i] -= s->scratch[i];
  lth_system_zero_held(system, s->rhs);
  memset(s->solution, 0, sizeof *s->solution * (size_t)s->n);
  LthOperator M = {.n = s->n, .apply = apply_mass, .self = s};
  LthSolveReport r = lth_cg_solve(s->cg, lth_threads(ctx), &M, NULL, s->rhs, s->solution,
                                  s->options.tolerance, s->options.max_iterations);
  s->report.converged &= r.converged;
  for (LitheCount i = 0; i < s->n; i++) g->v_old[i] += s->solution[i];
  return LITHE_OK;
}

static LitheStatus prepare(LitheCtx *ctx, LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  LthIntegrator kind = s->options.integrator;
  g->t1 = s->t + dt;
  g->iterates = kind != LTH_IMPLICIT_EULER;
  if (kind == LTH_NEWMARK && !g->has_old) LITHE_TRY(start_acceleration(ctx, s, dt));
  if (kind == LTH_NEWMARK)
    prepare_newmark(s, dt);
  else if (kind == LTH_BDF2 && g->has_old)
    prepare_bdf2(s, dt);
  else
    prepare_euler(s, dt);

  // inertia of held unknowns, where it reaches free ones, is that of the motion that is prescribed
  if (g->is_second_order && s->system->has_held) {
    LITHE_TRY(lth_step_drive(ctx, s, g->t1, g->H, g->x_hat)); // v1 of them in the stage
    LITHE_TRY(held_rate(s, g->t1, dt, 2, g->v_hat));
    for (LitheCount i = 0; i < s->n; i++)
      if (s->system->held[i]) g->v_hat[i] = s->driven[i] - g->H * g->v_hat[i];
  }
  lth_system_apply_mass(s->system, g->v_hat, g->p);
  return LITHE_OK;
}

/// What the next step needs of this one, before v is replaced.
static LitheStatus remember(LthSimulation *s, double dt) {
  LthStage *g = &s->stage;
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  if (s->options.integrator == LTH_BDF2) {
    memcpy(g->x_old, g->x_start, bytes);
    memcpy(g->v_old, s->v, bytes);
  }
  if (s->options.integrator == LTH_NEWMARK) {
    for (LitheCount i = 0; i < s->n; i++) g->v_old[i] = (s->solution[i] - g->v_hat[i]) / g->H;
    LITHE_TRY(held_rate(s, g->t1, dt, 2, g->v_old));
  }
  g->h_old = dt;
  g->has_old = true;
  return LITHE_OK;
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
  return g->is_second_order ? held_rate(s, g->t1, dt, 1, s->v) : LITHE_OK;
}

LitheStatus lth_simulation_step(LitheCtx *ctx, LthSimulation *s, double dt) {
  if (!(dt > 0) || !isfinite(dt))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "time.step: expected a positive number of seconds, got %g",
               dt);
  if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
  LITHE_TRY(lth_stage_begin(ctx, s));
  LitheStatus status = prepare(ctx, s, dt);
  if (status == LITHE_OK) status = lth_stage_solve(ctx, s);
  if (status != LITHE_OK) {
    memcpy(s->x, s->stage.x_start, sizeof *s->x * (size_t)s->n);
    return status;
  }
  lth_stage_balance(s, dt);
  LITHE_TRY(remember(s, dt));
  LITHE_TRY(move(s, dt));
  s->t = s->stage.t1;
  lth_step_contact_report(s);
  return LITHE_OK;
}
