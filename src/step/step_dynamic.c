/// One linearly implicit Euler step (Kaufmann et al. 2009, sections 4.2 and 6; docs/theory/stepping.md).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// base = M v0 + h force, equation (1).
static void momentum_balance(LthSimulation *s, double h) {
  for (LitheCount i = 0; i < s->n; i++) s->base[i] = s->mass[i / 3] * s->v[i] + h * s->force[i];
}

/// Damping acts on the strain rate only: constraints that move carry the damped forces with them,
/// base += b (f0(t + h) - f0(t)).
static void damp_moving_constraints(LthSimulation *s) {
  double b = s->body.damping_stiffness;
  if (b == 0) return;
  lth_dg_assemble_load(s->body.op, s->t, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->base[i] += b * (s->f0[i] - s->scratch[i]);
}

static LitheStatus find_contacts(LitheCtx *ctx, LthSimulation *s, double h) {
  LitheIndex n_active = 0;
  s->contact_on = false;
  if (!s->body.contact) return LITHE_OK;
  lth_simulation_displacement(s);
  LITHE_TRY(lth_contact_detect(ctx, s->body.contact, s->t, h, s->u, s->v, &n_active));
  s->contact_on = n_active > 0;
  return LITHE_OK;
}

static void report_contacts(LthSimulation *s) {
  double force;
  if (s->body.contact)
    lth_contact_report(s->body.contact, &s->report.contacts, &s->report.penetration, &force);
}

/// T^T A T for the three translations T; `size` is the sum of the absolute terms.
static void translation_matrix(const LthSimulation *s, double E[9], double *size) {
  const LthBlockMatrix *A = s->A;
  memset(E, 0, 9 * sizeof *E);
  *size = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      LitheIndex col = A->block_col[e];
      const LitheCount n = A->row_off[col + 1] - A->row_off[col];
      for (int k = 0; k < 9; k++) {
        double value = A->values[A->value_off[e] + k / 3 * n + k % 3];
        E[k] += value;
        *size += fabs(value);
      }
    }
}

/// True where nothing but inertia resists translations, so that momentum is kept. Found once: which
/// constraints there are does not change.
static bool is_free(LthSimulation *s, double inertia) {
  if (s->freedom == 0) {
    double E[9], size, rest = 0;
    translation_matrix(s, E, &size);
    for (int k = 0; k < 9; k++) rest = fmax(rest, fabs(E[k] - (k % 4 == 0 ? inertia : 0)));
    s->freedom = rest <= 1e-11 * size ? 1 : -1;
  }
  return s->freedom > 0;
}

/// Where a body is free its momentum is known beforehand, (1 + h a) P1 = P0 + h F: a translation takes away
/// what rounding and the solver's tolerance leave. (As a step of the solver it is the exact solution in
/// the space of translations T, where T^T A T = (1 + h a) m.)
static void balance_momentum(LthSimulation *s, double h) {
  const LthDgSpace *space = s->body.space;
  const double cm = 1 + h * s->body.damping_mass;
  double total = 0, missing[3] = {0};
  if (s->has_strong || s->contact_on) return;
  for (LitheIndex cell = 0; cell < space->n_cells; cell++) {
    double m = s->mass[space->func_off[cell]];
    total += m;
    for (int a = 0; a < 3; a++) {
      LitheCount i = lth_cell_first(s, cell) + a;
      missing[a] += m * (s->v[i] - cm * s->solution[i]) + h * s->f_ext[i];
    }
  }
  if (!is_free(s, cm * total)) return;
  for (LitheIndex cell = 0; cell < space->n_cells; cell++)
    for (int a = 0; a < 3; a++)
      s->solution[lth_cell_first(s, cell) + a] += missing[a] / (cm * total);
}

/// x1 = x0 + h v1, and the work of the external forces on the way.
static void move(LthSimulation *s, double h) {
  double work = 0;
  for (LitheCount i = 0; i < s->n; i++) {
    s->v[i] = s->solution[i];
    s->x[i] += h * s->v[i];
    work += s->f_ext[i] * h * s->v[i];
  }
  s->report.work += work;
}

LitheStatus lth_simulation_step(LitheCtx *ctx, LthSimulation *s, double dt) {
  const double cm = 1 + dt * s->body.damping_mass, ck = dt * dt + dt * s->body.damping_stiffness;
  const double t1 = s->t + dt;
  if (!(dt > 0) || !isfinite(dt))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "time.step: expected a positive number of seconds, got %g",
               dt);
  if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");

  LITHE_TRY(lth_step_assemble(ctx, s, t1));
  momentum_balance(s, dt);
  damp_moving_constraints(s);
  LITHE_TRY(lth_step_drive(ctx, s, t1, dt));
  lth_step_combine(ctx, s, cm, ck);
  lth_step_constrain(ctx, s);
  LITHE_TRY(find_contacts(ctx, s, dt));
  LITHE_TRY(lth_step_choose(ctx, s, false));
  LITHE_TRY(lth_step_factor_lagged(ctx, s, cm, ck));

  memcpy(s->solution, s->v, sizeof *s->v * (size_t)s->n);
  LITHE_TRY(lth_step_solve(ctx, s, s->options.tolerance));
  lth_step_tally(s);
  balance_momentum(s, dt);
  move(s, dt);
  s->t = t1;
  s->report.newton_iterations = 1;
  report_contacts(s);
  return LITHE_OK;
}
