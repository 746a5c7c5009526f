/// Random numbers of a seed that a failing test prints, and text that grows: scenes made at random.
#pragma once

#include <stdint.h>
#include <stdio.h>

static uint64_t seed;

/// Not test_random(): seeds of failures that tests keep belong to this sequence.
static inline double random_unit(void) {
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return (double)(seed >> 11) * 0x1p-53;
}

static inline double between(double low, double high) { return low + (high - low) * random_unit(); }
static inline int pick(int n) { return (int)(random_unit() * n); }

/// Text that grows.
typedef struct Text {
  char at[8000];
  size_t n;
} Text;

#define ADD(text, ...)                                                                             \
  ((text)->n += (size_t)snprintf((text)->at + (text)->n, sizeof(text)->at - (text)->n, __VA_ARGS__))
