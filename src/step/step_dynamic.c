/// One linearly implicit Euler step (Kaufmann et al. 2009, sections 4.2 and 6; docs/theory/stepping.md).
#include "base/tensor.h"
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// base = M v0 + h force, equation (1).
static void momentum_balance(LthSimulation *s, double h) {
  lth_system_apply_mass(s->system, s->v, s->base);
  for (LitheCount i = 0; i < s->n; i++) s->base[i] += h * s->force[i];
}

/// Damping acts on the strain rate only: constraints that move carry the damped forces with them,
/// base += b (f0(t + h) - f0(t)).
static void damp_moving_constraints(LthSimulation *s) {
  const LthSystem *system = s->system;
  double any = 0;
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    any = fmax(any, system->bodies[b].damping_stiffness);
  if (any == 0) return;
  lth_system_assemble_load(s->system, s->t, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->base[i] += system->bodies[b].damping_stiffness * (s->f0[i] - s->scratch[i]);
}

/// T^T A T for the three translations T of some rows; `size` is the sum of the absolute terms.
static void translation_matrix(const LthSimulation *s, LitheIndex first, LitheIndex last,
                               double E[9], double *size) {
  const LthBlockMatrix *A = s->A;
  memset(E, 0, 9 * sizeof *E);
  *size = 0;
  for (LitheIndex row = first; row < last; row++)
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

/// Bodies [first, last) that move together, and what of their momentum a step leaves out.
typedef struct Group {
  LitheIndex first, last;
  double inertia; // of the system matrix under a translation: sum of cm mass
  double missing[3];
} Group;

/// True where nothing but inertia resists translations, so that momentum is kept. Found once: which
/// constraints there are does not change.
static bool is_free(LthSimulation *s, const Group *g) {
  const LitheIndex *rows = s->system->row_first;
  if (s->freedom[g->first] == 0) {
    double E[9], size, rest = 0;
    translation_matrix(s, rows[g->first], rows[g->last], E, &size);
    for (int k = 0; k < 9; k++) rest = fmax(rest, fabs(E[k] - (k % 4 == 0 ? g->inertia : 0)));
    s->freedom[g->first] = rest <= 1e-11 * size ? 1 : -1;
  }
  return s->freedom[g->first] > 0;
}

/// Momentum that (1 + h a) P1 = P0 + h F asks for and the solution has not. `change` is M v0 + h F less the inertia
/// of the solution, per unknown.
static void add_missing(const LthSimulation *s, const double *change, Group *g) {
  const LthSystem *system = s->system;
  for (LitheIndex b = g->first; b < g->last; b++)
    for (LitheCount i = system->dof_first[b] / 3; i < system->dof_first[b + 1] / 3; i++) {
      if (system->one[i] == 0) continue;
      lth_v3_axpy(system->one[i], change + 3 * i, g->missing);
      g->inertia += s->cm[b] * system->one[i] * s->row_mass[i];
    }
}

/// Where bodies are free their momentum is known beforehand, (1 + h a) P1 = P0 + h F: a translation takes away
/// what rounding and the solver's tolerance leave. (As a step of the solver it is the exact solution in
/// the space of translations T, where T^T A T = (1 + h a) m.)
static void balance_momentum(LthSimulation *s, double h) {
  const LthSystem *system = s->system;
  if (system->has_held || s->contact_on) return;
  double *change = s->scratch, *inertia = s->rhs;
  lth_system_apply_mass(system, s->v, change);
  lth_system_apply_mass(system, s->solution, inertia);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      change[i] += h * s->f_ext[i] - s->cm[b] * inertia[i];
  bool coupled = system->n_couplings > 0;
  for (LitheIndex b = 0; b < system->n_bodies; b = coupled ? system->n_bodies : b + 1) {
    Group g = {.first = b, .last = coupled ? system->n_bodies : b + 1};
    add_missing(s, change, &g);
    if (!is_free(s, &g)) continue;
    for (LitheCount i = system->dof_first[g.first] / 3; i < system->dof_first[g.last] / 3; i++)
      lth_v3_axpy(system->one[i] / g.inertia, g.missing, s->solution + 3 * i);
  }
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
  const double t1 = s->t + dt;
  LitheIndex n_active = 0;
  if (!(dt > 0) || !isfinite(dt))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "time.step: expected a positive number of seconds, got %g",
               dt);
  if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");

  LITHE_TRY(lth_step_assemble(ctx, s, t1));
  momentum_balance(s, dt);
  damp_moving_constraints(s);
  LITHE_TRY(lth_step_drive(ctx, s, t1, dt));
  lth_step_combine(ctx, s, 1, dt * dt, dt);
  lth_step_constrain(ctx, s);
  LITHE_TRY(lth_step_detect(ctx, s, s->t, dt, &n_active));
  LITHE_TRY(lth_step_choose(ctx, s, false));
  LITHE_TRY(lth_step_factor_lagged(ctx, s, dt));

  memcpy(s->solution, s->v, sizeof *s->v * (size_t)s->n);
  LITHE_TRY(lth_step_solve(ctx, s, s->options.tolerance));
  lth_step_tally(s);
  balance_momentum(s, dt);
  move(s, dt);
  s->t = t1;
  s->report.newton_iterations = 1;
  lth_step_contact_report(s);
  return LITHE_OK;
}
