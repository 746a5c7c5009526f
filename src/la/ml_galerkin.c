/// Galerkin products: P^T A P column by column, and the leading unknowns of block rows.
#include "la/ml_priv.h"

#include <omp.h>
#include <string.h>

/// Neighbours of a row that are not yet in the list.
static LitheIndex add_row(const LthBlockMatrix *A, LitheIndex row, LitheIndex n, LitheIndex *slot,
                          LitheIndex *list) {
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (slot[A->block_col[e]] < 0) {
      slot[A->block_col[e]] = n;
      list[n++] = A->block_col[e];
    }
  return n;
}

/// Fine rows that (A + touch) P has in column J: neighbours of P's rows there, in the order of their discovery. `slot`
/// (n_rows) is -1 everywhere before and after; during the call it tells the place in `list`.
static LitheIndex reach(const LthLevel *fine, LitheIndex J, LitheIndex *slot, LitheIndex *list) {
  const LthTransfer *P = fine->P;
  LitheIndex n = 0;
  for (LitheCount t = P->twin_off[J]; t < P->twin_off[J + 1]; t++) {
    n = add_row(fine->A, P->twin_row[t], n, slot, list);
    if (fine->touch) n = add_row(fine->touch, P->twin_row[t], n, slot, list);
  }
  return n;
}

static void forget(LitheIndex n, const LitheIndex *list, LitheIndex *slot) {
  for (LitheIndex i = 0; i < n; i++) slot[list[i]] = -1;
}

/// Columns of P in the rows listed, unsorted; `seen` (n_cols) holds J where a column was met for J.
static LitheIndex coarse_columns(const LthTransfer *P, LitheIndex J, LitheIndex n,
                                 const LitheIndex *list, LitheIndex *seen, LitheIndex *col) {
  LitheIndex count = 0;
  for (LitheIndex i = 0; i < n; i++)
    for (LitheCount e = P->block_off[list[i]]; e < P->block_off[list[i] + 1]; e++)
      if (seen[P->block_col[e]] != J) {
        seen[P->block_col[e]] = J;
        if (col) col[count] = P->block_col[e];
        count++;
      }
  return count;
}

static void sort(LitheIndex n, LitheIndex *list) {
  for (LitheIndex i = 1; i < n; i++) {
    LitheIndex value = list[i], at = i;
    for (; at > 0 && list[at - 1] > value; at--) list[at] = list[at - 1];
    list[at] = value;
  }
}

static LitheStatus make_scratch(LitheCtx *ctx, const LthBlockMatrix *A, LitheIndex most,
                                LthGalerkin *g) {
  LitheCount block = 0;
  for (LitheIndex i = 0; i < A->n_rows; i++)
    if (lth_ml_size(A, i) * LTH_ML_PADDED > block) block = lth_ml_size(A, i) * LTH_ML_PADDED;
  bool fits = g->slot && g->threads == lth_threads(ctx) && g->n_rows >= A->n_rows &&
              g->most >= most && g->block >= block;
  if (fits) return LITHE_OK;
  if (A->n_rows > g->n_rows) g->n_rows = A->n_rows;
  if (most > g->most) g->most = most;
  if (block > g->block) g->block = block;
  g->threads = lth_threads(ctx);
  lth_ml_galerkin_free(ctx, g);
  LTH_NEW(ctx, g->slot, (LitheCount)g->threads * g->n_rows);
  LTH_NEW(ctx, g->list, (LitheCount)g->threads * g->most);
  LTH_NEW(ctx, g->product, (LitheCount)g->threads * g->most * g->block);
  memset(g->slot, 0xff, sizeof *g->slot * (size_t)g->threads * (size_t)g->n_rows);
  return LITHE_OK;
}

void lth_ml_galerkin_free(LitheCtx *ctx, LthGalerkin *g) {
  lth_free(ctx, g->slot);
  lth_free(ctx, g->list);
  lth_free(ctx, g->product);
  g->slot = NULL;
  g->list = NULL;
  g->product = NULL;
}

