/// A yardstick for the staggered operator: the same stencil with one coefficient for all, in a full box without blocks,
/// boundaries or samples, as plain loops that the compiler makes vectors of.
#pragma once

#include "base/ctx.h"

/// Seconds of one application in such a box for so many unknowns, the best of a few, on all threads.
LitheStatus dense_stencil_time(LitheCtx *ctx, int dim, LitheCount unknowns, double *seconds);
