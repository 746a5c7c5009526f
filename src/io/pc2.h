/// PC2 point caches, as Blender's Mesh Cache modifier reads them.
#pragma once

#include "base/ctx.h"

typedef struct LthPc2 LthPc2;

/// Open for frames of n points; sampled every `dt` seconds from 0.
LitheStatus lth_pc2_open(LitheCtx *ctx, const char *path, LitheIndex n_points, double dt,
                         LthPc2 **pc2);
/// Append a frame (n_points x 3); the header's count is kept right after every frame, so that an
/// interrupted file is valid. LITHE_NO_SPACE: cannot write (the file ends with the last whole frame).
LitheStatus lth_pc2_append(LitheCtx *ctx, LthPc2 *pc2, const double *points);
LitheStatus lth_pc2_close(LitheCtx *ctx, LthPc2 **pc2);
