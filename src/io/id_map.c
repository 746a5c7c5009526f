/// Numbers of nodes and elements: a plain table where they are dense, a hash table otherwise.
#include "io/id_map.h"

void lth_id_map_free(LitheCtx *ctx, LthIdMap *map) {
  lth_free(ctx, map->index);
  lth_hash_free(ctx, &map->hash);
  *map = (LthIdMap){0};
}

static LitheStatus fill_table(LitheCtx *ctx, const int64_t *id, LitheIndex n, LthIdMap *map,
                              LitheIndex *twice) {
  LTH_NEW(ctx, map->index, map->n_index);
  for (LitheIndex i = 0; i < n; i++) {
    if (map->index[id[i]] && *twice < 0) *twice = i;
    map->index[id[i]] = i + 1;
  }
  return LITHE_OK;
}

static LitheStatus fill_hash(LitheCtx *ctx, const int64_t *id, LitheIndex n, LthIdMap *map,
                             LitheIndex *twice) {
  LITHE_TRY(lth_hash_reserve(ctx, &map->hash, n));
  // from the end: the table keeps what comes first
  for (LitheIndex i = n - 1; i >= 0; i--) {
    LitheIndex kept = 0;
    LITHE_TRY(lth_hash_insert(ctx, &map->hash, (uint64_t)id[i], 0, i, &kept));
    if (kept != i) *twice = kept;
  }
  return LITHE_OK;
}

LitheStatus lth_id_map_create(LitheCtx *ctx, const int64_t *id, LitheIndex n, LthIdMap *map,
                              LitheIndex *twice) {
  int64_t low = INT64_MAX, high = 0;
  *map = (LthIdMap){0};
  *twice = -1;
  for (LitheIndex i = 0; i < n; i++) {
    low = id[i] < low ? id[i] : low;
    high = id[i] > high ? id[i] : high;
  }
  bool is_dense = n > 0 && low >= 0 && high <= 4 * (int64_t)n + 1024;
  map->n_index = is_dense ? high + 1 : 0;
  LitheStatus status =
      is_dense ? fill_table(ctx, id, n, map, twice) : fill_hash(ctx, id, n, map, twice);
  if (status != LITHE_OK) lth_id_map_free(ctx, map);
  return status;
}

LitheIndex lth_id_map_find(const LthIdMap *map, int64_t id) {
  if (map->n_index > 0) return id >= 0 && id < map->n_index ? map->index[id] - 1 : -1;
  return lth_hash_find(&map->hash, (uint64_t)id, 0);
}
