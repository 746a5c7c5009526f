/// Arrays as VTK's compressed appended data holds them: zlib blocks behind a header of their sizes.
///
/// Header, each number UInt64: blocks, bytes of a full block, bytes of the last block where it is not full
/// (else 0), then the compressed bytes of each block. The blocks follow one after the other.
#include "io/vtu_block.h"

#include <string.h>
#include <zlib.h>

#define BLOCK_BYTES (1 << 18)
#define COMPRESSION_LEVEL 1 // on floats, higher levels save some 3 % and take three times as long

void lth_vtu_block_free(LitheCtx *ctx, LthVtuBlock *block) {
  lth_free(ctx, block->bytes);
  *block = (LthVtuBlock){0};
}

static LitheCount bytes_of_block(LitheCount size, LitheCount i) {
  LitheCount rest = size - i * BLOCK_BYTES;
  return rest < BLOCK_BYTES ? rest : BLOCK_BYTES;
}

/// Compress each block into its own slot of `room` bytes. False where zlib refuses.
static bool compress_blocks(LitheCtx *ctx, const unsigned char *data, LitheCount size, LitheCount n,
                            LitheCount room, unsigned char *slots, uint64_t *lengths) {
  bool is_good = true;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(&& : is_good)
  for (LitheCount i = 0; i < n; i++) {
    uLongf length = (uLongf)room;
    is_good = compress2(slots + i * room, &length, data + i * BLOCK_BYTES,
                        (uLong)bytes_of_block(size, i), COMPRESSION_LEVEL) == Z_OK &&
              is_good;
    lengths[i] = length;
  }
  return is_good;
}

/// Header and slots, moved together.
static LitheStatus join(LitheCtx *ctx, LitheCount size, LitheCount n, LitheCount room,
                        const unsigned char *slots, const uint64_t *lengths, LthVtuBlock *block) {
  LitheCount total = 8 * (3 + n);
  for (LitheCount i = 0; i < n; i++) total += (LitheCount)lengths[i];
  LTH_NEW(ctx, block->bytes, total);
  block->size = total;

  uint64_t head[3] = {(uint64_t)n, BLOCK_BYTES, (uint64_t)(size % BLOCK_BYTES)};
  unsigned char *at = block->bytes;
  memcpy(at, head, sizeof head);
  at += sizeof head;
  memcpy(at, lengths, 8 * (size_t)n);
  at += 8 * n;
  for (LitheCount i = 0; i < n; at += lengths[i++]) memcpy(at, slots + i * room, lengths[i]);
  return LITHE_OK;
}

LitheStatus lth_vtu_block_encode(LitheCtx *ctx, const void *data, LitheCount size,
                                 LthVtuBlock *block) {
  LitheStatus status = LITHE_OK;
  LitheCount n = (size + BLOCK_BYTES - 1) / BLOCK_BYTES;
  LitheCount room = (LitheCount)compressBound(BLOCK_BYTES);
  unsigned char *slots = NULL;
  uint64_t *lengths = NULL;
  *block = (LthVtuBlock){0};
  LTH_NEW_OR(done, ctx, slots, n * room);
  LTH_NEW_OR(done, ctx, lengths, n);
  if (!compress_blocks(ctx, data, size, n, room, slots, lengths)) {
    status = lth_fail(ctx, LITHE_NO_MEMORY, "out of memory while compressing %lld bytes of output",
                      (long long)size);
    goto done;
  }
  LITHE_TRY_OR(done, join(ctx, size, n, room, slots, lengths, block));

done:
  lth_free(ctx, slots);
  lth_free(ctx, lengths);
  return status;
}
