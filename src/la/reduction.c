/// Red-black reduction of a block matrix for conjugate gradients.
#include "la/reduction.h"

#include <math.h>
#include <omp.h>
#include <string.h>

struct LthReduction {
  const LthBlockMatrix *A;
  const LthBlockJacobi *M;
  LitheIndex n_red, n_black;
  LitheIndex *red, *black; // rows, ascending
  double *w, *t, *rhs;     // (n)
};

/// Breadth-first order of all rows, part after part: on a grid its layers alternate in colour.
static void breadth_first(const LthBlockMatrix *A, LitheIndex *order, uint8_t *seen) {
  LitheIndex n = 0, next = 0;
  for (LitheIndex seed = 0; seed < A->n_rows; seed++) {
    if (seen[seed]) continue;
    seen[seed] = true;
    order[n++] = seed;
    for (; next < n; next++)
      for (LitheCount e = A->block_off[order[next]]; e < A->block_off[order[next] + 1]; e++) {
        LitheIndex col = A->block_col[e];
        if (!seen[col]) order[n++] = col;
        seen[col] = true;
      }
  }
}

static bool touches_red(const LthBlockMatrix *A, LitheIndex row, const uint8_t *is_red) {
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (is_red[A->block_col[e]]) return true;
  return false;
}

static void list_colours(LthReduction *r, const uint8_t *is_red) {
  for (LitheIndex row = 0; row < r->A->n_rows; row++)
    if (is_red[row])
      r->red[r->n_red++] = row;
    else
      r->black[r->n_black++] = row;
}

LitheStatus lth_reduction_create(LitheCtx *ctx, const LthBlockMatrix *A, const LthBlockJacobi *M,
                                 LthReduction **reduction) {
  LitheStatus status = LITHE_OK;
  LthReduction *r = NULL;
  LitheIndex *order = NULL;
  uint8_t *mark = NULL;
  *reduction = NULL;
  LTH_NEW_OR(done, ctx, r, 1);
  r->A = A;
  r->M = M;
  LTH_NEW_OR(done, ctx, r->red, A->n_rows);
  LTH_NEW_OR(done, ctx, r->black, A->n_rows);
  LTH_NEW_OR(done, ctx, r->w, A->n);
  LTH_NEW_OR(done, ctx, r->t, A->n);
  LTH_NEW_OR(done, ctx, r->rhs, A->n);
  LTH_NEW_OR(done, ctx, order, A->n_rows);
  LTH_NEW_OR(done, ctx, mark, A->n_rows);
  breadth_first(A, order, mark);
  memset(mark, 0, (size_t)A->n_rows);
  for (LitheIndex k = 0; k < A->n_rows; k++) mark[order[k]] = !touches_red(A, order[k], mark);
  list_colours(r, mark);
  *reduction = r;
  r = NULL;
done:
  lth_free(ctx, order);
  lth_free(ctx, mark);
  lth_reduction_destroy(ctx, &r);
  return status;
}

void lth_reduction_destroy(LitheCtx *ctx, LthReduction **reduction) {
  if (!reduction || !*reduction) return;
  lth_free(ctx, (*reduction)->red);
  lth_free(ctx, (*reduction)->black);
  lth_free(ctx, (*reduction)->w);
  lth_free(ctx, (*reduction)->t);
  lth_free(ctx, (*reduction)->rhs);
  lth_free(ctx, *reduction);
  *reduction = NULL;
}

LitheIndex lth_reduction_red(const LthReduction *r) { return r->n_red; }

/// Copy the entries of a row, `scale` times.
static void copy_row(const LthBlockMatrix *A, LitheIndex row, double scale, const double *from,
                     double *to) {
  for (LitheCount i = A->row_off[row]; i < A->row_off[row + 1]; i++) to[i] = scale * from[i];
}

