/// Block sparse matrix: pattern, lookup, product with a vector.
#include "la/block_matrix.h"

#include "base/clones.h"
#include "la/block_rows.h"
#include "la/krylov.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>

static LitheIndex block_size(const LthBlockMatrix *A, LitheIndex row) {
  return (LitheIndex)(A->row_off[row + 1] - A->row_off[row]);
}

/// Ascending columns within range and a diagonal block in every row.
static LitheStatus check_pattern(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *block_off,
                                 const LitheIndex *block_col) {
  for (LitheIndex row = 0; row < n_rows; row++) {
    bool has_diagonal = false;
    for (LitheCount e = block_off[row]; e < block_off[row + 1]; e++) {
      bool ascends = e == block_off[row] || block_col[e - 1] < block_col[e];
      if (!ascends || block_col[e] < 0 || block_col[e] >= n_rows)
        LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                   "block matrix: columns of row %d must ascend within 0..%d, got %d", (int)row,
                   (int)n_rows - 1, (int)block_col[e]);
      has_diagonal |= block_col[e] == row;
    }
    if (!has_diagonal)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "block matrix: row %d has no diagonal block", (int)row);
  }
  return LITHE_OK;
}

static void fill_offsets(LthBlockMatrix *A) {
  LitheCount value = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      A->value_off[e] = value;
      value += (LitheCount)block_size(A, row) * block_size(A, A->block_col[e]);
      if (A->block_col[e] == row) A->diagonal[row] = e;
    }
  A->value_off[A->block_off[A->n_rows]] = value;
}

/// Pattern alone; value_off as if blocks followed each other.
static LitheStatus create_pattern(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                                  const LitheCount *block_off, const LitheIndex *block_col,
                                  LthBlockMatrix **matrix) {
  static atomic_uint_least64_t last_revision;
  LitheStatus status = LITHE_OK;
  LitheCount n_blocks = block_off[n_rows];
  LthBlockMatrix *A = NULL;
  *matrix = NULL;
  LITHE_TRY(check_pattern(ctx, n_rows, block_off, block_col));
  LTH_NEW_OR(done, ctx, A, 1);
  A->n_rows = n_rows;
  A->n = row_off[n_rows] - row_off[0];
  LTH_NEW_OR(done, ctx, A->row_off, n_rows + 1);
  LTH_NEW_OR(done, ctx, A->block_off, n_rows + 1);
  LTH_NEW_OR(done, ctx, A->block_col, n_blocks);
  LTH_NEW_OR(done, ctx, A->value_off, n_blocks + 1);
  LTH_NEW_OR(done, ctx, A->diagonal, n_rows);
  memcpy(A->row_off, row_off, sizeof *row_off * (size_t)(n_rows + 1));
  memcpy(A->block_off, block_off, sizeof *block_off * (size_t)(n_rows + 1));
  memcpy(A->block_col, block_col, sizeof *block_col * (size_t)n_blocks);
  fill_offsets(A);
  A->pattern_revision = atomic_fetch_add(&last_revision, 1) + 1;
  *matrix = A;
  A = NULL;
done:
  lth_block_matrix_destroy(ctx, &A);
  return status;
}

LitheStatus lth_block_matrix_create(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                                    const LitheCount *block_off, const LitheIndex *block_col,
                                    LthBlockMatrix **matrix) {
  LitheStatus status = LITHE_OK;
  LITHE_TRY(create_pattern(ctx, n_rows, row_off, block_off, block_col, matrix));
  LTH_NEW_OR(done, ctx, (*matrix)->values, (*matrix)->value_off[block_off[n_rows]]);
done:
  if (status != LITHE_OK) lth_block_matrix_destroy(ctx, matrix);
  return status;
}

