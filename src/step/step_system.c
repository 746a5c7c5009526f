/// The linear system of a step: assembly, prescribed cells, contact, the solve.
#include "step/simulation_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define CONTACT_PASSES 8       // solves of one step while the contact set changes
#define CONTACT_TOLERANCE 1e-4 // while it does

double lth_step_norm(const LitheCtx *ctx, LitheCount n, const double *y) {
  return sqrt(lth_dot(lth_threads(ctx), n, y, y));
}

LitheStatus lth_step_assemble(LitheCtx *ctx, LthSimulation *s, double t) {
  double start = lth_now();
  lth_dg_update_rotations(s->body.op, s->x);
  lth_dg_assemble(s->body.op, t, s->A, s->f0);
  LITHE_TRY(lth_step_external_force(ctx, s, t));
  lth_block_matrix_apply(s->A, lth_threads(ctx), s->x, s->force);
  for (LitheCount i = 0; i < s->n; i++) s->force[i] = s->f_ext[i] + s->f0[i] - s->force[i];
  s->report.time_assemble += lth_now() - start;
  return LITHE_OK;
}

LitheStatus lth_step_drive(LitheCtx *ctx, LthSimulation *s, double t, double h) {
  (void)ctx;
  if (!s->has_strong) return LITHE_OK;
  memcpy(s->scratch, s->x, sizeof *s->x * (size_t)s->n);
  LITHE_TRY(s->body.prescribe(s->body.prescribe_self, t, s->scratch));
  for (LitheIndex cell = 0; cell < s->A->n_rows; cell++)
    for (LitheCount i = lth_cell_first(s, cell); i < lth_cell_first(s, cell + 1); i++)
      s->driven[i] = lth_is_strong(s, cell) ? (s->scratch[i] - s->x[i]) / h : 0;
  return LITHE_OK;
}

void lth_step_combine(LitheCtx *ctx, LthSimulation *s, double cm, double ck) {
  LthBlockMatrix *A = s->A;
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(ctx)) if (lth_block_matrix_is_large(A))
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheCount first = A->value_off[A->block_off[row]], last = A->value_off[A->block_off[row + 1]];
    if (ck != 1)
      for (LitheCount i = first; i < last; i++) A->values[i] *= ck;
    LitheCount m = A->row_off[row + 1] - A->row_off[row];
    double *B = A->values + A->value_off[A->diagonal[row]];
    const double *mass = s->mass + s->body.space->func_off[row];
    for (LitheCount i = 0; i < m; i++) B[i * m + i] += cm * mass[i / 3];
  }
}

void lth_step_zero_strong(const LthSimulation *s, double *y) {
  for (LitheIndex cell = 0; s->has_strong && cell < s->A->n_rows; cell++)
    if (lth_is_strong(s, cell))
      memset(y + lth_cell_first(s, cell), 0,
             sizeof *y * (size_t)(lth_cell_first(s, cell + 1) - lth_cell_first(s, cell)));
}

static void constrain_row(LthSimulation *s, LitheIndex row) {
  LthBlockMatrix *A = s->A;
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (lth_is_strong(s, row) || lth_is_strong(s, A->block_col[e]))
      memset(A->values + A->value_off[e], 0,
             sizeof *A->values * (size_t)(A->value_off[e + 1] - A->value_off[e]));
  if (!lth_is_strong(s, row)) return;
  LitheCount m = A->row_off[row + 1] - A->row_off[row];
  double *B = A->values + A->value_off[A->diagonal[row]];
  for (LitheCount i = 0; i < m; i++) B[i * m + i] = 1;
}

