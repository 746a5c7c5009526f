/// From the numbers that a mesh file gives its nodes and elements to indices.
#pragma once

#include "base/hash.h"

/// Zero-initialised it knows no number.
typedef struct LthIdMap {
  LitheIndex *index; ///< index + 1 of number k where numbers are dense   (n_index)
  LitheCount n_index;
  LthHash hash; ///< otherwise
} LthIdMap;

/// Map id[i] to i. The last of equal numbers is kept; `*twice` is the first index whose number came before, or -1.
LitheStatus lth_id_map_create(LitheCtx *ctx, const int64_t *id, LitheIndex n, LthIdMap *map,
                              LitheIndex *twice);
void lth_id_map_free(LitheCtx *ctx, LthIdMap *map);

/// Index of a number, -1.
LitheIndex lth_id_map_find(const LthIdMap *map, int64_t id);