LitheStatus lth_block_matrix_create_rough(LitheCtx *ctx, LitheIndex n_rows,
                                          const LitheCount *row_off, const LitheCount *block_off,
                                          const LitheIndex *block_col, LthBlockMatrix **matrix) {
  LitheStatus status = LITHE_OK;
  LITHE_TRY(create_pattern(ctx, n_rows, row_off, block_off, block_col, matrix));
  LTH_NEW_ROUGH_OR(done, ctx, (*matrix)->values, (*matrix)->value_off[block_off[n_rows]]);
done:
  if (status != LITHE_OK) lth_block_matrix_destroy(ctx, matrix);
  return status;
}

LitheStatus lth_block_matrix_lend(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                                  const LitheCount *block_off, const LitheIndex *block_col,
                                  const LitheCount *value_off, double *values,
                                  LthBlockMatrix **matrix) {
  LITHE_TRY(create_pattern(ctx, n_rows, row_off, block_off, block_col, matrix));
  memcpy((*matrix)->value_off, value_off, sizeof *value_off * (size_t)(block_off[n_rows] + 1));
  (*matrix)->values = values;
  (*matrix)->is_lent = true;
  return LITHE_OK;
}

void lth_block_matrix_destroy(LitheCtx *ctx, LthBlockMatrix **matrix) {
  if (!matrix || !*matrix) return;
  LthBlockMatrix *A = *matrix;
  lth_free(ctx, A->row_off);
  lth_free(ctx, A->block_off);
  lth_free(ctx, A->block_col);
  lth_free(ctx, A->value_off);
  lth_free(ctx, A->diagonal);
  if (!A->is_lent) lth_free(ctx, A->values);
  lth_free(ctx, A);
  *matrix = NULL;
}

LitheCount lth_block_matrix_find(const LthBlockMatrix *A, LitheIndex row, LitheIndex col) {
  LitheCount first = A->block_off[row], last = A->block_off[row + 1];
  while (first < last) {
    LitheCount middle = first + (last - first) / 2;
    if (A->block_col[middle] < col)
      first = middle + 1;
    else
      last = middle;
  }
  return first < A->block_off[row + 1] && A->block_col[first] == col ? first : -1;
}

/// That of all blocks of a row where they are square and have the same, else 0.
static LitheIndex common_size(const LthBlockMatrix *A, LitheIndex row) {
  const LitheIndex size = block_size(A, row);
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (block_size(A, A->block_col[e]) != size) return 0;
  return size;
}

/// As apply_row(), to the bit, where all blocks are 12 x 12.
LTH_CLONES
static void apply_row_12(const LthBlockMatrix *A, LitheIndex row, LitheCount skip,
                         const double *restrict x, double *restrict y) {
  LthRows12 s;
  lth_rows12_zero(&s);
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (e != skip) lth_rows12_add(A->values + A->value_off[e], x + A->row_off[A->block_col[e]], &s);
  double *yr = y + A->row_off[row];
#pragma GCC unroll 3
  for (int r = 0; r < LTH_TWELVE; r += 4) lth_quad_sums(s.row + r, (LthQuad *)(yr + r));
}

/// The same where all are 3 x 3.
LTH_CLONES
static void apply_row_3(const LthBlockMatrix *A, LitheIndex row, LitheCount skip,
                        const double *restrict x, double *restrict y) {
  LthRows3 s = {0};
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (e != skip) lth_rows3_add(A->values + A->value_off[e], x + A->row_off[A->block_col[e]], &s);
  lth_rows3_sums(&s, y + A->row_off[row]);
}

