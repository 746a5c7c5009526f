/// Arrays as VTK's compressed appended data holds them: zlib blocks behind a header of their sizes.
#pragma once

#include "base/ctx.h"

/// Header and blocks of one array, as they stand in the file.
typedef struct LthVtuBlock {
  unsigned char *bytes;
  LitheCount size;
} LthVtuBlock;

/// Compress `size` bytes on all threads of `ctx`; the same bytes for any number of them.
LitheStatus lth_vtu_block_encode(LitheCtx *ctx, const void *data, LitheCount size,
                                 LthVtuBlock *block);

void lth_vtu_block_free(LitheCtx *ctx, LthVtuBlock *block);