// Strong cells keep a right-hand side and a guess of zero, so that they weigh nothing in the norms of
// the solver; their values are put in at the end.
void lth_step_constrain(LitheCtx *ctx, LthSimulation *s) {
  if (!s->has_strong) return;
  lth_block_matrix_apply(s->A, lth_threads(ctx), s->driven, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->base[i] -= s->scratch[i];
  lth_step_zero_strong(s, s->base);
  for (LitheIndex row = 0; row < s->A->n_rows; row++) constrain_row(s, row);
}

static void apply_system(const void *self, int threads, const double *x, double *y) {
  const LthSimulation *s = self;
  lth_block_matrix_apply(s->A, threads, x, y);
  if (!s->contact_on) return;
  lth_contact_apply(s->body.contact, x, y);
  lth_step_zero_strong(s, y);
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

/// rhs = base plus contact; the preconditioner takes contact's diagonal in.
static LitheStatus add_contact(LitheCtx *ctx, LthSimulation *s) {
  memcpy(s->rhs, s->base, sizeof *s->rhs * (size_t)s->n);
  if (!s->contact_on) return LITHE_OK;
  lth_contact_add_rhs(s->body.contact, s->rhs);
  if (s->has_strong) { // rhs -= C driven
    memset(s->scratch, 0, sizeof *s->scratch * (size_t)s->n);
    lth_contact_apply(s->body.contact, s->driven, s->scratch);
    for (LitheCount i = 0; i < s->n; i++) s->rhs[i] -= s->scratch[i];
    lth_step_zero_strong(s, s->rhs);
  }
  if (s->use_cholesky) return LITHE_OK;
  memset(s->extra, 0, sizeof *s->extra * (size_t)s->n_extra);
  lth_contact_add_diagonal(s->body.contact, s->body.space, s->extra);
  LitheCount at = 0;
  for (LitheIndex cell = 0; cell < s->A->n_rows; cell++) {
    LitheCount m = s->A->row_off[cell + 1] - s->A->row_off[cell];
    if (lth_is_strong(s, cell)) memset(s->extra + at, 0, sizeof *s->extra * (size_t)(m * m));
    at += m * m;
  }
  return lth_block_jacobi_update(ctx, s->jacobi, s->A, s->extra);
}

static LitheStatus solve_once(LitheCtx *ctx, LthSimulation *s, double tolerance,
                              LthSolveReport *report) {
  LitheStatus status = LITHE_OK;
  if (!s->use_cholesky && !s->contact_on) {
    *report = lth_reduction_solve(s->reduction, s->cg, lth_threads(ctx), s->rhs, s->solution,
                                  tolerance, s->options.max_iterations);
    return LITHE_OK;
  }
  Inverse inverse = {ctx, s, &status};
  LthOperator A = {.n = s->n, .apply = apply_system, .self = s};
  LthOperator M = s->use_cholesky
                      ? (LthOperator){.n = s->n, .apply = apply_factor, .self = &inverse}
                      : lth_block_jacobi_operator(s->jacobi);
  // the factor is exact but for rounding and contact: one or a few iterations
  *report = lth_cg_solve(s->cg, lth_threads(ctx), &A, &M, s->rhs, s->solution, tolerance,
                         s->options.max_iterations);
  return status;
}

static void add_driven(const LthSimulation *s) {
  for (LitheCount i = 0; s->has_strong && i < s->n; i++) s->solution[i] += s->driven[i];
}

/// Solve with the contact set as it stands.
static LitheStatus solve_pass(LitheCtx *ctx, LthSimulation *s, double tolerance, bool *converged) {
  LITHE_TRY(add_contact(ctx, s));
  lth_step_zero_strong(s, s->solution);
  LthSolveReport r;
  LITHE_TRY(solve_once(ctx, s, tolerance, &r));
  add_driven(s);
  s->report.linear_iterations += r.iterations;
  s->report.linear_total += r.iterations;
  s->report.residual = r.residual;
  *converged = r.converged;
  if (!isfinite(r.residual))
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
               "the solution is no longer finite at t = %g s: take smaller steps or a softer load",
               s->t);
  return LITHE_OK;
}

// While points come and go a rough solution tells which: full accuracy comes once they stand.
LitheStatus lth_step_solve(LitheCtx *ctx, LthSimulation *s, double tolerance) {
  double start = lth_now(), rough = fmax(tolerance, CONTACT_TOLERANCE);
  bool converged = true;
  s->report.linear_iterations = 0;
  for (int pass = 0; pass < CONTACT_PASSES; pass++) {
    bool last =
        pass == CONTACT_PASSES - 1 || !s->body.contact || !s->contact_on || rough == tolerance;
    LITHE_TRY(solve_pass(ctx, s, last ? tolerance : rough, &converged));
    if (!s->body.contact) break;
    bool changed = lth_contact_revise(s->body.contact, s->solution);
    if (!changed && last) break;
    rough = changed ? fmax(tolerance, CONTACT_TOLERANCE) : tolerance;
    s->contact_on |= changed;
  }
  s->report.converged &= converged;
  s->report.time_solve += lth_now() - start;
  return LITHE_OK;
}
