/// Memory that gives out after a number of allocations.
#pragma once

#include <stddef.h>
#include <stdlib.h>

/// An allocate hook of LitheCtxDef; memory_user: how many allocations are left (int).
static inline void *test_failing_allocate(void *user, size_t alignment, size_t bytes) {
  int *left = user;
  return (*left)-- > 0 ? aligned_alloc(alignment, bytes) : NULL;
}
