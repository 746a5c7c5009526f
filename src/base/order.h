/// Orders for qsort(), and places in what is sorted.
#pragma once

#include "lithe/base.h"

#include <stdlib.h>

/// Indices, ascending.
static inline int lth_compare_index(const void *a, const void *b) {
  LitheIndex x = *(const LitheIndex *)a, y = *(const LitheIndex *)b;
  return (x > y) - (x < y);
}

/// First place in [first, last) of ascending indices whose entry is not below `value`; last where there is none.
static inline LitheCount lth_lower_bound(const LitheIndex *sorted, LitheCount first,
                                         LitheCount last, LitheIndex value) {
  while (first < last) {
    LitheCount middle = first + (last - first) / 2;
    if (sorted[middle] < value)
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

/// Sort n indices, which may be none at all (NULL), and leave each once; returns how many there are then.
static inline LitheIndex lth_sort_unique(LitheIndex *list, LitheIndex n) {
  LitheIndex kept = 0;
  if (n > 0) qsort(list, (size_t)n, sizeof *list, lth_compare_index);
  for (LitheIndex i = 0; i < n; i++)
    if (i == 0 || list[i] != list[i - 1]) list[kept++] = list[i];
  return kept;
}
