/// A hash table from 128-bit keys to indices: point pairs, point triples, edges in planes.
#pragma once

#include "base/ctx.h"

/// Open addressing, grown at half load. Zero-initialised it is empty and usable.
typedef struct LthHash {
  uint64_t *key;     ///< (cap x 2)
  LitheIndex *value; ///< value + 1, 0 where free (cap)
  LitheCount cap, n;
} LthHash;

void lth_hash_free(LitheCtx *ctx, LthHash *hash);

/// Make room for n entries without further growth.
LitheStatus lth_hash_reserve(LitheCtx *ctx, LthHash *hash, LitheCount n);

/// Value of a key, -1 where it is not in the table.
LitheIndex lth_hash_find(const LthHash *hash, uint64_t key0, uint64_t key1);

/// Insert `value` (>= 0) unless the key is there; `*kept` is the value that the table holds now.
LitheStatus lth_hash_insert(LitheCtx *ctx, LthHash *hash, uint64_t key0, uint64_t key1,
                            LitheIndex value, LitheIndex *kept);

/// Two indices as one half of a key.
static inline uint64_t lth_hash_pair(LitheIndex a, LitheIndex b) {
  return (uint64_t)(uint32_t)a << 32 | (uint32_t)b;
}
