/// One implicit stage: the nonlinear system that every integrator solves in a step (docs/theory/stepping.md).
///
///   M v1 = M v^ + H F(x^ + H v1, v1),   x1 = x^ + H v1
///
/// With rotations frozen it is linear. Fixed point over rotations with a line search on the residual's norm:
/// the energy with frozen rotations is no merit function.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

#define ROUNDING (64 * 0x1p-53)
#define INNER 0.03 // residual that a solve is asked for, over the one before it
#define INNER_MAX 1e-3
#define CONTACT_SOLVES 2 // of a step in which contact is revised
#define DROPS 20         // times that points are left out of a step
#define SUFFICIENT 1e-4  // part of the promised fall of the residual that a step must deliver
#define HALVINGS 4

static LitheStatus allocate(LitheCtx *ctx, LthSimulation *s) {
  LthStage *g = &s->stage;
  if (g->x_hat) return LITHE_OK;
  double **vectors[] = {&g->x_hat,   &g->v_hat, &g->p,     &g->v_last, &g->x_start,
                        &g->f_start, &g->x_old, &g->v_old, &g->f_old};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) LTH_NEW(ctx, *vectors[i], s->n);
  return LITHE_OK;
}

LitheStatus lth_stage_begin(LitheCtx *ctx, LthSimulation *s) {
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  LITHE_TRY(allocate(ctx, s));
  memcpy(s->stage.x_start, s->x, bytes);
  memcpy(s->stage.f_start, s->f_ext, bytes);
  lth_fade_begin(s);
  return lth_rigid_find(ctx, s);
}

void lth_stage_free(LitheCtx *ctx, LthStage *g) {
  double *vectors[] = {g->x_hat,   g->v_hat, g->p,     g->v_last, g->x_start,
                       g->f_start, g->x_old, g->v_old, g->f_old};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) lth_free(ctx, vectors[i]);
}

bool lth_stage_has_stiffness_damping(const LthSystem *system) {
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (system->bodies[b].damping_stiffness != 0) return true;
  return false;
}

void lth_stage_add_damped_load(LthSimulation *s, double weight, double t, const double *f0,
                               double *y) {
  const LthSystem *system = s->system;
  if (!f0) lth_system_assemble_load(s->system, t, s->scratch);
  if (!f0) f0 = s->scratch;
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      y[i] += weight * system->bodies[b].damping_stiffness * f0[i];
}

/// Damping acts on the strain rate only: constraints that move carry the damped forces with them, base += H b f0'.
/// The rate is that of the stage: over H of first order, or from three times of second order.
static void damp_moving_constraints(LthSimulation *s) {
  const LthStage *g = &s->stage;
  if (!lth_stage_has_stiffness_damping(s->system)) return;
  lth_stage_add_damped_load(s, g->is_second_order ? 3 : 1, g->t1, s->f0, s->base);
  if (g->is_second_order) lth_stage_add_damped_load(s, -4, g->t1 - 0.5 * g->H, NULL, s->base);
  lth_stage_add_damped_load(s, g->is_second_order ? 1 : -1, g->t1 - g->H, NULL, s->base);
}

/// Matrix and right-hand side with the rotations of s->x: A v1 = base (+ contact).
static LitheStatus linearize(LitheCtx *ctx, LthSimulation *s) {
  const LthStage *g = &s->stage;
  LITHE_TRY(lth_step_assemble(ctx, s, g->t1, g->x_hat));
  for (LitheCount i = 0; i < s->n; i++) s->base[i] = g->p[i] + g->H * s->force[i];
  damp_moving_constraints(s);
  lth_step_combine(ctx, s, 1, g->H * g->H, g->H);
  lth_step_constrain(ctx, s);
  return LITHE_OK;
}

static LitheStatus solve_as_chosen(LitheCtx *ctx, LthSimulation *s, double tolerance) {
  LITHE_TRY(lth_step_choose(ctx, s, false));
  LITHE_TRY(lth_step_factor_lagged(ctx, s, s->stage.H));
  LITHE_TRY(lth_step_solve(ctx, s, tolerance));
  lth_step_tally(s);
  return LITHE_OK;
}

/// Where what `auto` took does not come to the tolerance - conjugate gradients beside thin pieces, which a step's mass holds
/// little - another solver goes on from there.
static LitheStatus solve(LitheCtx *ctx, LthSimulation *s, double tolerance) {
  const bool before = s->report.converged;
  LITHE_TRY(solve_as_chosen(ctx, s, tolerance));
  while (before && !s->report.converged && lth_step_has_other_way(s)) {
    s->report.converged = true;
    LITHE_TRY(solve_as_chosen(ctx, s, tolerance));
  }
  s->report.newton_iterations++;
  return LITHE_OK;
}

/// Points in contact from where the stage starts.
static LitheStatus detect(LitheCtx *ctx, LthSimulation *s) {
  const LthStage *g = &s->stage;
  LitheIndex n_active = 0;
  memcpy(s->x, g->x_hat, sizeof *s->x * (size_t)s->n);
  return lth_step_detect(ctx, s, LTH_LOOK_STEP, g->t1 - g->H, g->H, g->contact_weight, g->ahead,
                         &n_active);
}

