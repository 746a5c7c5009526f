/// Anderson acceleration of a fixed-point iteration x <- x + g(x).
#pragma once

#include "base/ctx.h"

#define LTH_ANDERSON_DEPTH 6

/// The last differences of states and of corrections.
typedef struct LthAnderson LthAnderson;

LitheStatus lth_anderson_create(LitheCtx *ctx, LitheCount n, LthAnderson **anderson);
void lth_anderson_destroy(LitheCtx *ctx, LthAnderson **anderson);

/// Forget all, as after a jump.
void lth_anderson_reset(LthAnderson *anderson);

/// x += the combination of g (n) and of what was learnt from earlier steps that makes the correction
/// smallest; plain x += g at first. Same bits for any number of threads.
void lth_anderson_step(LthAnderson *anderson, int threads, const double *g, double *x);
