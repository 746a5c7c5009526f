/// Sparse Cholesky by CHOLMOD (Chen, Davis, Hager, Rajamanickam 2008) behind la's engine interface.
#include "engine/local/engine_local.h"
#include "la/blas_threads.h"

#include <cholmod.h>
#include <math.h>
#include <string.h>

// The long interface: factors of 3D bodies pass 2^31 entries long before memory ends.
struct LthFactor {
  cholmod_common common;
  bool started;
  cholmod_sparse *lower; // lower triangle by columns, zeros of the dense blocks kept
  cholmod_factor *L;
  cholmod_dense *x, *y, *e; // kept between solves
  uint64_t pattern_revision;
  double bytes, flops;
};

/// CHOLMOD's own messages would go to standard output.
static void keep_quiet(int status, const char *file, int line, const char *message) {
  (void)status, (void)file, (void)line, (void)message;
}

static LitheStatus failure(LitheCtx *ctx, const LthFactor *f, const char *phase) {
  switch (f->common.status) {
  case CHOLMOD_OUT_OF_MEMORY:
    LITHE_FAIL(
        ctx, LITHE_NO_MEMORY,
        "out of memory in the sparse Cholesky (%s): the factor takes about %.3g GB; use multigrid",
        phase, f->bytes * 1e-9);
  case CHOLMOD_TOO_LARGE:
    LITHE_FAIL(ctx, LITHE_NO_MEMORY,
               "the matrix is too large for the sparse Cholesky; use multigrid");
  case CHOLMOD_NOT_POSDEF:
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
               "the matrix is not positive definite (pivot %lld of %lld): raise the penalty, "
               "constrain the body, or let thin elements be merged (method.sliver)",
               (long long)(f->L ? f->L->minor : 0), (long long)(f->L ? f->L->n : 0));
  default:
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "CHOLMOD's status is %d (%s)", f->common.status, phase);
  }
}

/// By symmetry, column j of the lower triangle is row j of the upper one, whose entries lie in A in
/// order: blocks on and right of the diagonal.
static LitheCount upper_row_length(const LthBlockMatrix *A, LitheIndex row, LitheCount r) {
  LitheCount length = 0;
  for (LitheCount e = A->diagonal[row]; e < A->block_off[row + 1]; e++)
    length += A->row_off[A->block_col[e] + 1] - A->row_off[A->block_col[e]];
  return length - r;
}

static LitheStatus allocate_lower(LitheCtx *ctx, LthFactor *f, const LthBlockMatrix *A) {
  LitheCount n_values = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount r = 0; r < A->row_off[row + 1] - A->row_off[row]; r++)
      n_values += upper_row_length(A, row, r);
  f->lower = cholmod_l_allocate_sparse((size_t)A->n, (size_t)A->n, (size_t)n_values, true, true, -1,
                                       CHOLMOD_REAL, &f->common);
  return f->lower ? LITHE_OK : failure(ctx, f, "analysis");
}

static void fill_pattern(const LthBlockMatrix *A, cholmod_sparse *lower) {
  SuiteSparse_long *start = lower->p, *index = lower->i;
  LitheCount at = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount r = A->row_off[row]; r < A->row_off[row + 1]; r++) {
      start[r] = at;
      for (LitheCount e = A->diagonal[row]; e < A->block_off[row + 1]; e++) {
        LitheIndex col = A->block_col[e];
        LitheCount first = col == row ? r : A->row_off[col];
        for (LitheCount c = first; c < A->row_off[col + 1]; c++) index[at++] = c;
      }
    }
  start[A->n] = at;
}

static void fill_values(const LthBlockMatrix *A, cholmod_sparse *lower) {
  double *value = lower->x;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount r = 0; r < A->row_off[row + 1] - A->row_off[row]; r++)
      for (LitheCount e = A->diagonal[row]; e < A->block_off[row + 1]; e++) {
        LitheIndex col = A->block_col[e];
        LitheCount n = A->row_off[col + 1] - A->row_off[col], skip = col == row ? r : 0;
        memcpy(value, A->values + A->value_off[e] + r * n + skip,
               sizeof *value * (size_t)(n - skip));
        value += n - skip;
      }
}

