/// Products with rows of up to six columns, padded to eight so that two registers of four hold one.
#include "la/ml_priv.h"

#include "base/clones.h"
#include "base/quad.h"

#define PADDED LTH_ML_PADDED
#define MOST 6 // rows at a time: twelve sums, a row of Q and a factor fill sixteen registers

void lth_ml_pad(int m, int n, const float *restrict B, double *restrict to) {
  for (int r = 0; r < m; r++, B += n, to += PADDED)
    if (n == LTH_ML_MODES)
      for (int c = 0; c < PADDED; c++) to[c] = c < LTH_ML_MODES ? B[c] : 0;
    else
      for (int c = 0; c < PADDED; c++) to[c] = c < n ? B[c] : 0;
}

/// `rows` rows of lth_ml_add_product(), a constant.
static inline __attribute__((always_inline)) void
add_rows(int rows, int n, const double *restrict B, LitheCount row_stride, LitheCount col_stride,
         const double *restrict Q, double *restrict W) {
  LthQuad low[MOST], high[MOST];
#pragma GCC unroll 6
  for (int r = 0; r < rows; r++) low[r] = high[r] = (LthQuad){0};
  for (int k = 0; k < n; k++, B += col_stride, Q += PADDED) {
    const LthQuad q0 = LTH_QUAD(Q), q1 = LTH_QUAD(Q + 4);
#pragma GCC unroll 6
    for (int r = 0; r < rows; r++) {
      low[r] += B[r * row_stride] * q0;
      high[r] += B[r * row_stride] * q1;
    }
  }
#pragma GCC unroll 6
  for (int r = 0; r < rows; r++, W += PADDED) {
    *(LthQuad *)W += low[r];
    *(LthQuad *)(W + 4) += high[r];
  }
}

LTH_CLONES
static void add_product(int m, int n, const double *restrict B, LitheCount row_stride,
                        LitheCount col_stride, const double *restrict Q, double *restrict W) {
  int r = 0;
  for (; r + 6 <= m; r += 6)
    add_rows(6, n, B + r * row_stride, row_stride, col_stride, Q, W + PADDED * r);
  for (; r + 3 <= m; r += 3)
    add_rows(3, n, B + r * row_stride, row_stride, col_stride, Q, W + PADDED * r);
  for (; r < m; r++) add_rows(1, n, B + r * row_stride, row_stride, col_stride, Q, W + PADDED * r);
}

void lth_ml_add_product(int m, int n, const double *B, LitheCount row_stride, LitheCount col_stride,
                        const double *Q, double *W) {
  add_product(m, n, B, row_stride, col_stride, Q, W);
}
