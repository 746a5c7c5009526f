/// Block sparse matrix with dense blocks of varying size: one block row per element.
#pragma once

#include "base/ctx.h"

/// Both triangles are stored; columns ascend; blocks are dense and row-major. Pattern and values are
/// split so that a new assembly keeps the pattern.
typedef struct LthBlockMatrix {
  LitheIndex n_rows;         ///< block rows = block columns
  LitheCount n;              ///< scalar rows
  LitheCount *row_off;       ///< first scalar row of a block row            (n_rows + 1)
  LitheCount *block_off;     ///< blocks of a row                             (n_rows + 1)
  LitheIndex *block_col;     ///< block column of a block                     (n_blocks)
  LitheCount *value_off;     ///< first value of a block                      (n_blocks + 1)
  LitheCount *diagonal;      ///< block index of the diagonal block of a row  (n_rows)
  double *values;            ///< (value_off[n_blocks])
  bool is_lent;              ///< the values are another's
  uint64_t pattern_revision; ///< changes when the pattern does: a symbolic analysis is stale then
} LthBlockMatrix;

/// Allocate for a pattern given by ascending columns per row, diagonal included. All is copied.
LitheStatus lth_block_matrix_create(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                                    const LitheCount *block_off, const LitheIndex *block_col,
                                    LthBlockMatrix **A);

/// The same for who writes all blocks before they are read: values are not zero.
LitheStatus lth_block_matrix_create_rough(LitheCtx *ctx, LitheIndex n_rows,
                                          const LitheCount *row_off, const LitheCount *block_off,
                                          const LitheIndex *block_col, LthBlockMatrix **A);

/// The same over values of another, borrowed for life: those of block e from value_off[e] on, none of them beyond
/// value_off[n_blocks].
LitheStatus lth_block_matrix_lend(LitheCtx *ctx, LitheIndex n_rows, const LitheCount *row_off,
                                  const LitheCount *block_off, const LitheIndex *block_col,
                                  const LitheCount *value_off, double *values, LthBlockMatrix **A);
void lth_block_matrix_destroy(LitheCtx *ctx, LthBlockMatrix **A);

/// Block (row, col), or -1. Binary search.
LitheCount lth_block_matrix_find(const LthBlockMatrix *A, LitheIndex row, LitheIndex col);

/// y = A x on `threads` threads; the same bits for any number of them.
void lth_block_matrix_apply(const LthBlockMatrix *A, int threads, const double *x, double *y);

/// Rounding of a product A x beside b: |(|A| |x| + |b|)| times the unit of rounding. A residual of a few times that is
/// the best that a solution in double precision has.
double lth_block_matrix_rounding(const LthBlockMatrix *A, const double *x, const double *b);

/// The entries of y = A x in one block row alone; block `skip` (-1: none) counts as zero.
void lth_block_matrix_apply_row(const LthBlockMatrix *A, LitheIndex row, LitheCount skip,
                                const double *x, double *y);

/// True where products are long enough for several threads to pay; to wake them takes microseconds, and on a
/// busy machine much longer.
static inline bool lth_block_matrix_is_large(const LthBlockMatrix *A) {
  return A->value_off[A->block_off[A->n_rows]] > 150000;
}

/// Largest |A - A^T| over largest |A|.
double lth_block_matrix_asymmetry(const LthBlockMatrix *A);

/// 2-norm condition number of a symmetric positive definite A: dense eigenvalues (LAPACK) up to 3000
/// unknowns, Lanczos with a Cholesky factor beyond. LITHE_BAD_INPUT where A is not definite.
LitheStatus lth_block_matrix_condition(LitheCtx *ctx, const LthBlockMatrix *A, double *condition);

/// The same without the `n_zero` smallest eigenvalues: six are those of rigid motions. By dense eigenvalues: for small A.
LitheStatus lth_block_matrix_condition_beyond(LitheCtx *ctx, const LthBlockMatrix *A, int n_zero,
                                              double *condition);
