/// Prolongation between levels: pattern, products.
#include "la/ml_priv.h"

#include "base/clones.h"
#include "base/quad.h"

#include <omp.h>
#include <string.h>

typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));

#define WIDEN(from) __builtin_convertvector(*(const Four *)(from), LthQuad)

void lth_ml_transfer_destroy(LitheCtx *ctx, LthTransfer **transfer) {
  if (!transfer || !*transfer) return;
  LthTransfer *P = *transfer;
  lth_free(ctx, P->row_off);
  lth_free(ctx, P->col_off);
  lth_free(ctx, P->block_off);
  lth_free(ctx, P->block_col);
  lth_free(ctx, P->value_off);
  lth_free(ctx, P->values);
  lth_free(ctx, P->twin_off);
  lth_free(ctx, P->twin);
  lth_free(ctx, P->twin_row);
  lth_free(ctx, P);
  *transfer = NULL;
}

/// Columns that `in` has in a row and its neighbours, ascending, into `col`; returns how many. `seen` (n_cols)
/// is not `row` anywhere before.
static LitheIndex spread(const LthBlockMatrix *A, const LthTransfer *in, LitheIndex row,
                         LitheIndex *seen, LitheIndex *col) {
  LitheIndex n = 0;
  for (LitheCount a = A->block_off[row]; a < A->block_off[row + 1]; a++)
    for (LitheCount e = in->block_off[A->block_col[a]]; e < in->block_off[A->block_col[a] + 1];
         e++) {
      LitheIndex c = in->block_col[e], at = n;
      if (seen[c] == row) continue;
      seen[c] = row;
      for (; at > 0 && col[at - 1] > c; at--) col[at] = col[at - 1];
      col[at] = c;
      n++;
    }
  return n;
}

static void fill_offsets(LthTransfer *P) {
  LitheCount value = 0;
  for (LitheIndex i = 0; i < P->n_rows; i++)
    for (LitheCount e = P->block_off[i]; e < P->block_off[i + 1]; e++) {
      P->value_off[e] = value;
      LitheIndex col = P->block_col[e];
      value += (P->row_off[i + 1] - P->row_off[i]) * (P->col_off[col + 1] - P->col_off[col]);
    }
  P->value_off[P->block_off[P->n_rows]] = value;
}

static void list_twins(LthTransfer *P) {
  for (LitheCount e = 0; e < P->block_off[P->n_rows]; e++) P->twin_off[P->block_col[e] + 1]++;
  for (LitheIndex c = 0; c < P->n_cols; c++) P->twin_off[c + 1] += P->twin_off[c];
  for (LitheIndex i = 0; i < P->n_rows; i++)
    for (LitheCount e = P->block_off[i]; e < P->block_off[i + 1]; e++) {
      LitheCount at = P->twin_off[P->block_col[e]]++;
      P->twin[at] = e;
      P->twin_row[at] = i;
    }
  for (LitheIndex c = P->n_cols; c > 0; c--) P->twin_off[c] = P->twin_off[c - 1];
  P->twin_off[0] = 0;
}

/// What follows from rows, columns and block_off.
static LitheStatus allocate(LitheCtx *ctx, LthTransfer *P) {
  LitheCount n_blocks = P->block_off[P->n_rows];
  LTH_NEW(ctx, P->block_col, n_blocks);
  LTH_NEW(ctx, P->value_off, n_blocks + 1);
  LTH_NEW(ctx, P->twin_off, P->n_cols + 1);
  LTH_NEW(ctx, P->twin, n_blocks);
  LTH_NEW(ctx, P->twin_row, n_blocks);
  return LITHE_OK;
}

static LitheStatus create(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                          LitheIndex n_cols, const LitheCount *col_off, LthTransfer **transfer) {
  LTH_NEW(ctx, *transfer, 1);
  LthTransfer *P = *transfer;
  P->n_rows = n_rows;
  P->n_cols = n_cols;
  LTH_NEW(ctx, P->row_off, n_rows + 1);
  LTH_NEW(ctx, P->col_off, n_cols + 1);
  LTH_NEW(ctx, P->block_off, n_rows + 1);
  memcpy(P->row_off, row_off, sizeof *row_off * (size_t)(n_rows + 1));
  memcpy(P->col_off, col_off, sizeof *col_off * (size_t)(n_cols + 1));
  return LITHE_OK;
}

static LitheStatus finish(LitheCtx *ctx, LthTransfer *P) {
  fill_offsets(P);
  list_twins(P);
  LTH_NEW(ctx, P->values, P->value_off[P->block_off[P->n_rows]] + 2); // add_rows() reads beyond
  return LITHE_OK;
}

LitheStatus lth_ml_transfer_create(LitheCtx *ctx, const LthLevel *fine, const LitheCount *col_off,
                                   LthTransfer **transfer) {
  LitheStatus status = LITHE_OK;
  LthTransfer *P = NULL;
  LITHE_TRY_OR(done,
               create(ctx, fine->A->n_rows, fine->A->row_off, fine->n_aggregates, col_off, &P));
  for (LitheIndex i = 0; i < P->n_rows; i++)
    P->block_off[i + 1] = P->block_off[i] + (fine->aggregate[i] >= 0);
  LITHE_TRY_OR(done, allocate(ctx, P));
  for (LitheIndex i = 0; i < P->n_rows; i++)
    if (fine->aggregate[i] >= 0) P->block_col[P->block_off[i]] = fine->aggregate[i];
  LITHE_TRY_OR(done, finish(ctx, P));
done:
  *transfer = P;
  return status;
}

