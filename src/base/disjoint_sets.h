/// Disjoint sets of indices as a forest: the root of a set is its lowest member.
#pragma once

#include "lithe/base.h"

/// Every index a set of its own. (n)
static inline void lth_sets_reset(LitheIndex *parent, LitheIndex n) {
  for (LitheIndex i = 0; i < n; i++) parent[i] = i;
}

/// Root of the set of i; paths are halved on the way.
static inline LitheIndex lth_sets_root(LitheIndex *parent, LitheIndex i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Unite the sets of a and b; false where they are one already.
static inline bool lth_sets_unite(LitheIndex *parent, LitheIndex a, LitheIndex b) {
  LitheIndex i = lth_sets_root(parent, a), j = lth_sets_root(parent, b);
  parent[i > j ? i : j] = i > j ? j : i;
  return i != j;
}
