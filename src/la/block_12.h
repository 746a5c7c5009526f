/// Products with blocks of 12 x 12, those of linear dg.
#pragma once

#include "base/quad.h"

#define LTH_TWELVE 12

/// Twelve rows of a product, four sums each, which the columns take in turns.
typedef struct LthRows12 {
  LthQuad row[LTH_TWELVE];
} LthRows12;

// gcc keeps the rows in registers only where no loop over them is left
LTH_QUAD_INLINE void lth_rows12_zero(LthRows12 *s) {
#pragma GCC unroll 12
  for (int r = 0; r < LTH_TWELVE; r++) s->row[r] = (LthQuad){0};
}

/// s += B x, B (12 x 12) read from its first value to its last.
LTH_QUAD_INLINE void lth_rows12_add(const double *restrict B, const double *restrict x,
                                    LthRows12 *s) {
  const LthQuad x0 = LTH_QUAD(x), x1 = LTH_QUAD(x + 4), x2 = LTH_QUAD(x + 8);
#pragma GCC unroll 12
  for (int r = 0; r < LTH_TWELVE; r++) {
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r) * x0;
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r + 4) * x1;
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r + 8) * x2;
  }
}