LitheStatus lth_ml_transfer_spread(LitheCtx *ctx, const LthBlockMatrix *A, const LthTransfer *in,
                                   LthTransfer **transfer) {
  LitheStatus status = LITHE_OK;
  LthTransfer *P = NULL;
  LitheIndex *seen = NULL, *col = NULL;
  LTH_NEW_OR(done, ctx, seen, in->n_cols);
  LTH_NEW_OR(done, ctx, col, in->n_cols);
  LITHE_TRY_OR(done, create(ctx, in->n_rows, in->row_off, in->n_cols, in->col_off, &P));
  for (int pass = 0; pass < 2; pass++) {
    for (LitheIndex i = 0; i < in->n_cols; i++) seen[i] = -1;
    for (LitheIndex i = 0; i < P->n_rows; i++) {
      LitheIndex n = spread(A, in, i, seen, col);
      if (pass == 0) P->block_off[i + 1] = P->block_off[i] + n;
      if (pass == 1) memcpy(P->block_col + P->block_off[i], col, sizeof *col * (size_t)n);
    }
    if (pass == 0) LITHE_TRY_OR(done, allocate(ctx, P));
  }
  LITHE_TRY_OR(done, finish(ctx, P));
done:
  lth_free(ctx, seen);
  lth_free(ctx, col);
  *transfer = P;
  return status;
}

LitheIndex lth_ml_transfer_widest(const LthTransfer *P) {
  LitheCount most = 0;
  for (LitheIndex i = 0; i < P->n_rows; i++)
    if (P->block_off[i + 1] - P->block_off[i] > most) most = P->block_off[i + 1] - P->block_off[i];
  return (LitheIndex)most;
}

static bool is_large(const LthTransfer *P) {
  return P->value_off[P->block_off[P->n_rows]] > 150000;
}

/// A row of six columns: those from the fifth on are the next row's and count for nothing.
typedef struct Row {
  LthQuad low, high;
} Row;

static inline void add_row(double factor, const float *B, Row *sum) {
  sum->low += factor * WIDEN(B);
  sum->high += factor * WIDEN(B + 4);
}

/// sum += B^T r, B (m x 6).
static inline void add_rows(LitheCount m, const float *restrict B, const double *restrict r,
                            Row *sum) {
  Row odd = {0};
  LitheCount i = 0;
  for (; i + 2 <= m; i += 2, B += 2 * LTH_ML_MODES) {
    add_row(r[i], B, sum);
    add_row(r[i + 1], B + LTH_ML_MODES, &odd);
  }
  if (i < m) add_row(r[i], B, sum);
  sum->low += odd.low;
  sum->high += odd.high;
}

/// b = P^T r in a block column of six columns.
LTH_CLONES
static void restrict_column_6(const LthTransfer *P, LitheIndex col, const double *restrict r,
                              double *restrict b) {
  Row sum = {0};
  for (LitheCount t = P->twin_off[col]; t < P->twin_off[col + 1]; t++) {
    const LitheCount first = P->row_off[P->twin_row[t]], last = P->row_off[P->twin_row[t] + 1];
    add_rows(last - first, P->values + P->value_off[P->twin[t]], r + first, &sum);
  }
  *(LthQuad *)b = sum.low;
  b[4] = sum.high[0];
  b[5] = sum.high[1];
}

/// The same for fewer columns.
static void restrict_column(const LthTransfer *P, LitheIndex col, const double *restrict r,
                            double *restrict b) {
  const int n = (int)(P->col_off[col + 1] - P->col_off[col]);
  for (int c = 0; c < n; c++) b[c] = 0;
  for (LitheCount t = P->twin_off[col]; t < P->twin_off[col + 1]; t++) {
    const float *restrict B = P->values + P->value_off[P->twin[t]];
    const LitheCount first = P->row_off[P->twin_row[t]], last = P->row_off[P->twin_row[t] + 1];
    for (LitheCount i = first; i < last; i++, B += n)
      for (int c = 0; c < n; c++) b[c] += B[c] * r[i];
  }
}

void lth_ml_restrict(const LthTransfer *P, int threads, const double *r, double *b) {
#pragma omp parallel for schedule(static) num_threads(threads) if (is_large(P))
  for (LitheIndex col = 0; col < P->n_cols; col++)
    if (P->col_off[col + 1] - P->col_off[col] == LTH_ML_MODES)
      restrict_column_6(P, col, r, b + P->col_off[col]);
    else
      restrict_column(P, col, r, b + P->col_off[col]);
}

LTH_CLONES
static void prolong_row(const LthTransfer *P, LitheIndex row, const double *restrict e,
                        double *restrict x) {
  const LitheCount first = P->row_off[row], last = P->row_off[row + 1];
  for (LitheCount k = P->block_off[row]; k < P->block_off[row + 1]; k++) {
    const LitheIndex col = P->block_col[k];
    const int n = (int)(P->col_off[col + 1] - P->col_off[col]);
    const float *restrict B = P->values + P->value_off[k];
    const double *ec = e + P->col_off[col];
    if (n == LTH_ML_MODES)
      for (LitheCount i = first; i < last; i++, B += LTH_ML_MODES)
        x[i] += (B[0] * ec[0] + B[1] * ec[1]) + (B[2] * ec[2] + B[3] * ec[3]) +
                (B[4] * ec[4] + B[5] * ec[5]);
    else
      for (LitheCount i = first; i < last; i++, B += n) {
        double sum = 0;
        for (int c = 0; c < n; c++) sum += B[c] * ec[c];
        x[i] += sum;
      }
  }
}

void lth_ml_prolong(const LthTransfer *P, int threads, const double *e, double *x) {
#pragma omp parallel for schedule(static) num_threads(threads) if (is_large(P))
  for (LitheIndex row = 0; row < P->n_rows; row++) prolong_row(P, row, e, x);
}
