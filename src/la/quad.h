/// Four doubles at once: the widest vector that every x86-64 with AVX2 holds in a register; gcc 12 passes wider ones
/// through memory there. And products with blocks of 12 x 12 (linear dg) made of them.
#pragma once

#define LTH_QUAD_INLINE static inline __attribute__((always_inline))

/// At any address. A compiler without wide registers splits it.
typedef double LthQuad __attribute__((vector_size(32), aligned(8), may_alias));

#define LTH_QUAD(from) (*(const LthQuad *)(from))

LTH_QUAD_INLINE double lth_quad_sum(const LthQuad *s) {
  return ((*s)[0] + (*s)[1]) + ((*s)[2] + (*s)[3]);
}

/// Four of these sums, to the bit, without taking the vectors apart.
LTH_QUAD_INLINE void lth_quad_sums(const LthQuad *s, LthQuad *sums) {
  const LthQuad s01 = __builtin_shufflevector(s[0], s[1], 0, 4, 2, 6) +
                      __builtin_shufflevector(s[0], s[1], 1, 5, 3, 7);
  const LthQuad s23 = __builtin_shufflevector(s[2], s[3], 0, 4, 2, 6) +
                      __builtin_shufflevector(s[2], s[3], 1, 5, 3, 7);
  *sums =
      __builtin_shufflevector(s01, s23, 0, 1, 4, 5) + __builtin_shufflevector(s01, s23, 2, 3, 6, 7);
}

#define LTH_TWELVE 12

/// Twelve rows of a product, four sums each, which the columns take in turns.
typedef struct LthQuad12 {
  LthQuad row[LTH_TWELVE];
} LthQuad12;

// gcc keeps the rows in registers only where no loop over them is left
LTH_QUAD_INLINE void lth_quad12_zero(LthQuad12 *s) {
#pragma GCC unroll 12
  for (int r = 0; r < LTH_TWELVE; r++) s->row[r] = (LthQuad){0};
}

/// s += B x, B (12 x 12) read from its first value to its last.
LTH_QUAD_INLINE void lth_quad12_add(const double *restrict B, const double *restrict x,
                                    LthQuad12 *s) {
  const LthQuad x0 = LTH_QUAD(x), x1 = LTH_QUAD(x + 4), x2 = LTH_QUAD(x + 8);
#pragma GCC unroll 12
  for (int r = 0; r < LTH_TWELVE; r++) {
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r) * x0;
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r + 4) * x1;
    s->row[r] += LTH_QUAD(B + LTH_TWELVE * r + 8) * x2;
  }
}
