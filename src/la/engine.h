/// Direct solvers behind one table of functions; engine/ implements it, nobody includes engine/.
#pragma once

#include "la/block_matrix.h"

typedef struct LthFactor LthFactor; ///< an engine's own state

typedef struct LthEngine {
  const char *name;
  /// Ordering and symbolic analysis for A's pattern; kept while A->pattern_revision stands.
  LitheStatus (*analyse)(LitheCtx *ctx, const LthBlockMatrix *A, LthFactor **factor);
  /// Numeric factor of the symmetric positive definite A. LITHE_NOT_CONVERGED: not definite.
  LitheStatus (*factorize)(LitheCtx *ctx, LthFactor *factor, const LthBlockMatrix *A);
  /// x = A^-1 b (n). b and x may be the same.
  LitheStatus (*solve)(LitheCtx *ctx, LthFactor *factor, const double *b, double *x);
  /// Bytes of the numeric factor, predicted by the analysis, and its flops.
  void (*predict)(const LthFactor *factor, double *bytes, double *flops);
  void (*destroy)(LitheCtx *ctx, LthFactor **factor);
} LthEngine;

/// The engine called `name` ("cholesky"), or NULL. `lithe info` lists lth_engine_count() of them.
const LthEngine *lth_engine_find(const char *name);
int lth_engine_count(void);
const LthEngine *lth_engine_at(int i);
