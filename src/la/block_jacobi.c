/// Block-Jacobi preconditioner: the inverse of every diagonal block.
#include "la/krylov.h"

#include "base/clones.h"
#include "la/block_rows.h"

#include <omp.h>
#include <string.h>

// Inverses are kept whole instead of as triangular factors: products with small dense blocks run at the
// speed of memory, while substitution in blocks of 12 waits for every division.
struct LthBlockJacobi {
  LitheIndex n_rows;
  LitheCount n;
  LitheCount *row_off; // (n_rows + 1)
  LitheCount *inv_off; // (n_rows + 1)
  double *inv;         // symmetric, row-major
  uint8_t *failed;     // (n_rows)
};

LitheStatus lth_block_jacobi_create(LitheCtx *ctx, const LthBlockMatrix *A, LthBlockJacobi **out) {
  LitheStatus status = LITHE_OK;
  LthBlockJacobi *M = NULL;
  *out = NULL;
  LTH_NEW_OR(done, ctx, M, 1);
  M->n_rows = A->n_rows;
  M->n = A->n;
  LTH_NEW_OR(done, ctx, M->row_off, A->n_rows + 1);
  LTH_NEW_OR(done, ctx, M->inv_off, A->n_rows + 1);
  LTH_NEW_OR(done, ctx, M->failed, A->n_rows);
  memcpy(M->row_off, A->row_off, sizeof *A->row_off * (size_t)(A->n_rows + 1));
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheCount m = A->row_off[row + 1] - A->row_off[row];
    M->inv_off[row + 1] = M->inv_off[row] + m * m;
  }
  LTH_NEW_ROUGH_OR(done, ctx, M->inv, M->inv_off[A->n_rows]);
  *out = M;
  M = NULL;
done:
  lth_block_jacobi_destroy(ctx, &M);
  return status;
}

void lth_block_jacobi_destroy(LitheCtx *ctx, LthBlockJacobi **M) {
  if (!M || !*M) return;
  lth_free(ctx, (*M)->row_off);
  lth_free(ctx, (*M)->inv_off);
  lth_free(ctx, (*M)->inv);
  lth_free(ctx, (*M)->failed);
  lth_free(ctx, *M);
  *M = NULL;
}

/// As lth_block_matrix_is_large(): inverses are read like a product's blocks.
static bool is_large(const LthBlockJacobi *M) { return M->inv_off[M->n_rows] > 50000; }

/// B = B^-1 in place by symmetric elimination without exchange, which is stable for definite B. The
/// pivots are those of L D L^T: B is definite exactly where all are positive.
LTH_QUAD_INLINE bool invert(int n, double *B) {
  for (int k = 0; k < n; k++) {
    double *pivot_row = B + (size_t)k * (size_t)n;
    if (!(pivot_row[k] > 0)) return false;
    double inverse = 1 / pivot_row[k];
    for (int c = 0; c < n; c++) pivot_row[c] *= inverse;
    pivot_row[k] = inverse;
    for (int r = 0; r < n; r++) {
      if (r == k) continue;
      double *row = B + (size_t)r * (size_t)n;
      double factor = row[k];
      lth_row_add(n, -factor, pivot_row, row);
      row[k] =
          0 -
          factor *
              inverse; // last: a vector that is read right after one of its numbers was written waits
    }
  }
  return true;
}

/// The common size is compiled with constant trip counts.
LTH_CLONES
static bool invert_sized(int n, double *B) {
  return n == LTH_TWELVE ? invert(LTH_TWELVE, B) : invert(n, B);
}

/// Rounding leaves the inverse a little unsymmetric, which conjugate gradients would not forgive.
static void symmetrize(double *B, int n) {
  for (int r = 0; r < n; r++)
    for (int c = 0; c < r; c++) {
      double mean = 0.5 * (B[r * n + c] + B[c * n + r]);
      B[r * n + c] = B[c * n + r] = mean;
    }
}

static bool update_row(LthBlockJacobi *M, const LthBlockMatrix *A, LitheIndex row,
                       const double *extra) {
  LitheCount size = M->inv_off[row + 1] - M->inv_off[row];
  int m = (int)(M->row_off[row + 1] - M->row_off[row]);
  double *B = M->inv + M->inv_off[row];
  memcpy(B, A->values + A->value_off[A->diagonal[row]], sizeof *B * (size_t)size);
  if (extra)
    for (LitheCount i = 0; i < size; i++) B[i] += extra[M->inv_off[row] + i];
  if (!invert_sized(m, B)) return false;
  symmetrize(B, m);
  return true;
}

LitheStatus lth_block_jacobi_update(LitheCtx *ctx, LthBlockJacobi *M, const LthBlockMatrix *A,
                                    const double *extra) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) if (is_large(M))
  for (LitheIndex row = 0; row < M->n_rows; row++) M->failed[row] = !update_row(M, A, row, extra);
  for (LitheIndex row = 0; row < M->n_rows; row++)
    if (M->failed[row])
      LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
                 "the diagonal block of element %d is not positive definite: the matrix is not; "
                 "raise the penalty, constrain the body, or let thin elements be merged "
                 "(method.sliver)",
                 (int)row);
  return LITHE_OK;
}

/// As apply_block() for n = 12, to the bit.
LTH_CLONES
static void apply_block_12(const double *restrict B, const double *restrict r, double *restrict z) {
  LthRows12 s;
  lth_rows12_zero(&s);
  lth_rows12_add(B, r, &s);
#pragma GCC unroll 3
  for (int i = 0; i < LTH_TWELVE; i += 4) lth_quad_sums(s.row + i, (LthQuad *)(z + i));
}

/// z = B r for a symmetric dense block.
LTH_CLONES
static void apply_block(int n, const double *restrict B, const double *restrict r,
                        double *restrict z) {
  for (int i = 0; i < n; i++) {
    const double *b = B + (size_t)i * (size_t)n;
    LthQuad s = {0};
    double t = 0;
    int c = 0;
    for (; c + 4 <= n; c += 4) s += LTH_QUAD(b + c) * LTH_QUAD(r + c);
    for (; c < n; c++) t += b[c] * r[c];
    z[i] = lth_quad_sum(&s) + t;
  }
}

void lth_block_jacobi_apply_row(const LthBlockJacobi *M, LitheIndex row, const double *r,
                                double *z) {
  const double *B = M->inv + M->inv_off[row];
  const LitheCount at = M->row_off[row];
  const int n = (int)(M->row_off[row + 1] - at);
  if (n == LTH_TWELVE)
    apply_block_12(B, r + at, z + at);
  else
    apply_block(n, B, r + at, z + at);
}

const double *lth_block_jacobi_inverse(const LthBlockJacobi *M, LitheIndex row) {
  return M->inv + M->inv_off[row];
}

static void apply_inverse(const void *self, int threads, const double *r, double *z) {
  const LthBlockJacobi *M = self;
#pragma omp parallel for schedule(static) num_threads(threads) if (is_large(M))
  for (LitheIndex row = 0; row < M->n_rows; row++) lth_block_jacobi_apply_row(M, row, r, z);
}

LthOperator lth_block_jacobi_operator(const LthBlockJacobi *M) {
  return (LthOperator){.n = M->n, .apply = apply_inverse, .self = M};
}
