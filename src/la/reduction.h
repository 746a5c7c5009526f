/// Conjugate gradients on what is left when an independent set of block rows is eliminated.
#pragma once

#include "la/krylov.h"

/// Rows of a block matrix are red (no two of them coupled) or black; the red ones are eliminated
/// exactly, S = A_bb - A_br D_r^-1 A_rb. On a grid that is a chessboard, and conjugate gradients take
/// half the steps of block-Jacobi on A, each at the cost of one product with A (Young 1971; Hageman and
/// Young 1981).
typedef struct LthReduction LthReduction;

/// Colour the rows of A's pattern and allocate. A and M (its block-Jacobi) are borrowed for life.
LitheStatus lth_reduction_create(LitheCtx *ctx, const LthBlockMatrix *A, const LthBlockJacobi *M,
                                 LthReduction **reduction);
void lth_reduction_destroy(LitheCtx *ctx, LthReduction **reduction);

/// Number of red rows.
LitheIndex lth_reduction_red(const LthReduction *reduction);

/// As lth_cg_solve() for A with M, which must be up to date without extra diagonal. Allocates nothing.
LthSolveReport lth_reduction_solve(LthReduction *reduction, LthCg *cg, int threads, const double *b,
                                   double *x, double tolerance, LitheIndex max_iterations);
