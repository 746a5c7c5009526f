/// Products of block rows whose blocks all have one size: 12 x 12 (elements of linear dg) or 3 x 3 (nodes).
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

#define LTH_THREE 3

/// Three rows of a product: their nine sums, one for each place in a block.
typedef struct LthRows3 {
  LthQuad low, high;
  double last;
} LthRows3;

/// s += B x, B (3 x 3).
LTH_QUAD_INLINE void lth_rows3_add(const double *restrict B, const double *restrict x,
                                   LthRows3 *s) {
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  s->low += LTH_QUAD(B) * (LthQuad){x0, x1, x2, x0};
  s->high += LTH_QUAD(B + 4) * (LthQuad){x1, x2, x0, x1};
  s->last += B[8] * x2;
}

LTH_QUAD_INLINE void lth_rows3_sums(const LthRows3 *s, double sums[3]) {
  sums[0] = s->low[0] + s->low[1] + s->low[2];
  sums[1] = s->low[3] + s->high[0] + s->high[1];
  sums[2] = s->high[2] + s->high[3] + s->last;
}
