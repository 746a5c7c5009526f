/// Four doubles at once: the widest vector that every x86-64 with AVX2 holds in a register; gcc 12 passes wider ones
/// through memory there. And sums of rows, short lists of numbers, made of them: gcc 12 unrolls a loop over a row of
/// constant length before it looks for vectors, and then finds few.
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

/// y += a x
LTH_QUAD_INLINE void lth_row_add(int n, double a, const double *restrict x, double *restrict y) {
  int j = 0;
#pragma GCC unroll 4
  for (; j + 4 <= n; j += 4) *(LthQuad *)(y + j) += a * LTH_QUAD(x + j);
  for (; j < n; j++) y[j] += a * x[j];
}

/// y += a x + b z
LTH_QUAD_INLINE void lth_row_add2(int n, double a, const double *restrict x, double b,
                                  const double *restrict z, double *restrict y) {
  int j = 0;
  for (; j + 4 <= n; j += 4) *(LthQuad *)(y + j) += a * LTH_QUAD(x + j) + b * LTH_QUAD(z + j);
  for (; j < n; j++) y[j] += a * x[j] + b * z[j];
}

/// y = a_0 x_0 + a_1 x_1 + a_2 x_2; the x start at x, x + stride and x + 2 stride.
LTH_QUAD_INLINE void lth_row_combine3(int n, const double a[3], const double *restrict x,
                                      int stride, double *restrict y) {
  const double *x1 = x + stride, *x2 = x1 + stride;
  int j = 0;
  for (; j + 4 <= n; j += 4)
    *(LthQuad *)(y + j) =
        a[0] * LTH_QUAD(x + j) + a[1] * LTH_QUAD(x1 + j) + a[2] * LTH_QUAD(x2 + j);
  for (; j < n; j++) y[j] = a[0] * x[j] + a[1] * x1[j] + a[2] * x2[j];
}