LitheStatus lth_ml_galerkin_create(LitheCtx *ctx, const LthLevel *fine, LthGalerkin *g,
                                   LthBlockMatrix **coarse) {
  const LthBlockMatrix *A = fine->A;
  const LthTransfer *P = fine->P;
  LitheStatus status = LITHE_OK;
  LitheIndex *slot = NULL, *list = NULL, *seen = NULL, *col = NULL, most = 0;
  LitheCount *off = NULL;
  *coarse = NULL;
  LTH_NEW_OR(done, ctx, slot, A->n_rows);
  LTH_NEW_OR(done, ctx, list, A->n_rows);
  LTH_NEW_OR(done, ctx, seen, P->n_cols);
  LTH_NEW_OR(done, ctx, off, P->n_cols + 1);
  memset(slot, 0xff, sizeof *slot * (size_t)A->n_rows);
  memset(seen, 0xff, sizeof *seen * (size_t)P->n_cols);
  for (int pass = 0; pass < 2; pass++) {
    for (LitheIndex J = 0; J < P->n_cols; J++) {
      LitheIndex n = reach(fine, J, slot, list);
      LitheIndex count = coarse_columns(P, J, n, list, seen, col ? col + off[J] : NULL);
      forget(n, list, slot);
      if (n > most) most = n;
      if (pass == 0) off[J + 1] = off[J] + count;
      if (pass == 1) sort(count, col + off[J]);
    }
    if (pass == 0) LTH_NEW_OR(done, ctx, col, off[P->n_cols]);
    memset(seen, 0xff, sizeof *seen * (size_t)P->n_cols);
  }
  if (lth_ml_transfer_widest(P) > most) most = lth_ml_transfer_widest(P);
  LITHE_TRY_OR(done, make_scratch(ctx, A, most, g));
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, P->n_cols, P->col_off, off, col, coarse));
done:
  lth_free(ctx, slot);
  lth_free(ctx, list);
  lth_free(ctx, seen);
  lth_free(ctx, col);
  lth_free(ctx, off);
  return status;
}

/// C (n x nj) += P^T T, P (m x n), T (m x 8).
static void add_outer(int m, int n, int nj, const float *P, const double *T, double *C) {
  double padded[LTH_ML_ROW * LTH_ML_PADDED], sum[LTH_ML_MODES * LTH_ML_PADDED] = {0};
  lth_ml_pad(m, n, P, padded);
  lth_ml_add_product(n, m, padded, 1, LTH_ML_PADDED, T, sum);
  for (int a = 0; a < n; a++)
    for (int b = 0; b < nj; b++) C[a * nj + b] += sum[LTH_ML_PADDED * a + b];
}

/// The rows of a product with P, in the order of `slot`, take what row i of A^T = A gives them.
static void multiply_row(const LthBlockMatrix *A, LitheIndex i, const double *Q,
                         const LitheIndex *slot, LitheCount block, double *product) {
  for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++) {
    const LitheIndex col = A->block_col[e];
    const int n = lth_ml_size(A, col);
    lth_ml_add_product(n, lth_ml_size(A, i), A->values + A->value_off[e], 1, n, Q,
                       product + slot[col] * block);
  }
}

/// Column J of the coarse matrix, the blocks on and above the diagonal: first A P, then P^T of that.
static void fill_column(const LthLevel *fine, LitheIndex J, LitheIndex *slot, LitheIndex *list,
                        double *product, LitheCount block, LthBlockMatrix *coarse) {
  const LthBlockMatrix *A = fine->A;
  const LthTransfer *P = fine->P;
  double Q[LTH_ML_ROW * LTH_ML_PADDED];
  const LitheIndex n = reach(fine, J, slot, list);
  const int nj = (int)(P->col_off[J + 1] - P->col_off[J]);
  memset(product, 0, sizeof *product * (size_t)(n * block));
  for (LitheCount t = P->twin_off[J]; t < P->twin_off[J + 1]; t++) {
    const LitheIndex i = P->twin_row[t];
    const int m = lth_ml_size(A, i);
    lth_ml_pad(m, nj, P->values + P->value_off[P->twin[t]], Q);
    multiply_row(A, i, Q, slot, block, product);
    if (fine->touch) multiply_row(fine->touch, i, Q, slot, block, product);
  }
  for (LitheIndex k = 0; k < n; k++)
    for (LitheCount e = P->block_off[list[k]]; e < P->block_off[list[k] + 1]; e++) {
      const LitheIndex I = P->block_col[e];
      if (I > J) break;
      // block (I, J) belongs to nobody else's column
      double *C = coarse->values + coarse->value_off[lth_block_matrix_find(coarse, I, J)];
      add_outer(lth_ml_size(A, list[k]), (int)(P->col_off[I + 1] - P->col_off[I]), nj,
                P->values + P->value_off[e], product + k * block, C);
    }
  forget(n, list, slot);
}