static LitheStatus order(LitheCtx *ctx, LthFactor *f) {
  static const int orderings[] = {CHOLMOD_METIS, CHOLMOD_AMD};
  f->common.supernodal = CHOLMOD_SUPERNODAL;
  f->common.nmethods = 1;
  f->common.postorder = true;
  for (int i = 0; i < 2 && !f->L; i++) {
    f->common.method[0].ordering = orderings[i];
    f->L = cholmod_l_analyze(f->lower, &f->common);
    if (!f->L && f->common.status == CHOLMOD_OUT_OF_MEMORY) break;
  }
  if (!f->L) return failure(ctx, f, "analysis");
  f->bytes = 8.0 * ((double)f->L->xsize + (double)f->L->ssize);
  f->flops = f->common.fl;
  return LITHE_OK;
}

static void cholmod_destroy(LitheCtx *ctx, LthFactor **factor) {
  if (!factor || !*factor) return;
  LthFactor *f = *factor;
  if (f->started) {
    cholmod_l_free_sparse(&f->lower, &f->common);
    cholmod_l_free_factor(&f->L, &f->common);
    cholmod_l_free_dense(&f->x, &f->common);
    cholmod_l_free_dense(&f->y, &f->common);
    cholmod_l_free_dense(&f->e, &f->common);
    cholmod_l_finish(&f->common);
  }
  lth_free(ctx, f);
  *factor = NULL;
}

static LitheStatus cholmod_analyse(LitheCtx *ctx, const LthBlockMatrix *A, LthFactor **factor) {
  LitheStatus status = LITHE_OK;
  LthFactor *f = NULL;
  *factor = NULL;
  int threads = lth_blas_one_thread();
  LTH_NEW_OR(done, ctx, f, 1);
  f->started = cholmod_l_start(&f->common);
  f->common.print = 0;
  f->common.error_handler = keep_quiet;
  LITHE_TRY_OR(done, allocate_lower(ctx, f, A));
  fill_pattern(A, f->lower);
  LITHE_TRY_OR(done, order(ctx, f));
  f->pattern_revision = A->pattern_revision;
  *factor = f;
  f = NULL;
done:
  cholmod_destroy(ctx, &f);
  lth_blas_threads(threads);
  return status;
}

static LitheStatus cholmod_numeric(LitheCtx *ctx, LthFactor *f, const LthBlockMatrix *A) {
  if (f->pattern_revision != A->pattern_revision)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "sparse Cholesky: the matrix has another pattern than was analysed");
  int threads = lth_blas_one_thread();
  fill_values(A, f->lower);
  f->common.status = CHOLMOD_OK;
  bool done = cholmod_l_factorize(f->lower, f->L, &f->common) && f->common.status == CHOLMOD_OK;
  lth_blas_threads(threads);
  return done ? LITHE_OK : failure(ctx, f, "factorisation");
}

static LitheStatus cholmod_apply_inverse(LitheCtx *ctx, LthFactor *f, const double *b, double *x) {
  cholmod_dense rhs = {.nrow = f->L->n,
                       .ncol = 1,
                       .nzmax = f->L->n,
                       .d = f->L->n,
                       .x = (void *)b,
                       .xtype = CHOLMOD_REAL,
                       .dtype = CHOLMOD_DOUBLE};
  int threads = lth_blas_one_thread();
  bool done = cholmod_l_solve2(CHOLMOD_A, f->L, &rhs, NULL, &f->x, NULL, &f->y, &f->e, &f->common);
  lth_blas_threads(threads);
  if (!done) return failure(ctx, f, "solve");
  memcpy(x, f->x->x, sizeof *x * f->L->n);
  return LITHE_OK;
}

static void cholmod_predict(const LthFactor *f, double *bytes, double *flops) {
  *bytes = f->bytes;
  *flops = f->flops;
}

const LthEngine lth_engine_cholmod = {.name = "cholesky",
                                      .analyse = cholmod_analyse,
                                      .factorize = cholmod_numeric,
                                      .solve = cholmod_apply_inverse,
                                      .predict = cholmod_predict,
                                      .destroy = cholmod_destroy};
