/// The coarsest level of the staggered multigrid: its matrix and a Cholesky factor.
#pragma once

#include "disc/staggered/staggered_entries.h"
#include "disc/staggered/staggered_fast.h"
#include "la/engine.h"

typedef struct LthStaggeredCoarsest {
  const LthFastLevel *level;
  LthBlockMatrix *A; ///< over free unknowns, blocks of one; NULL: too many for a factor
  LitheCount *place; ///< of an unknown: (slot) dim + component                      (A->n)
  LitheIndex *index; ///< of an unknown in A, component by component over slots, -1 (dim x n_slots)
  const LthEngine *engine;
  LthFactor *factor;
  double *value; ///< right-hand side and solution                             (A->n)
} LthStaggeredCoarsest;

/// Analyse, unless there are more than `most` unknowns.
LitheStatus lth_staggered_coarsest_create(LitheCtx *ctx, const LthFastLevel *level, LitheCount most,
                                          LthStaggeredCoarsest *coarsest);
void lth_staggered_coarsest_free(LitheCtx *ctx, LthStaggeredCoarsest *coarsest);
/// Factor (cm M + ck K) / unit.
LitheStatus lth_staggered_coarsest_set(LitheCtx *ctx, LthStaggeredCoarsest *coarsest, double cm,
                                       double ck, double unit);
/// The level's x from its b.
LitheStatus lth_staggered_coarsest_solve(LitheCtx *ctx, LthStaggeredCoarsest *coarsest);
/// Bytes that such a solve touches: the factor's, twice.
double lth_staggered_coarsest_bytes(const LthStaggeredCoarsest *coarsest);
