/// The linear system of a step: assembly, prescribed cells, contact, the solve.
#include "step/simulation_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define ROUNDINGS 64           // of a residual that no solution betters
#define CONTACT_PASSES 8       // solves of one step while the contact set changes
#define CONTACT_TOLERANCE 1e-4 // while it does
#define SHARPER 0.03           // times the tolerance, where what is left makes energy ...
#define SHARPER_MAX 4          // ... so often

double lth_step_norm(const LitheCtx *ctx, LitheCount n, const double *y) {
  return sqrt(lth_dot(lth_threads(ctx), n, y, y));
}

LitheStatus lth_step_assemble(LitheCtx *ctx, LthSimulation *s, double t, const double *at) {
  double start = lth_now();
  lth_system_update_rotations(s->system, s->x);
  lth_step_volume_begin(s);
  LITHE_TRY(lth_fade_external_force(ctx, s, t));
  if (s->own) {
    s->cm[0] = 0;
    s->ck[0] = 1;
    s->own->force(s->system->bodies[0].disc, lth_threads(ctx), at, s->force);
  } else {
    lth_system_assemble(s->system, t, s->A, s->f0);
    lth_block_matrix_apply(s->A, lth_threads(ctx), at, s->force);
  }
  for (LitheCount i = 0; i < s->n; i++)
    s->force[i] = s->f_ext[i] + (s->f0 ? s->f0[i] : 0) - s->force[i];
  s->report.time_assemble += lth_now() - start;
  return LITHE_OK;
}

LitheStatus lth_step_drive(LitheCtx *ctx, LthSimulation *s, double t, double h,
                           const double *from) {
  (void)ctx;
  const LthSystem *system = s->system;
  if (!system->has_held) return LITHE_OK;
  memcpy(s->scratch, s->x, sizeof *s->x * (size_t)s->n);
  LITHE_TRY(lth_system_prescribe(system, t, s->scratch));
  for (LitheCount i = 0; i < s->n; i++)
    s->driven[i] = system->held[i] ? (s->scratch[i] - from[i]) / h : 0;
  return LITHE_OK;
}

void lth_step_combine(LitheCtx *ctx, LthSimulation *s, double cm, double ck, double h) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++) {
    s->cm[b] = cm * (1 + h * s->system->bodies[b].damping_mass);
    s->ck[b] = ck + h * s->system->bodies[b].damping_stiffness;
  }
  if (!s->own) lth_system_combine(ctx, s->system, s->cm, s->ck, s->A);
}