/// y of one block row without block `skip`; three rows of every block at a time share the loads of x.
/// Quads are summed once at the end of the row, so short blocks cost no horizontal sums.
LTH_CLONES
static void apply_row(const LthBlockMatrix *A, LitheIndex row, LitheCount skip,
                      const double *restrict x, double *restrict y) {
  const LitheIndex m = block_size(A, row);
  for (LitheIndex r = 0; r < m; r += 3) {
    const LitheIndex r1 = r + 1 < m ? r + 1 : r, r2 = r + 2 < m ? r + 2 : r;
    LthQuad s0 = {0}, s1 = {0}, s2 = {0};
    double t0 = 0, t1 = 0, t2 = 0;
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      if (e == skip) continue;
      const LitheIndex col = A->block_col[e], n = block_size(A, col);
      const double *restrict B = A->values + A->value_off[e];
      const double *b0 = B + (size_t)r * (size_t)n, *b1 = B + (size_t)r1 * (size_t)n,
                   *b2 = B + (size_t)r2 * (size_t)n, *xc = x + A->row_off[col];
      LitheIndex c = 0;
      for (; c + 4 <= n; c += 4) {
        const LthQuad v = LTH_QUAD(xc + c);
        s0 += LTH_QUAD(b0 + c) * v;
        s1 += LTH_QUAD(b1 + c) * v;
        s2 += LTH_QUAD(b2 + c) * v;
      }
      for (; c < n; c++) {
        t0 += b0[c] * xc[c];
        t1 += b1[c] * xc[c];
        t2 += b2[c] * xc[c];
      }
    }
    double *yr = y + A->row_off[row];
    yr[r] = lth_quad_sum(&s0) + t0;
    if (r + 1 < m) yr[r + 1] = lth_quad_sum(&s1) + t1;
    if (r + 2 < m) yr[r + 2] = lth_quad_sum(&s2) + t2;
  }
}

static void apply_any_row(const LthBlockMatrix *A, LitheIndex row, LitheCount skip, const double *x,
                          double *y) {
  const LitheIndex size = common_size(A, row);
  if (size == LTH_TWELVE)
    apply_row_12(A, row, skip, x, y);
  else if (size == LTH_THREE)
    apply_row_3(A, row, skip, x, y);
  else
    apply_row(A, row, skip, x, y);
}

void lth_block_matrix_apply(const LthBlockMatrix *A, int threads, const double *x, double *y) {
#pragma omp parallel for schedule(static) num_threads(threads) if (lth_block_matrix_is_large(A))
  for (LitheIndex row = 0; row < A->n_rows; row++) apply_any_row(A, row, -1, x, y);
}

void lth_block_matrix_apply_row(const LthBlockMatrix *A, LitheIndex row, LitheCount skip,
                                const double *x, double *y) {
  apply_any_row(A, row, skip, x, y);
}

double lth_block_matrix_rounding(const LthBlockMatrix *A, const double *x, const double *b) {
  double sum = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheIndex m = block_size(A, row);
    for (LitheIndex r = 0; r < m; r++) {
      double size = fabs(b[A->row_off[row] + r]);
      for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
        LitheIndex col = A->block_col[e], n = block_size(A, col);
        const double *B = A->values + A->value_off[e] + (LitheCount)r * n;
        for (LitheIndex c = 0; c < n; c++) size += fabs(B[c] * x[A->row_off[col] + c]);
      }
      sum += size * size;
    }
  }
  return 0x1p-53 * sqrt(sum);
}

static void apply_operator(const void *self, int threads, const double *x, double *y) {
  lth_block_matrix_apply(self, threads, x, y);
}

LthOperator lth_block_matrix_operator(const LthBlockMatrix *A) {
  return (LthOperator){.n = A->n, .apply = apply_operator, .self = A};
}

double lth_block_matrix_asymmetry(const LthBlockMatrix *A) {
  double largest = 0, difference = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      LitheIndex col = A->block_col[e], m = block_size(A, row), n = block_size(A, col);
      LitheCount twin = lth_block_matrix_find(A, col, row);
      const double *B = A->values + A->value_off[e];
      const double *T = twin < 0 ? NULL : A->values + A->value_off[twin];
      for (LitheIndex r = 0; r < m; r++)
        for (LitheIndex c = 0; c < n; c++) {
          double b = B[r * n + c], t = T ? T[c * m + r] : 0;
          largest = fmax(largest, fabs(b));
          difference = fmax(difference, fabs(b - t));
        }
    }
  return largest > 0 ? difference / largest : 0;
}
