/// PC2 point caches, as Blender's Mesh Cache modifier reads them.
#pragma once

#include "base/archive.h"

typedef struct LthPc2 LthPc2;

/// Open for frames of n points; sampled every `dt` seconds from 0.
LitheStatus lth_pc2_open(LitheCtx *ctx, const char *path, LitheIndex n_points, double dt,
                         LthPc2 **pc2);
/// Open a cache that an interrupted run left, to go on at the frame where lth_pc2_archive() was told to write.
/// LITHE_BAD_INPUT: it is not there.
LitheStatus lth_pc2_reopen(LitheCtx *ctx, const char *path, LitheIndex n_points, LthPc2 **pc2);

/// The number of whole frames. Reading cuts a reopened cache there; LITHE_BAD_INPUT in the archive: it has
/// become shorter.
void lth_pc2_archive(LthPc2 *pc2, LthArchive *archive);

/// Append a frame (n_points x 3); the header's count is kept right after every frame, so that an
/// interrupted file is valid. LITHE_NO_SPACE: cannot write (the file ends with the last whole frame).
LitheStatus lth_pc2_append(LitheCtx *ctx, LthPc2 *pc2, const double *points);
LitheStatus lth_pc2_close(LitheCtx *ctx, LthPc2 **pc2);