// Held unknowns keep a right-hand side and a guess of zero, so that they weigh nothing in the norms of
// the solver; their values are put in at the end.
void lth_step_constrain(LitheCtx *ctx, LthSimulation *s) {
  if (!s->system->has_held) return;
  lth_step_apply(s, lth_threads(ctx), s->driven, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->base[i] -= s->scratch[i];
  lth_system_zero_held(s->system, s->base);
  if (!s->own) lth_system_hold(ctx, s->system, s->A);
}

static void apply_bodies(const LthSimulation *s, int threads, const double *x, double *y) {
  lth_step_apply(s, threads, x, y);
  if (s->rigid.H > 0) lth_rigid_spare(s, -s->rigid.H, x, y);
}

/// What a body that is solved without a matrix does not know of: contact, and motions that damping spares.
static void apply_extra(const void *self, int threads, const double *x, double *y) {
  const LthSimulation *s = self;
  (void)threads;
  memset(y, 0, sizeof *y * (size_t)s->n);
  if (s->rigid.H > 0) lth_rigid_spare(s, -s->rigid.H, x, y);
  if (s->contact_on) lth_step_contact_apply(s, x, y);
  lth_system_zero_held(s->system, y);
}

void lth_step_apply_system(const LthSimulation *s, int threads, const double *x, double *y) {
  apply_bodies(s, threads, x, y);
  if (!s->contact_on) return;
  lth_step_contact_apply(s, x, y);
  lth_system_zero_held(s->system, y);
}

static void apply_system(const void *self, int threads, const double *x, double *y) {
  lth_step_apply_system(self, threads, x, y);
}

/// The factor as a preconditioner; operators cannot fail, so a failure is kept until the solve is over.
typedef struct Inverse {
  LitheCtx *ctx;
  const LthSimulation *s;
  LitheStatus *status;
} Inverse;

static void apply_factor(const void *self, int threads, const double *x, double *y) {
  const Inverse *inverse = self;
  (void)threads;
  LitheStatus status = inverse->s->engine->solve(inverse->ctx, inverse->s->factor, x, y);
  if (status == LITHE_OK) return;
  *inverse->status = status;
  memset(y, 0, sizeof *y * (size_t)inverse->s->n); // a direction without energy ends the iteration
}

/// rhs = base plus contact.
static void add_contact(LthSimulation *s) {
  memcpy(s->rhs, s->base, sizeof *s->rhs * (size_t)s->n);
  if (!s->contact_on) return;
  lth_step_contact_rhs(s, s->rhs);
  if (s->system->has_held) { // rhs -= C driven
    memset(s->scratch, 0, sizeof *s->scratch * (size_t)s->n);
    lth_step_contact_apply(s, s->driven, s->scratch);
    for (LitheCount i = 0; i < s->n; i++) s->rhs[i] -= s->scratch[i];
    lth_system_zero_held(s->system, s->rhs);
  }
}

void lth_step_residual(LitheCtx *ctx, LthSimulation *s, double *residual, double *scale) {
  double *r = s->scratch;
  add_contact(s);
  *scale = lth_step_norm(ctx, s->n, s->rhs);
  if (s->system->has_held) lth_system_zero_held(s->system, s->solution);
  apply_system(s, lth_threads(ctx), s->solution, r);
  for (LitheCount i = 0; i < s->n; i++) r[i] = s->rhs[i] - r[i];
  *residual = lth_step_norm(ctx, s->n, r);
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++) s->solution[i] += s->driven[i];
}

/// y -= H times the forces by which pressures have changed: f_int at the end has them.
static void subtract_pressures(LthSimulation *s, double *y) {
  bool any = false;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    any |= s->system->bodies[b].disc->table->volume != NULL;
  if (!any) return;
  memset(s->rhs, 0, sizeof *s->rhs * (size_t)s->n);
  lth_step_volume_push_change(s, s->rhs);
  for (LitheCount i = 0; i < s->n; i++) y[i] -= s->stage.H * s->rhs[i];
}

void lth_step_defect(LitheCtx *ctx, LthSimulation *s, double *y) {
  if (s->system->has_held) lth_system_zero_held(s->system, s->solution);
  apply_bodies(s, lth_threads(ctx), s->solution, y);
  for (LitheCount i = 0; i < s->n; i++) y[i] = s->base[i] - y[i];
  subtract_pressures(s, y);
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++) s->solution[i] += s->driven[i];
}

LitheStatus lth_step_solve_linear(LitheCtx *ctx, LthSimulation *s, double tolerance,
                                  LthSolveReport *report) {
  LitheStatus status = LITHE_OK;
  bool is_blocks = !s->contact_on && !(s->rigid.H > 0 && s->rigid.spares);
  if (s->own) {
    LthOperator extra = {.n = s->n, .apply = apply_extra, .self = s};
    return lth_step_solve_own(ctx, s, is_blocks ? NULL : &extra, tolerance, report);
  }
  if (s->solver == LTH_LINEAR_PCG && is_blocks) {
    *report = lth_reduction_solve(s->reduction, s->cg, lth_threads(ctx), s->rhs, s->solution,
                                  tolerance, s->options.max_iterations);
    return LITHE_OK;
  }
  Inverse inverse = {ctx, s, &status};
  LthOperator A = {.n = s->n, .apply = apply_system, .self = s};
  if (s->solver == LTH_LINEAR_MULTIGRID) {
    *report = lth_multilevel_solve(s->levels, s->cg, lth_threads(ctx), &A, s->rhs, s->solution,
                                   tolerance, s->options.max_iterations);
    return LITHE_OK;
  }
  LthOperator M = s->solver == LTH_LINEAR_CHOLESKY
                      ? (LthOperator){.n = s->n, .apply = apply_factor, .self = &inverse}
                      : lth_block_jacobi_operator(s->jacobi);
  // the factor is exact but for rounding and contact: one or a few iterations
  *report = lth_cg_solve(s->cg, lth_threads(ctx), &A, &M, s->rhs, s->solution, tolerance,
                         s->options.max_iterations);
  return status;
}