/// y_b = S x_b, y_r = 0. With w = (-D_r^-1 A_rb x_b, x_b) it is the black part of A w.
static void apply_schur(const void *self, int threads, const double *x, double *y) {
  const LthReduction *r = self;
  const LthBlockMatrix *A = r->A;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(r->A))
  {
#pragma omp for schedule(static) nowait
    for (LitheIndex k = 0; k < r->n_black; k++) copy_row(A, r->black[k], 1, x, r->w);
#pragma omp for schedule(static)
    for (LitheIndex k = 0; k < r->n_red; k++) {
      LitheIndex row = r->red[k];
      lth_block_matrix_apply_row(A, row, A->diagonal[row], x, y);
      copy_row(A, row, -1, y, r->t);
      lth_block_jacobi_apply_row(r->M, row, r->t, r->w);
      copy_row(A, row, 0, x, y);
    }
#pragma omp for schedule(static)
    for (LitheIndex k = 0; k < r->n_black; k++)
      lth_block_matrix_apply_row(A, r->black[k], -1, r->w, y);
  }
}

/// Block-Jacobi on the black rows; red residuals are zero.
static void apply_black_inverse(const void *self, int threads, const double *x, double *z) {
  const LthReduction *r = self;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(r->A))
  {
#pragma omp for schedule(static) nowait
    for (LitheIndex k = 0; k < r->n_black; k++) lth_block_jacobi_apply_row(r->M, r->black[k], x, z);
#pragma omp for schedule(static)
    for (LitheIndex k = 0; k < r->n_red; k++) copy_row(r->A, r->red[k], 0, x, z);
  }
}

/// rhs = (0, b_b - A_br D_r^-1 b_r); x_r = 0 for the time of the solve.
static void reduce(LthReduction *r, int threads, const double *b, double *x) {
  const LthBlockMatrix *A = r->A;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(r->A))
  {
#pragma omp for schedule(static) nowait
    for (LitheIndex k = 0; k < r->n_black; k++) copy_row(A, r->black[k], 0, b, r->w);
#pragma omp for schedule(static)
    for (LitheIndex k = 0; k < r->n_red; k++) {
      lth_block_jacobi_apply_row(r->M, r->red[k], b, r->w);
      copy_row(A, r->red[k], 0, b, r->rhs);
      copy_row(A, r->red[k], 0, b, x);
    }
#pragma omp for schedule(static)
    for (LitheIndex k = 0; k < r->n_black; k++) {
      LitheIndex row = r->black[k];
      lth_block_matrix_apply_row(A, row, A->diagonal[row], r->w, r->t);
      for (LitheCount i = A->row_off[row]; i < A->row_off[row + 1]; i++) r->rhs[i] = b[i] - r->t[i];
    }
  }
}

/// x_r = D_r^-1 (b_r - A_rb x_b)
static void expand(LthReduction *r, int threads, const double *b, double *x) {
  const LthBlockMatrix *A = r->A;
#pragma omp parallel for schedule(static) num_threads(threads) if (lth_block_matrix_is_large(A))
  for (LitheIndex k = 0; k < r->n_red; k++) {
    LitheIndex row = r->red[k];
    lth_block_matrix_apply_row(A, row, A->diagonal[row], x, r->t);
    for (LitheCount i = A->row_off[row]; i < A->row_off[row + 1]; i++) r->t[i] = b[i] - r->t[i];
    lth_block_jacobi_apply_row(r->M, row, r->t, r->w);
  }
  for (LitheIndex k = 0; k < r->n_red; k++) copy_row(A, r->red[k], 1, r->w, x);
}

LthSolveReport lth_reduction_solve(LthReduction *r, LthCg *cg, int threads, const double *b,
                                   double *x, double tolerance, LitheIndex max_iterations) {
  const LthOperator S = {.n = r->A->n, .apply = apply_schur, .self = r};
  const LthOperator P = {.n = r->A->n, .apply = apply_black_inverse, .self = r};
  const LitheCount n = r->A->n;
  double norm = sqrt(lth_dot(threads, n, b, b));
  reduce(r, threads, b, x);

  // red rows are solved exactly: the residual of S is that of A, and is measured by A's right-hand side
  double reduced = sqrt(lth_dot(threads, n, r->rhs, r->rhs)),
         ratio = reduced > 0 ? norm / reduced : 1;
  LthSolveReport report =
      lth_cg_solve(cg, threads, &S, &P, r->rhs, x, tolerance * ratio, max_iterations);
  expand(r, threads, b, x);
  report.residual /= ratio;
  return report;
}
