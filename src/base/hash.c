/// A hash table from 128-bit keys to indices, with linear probing and a finalised 64-bit mix.
#include "base/hash.h"

#include <string.h>

/// Two rounds of a multiply-xorshift finaliser: every key bit reaches every result bit.
static uint64_t mix(uint64_t key0, uint64_t key1) {
  uint64_t h = key0 * 0x9E3779B97F4A7C15u;
  h ^= h >> 32;
  h = (h + key1) * 0xD6E8FEB86659FD93u;
  h ^= h >> 32;
  h *= 0xD6E8FEB86659FD93u;
  return h ^ h >> 32;
}

/// The key's slot, or the free one where it belongs.
static LitheCount slot_of(const LthHash *hash, uint64_t key0, uint64_t key1) {
  LitheCount mask = hash->cap - 1;
  LitheCount i = (LitheCount)(mix(key0, key1) & (uint64_t)mask);
  while (hash->value[i] && (hash->key[2 * i] != key0 || hash->key[2 * i + 1] != key1))
    i = (i + 1) & mask;
  return i;
}

void lth_hash_free(LitheCtx *ctx, LthHash *hash) {
  lth_free(ctx, hash->key);
  lth_free(ctx, hash->value);
  *hash = (LthHash){0};
}

static LitheStatus grow(LitheCtx *ctx, LthHash *hash, LitheCount cap) {
  LthHash grown = {.cap = cap, .n = hash->n};
  LTH_NEW(ctx, grown.key, 2 * cap);
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(fail, ctx, grown.value, cap);
  for (LitheCount i = 0; i < hash->cap; i++) {
    if (!hash->value[i]) continue;
    LitheCount j = slot_of(&grown, hash->key[2 * i], hash->key[2 * i + 1]);
    memcpy(grown.key + 2 * j, hash->key + 2 * i, 2 * sizeof *grown.key);
    grown.value[j] = hash->value[i];
  }
  lth_hash_free(ctx, hash);
  *hash = grown;
  return LITHE_OK;
fail:
  lth_hash_free(ctx, &grown);
  return status;
}

LitheStatus lth_hash_reserve(LitheCtx *ctx, LthHash *hash, LitheCount n) {
  LitheCount cap = 16;
  while (cap < 2 * n) cap *= 2;
  return cap > hash->cap ? grow(ctx, hash, cap) : LITHE_OK;
}

LitheIndex lth_hash_find(const LthHash *hash, uint64_t key0, uint64_t key1) {
  return hash->cap ? hash->value[slot_of(hash, key0, key1)] - 1 : -1;
}

LitheStatus lth_hash_insert(LitheCtx *ctx, LthHash *hash, uint64_t key0, uint64_t key1,
                            LitheIndex value, LitheIndex *kept) {
  LITHE_ASSERT(value >= 0 && value < INT32_MAX);
  if (2 * (hash->n + 1) > hash->cap) LITHE_TRY(lth_hash_reserve(ctx, hash, 2 * hash->n + 8));
  LitheCount i = slot_of(hash, key0, key1);
  if (!hash->value[i]) {
    hash->key[2 * i] = key0;
    hash->key[2 * i + 1] = key1;
    hash->value[i] = value + 1;
    hash->n++;
  }
  *kept = hash->value[i] - 1;
  return LITHE_OK;
}
