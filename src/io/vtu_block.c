/// Arrays as VTK's compressed appended data holds them: zlib blocks behind a header of their sizes.
///
/// Header, each number UInt64: blocks, bytes of a full block, bytes of the last block where it is not full
/// (else 0), then the compressed bytes of each block. The blocks follow one after the other.
#include "io/vtu_block.h"

#include <string.h>
#include <zlib.h>

#define BLOCK_BYTES LTH_VTU_BLOCK_BYTES
#define COMPRESSION_LEVEL 1 // on floats, higher levels save some 3 % and take three times as long
#define GROUP 64            // blocks that are compressed side by side

void lth_vtu_block_free(LitheCtx *ctx, LthVtuBlock *block) {
  lth_free(ctx, block->bytes);
  *block = (LthVtuBlock){0};
}

static LitheCount bytes_of_block(LitheCount size, LitheCount i) {
  LitheCount rest = size - i * BLOCK_BYTES;
  return rest < BLOCK_BYTES ? rest : BLOCK_BYTES;
}

/// Where blocks are compressed: room for a group of them, plain and packed.
typedef struct Group {
  LitheCount room; // bytes of a packed block at most
  unsigned char *plain, *packed;
  uint64_t lengths[GROUP];
} Group;

/// Fill and compress blocks first ... first + n. False where zlib refuses.
static bool compress_group(LitheCtx *ctx, LthVtuFill fill, const void *self, LitheCount size,
                           LitheCount first, LitheCount n, Group *g) {
  bool is_good = true;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(&& : is_good)
  for (LitheCount i = 0; i < n; i++) {
    uLongf length = (uLongf)g->room;
    LitheCount bytes = bytes_of_block(size, first + i);
    unsigned char *plain = g->plain + i * BLOCK_BYTES;
    fill(self, (first + i) * BLOCK_BYTES, bytes, plain);
    is_good = compress2(g->packed + i * g->room, &length, plain, (uLong)bytes, COMPRESSION_LEVEL) ==
                  Z_OK &&
              is_good;
    g->lengths[i] = length;
  }
  return is_good;
}

/// Behind what is there.
static LitheStatus append_group(LitheCtx *ctx, const Group *g, LitheCount first, LitheCount n,
                                LthVtuBlock *block, LitheCount *cap) {
  LitheCount more = 0;
  for (LitheCount i = 0; i < n; i++) more += (LitheCount)g->lengths[i];
  LTH_RESERVE(ctx, block->bytes, *cap, block->size + more);
  memcpy(block->bytes + 8 * (3 + first), g->lengths, 8 * (size_t)n);
  for (LitheCount i = 0; i < n; block->size += (LitheCount)g->lengths[i++])
    memcpy(block->bytes + block->size, g->packed + i * g->room, g->lengths[i]);
  return LITHE_OK;
}

static LitheStatus compress_all(LitheCtx *ctx, LthVtuFill fill, const void *self, LitheCount size,
                                Group *g, LthVtuBlock *block) {
  LitheCount n = (size + BLOCK_BYTES - 1) / BLOCK_BYTES, cap = 0;
  uint64_t head[3] = {(uint64_t)n, BLOCK_BYTES, (uint64_t)(size % BLOCK_BYTES)};
  LTH_RESERVE(ctx, block->bytes, cap, 8 * (3 + n));
  memcpy(block->bytes, head, sizeof head);
  block->size = 8 * (3 + n);
  for (LitheCount first = 0; first < n; first += GROUP) {
    LitheCount count = n - first < GROUP ? n - first : GROUP;
    if (!compress_group(ctx, fill, self, size, first, count, g))
      LITHE_FAIL(ctx, LITHE_NO_MEMORY, "out of memory while compressing %lld bytes of output",
                 (long long)size);
    LITHE_TRY(append_group(ctx, g, first, count, block, &cap));
  }
  return LITHE_OK;
}

LitheStatus lth_vtu_block_stream(LitheCtx *ctx, LthVtuFill fill, const void *self, LitheCount size,
                                 LthVtuBlock *block) {
  LitheStatus status = LITHE_OK;
  LitheCount n = (size + BLOCK_BYTES - 1) / BLOCK_BYTES;
  if (n > GROUP) n = GROUP;
  Group g = {.room = (LitheCount)compressBound(BLOCK_BYTES)};
  *block = (LthVtuBlock){0};
  LTH_NEW_OR(done, ctx, g.plain, n * BLOCK_BYTES);
  LTH_NEW_OR(done, ctx, g.packed, n * g.room);
  LITHE_TRY_OR(done, compress_all(ctx, fill, self, size, &g, block));

done:
  lth_free(ctx, g.plain);
  lth_free(ctx, g.packed);
  if (status != LITHE_OK) lth_vtu_block_free(ctx, block);
  return status;
}

static void copy_bytes(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  memcpy(to, (const unsigned char *)self + first, (size_t)n);
}

LitheStatus lth_vtu_block_encode(LitheCtx *ctx, const void *data, LitheCount size,
                                 LthVtuBlock *block) {
  return lth_vtu_block_stream(ctx, copy_bytes, data, size, block);
}
