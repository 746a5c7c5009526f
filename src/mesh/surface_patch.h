/// The patch of a triangle surface around a point, as far as it does not bend sharply.
#pragma once

#include "geometry/bvh.h"

/// Mark (1) the triangle nearest to `point` and all that are reached from it across edges where the normal turns by at
/// most `angle` [rad] from triangle to triangle; others are set to 0. `member` (n_tris).
LitheStatus lth_surface_patch_grow(LitheCtx *ctx, const LthBvh *bvh, const double point[3],
                                   double angle, uint8_t *member);
