/// Cholesky factor of the coarsest level, dense and in one order of operations.
#include "la/ml_priv.h"

#include "base/clones.h"

#include <math.h>
#include <string.h>

/// Sum of products of two rows; lanes in fixed order.
LTH_CLONES
static double row_product(LitheCount n, const double *restrict a, const double *restrict b) {
  double lane[8] = {0}, tail = 0;
  LitheCount i = 0;
  for (; i + 8 <= n; i += 8)
    for (int l = 0; l < 8; l++) lane[l] += a[i + l] * b[i + l];
  for (; i < n; i++) tail += a[i] * b[i];
  return ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7])) +
         tail;
}

static void expand(const LthBlockMatrix *A, double *L) {
  memset(L, 0, sizeof *L * (size_t)(A->n * A->n));
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e <= A->diagonal[row]; e++) {
      LitheIndex col = A->block_col[e];
      int m = lth_ml_size(A, row), n = lth_ml_size(A, col);
      for (int r = 0; r < m; r++)
        memcpy(L + (A->row_off[row] + r) * A->n + A->row_off[col],
               A->values + A->value_off[e] + r * n, sizeof *L * (size_t)n);
    }
}

bool lth_ml_dense_factor(const LthBlockMatrix *A, double *L) {
  const LitheCount n = A->n;
  expand(A, L);
  for (LitheCount i = 0; i < n; i++) {
    double *row = L + i * n;
    for (LitheCount j = 0; j < i; j++)
      row[j] = (row[j] - row_product(j, row, L + j * n)) / L[j * n + j];
    double pivot = row[i] - row_product(i, row, row);
    if (!(pivot > 0)) return false;
    row[i] = sqrt(pivot);
  }
  return true;
}

LTH_CLONES
static void subtract(LitheCount n, double a, const double *restrict row, double *restrict x) {
  for (LitheCount i = 0; i < n; i++) x[i] -= a * row[i];
}

void lth_ml_dense_solve(LitheCount n, const double *L, const double *b, double *x) {
  for (LitheCount i = 0; i < n; i++) x[i] = (b[i] - row_product(i, L + i * n, x)) / L[i * n + i];
  for (LitheCount i = n - 1; i >= 0; i--) {
    x[i] /= L[i * n + i];
    subtract(i, x[i], L + i * n, x);
  }
}
