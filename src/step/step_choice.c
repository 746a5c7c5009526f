/// Which solver a step takes, and how long a factor is kept: by counted costs, never by times, so that the
/// choice is the same on every run and for any number of threads (docs/theory/stepping.md).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#define CHOLESKY_MAX_UNKNOWNS 400000 // the analysis alone takes seconds beyond
#define LAGGED_MAX_UNKNOWNS 60000    // beyond, factors do not pay in dynamic steps
#define FIRST_LIFE 10                // steps that a first factor is taken to serve
#define RETRY 12                     // steps after which the other solver is tried again
#define CHOLESKY_MAX_FLOPS 1e12      // about half a minute on one core

LitheStatus lth_step_analyse(LitheCtx *ctx, LthSimulation *s) {
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
  if (lth_step_analyse(ctx, s) != LITHE_OK)
    return "the sparse Cholesky could not analyse the matrix";
  double bytes, flops;
  s->engine->predict(s->factor, &bytes, &flops);
  if (bytes > memory_limit(&s->options)) return "the Cholesky factor would not fit in memory";
  if (flops > CHOLESKY_MAX_FLOPS) return "the Cholesky factor would take more than 1e12 operations";
  return NULL;
}

static LitheStatus take_cholesky(LitheCtx *ctx, LthSimulation *s, const char *reason) {
  LITHE_TRY(lth_step_analyse(ctx, s));
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
    s->no_lag = lth_step_analyse(ctx, s) != LITHE_OK;
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

LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double h) {
  bool lags = s->use_cholesky && s->options.linear == LTH_LINEAR_AUTO;
  if (lags && !s->stale && s->factor_step == h) return LITHE_OK;
  LitheStatus status = lth_step_factor(ctx, s);
  if (lags && status == LITHE_NOT_CONVERGED) { // PCG may still find its way, and says if not
    s->no_lag = true;
    take_pcg(s, "the sparse Cholesky found the matrix not definite");
    return lth_step_factor(ctx, s);
  }
  if (lags) {
    s->factor_step = h;
    s->factor_t = s->stage.t1;
    memcpy(s->factor_x, s->x, sizeof *s->x * (size_t)s->n);
    s->has_lagged = s->fresh = true;
    s->stale = false;
    s->age_cost = 0;
  }
  return status;
}
