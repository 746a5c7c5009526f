/// Preconditioned conjugate gradients and the block-Jacobi preconditioner.
#pragma once

#include "la/block_matrix.h"

/// y = A x, as a callback that may use `threads` threads. Same bits for any number of them.
typedef struct LthOperator {
  LitheCount n;
  void (*apply)(const void *self, int threads, const double *x, double *y);
  const void *self;
} LthOperator;

typedef struct LthSolveReport {
  bool converged;
  LitheIndex iterations;
  double residual; ///< |b - A x| / |b|, true at the end
} LthSolveReport;

/// Vectors of a solve, allocated once.
typedef struct LthCg LthCg;
LitheStatus lth_cg_create(LitheCtx *ctx, LitheCount n, LthCg **cg);
void lth_cg_destroy(LitheCtx *ctx, LthCg **cg);

/// Solve A x = b from the x given (warm start) until |r| <= tolerance |b|. Allocates nothing.
/// Sums in fixed blocks and order: the same bits for any number of threads. M may be NULL. Where A or M
/// turns out not to be definite the report says converged = false with few iterations.
LthSolveReport lth_cg_solve(LthCg *cg, int threads, const LthOperator *A, const LthOperator *M,
                            const double *b, double *x, double tolerance,
                            LitheIndex max_iterations);

/// Inverses of the diagonal blocks of A plus an optional extra diagonal operator.
typedef struct LthBlockJacobi LthBlockJacobi;
LitheStatus lth_block_jacobi_create(LitheCtx *ctx, const LthBlockMatrix *A, LthBlockJacobi **M);
void lth_block_jacobi_destroy(LitheCtx *ctx, LthBlockJacobi **M);

/// Refactor from A's current diagonal blocks; `extra` (same layout as the diagonal blocks one after the
/// other, or NULL) is added first. LITHE_NOT_CONVERGED names the first block that is not definite.
LitheStatus lth_block_jacobi_update(LitheCtx *ctx, LthBlockJacobi *M, const LthBlockMatrix *A,
                                    const double *extra);
LthOperator lth_block_jacobi_operator(const LthBlockJacobi *M);

/// z = (inverse block) r for one block row; r and z are whole vectors.
void lth_block_jacobi_apply_row(const LthBlockJacobi *M, LitheIndex row, const double *r,
                                double *z);

/// The inverse block of one row, symmetric and row-major.
const double *lth_block_jacobi_inverse(const LthBlockJacobi *M, LitheIndex row);

LthOperator lth_block_matrix_operator(const LthBlockMatrix *A);

/// Dot product in fixed blocks.
double lth_dot(int threads, LitheCount n, const double *x, const double *y);
