/// The linear system of a step: assembly, prescribed cells, contact, the choice of a solver, the solve.
#include "step/simulation_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include <unistd.h>

#define CONTACT_PASSES 8             // solves of one step while the contact set changes
#define CHOLESKY_MAX_UNKNOWNS 400000 // the analysis alone takes seconds beyond
#define CONTACT_TOLERANCE 1e-4       // while it does
#define LAGGED_MAX_UNKNOWNS 60000    // beyond, factors do not pay in dynamic steps
#define FIRST_LIFE 10                // steps that a first factor is taken to serve
#define RETRY 12                     // steps after which the other solver is tried again
#define CHOLESKY_MAX_FLOPS 1e12      // about half a minute on one core

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

static LitheStatus analyse(LitheCtx *ctx, LthSimulation *s) {
  if (s->factor) return LITHE_OK;
  s->engine = lth_engine_find("cholesky");
  if (!s->engine)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "solver.linear: this build has no sparse Cholesky; use pcg");
  double start = lth_now();
  LitheStatus status = s->engine->analyse(ctx, s->A, &s->factor);
  s->report.time_factor += lth_now() - start;
  return status;
}

static double memory_limit(const LthStepOptions *o) {
  if (o->memory_limit > 0) return o->memory_limit;
  return 0.75 * (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
}

static const char *why_not_cholesky(LitheCtx *ctx, LthSimulation *s) {
  if (s->n > CHOLESKY_MAX_UNKNOWNS) return "more than 400000 unknowns";
  if (analyse(ctx, s) != LITHE_OK) return "the sparse Cholesky could not analyse the matrix";
  double bytes, flops;
  s->engine->predict(s->factor, &bytes, &flops);
  if (bytes > memory_limit(&s->options)) return "the Cholesky factor would not fit in memory";
  if (flops > CHOLESKY_MAX_FLOPS) return "the Cholesky factor would take more than 1e12 operations";
  return NULL;
}

static LitheStatus take_cholesky(LitheCtx *ctx, LthSimulation *s, const char *reason) {
  LITHE_TRY(analyse(ctx, s));
  s->use_cholesky = true;
  s->report.linear = "cholesky";
  s->report.linear_reason = reason;
  return LITHE_OK;
}

static void take_pcg(LthSimulation *s, const char *reason) {
  s->use_cholesky = false;
  s->report.linear = "pcg";
  s->report.linear_reason = reason;
}

// What the linear algebra of a step costs, in bytes that products read: counts alone, no times, so that the
// choice is the same on every run and for any number of threads. Measured on bodies of 300 to 10000 unknowns:
// a solve takes about 1.5 bytes for each of the factor (one thread), a factorisation 2 for each operation.

static double product_cost(const LthSimulation *s) {
  return 8.0 * (double)s->A->value_off[s->A->block_off[s->A->n_rows]];
}

static void factor_cost(const LthSimulation *s, double *factor, double *iteration) {
  double bytes, flops;
  s->engine->predict(s->factor, &bytes, &flops);
  *factor = 2 * flops;
  *iteration = product_cost(s) + 1.5 * bytes;
}

void lth_step_tally(LthSimulation *s) {
  double factor, iteration, cost = s->report.linear_iterations * product_cost(s);
  if (s->options.linear != LTH_LINEAR_AUTO || !s->factor) return;
  if (s->use_cholesky) {
    factor_cost(s, &factor, &iteration);
    if (s->fresh) {
      s->fresh_iterations = s->report.linear_iterations;
      s->life = s->age > 0 ? s->age : FIRST_LIFE;
      s->age = 0;
    }
    s->age++;
    cost = s->report.linear_iterations * iteration + factor / s->life;
    s->age_cost += fmax(0, s->report.linear_iterations - s->fresh_iterations) * iteration;
    s->stale = s->age_cost > factor;
    s->fresh = false;
  }
  double *mean = &s->cost[s->contact_on][s->use_cholesky];
  *mean = *mean > 0 ? 0.5 * *mean + 0.5 * cost : cost;
  s->n_tallied[s->contact_on]++;
}

/// The cheaper of the two so far; what is not known yet is tried, and the dearer once in a while again.
static bool factor_pays(LthSimulation *s) {
  const double *cost = s->cost[s->contact_on];
  double factor, iteration;
  factor_cost(s, &factor, &iteration);
  if (cost[0] == 0) return false;
  if (cost[1] == 0) return cost[0] > factor / FIRST_LIFE + 10 * iteration;
  bool cheaper = cost[1] < cost[0];
  return s->n_tallied[s->contact_on] % RETRY == 0 ? !cheaper : cheaper;
}

static LitheStatus choose_dynamic(LitheCtx *ctx, LthSimulation *s) {
  if (!s->factor && s->n <= LAGGED_MAX_UNKNOWNS && !s->no_lag)
    s->no_lag = analyse(ctx, s) != LITHE_OK;
  if (s->factor && !s->no_lag && factor_pays(s))
    return take_cholesky(ctx, s,
                         "a factor kept over some steps costs less than the iterations it saves");
  take_pcg(s, "the matrix changes with every step and the mass keeps it well conditioned");
  return LITHE_OK;
}

LitheStatus lth_step_choose(LitheCtx *ctx, LthSimulation *s, bool is_static) {
  if (s->options.linear == LTH_LINEAR_CHOLESKY) return take_cholesky(ctx, s, "as asked");
  if (s->options.linear == LTH_LINEAR_PCG) {
    take_pcg(s, "as asked");
    return LITHE_OK;
  }
  if (!is_static) return choose_dynamic(ctx, s);
  if (!s->static_chosen) {
    s->static_reason = why_not_cholesky(ctx, s);
    s->static_chosen = true;
  }
  if (!s->static_reason) return take_cholesky(ctx, s, "the factor fits in memory");
  take_pcg(s, s->static_reason);
  return LITHE_OK;
}

LitheStatus lth_step_factor(LitheCtx *ctx, LthSimulation *s) {
  double start = lth_now();
  s->stale = true;
  LitheStatus status = s->use_cholesky ? s->engine->factorize(ctx, s->factor, s->A)
                                       : lth_block_jacobi_update(ctx, s->jacobi, s->A, NULL);
  s->report.time_factor += lth_now() - start;
  return status;
}

LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double cm, double ck) {
  bool lags = s->use_cholesky && s->options.linear == LTH_LINEAR_AUTO;
  if (lags && !s->stale && s->factor_cm == cm && s->factor_ck == ck) return LITHE_OK;
  LitheStatus status = lth_step_factor(ctx, s);
  if (lags && status == LITHE_NOT_CONVERGED) { // PCG may still find its way, and says if not
    s->no_lag = true;
    take_pcg(s, "the sparse Cholesky found the matrix not definite");
    return lth_step_factor(ctx, s);
  }
  if (lags) {
    s->factor_cm = cm;
    s->factor_ck = ck;
    s->fresh = true;
    s->stale = false;
    s->age_cost = 0;
  }
  return status;
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