/// The lower triangle from the upper one, and a diagonal that is symmetric to the last bit.
static void mirror_row(LthBlockMatrix *A, LitheIndex row) {
  const int m = lth_ml_size(A, row);
  for (LitheCount e = A->block_off[row]; e <= A->diagonal[row]; e++) {
    const LitheIndex col = A->block_col[e];
    const int n = lth_ml_size(A, col);
    double *B = A->values + A->value_off[e];
    if (col == row) {
      for (int r = 0; r < m; r++)
        for (int c = 0; c < r; c++)
          B[r * m + c] = B[c * m + r] = 0.5 * (B[r * m + c] + B[c * m + r]);
      return;
    }
    const double *T = A->values + A->value_off[lth_block_matrix_find(A, col, row)];
    for (int r = 0; r < m; r++)
      for (int c = 0; c < n; c++) B[r * n + c] = T[c * m + r];
  }
}

void lth_ml_galerkin(const LthLevel *fine, const LthGalerkin *g, LthBlockMatrix *coarse) {
  memset(coarse->values, 0,
         sizeof *coarse->values * (size_t)coarse->value_off[coarse->block_off[coarse->n_rows]]);
#pragma omp parallel num_threads(g->threads)
  {
    const int thread = omp_get_thread_num();
#pragma omp for schedule(dynamic, 16)
    for (LitheIndex J = 0; J < coarse->n_rows; J++)
      fill_column(fine, J, g->slot + (LitheCount)thread * g->n_rows,
                  g->list + (LitheCount)thread * g->most,
                  g->product + (LitheCount)thread * g->most * g->block, g->block, coarse);
#pragma omp for schedule(static)
    for (LitheIndex row = 0; row < coarse->n_rows; row++) mirror_row(coarse, row);
  }
}

/// Columns of a row that A or touch has, ascending.
static LitheIndex join_row(const LthLevel *fine, LitheIndex row, LitheIndex *col) {
  const LthBlockMatrix *A = fine->A, *T = fine->touch;
  LitheCount a = A->block_off[row], t = T ? T->block_off[row] : 0;
  const LitheCount a_end = A->block_off[row + 1], t_end = T ? T->block_off[row + 1] : 0;
  LitheIndex n = 0;
  while (a < a_end || t < t_end) {
    LitheIndex from_a = a < a_end ? A->block_col[a] : A->n_rows;
    LitheIndex from_t = t < t_end ? T->block_col[t] : A->n_rows;
    LitheIndex next = from_a < from_t ? from_a : from_t;
    a += from_a == next;
    t += from_t == next;
    if (col) col[n] = next;
    n++;
  }
  return n;
}

LitheStatus lth_ml_leading_create(LitheCtx *ctx, const LthLevel *fine, LthBlockMatrix **coarse) {
  LitheStatus status = LITHE_OK;
  const LitheIndex n = fine->A->n_rows;
  LitheCount *off = NULL, *block_off = NULL;
  LitheIndex *col = NULL;
  LTH_NEW_OR(done, ctx, off, n + 1);
  LTH_NEW_OR(done, ctx, block_off, n + 1);
  for (LitheIndex i = 0; i < n; i++) {
    off[i + 1] = off[i] + fine->lead[i];
    block_off[i + 1] = block_off[i] + join_row(fine, i, NULL);
  }
  LTH_NEW_OR(done, ctx, col, block_off[n]);
  for (LitheIndex i = 0; i < n; i++) join_row(fine, i, col + block_off[i]);
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, n, off, block_off, col, coarse));
done:
  lth_free(ctx, off);
  lth_free(ctx, block_off);
  lth_free(ctx, col);
  return status;
}

/// to (m x n) += the leading rows and columns of a block with rows as long as `stride`.
static void add_leading(int m, int n, int stride, const double *from, double *to) {
  for (int r = 0; r < m; r++)
    for (int c = 0; c < n; c++) to[r * n + c] += from[r * stride + c];
}

static void add_leading_row(const LthBlockMatrix *A, LitheIndex row, LthBlockMatrix *coarse) {
  LitheCount at = coarse->block_off[row];
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    const LitheIndex col = A->block_col[e];
    while (coarse->block_col[at] != col) at++;
    add_leading(lth_ml_size(coarse, row), lth_ml_size(coarse, col), lth_ml_size(A, col),
                A->values + A->value_off[e], coarse->values + coarse->value_off[at]);
  }
}

void lth_ml_leading(const LthLevel *fine, int threads, LthBlockMatrix *coarse) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex row = 0; row < fine->A->n_rows; row++) {
    const LitheCount first = coarse->value_off[coarse->block_off[row]],
                     last = coarse->value_off[coarse->block_off[row + 1]];
    memset(coarse->values + first, 0, sizeof *coarse->values * (size_t)(last - first));
    add_leading_row(fine->A, row, coarse);
    if (fine->touch) add_leading_row(fine->touch, row, coarse);
  }
}
