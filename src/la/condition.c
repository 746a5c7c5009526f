/// Condition number: dense eigenvalues, or Lanczos (1950) on the matrix and on its inverse.
#include "la/blas_threads.h"
#include "la/engine.h"
#include "la/krylov.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

#define DENSE_LIMIT 3000
#define LANCZOS_STEPS 300
#define LANCZOS_TOLERANCE 1e-8

static void expand(const LthBlockMatrix *A, double *dense) {
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      LitheIndex col = A->block_col[e];
      LitheCount m = A->row_off[row + 1] - A->row_off[row],
                 n = A->row_off[col + 1] - A->row_off[col];
      for (LitheCount r = 0; r < m; r++)
        memcpy(dense + (A->row_off[row] + r) * A->n + A->row_off[col],
               A->values + A->value_off[e] + r * n, sizeof *dense * (size_t)n);
    }
}

static LitheStatus from_extremes(LitheCtx *ctx, double smallest, double largest,
                                 double *condition) {
  *condition = INFINITY;
  if (!(smallest > 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "condition number: the matrix is not positive definite (smallest eigenvalue %g, "
               "largest %g)",
               smallest, largest);
  *condition = largest / smallest;
  return LITHE_OK;
}

LitheStatus lth_block_matrix_condition_beyond(LitheCtx *ctx, const LthBlockMatrix *A, int n_zero,
                                              double *condition) {
  LitheStatus status = LITHE_OK;
  double *dense = NULL, *eigenvalue = NULL;
  LTH_NEW_OR(done, ctx, dense, A->n * A->n);
  LTH_NEW_OR(done, ctx, eigenvalue, A->n);
  expand(A, dense);
  int threads = lth_blas_one_thread();
  int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'N', 'L', (int)A->n, dense, (int)A->n, eigenvalue);
  lth_blas_threads(threads);
  if (info != 0)
    status = lth_fail(ctx, LITHE_NOT_CONVERGED, "condition number: LAPACK's dsyevd gave %d", info);
  else
    status = from_extremes(ctx, eigenvalue[n_zero], eigenvalue[A->n - 1], condition);
done:
  lth_free(ctx, dense);
  lth_free(ctx, eigenvalue);
  return status;
}

/// Largest eigenvalue of the tridiagonal matrix (alpha, beta) by bisection on Sturm counts.
static double largest_ritz(int n, const double *alpha, const double *beta) {
  double low = -INFINITY, high = -INFINITY;
  for (int i = 0; i < n; i++) {
    double radius = (i > 0 ? beta[i - 1] : 0) + (i + 1 < n ? beta[i] : 0);
    low = fmax(low, alpha[i]);
    high = fmax(high, alpha[i] + radius);
  }
  for (int step = 0; step < 100 && high - low > 1e-14 * fabs(high); step++) {
    double middle = 0.5 * (low + high), d = 1;
    bool above = false; // an eigenvalue lies above `middle`
    for (int i = 0; i < n && !above; i++) {
      d = middle - alpha[i] - (i > 0 ? beta[i - 1] * beta[i - 1] / d : 0);
      above = d <= 0;
    }
    if (above)
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

/// An operator that may fail: A x or A^-1 x.
typedef struct Spectrum {
  LitheCtx *ctx;
  const LthBlockMatrix *A;
  const LthEngine *engine;
  LthFactor *factor; // NULL: multiply by A
} Spectrum;

static LitheStatus spectrum_apply(const Spectrum *s, const double *x, double *y) {
  if (s->factor) return s->engine->solve(s->ctx, s->factor, x, y);
  lth_block_matrix_apply(s->A, lth_threads(s->ctx), x, y);
  return LITHE_OK;
}

/// Remove from w its parts along the first `count` basis vectors, twice for full orthogonality.
static void orthogonalize(int threads, LitheCount n, int count, const double *basis, double *w) {
  for (int pass = 0; pass < 2; pass++)
    for (int k = 0; k < count; k++) {
      const double *v = basis + k * n;
      double along = lth_dot(threads, n, v, w);
      for (LitheCount i = 0; i < n; i++) w[i] -= along * v[i];
    }
}

static LitheStatus lanczos_largest(const Spectrum *s, double *largest) {
  LitheStatus status = LITHE_OK;
  LitheCount n = s->A->n;
  int threads = lth_threads(s->ctx), steps = n < LANCZOS_STEPS ? (int)n : LANCZOS_STEPS;
  double alpha[LANCZOS_STEPS], beta[LANCZOS_STEPS], *basis = NULL, *w = NULL;
  LTH_NEW_OR(done, s->ctx, basis, n * steps);
  LTH_NEW_OR(done, s->ctx, w, n);
  *largest = 0;
  uint32_t seed = 1;
  for (LitheCount i = 0; i < n; i++)
    w[i] = (seed = seed * 1664525u + 1013904223u) / 4294967296.0 - 0.5;
  double norm = sqrt(lth_dot(threads, n, w, w));
  for (int k = 0; k < steps && norm > 0; k++) {
    double *v = basis + k * n, before = *largest;
    for (LitheCount i = 0; i < n; i++) v[i] = w[i] / norm;
    LITHE_TRY_OR(done, spectrum_apply(s, v, w));
    alpha[k] = lth_dot(threads, n, v, w);
    orthogonalize(threads, n, k + 1, basis, w);
    beta[k] = norm = sqrt(lth_dot(threads, n, w, w));
    *largest = largest_ritz(k + 1, alpha, beta);
    if (k > 10 && fabs(*largest - before) <= LANCZOS_TOLERANCE * fabs(*largest)) break;
  }
done:
  lth_free(s->ctx, basis);
  lth_free(s->ctx, w);
  return status;
}

static LitheStatus lanczos_condition(LitheCtx *ctx, const LthBlockMatrix *A, double *condition) {
  LitheStatus status = LITHE_OK;
  Spectrum s = {.ctx = ctx, .A = A, .engine = lth_engine_find("cholesky")};
  double largest = 0, inverse = 0;
  if (!s.engine)
    LITHE_FAIL(
        ctx, LITHE_UNSUPPORTED,
        "condition number: beyond %d unknowns it needs the sparse Cholesky engine, which this "
        "build lacks; got %lld",
        DENSE_LIMIT, (long long)A->n);
  LITHE_TRY(lanczos_largest(&s, &largest));
  LITHE_TRY_OR(done, s.engine->analyse(ctx, A, &s.factor));
  status = s.engine->factorize(ctx, s.factor, A);
  if (status == LITHE_NOT_CONVERGED) {
    *condition = INFINITY;
    status =
        lth_fail(ctx, LITHE_BAD_INPUT, "condition number: the matrix is not positive definite");
  }
  LITHE_TRY_OR(done, status);
  LITHE_TRY_OR(done, lanczos_largest(&s, &inverse));
  status = from_extremes(ctx, 1 / inverse, largest, condition);
done:
  s.engine->destroy(ctx, &s.factor);
  return status;
}

LitheStatus lth_block_matrix_condition(LitheCtx *ctx, const LthBlockMatrix *A, double *condition) {
  return A->n <= DENSE_LIMIT ? lth_block_matrix_condition_beyond(ctx, A, 0, condition)
                             : lanczos_condition(ctx, A, condition);
}
