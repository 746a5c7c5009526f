/// Arrays as VTK's compressed appended data holds them: zlib blocks behind a header of their sizes.
#pragma once

#include "base/ctx.h"

#define LTH_VTU_BLOCK_BYTES (1 << 18) ///< before compression

/// Header and blocks of one array, as they stand in the file.
typedef struct LthVtuBlock {
  unsigned char *bytes;
  LitheCount size;
} LthVtuBlock;

/// Compress `size` bytes on all threads of `ctx`; the same bytes for any number of them.
LitheStatus lth_vtu_block_encode(LitheCtx *ctx, const void *data, LitheCount size,
                                 LthVtuBlock *block);

/// Writes bytes [first, first + n) of an array; thread-safe.
typedef void (*LthVtuFill)(const void *self, LitheCount first, LitheCount n, unsigned char *to);

/// The same of an array that is never there as a whole. Every piece but the last has LTH_VTU_BLOCK_BYTES.
LitheStatus lth_vtu_block_stream(LitheCtx *ctx, LthVtuFill fill, const void *self, LitheCount size,
                                 LthVtuBlock *block);

void lth_vtu_block_free(LitheCtx *ctx, LthVtuBlock *block);
