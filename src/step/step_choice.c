/// Which solver a step takes, and how long a factor is kept: by counted costs, never by times, so that the
/// choice is the same on every run and for any number of threads (docs/theory/stepping.md).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#define CHOLESKY_MAX_UNKNOWNS 400000 // the analysis alone takes seconds beyond
#define LAGGED_MAX_UNKNOWNS 60000    // beyond, factors do not pay in dynamic steps
#define FIRST_LIFE 10                // steps that a first factor is taken to serve
#define RETRY 12                     // steps after which the second best solver is tried again
#define CHOLESKY_SMALL 2e10          // operations: a second on one core, not worth a thought
#define FORESEEN_MAX_FLOPS 4e12      // of a compact body; beyond, no analysis is tried
#define FLOP_COST 2.0                // bytes, see below
#define LEVELS_CYCLE 4.5             // products
#define LEVELS_ITERATIONS 60         // what multigrid is expected to take for an equilibrium
#define LEVELS_STEP_ITERATIONS 20    // and in a step

LitheStatus lth_step_analyse(LitheCtx *ctx, LthSimulation *s) {
  if (s->factor) return LITHE_OK;
  s->engine = lth_engine_find("cholesky");
  if (!s->engine)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "solver.linear: this build has no sparse Cholesky; use multigrid");
  double start = lth_now();
  LitheStatus status = s->engine->analyse(ctx, s->A, &s->factor);
  s->report.time_factor += lth_now() - start;
  return status;
}

