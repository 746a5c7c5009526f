/// What may be wrong with a polygon's loops.
#pragma once

#include "geometry/loops.h"

#define LTH_LOOPS_MAX 10000

/// LITHE_BAD_INPUT: edges that touch or cross, holes that are not inside the first loop or inside another.
/// All else is built.
LitheStatus lth_loops_check(LitheCtx *ctx, const LthLoops *loops);
