/// Orders for qsort().
#pragma once

#include "lithe/base.h"

/// Indices, ascending.
static inline int lth_compare_index(const void *a, const void *b) {
  LitheIndex x = *(const LitheIndex *)a, y = *(const LitheIndex *)b;
  return (x > y) - (x < y);
}