static double memory_limit(const LthStepOptions *o) {
  if (o->memory_limit > 0) return o->memory_limit;
  return 0.75 * (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
}

// A compact body of N block rows of m unknowns, nested dissection: measured on cubes, dg of degrees 1 and 2 (7 blocks
// a row: 1.7 N^2 m^3 operations, 2.8 N^(4/3) m^2 values) and trilinear cg (27 blocks: 6 and 9.4).
static void guess_factor(const LthBlockMatrix *A, double *bytes, double *flops) {
  double N = fmax(1, A->n_rows), m = (double)A->n / N, width = (double)A->block_off[A->n_rows] / N;
  *flops = 0.25 * width * N * N * m * m * m;
  *bytes = 8 * 0.4 * width * pow(N, 4.0 / 3) * m * m;
}

bool lth_step_foresees_levels(const LthBlockMatrix *A, double limit) {
  double bytes, flops;
  guess_factor(A, &bytes, &flops);
  bool too_large = A->n > CHOLESKY_MAX_UNKNOWNS || flops > FORESEEN_MAX_FLOPS;
  return too_large || (limit > 0 && bytes > 4 * limit);
}

bool lth_step_prefers_levels(const LthBlockMatrix *A, double flops) {
  double product = 8.0 * (double)A->value_off[A->block_off[A->n_rows]];
  double levels = lth_multilevel_update_cost(A, LTH_STEP_LINEAR) +
                  LEVELS_ITERATIONS * (1 + LEVELS_CYCLE) * product;
  return flops > CHOLESKY_SMALL && FLOP_COST * flops > levels;
}

bool lth_step_needs_no_matrix(const LthSystem *system, const LthStepOptions *o) {
  if (o->needs_matrix || (o->linear != LTH_LINEAR_AUTO && o->linear != LTH_LINEAR_MULTIGRID))
    return false;
  return lth_system_solver(system) != NULL;
}

static LitheStatus take_cholesky(LitheCtx *ctx, LthSimulation *s, const char *reason) {
  LITHE_TRY(lth_step_analyse(ctx, s));
  s->solver = LTH_LINEAR_CHOLESKY;
  s->report.linear = "cholesky";
  s->report.linear_reason = reason;
  return LITHE_OK;
}

static void take(LthSimulation *s, LthLinearChoice solver, const char *reason) {
  s->solver = solver;
  s->report.linear = solver == LTH_LINEAR_MULTIGRID ? "multigrid" : "pcg";
  s->report.linear_reason = reason;
}

// What the linear algebra of a step costs, in bytes that products read: counts alone, no times, so that the
// choice is the same on every run and for any number of threads. Measured on bodies of 300 to 10000 unknowns:
// a solve takes about 1.5 bytes for each of the factor (one thread), a factorisation 2 for each operation, a cycle
// of multigrid as long as 4.5 products or 9, smoothed more.

static double product_cost(const LthSimulation *s) {
  return 8.0 * (double)s->A->value_off[s->A->block_off[s->A->n_rows]];
}

/// To make what a solver keeps, and an iteration with it.
static void solver_cost(const LthSimulation *s, LthLinearChoice solver, double *setup,
                        double *iteration) {
  *setup = 0;
  *iteration = product_cost(s);
  if (solver == LTH_LINEAR_CHOLESKY) {
    double bytes, flops;
    s->engine->predict(s->factor, &bytes, &flops);
    *setup = FLOP_COST * flops;
    *iteration += 1.5 * bytes;
  }
  if (solver == LTH_LINEAR_MULTIGRID) {
    *setup = lth_multilevel_update_cost(s->A, LTH_STEP_LINEAR);
    *iteration +=
        (s->levels && lth_multilevel_is_strong(s->levels) ? 2 : 1) * LEVELS_CYCLE * product_cost(s);
  }
}

static const char *why_not_cholesky(LitheCtx *ctx, LthSimulation *s) {
  const double limit = memory_limit(&s->options);
  double bytes, flops;
  if (lth_step_foresees_levels(s->A, limit))
    return "a Cholesky factor of so many unknowns would take too long or too much memory";
  if (lth_step_analyse(ctx, s) != LITHE_OK)
    return "the sparse Cholesky could not analyse the matrix";
  s->engine->predict(s->factor, &bytes, &flops);
  if (bytes > limit) return "the Cholesky factor would not fit in memory";
  if (lth_step_prefers_levels(s->A, flops))
    return "the Cholesky factor would cost more than the iterations";
  return NULL;
}

void lth_step_tally(LthSimulation *s) {
  const LthLinearChoice solver = s->solver;
  double setup, iteration;
  if (s->own || (s->options.linear != LTH_LINEAR_AUTO && solver != LTH_LINEAR_MULTIGRID)) return;
  solver_cost(s, solver, &setup, &iteration);
  double cost = s->report.linear_iterations * iteration;
  if (solver != LTH_LINEAR_PCG) {
    if (s->fresh) {
      s->fresh_iterations = s->report.linear_iterations;
      s->life = s->age > 0 ? s->age : FIRST_LIFE;
      s->age = 0;
    }
    s->age++;
    cost += setup / s->life;
    s->age_cost += fmax(0, s->report.linear_iterations - s->fresh_iterations) * iteration;
    s->stale = s->age_cost > setup;
    s->fresh = false;
  }
  double *mean = &s->cost[s->contact_on][solver];
  *mean = *mean > 0 ? 0.5 * *mean + 0.5 * cost : cost;
  s->n_tallied[s->contact_on]++;
}

/// What a step with a solver costs: as tallied, or as hoped for where it was not tried.
static double expected_cost(const LthSimulation *s, LthLinearChoice solver, double guess) {
  double setup, iteration, known = s->cost[s->contact_on][solver];
  if (known > 0) return known;
  solver_cost(s, solver, &setup, &iteration);
  return setup / FIRST_LIFE + guess * iteration;
}

/// The cheapest so far; once in a while the second cheapest again.
static LthLinearChoice cheapest(const LthSimulation *s, bool has_factor) {
  double cost[LTH_LINEAR_COUNT];
  if (s->cost[s->contact_on][LTH_LINEAR_PCG] == 0) return LTH_LINEAR_PCG;
  cost[LTH_LINEAR_AUTO] = INFINITY;
  cost[LTH_LINEAR_PCG] = s->cost[s->contact_on][LTH_LINEAR_PCG];
  cost[LTH_LINEAR_CHOLESKY] = has_factor ? expected_cost(s, LTH_LINEAR_CHOLESKY, 10) : INFINITY;
  cost[LTH_LINEAR_MULTIGRID] =
      s->no_levels ? INFINITY : expected_cost(s, LTH_LINEAR_MULTIGRID, LEVELS_STEP_ITERATIONS);
  LthLinearChoice best = LTH_LINEAR_PCG, second = LTH_LINEAR_PCG;
  for (int k = 0; k < LTH_LINEAR_COUNT; k++)
    if (cost[k] < cost[best]) best = (LthLinearChoice)k;
  if (s->n_tallied[s->contact_on] % RETRY != 0) return best;
  cost[best] = INFINITY;
  for (int k = 0; k < LTH_LINEAR_COUNT; k++)
    if (cost[k] < cost[second]) second = (LthLinearChoice)k;
  return cost[second] < INFINITY ? second : best;
}

bool lth_step_has_other_way(LthSimulation *s) {
  if (s->own || s->options.linear != LTH_LINEAR_AUTO) return false;
  s->stale = true;
  if (s->solver != LTH_LINEAR_PCG && s->age > 1) return true; // it was kept, and is made anew
  double *cost = s->cost[s->contact_on];
  cost[s->solver] = INFINITY;
  return cost[cheapest(s, s->factor && !s->no_lag)] < INFINITY;
}

static LitheStatus choose_dynamic(LitheCtx *ctx, LthSimulation *s) {
  if (!s->factor && s->n <= LAGGED_MAX_UNKNOWNS && !s->no_lag)
    s->no_lag = lth_step_analyse(ctx, s) != LITHE_OK;
  LthLinearChoice best = cheapest(s, s->factor && !s->no_lag);
  if (best == LTH_LINEAR_CHOLESKY)
    return take_cholesky(ctx, s,
                         "a factor kept over some steps costs less than the iterations it saves");
  if (best == LTH_LINEAR_MULTIGRID)
    take(s, best, "coarse levels kept over some steps cost less than the iterations they save");
  else
    take(s, best, "the matrix changes with every step and the mass keeps it well conditioned");
  return LITHE_OK;
}

static LitheStatus choose(LitheCtx *ctx, LthSimulation *s, bool is_static) {
  if (s->own) {
    take(s, LTH_LINEAR_MULTIGRID, "a linear body on a grid of its own needs no matrix");
    return LITHE_OK;
  }
  if (s->options.linear == LTH_LINEAR_CHOLESKY) return take_cholesky(ctx, s, "as asked");
  if (s->options.linear != LTH_LINEAR_AUTO) {
    take(s, s->options.linear, "as asked");
    return LITHE_OK;
  }
  if (!is_static) return choose_dynamic(ctx, s);
  if (!s->static_chosen) {
    s->static_reason = why_not_cholesky(ctx, s);
    s->static_chosen = true;
  }
  if (!s->static_reason)
    return take_cholesky(ctx, s, "the factor fits in memory and costs less than iterations");
  take(s, LTH_LINEAR_MULTIGRID, s->static_reason);
  return LITHE_OK;
}

LitheStatus lth_step_choose(LitheCtx *ctx, LthSimulation *s, bool is_static) {
  LITHE_TRY(choose(ctx, s, is_static));
  if (s->solver == LTH_LINEAR_PCG || s->solver == s->kept) return LITHE_OK;
  s->stale = true; // what is kept is another solver's
  s->age = 0;
  s->kept = s->solver;
  return LITHE_OK;
}

static LitheStatus make(LitheCtx *ctx, LthSimulation *s, double h) {
  if (s->own) return lth_step_prepare_own(ctx, s);
  if (s->solver == LTH_LINEAR_CHOLESKY) return s->engine->factorize(ctx, s->factor, s->A);
  if (s->solver == LTH_LINEAR_PCG) return lth_block_jacobi_update(ctx, s->jacobi, s->A, NULL);
  return lth_step_make_levels(ctx, s, h);
}

/// `auto` goes on with PCG, which may still find its way and says if not, where others meet a matrix that is
/// not definite.
static LitheStatus make_or_fall_back(LitheCtx *ctx, LthSimulation *s, double h) {
  LitheStatus status = make(ctx, s, h);
  if (status != LITHE_NOT_CONVERGED || s->options.linear != LTH_LINEAR_AUTO) return status;
  if (s->solver == LTH_LINEAR_PCG) return status;
  if (s->solver == LTH_LINEAR_CHOLESKY) s->no_lag = true;
  if (s->solver == LTH_LINEAR_MULTIGRID) s->no_levels = true;
  take(s, LTH_LINEAR_PCG,
       s->no_lag ? "the sparse Cholesky found the matrix not definite"
                 : "multigrid found the matrix not definite");
  return make(ctx, s, h);
}

LitheStatus lth_step_factor(LitheCtx *ctx, LthSimulation *s) {
  double start = lth_now(), used = lth_processor_time();
  s->stale = true;
  LitheStatus status = make(ctx, s, 0);
  s->report.time_factor += lth_now() - start;
  s->report.processor_factor += lth_processor_time() - used;
  return status;
}

/// A factor that was asked for is exact; `auto` keeps it as a preconditioner.
static bool lags(const LthSimulation *s) {
  if (s->own) return false;
  return s->solver == LTH_LINEAR_MULTIGRID ||
         (s->solver == LTH_LINEAR_CHOLESKY && s->options.linear == LTH_LINEAR_AUTO);
}

void lth_step_date_factor(LthSimulation *s, double h) {
  s->factor_step = h;
  s->factor_t = s->stage.t1;
  memcpy(s->factor_x, s->x, sizeof *s->x * (size_t)s->n);
}

LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double h) {
  double start = lth_now(), used = lth_processor_time();
  bool keep = lags(s) && !s->stale && s->factor_step == h;
  LitheStatus status = keep ? lth_step_refresh(ctx, s) : make_or_fall_back(ctx, s, h);
  s->report.time_factor += lth_now() - start;
  s->report.processor_factor += lth_processor_time() - used;
  if (status != LITHE_OK || keep) return status;
  s->stale = true;
  if (!lags(s)) return LITHE_OK;
  lth_step_date_factor(s, h);
  s->has_lagged = s->fresh = true;
  s->stale = false;
  s->age_cost = 0;
  return LITHE_OK;
}