/// s->x = x^ + H solution, linearized there, and how far the solution is from solving that.
static LitheStatus evaluate(LitheCtx *ctx, LthSimulation *s, double *residual, double *target) {
  const LthStage *g = &s->stage;
  double scale;
  for (LitheCount i = 0; i < s->n; i++) s->x[i] = g->x_hat[i] + g->H * s->solution[i];
  LITHE_TRY(linearize(ctx, s));
  lth_step_residual(ctx, s, residual, &scale);
  double floor =
      ROUNDING * (g->H * lth_step_norm(ctx, s->n, s->f0) + lth_step_norm(ctx, s->n, g->p));
  *target = fmax(s->options.newton_tolerance * scale, floor);
  s->report.residual = scale > 0 ? *residual / scale : *residual;
  if (!isfinite(*residual))
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
               "the solution is no longer finite at t = %g s: take smaller steps or a softer load",
               s->t);
  return LITHE_OK;
}

/// From v_last towards the solution of the linear system, by halves until the residual falls.
static LitheStatus search_line(LitheCtx *ctx, LthSimulation *s, double *residual, double *target) {
  const double *last = s->stage.v_last, before = *residual;
  double part = 1;
  LITHE_TRY(evaluate(ctx, s, residual, target));
  for (int i = 0; i<HALVINGS && * residual> * target; i++) {
    if (*residual <= (1 - SUFFICIENT * part) * before) return LITHE_OK;
    part *= 0.5;
    for (LitheCount k = 0; k < s->n; k++) s->solution[k] = 0.5 * (last[k] + s->solution[k]);
    LITHE_TRY(evaluate(ctx, s, residual, target));
  }
  return LITHE_OK;
}

/// Linear solves are as good as the residual before them makes worth while.
static double inner_tolerance(const LthSimulation *s, double residual, double target) {
  if (!s->system->is_nonlinear) return s->options.tolerance;
  return fmin(s->options.newton_tolerance * fmax(0.3, INNER * residual / target), INNER_MAX);
}

/// Solves and line searches from solve `it` on until the residual is below its target.
static LitheStatus approach(LitheCtx *ctx, LthSimulation *s, LitheIndex *it, bool *ended) {
  double residual, target;
  LITHE_TRY(evaluate(ctx, s, &residual, &target));
  for (bool first = true; first || residual > target; first = false, ++*it) {
    if (*it >= s->options.newton_iterations) {
      *ended = false;
      break;
    }
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    memcpy(s->stage.v_last, s->solution, sizeof *s->solution * (size_t)s->n);
    LitheIndex linear = s->report.linear_iterations;
    s->contact_stands = *it >= CONTACT_SOLVES;
    LITHE_TRY(solve(ctx, s, inner_tolerance(s, residual, target)));
    s->report.linear_iterations += linear;
    if (!s->system->is_nonlinear) break;
    LITHE_TRY(search_line(ctx, s, &residual, &target));
  }
  return LITHE_OK;
}

/// Rotations and followers iterated until the residual is below newton_tolerance. Contact is revised in the first
/// solves, as in a linear step, and stands in the others: friction's secants would never settle to so many digits. Points that pull in the end and
/// make energy by that are left out, and the iteration goes on.
static LitheStatus iterate(LitheCtx *ctx, LthSimulation *s, bool *ended) {
  LitheIndex it = 0;
  LITHE_TRY(detect(ctx, s));
  s->report.linear_iterations = 0;
  for (int drops = 0; *ended; drops++) {
    LITHE_TRY(approach(ctx, s, &it, ended));
    if (s->contact_stands)
      lth_step_contact_revise(s, s->solution); // what the next step starts from
    if (!lth_step_contact_drop_pulls(s)) break;
    if (drops == DROPS) *ended = false;
    it = it < CONTACT_SOLVES ? CONTACT_SOLVES : it;
  }
  return LITHE_OK;
}

/// The one system of a step that does not iterate, once more without points that pull and make energy by that.
static LitheStatus solve_once(LitheCtx *ctx, LthSimulation *s) {
  LitheIndex linear = 0;
  for (int drops = 0;; drops++) {
    LITHE_TRY(solve(ctx, s, s->options.tolerance));
    linear += s->report.linear_iterations;
    s->report.linear_iterations = linear;
    if (drops == DROPS || !lth_step_contact_drop_pulls(s)) return LITHE_OK;
  }
}

LitheStatus lth_stage_solve(LitheCtx *ctx, LthSimulation *s, bool *ended) {
  *ended = true;
  s->report.newton_iterations = 0;
  s->contact_stands = false;
  s->rigid.H = s->stage.H;
  lth_rigid_prepare(s, s->stage.x_hat);
  LITHE_TRY(lth_step_drive(ctx, s, s->stage.t1, s->stage.H, s->stage.x_hat));
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++)
    if (s->system->held[i]) s->solution[i] = s->driven[i];
  if (s->stage.iterates) return iterate(ctx, s, ended);
  memcpy(s->x, s->stage.x_hat, sizeof *s->x * (size_t)s->n);
  LITHE_TRY(linearize(ctx, s));
  LITHE_TRY(detect(ctx, s));
  return solve_once(ctx, s);
}