/// Thin parts are so stiff that a product with the matrix may have more rounding than the tolerance allows.
static bool is_as_good_as_rounding(LitheCtx *ctx, const LthSimulation *s, double residual) {
  if (s->own || s->volume) return false;
  return residual * lth_step_norm(ctx, s->n, s->rhs) <=
         ROUNDINGS * lth_block_matrix_rounding(s->A, s->solution, s->rhs);
}

static void add_driven(const LthSimulation *s) {
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++) s->solution[i] += s->driven[i];
}

/// Whether what a solve of a time step has left of its residual r makes energy: r . v1 does. The tolerance measures r by the right-hand side, in which
/// contact of thin pieces may be so large (their functions are, at their rims) that nothing else counts.
static bool makes_energy(LitheCtx *ctx, LthSimulation *s, double tolerance) {
  double energy = 0;
  if (!(s->rigid.H > 0) || !s->contact_on || s->own || s->volume) return false;
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    energy += lth_contact_start_energy(s->system->contacts[c]);
  const int threads = lth_threads(ctx);
  apply_system(s, threads, s->solution, s->scratch);
  const double made =
      lth_dot(threads, s->n, s->rhs, s->solution) - lth_dot(threads, s->n, s->scratch, s->solution);
  energy += fabs(lth_dot(threads, s->n, s->stage.p, s->solution));
  return energy > 0 && fabs(made) > tolerance * energy;
}

static LitheStatus solve_to(LitheCtx *ctx, LthSimulation *s, double tolerance, LthSolveReport *r) {
  if (s->volume)
    LITHE_TRY(lth_step_volume_solve(ctx, s, tolerance, r));
  else
    LITHE_TRY(lth_step_solve_linear(ctx, s, tolerance, r));
  s->report.linear_iterations += r->iterations;
  s->report.linear_total += r->iterations;
  s->report.residual = r->residual;
  if (!isfinite(r->residual))
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
               "the solution is no longer finite at t = %g s: take smaller steps or a softer load",
               s->t);
  return LITHE_OK;
}

/// Solve with the contact set as it stands.
static LitheStatus solve_pass(LitheCtx *ctx, LthSimulation *s, double tolerance, bool *converged) {
  add_contact(s);
  if (s->contact_on) LITHE_TRY(lth_step_refresh(ctx, s));
  lth_system_zero_held(s->system, s->solution);
  LthSolveReport r;
  LITHE_TRY(solve_to(ctx, s, tolerance, &r));
  *converged = r.converged || is_as_good_as_rounding(ctx, s, r.residual);
  double sharper = tolerance;
  for (int k = 0; k < SHARPER_MAX && r.converged && makes_energy(ctx, s, tolerance); k++)
    LITHE_TRY(solve_to(ctx, s, sharper *= SHARPER, &r));
  add_driven(s);
  return LITHE_OK;
}

// While points come and go a rough solution tells which: full accuracy comes once they stand.
LitheStatus lth_step_solve(LitheCtx *ctx, LthSimulation *s, double tolerance) {
  double start = lth_now(), rough = fmax(tolerance, CONTACT_TOLERANCE);
  bool converged = true;
  s->report.linear_iterations = 0;
  for (int pass = 0; pass < CONTACT_PASSES; pass++) {
    bool last =
        pass == CONTACT_PASSES - 1 || !s->contact_on || s->contact_stands || rough == tolerance;
    LITHE_TRY(solve_pass(ctx, s, last ? tolerance : rough, &converged));
    if (!s->has_contact || s->contact_stands) break;
    bool changed = lth_step_contact_revise(s, s->solution);
    if (!changed && last) break;
    rough = changed ? fmax(tolerance, CONTACT_TOLERANCE) : tolerance;
    s->contact_on |= changed;
  }
  s->report.converged &= converged;
  s->report.time_solve += lth_now() - start;
  return LITHE_OK;
}
