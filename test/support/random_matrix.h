/// Random block matrices for tests: chains with fill, blocks of the sizes that degrees give.
#pragma once

#include "check.h"

#include "la/block_matrix.h"

#include <string.h>

/// Block sizes cycle through `sizes`; row i couples with i +- 1 and i +- 7. Diagonally dominant, hence
/// definite; symmetric to the bit.
static inline LthBlockMatrix *random_matrix(LitheCtx *ctx, LitheIndex n_rows, const int *sizes,
                                            int n_sizes, uint64_t seed) {
  LitheCount *row_off = calloc((size_t)n_rows + 1, sizeof *row_off);
  LitheCount *block_off = calloc((size_t)n_rows + 1, sizeof *block_off);
  LitheIndex *block_col = calloc((size_t)n_rows * 5, sizeof *block_col);
  static const LitheIndex reach[] = {-7, -1, 0, 1, 7};
  LitheCount n_blocks = 0;
  for (LitheIndex i = 0; i < n_rows; i++) {
    row_off[i + 1] = row_off[i] + sizes[i % n_sizes];
    for (int k = 0; k < 5; k++)
      if (i + reach[k] >= 0 && i + reach[k] < n_rows) block_col[n_blocks++] = i + reach[k];
    block_off[i + 1] = n_blocks;
  }
  LthBlockMatrix *A = NULL;
  CHECK_OK(ctx, lth_block_matrix_create(ctx, n_rows, row_off, block_off, block_col, &A));
  for (LitheIndex i = 0; i < n_rows; i++)
    for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++) {
      LitheIndex j = A->block_col[e];
      int m = sizes[i % n_sizes], n = sizes[j % n_sizes];
      double *B = A->values + A->value_off[e];
      if (j < i) { // the mirror of an upper block
        const double *T = A->values + A->value_off[lth_block_matrix_find(A, j, i)];
        for (int r = 0; r < m; r++)
          for (int c = 0; c < n; c++) B[r * n + c] = T[c * m + r];
        continue;
      }
      for (int r = 0; r < m; r++)
        for (int c = j == i ? r : 0; c < n; c++) {
          B[r * n + c] = test_random(&seed) - 0.5;
          if (j == i) B[c * n + r] = B[r * n + c];
        }
      // each of at most 5 blocks adds at most half its columns to a row's sum
      if (j == i)
        for (int r = 0; r < m; r++) B[r * n + r] += 0.5 * 5 * 105;
    }
  free(row_off), free(block_off), free(block_col);
  return A;
}

static inline void random_vector(LitheCount n, uint64_t seed, double *x) {
  for (LitheCount i = 0; i < n; i++) x[i] = test_random(&seed) - 0.5;
}
