/// Forces of the rows of a block, f = K u: part of staggered_rows.h. Formulas: docs/theory/staggered.md, equation (2).
// A stress is found once, and handed on to the next row and the next plane: docs/theory/staggered-multigrid.md, section 6.

#define N_SHEAR (DIM == 3 ? 3 : 1)
#define SHEAR(a, b) (DIM == 3 ? 3 - (a) - (b) : 0) // place of a shear in arrays of them

/// Coefficients of a general block, in rows of samples.
typedef struct N(Samples) {
  const REAL *lambda, *mu, *shear[N_SHEAR];
  LitheCount stride; ///< from row to row of samples
  LitheIndex
      here[N_ROWS]; ///< which they are, for rows of the block and of those around it along y and z
  LitheIndex before[BLOCK_ROWS], behind[BLOCK_ROWS]; ///< for those beside it along x
} N(Samples);

/// Rows of samples of a block; those of zeros where it is not there.
ALWAYS void N(copy_numbers)(const LthStaggeredLevel *l, LitheIndex block, int first, int n,
                            LitheIndex *to) {
  for (int r = 0; r < n; r++)
    to[r] = block < 0 ? l->n_rows : l->row[block * (LitheCount)BLOCK_ROWS + first + r];
}

ALWAYS void N(find_samples)(const LthStaggeredLevel *l, const LitheIndex near[N_NEAR],
                            N(Samples) * c) {
  const LitheIndex *block = near + N_NEAR / 2;
  N(copy_numbers)(l, block[-1], 0, BLOCK_ROWS, c->before);
  N(copy_numbers)(l, block[1], 0, BLOCK_ROWS, c->behind);
  for (int k = 0; k < DEEP; k++) {
    N(copy_numbers)(l, block[-3], k * SIDE + SIDE - 1, 1, c->here + ROW(-1, k));
    N(copy_numbers)(l, block[0], k * SIDE, SIDE, c->here + ROW(0, k));
    N(copy_numbers)(l, block[3], k * SIDE, 1, c->here + ROW(SIDE, k));
  }
  if (DIM == 2) return;
  N(copy_numbers)(l, block[-9], BLOCK_ROWS - SIDE, SIDE, c->here + ROW(0, FIRST_K));
  N(copy_numbers)(l, block[9], 0, SIDE, c->here + ROW(0, DEEP));
}

#include "disc/staggered/staggered_ahead.h"

/// The operator in a block.
typedef struct N(Block) {
  N(Rows) rows;
  N(Samples) samples;
  N(Ahead) ahead;
  N(Near) own;
  N(Lane) lambda, mu; ///< of a uniform block
  REAL ratio[3];      ///< h_x / h_a
  REAL step[3];       ///< the same times the scale of the result
} N(Block);

/// Stresses that rows of forces share: yy of the row before along y, xy at the row whose turn it is; zz of the plane before, by rows,
/// zx and yz at the plane whose turn it is.
typedef struct N(Slide) {
  N(Lane) yy[PARTS], xy[PARTS];
#if DIM == 3
  N(Lane) zz[SIDE][PARTS], zx[SIDE][PARTS], yz[SIDE + 1][PARTS];
#endif
} N(Slide);

/// A sample of row r, from place i on.
ALWAYS N(Lane) N(sample)(const N(Block) * B, const REAL *of, int r, int i) {
  return N(load)(of + B->samples.here[r] * B->samples.stride + i);
}

/// Fetch samples that come soon: rows that differ stand one after the other.
ALWAYS void N(fetch_samples)(const N(Block) * B, int r) {
  const N(Samples) *c = &B->samples;
  const LitheCount at = (c->here[r] + SOON) * c->stride;
  __builtin_prefetch(c->lambda + at, 0, 2);
  __builtin_prefetch(c->mu + at, 0, 2);
  UNROLL
  for (int e = 0; e < N_SHEAR; e++) __builtin_prefetch(c->shear[e] + at, 0, 2);
}

/// Normal stresses in the cells of row r, from place i on.
ALWAYS void N(normal)(const N(Block) * B, const bool uniform, int r, int i, N(Lane) s[DIM]) {
  const N(Samples) *c = &B->samples;
  const N(Lane) lambda = uniform ? B->lambda : N(sample)(B, c->lambda, r, i);
  const N(Lane) mu = uniform ? B->mu : N(sample)(B, c->mu, r, i);
  N(Lane) sum = s[0] = N(rise)(&B->rows, 0, 0, r, 0, i);
  UNROLL
  for (int a = 1; a < DIM; a++) sum += s[a] = N(rise)(&B->rows, a, a, r, 0, i) * B->ratio[a];
  const N(Lane) pressure = lambda * sum;
  UNROLL
  for (int a = 0; a < DIM; a++) s[a] = (mu + mu) * s[a] + pressure;
}

/// That along x in the cell before row `row`, which is row r of tables.
ALWAYS REAL N(normal_before)(const N(Block) * B, const bool uniform, int row, int r) {
  enum { LAST = SIDE - 1 };
  const N(Samples) *c = &B->samples;
  const N(Rows) *rows = &B->rows;
  const LitheCount at = uniform ? 0 : c->before[row] * c->stride + LAST;
  const REAL lambda = uniform ? B->lambda[0] : c->lambda[at], mu = uniform ? B->mu[0] : c->mu[at];
  const REAL xx = rows->at[1][r][0] - rows->at[0][r][LAST];
  REAL sum = xx;
  UNROLL
  for (int a = 1; a < DIM; a++)
    sum +=
        (rows->at[0][r + UP(a)][a * SIDE + LAST] - rows->at[0][r][a * SIDE + LAST]) * B->ratio[a];
  return (mu + mu) * xx + lambda * sum;
}

/// Shear stress between axes a < b at the edges of row r, from place i on.
ALWAYS N(Lane) N(shear)(const N(Block) * B, const bool uniform, int a, int b, int r, int i) {
  const N(Lane) mu = uniform ? B->mu : N(sample)(B, B->samples.shear[SHEAR(a, b)], r, i);
  const N(Lane) first = N(rise)(&B->rows, a, b, r - UP(b), 0, i) * B->ratio[b];
  N(Lane) second = N(rise)(&B->rows, b, a, r - UP(a), -(a == 0), i);
  if (a != 0) second *= B->ratio[a];
  return mu * (first + second);
}

/// That between x and b at the edge behind row `row`, which is row r of tables.
ALWAYS REAL N(shear_behind)(const N(Block) * B, const bool uniform, int b, int row, int r) {
  const N(Samples) *c = &B->samples;
  const N(Rows) *rows = &B->rows;
  const REAL mu = uniform ? B->mu[0] : c->shear[SHEAR(0, b)][c->behind[row] * c->stride];
  return mu * ((rows->at[2][r][0] - rows->at[2][r - UP(b)][0]) * B->ratio[b] +
               (rows->at[2][r][b * SIDE] - rows->at[1][r][b * SIDE + SIDE - 1]));
}

/// What row j + 1 of plane k finds of row j, where that has not been its turn.
ALWAYS void N(begin_row)(const N(Block) * B, const bool uniform, int j, int k, N(Slide) * s) {
  UNROLL_SIDE
  for (int n = 0; n < PARTS; n++) {
    N(Lane) normal[DIM];
    N(normal)(B, uniform, ROW(j, k), n * LANES, normal);
    s->yy[n] = normal[1];
    s->xy[n] = N(shear)(B, uniform, 0, 1, ROW(j + 1, k), n * LANES);
  }
}

#if DIM == 3
/// What row j of plane k + 1 finds of plane k, where that has not been its turn.
ALWAYS void N(begin_plane)(const N(Block) * B, const bool uniform, int j, int k, N(Slide) * s) {
  UNROLL_SIDE
  for (int n = 0; n < PARTS; n++) {
    N(Lane) normal[DIM];
    N(normal)(B, uniform, ROW(j, k), n * LANES, normal);
    s->zz[j][n] = normal[2];
    s->zx[j][n] = N(shear)(B, uniform, 0, 2, ROW(j, k + 1), n * LANES);
    s->yz[j][n] = N(shear)(B, uniform, 1, 2, ROW(j, k + 1), n * LANES);
  }
}

/// The same for the row behind the last one of a plane, of which yz alone is read.
ALWAYS void N(end_plane)(const N(Block) * B, const bool uniform, int k, N(Slide) * s) {
  UNROLL_SIDE
  for (int n = 0; n < PARTS; n++)
    s->yz[SIDE][n] = N(shear)(B, uniform, 1, 2, ROW(SIDE, k + 1), n * LANES);
}
#endif

/// f = K u in row (j, k): equation (2).
ALWAYS void N(force)(const N(Block) * B, const bool uniform, int j, int k, N(Slide) * s,
                     N(Lane) f[PARTS][DIM]) {
  const int r = ROW(j, k), row = k * SIDE + j;
  N(Lane) before = N(same)(N(normal_before)(B, uniform, row, r));
  const N(Lane) xy_end = N(same)(N(shear_behind)(B, uniform, 1, row, r));
#if DIM == 3
  const N(Lane) zx_end = N(same)(N(shear_behind)(B, uniform, 2, row, r));
#endif
  UNROLL_SIDE
  for (int n = 0; n < PARTS; n++) {
    const int i = n * LANES;
    const bool last = n + 1 == PARTS;
    N(Lane) normal[DIM], old = s->xy[n], now = N(shear)(B, uniform, 0, 1, r + UP(1), i);
    N(normal)(B, uniform, r, i, normal);
    f[n][0] =
        B->step[0] * (N(shift_down)(before, normal[0]) - normal[0]) - B->step[1] * (now - old);
    f[n][1] = B->step[1] * (s->yy[n] - normal[1]) -
              B->step[0] * (N(shift_up)(old, last ? xy_end : s->xy[n + 1]) - old);
    before = normal[0];
    s->yy[n] = normal[1];
    s->xy[n] = now;
#if DIM == 3
    old = s->zx[j][n];
    now = N(shear)(B, uniform, 0, 2, r + UP(2), i);
    f[n][0] -= B->step[2] * (now - old);
    f[n][2] = B->step[2] * (s->zz[j][n] - normal[2]) -
              B->step[0] * (N(shift_up)(old, last ? zx_end : s->zx[j][n + 1]) - old);
    s->zz[j][n] = normal[2];
    s->zx[j][n] = now;
    old = s->yz[j][n];
    now = N(shear)(B, uniform, 1, 2, r + UP(2), i);
    f[n][1] -= B->step[2] * (now - old);
    f[n][2] -= B->step[1] * (s->yz[j + 1][n] - old);
    s->yz[j][n] = now;
#endif
  }
}

/// Takes the forces of row `row` of a block, row q of vectors.
typedef void (*N(Take))(void *to, int row, LitheIndex q, N(Lane) f[PARTS][DIM]);

/// Rows from j on that follow each other and are `alive`, from row q of vectors on; returns the row behind the last one.
ALWAYS int N(sweep_rows)(const N(Block) * B, const bool uniform, int j, int k, uint64_t alive,
                         LitheIndex q, N(Slide) * s, const N(Take) take, void *to) {
  N(Lane) f[PARTS][DIM];
  N(begin_row)(B, uniform, j - 1, k, s);
  do {
    if (!uniform) N(fetch_samples)(B, ROW(j, k));
    N(force)(B, uniform, j, k, s, f);
    take(to, k * SIDE + j, q++, f);
  } while (alive >> ++j & 1);
  return j;
}

#if DIM == 3
/// What rows of plane k + 1 that are `alive` find of plane k, but what rows of that, `done`, have left.
ALWAYS void N(sweep_under)(const N(Block) * B, const bool uniform, int k, uint64_t alive,
                           uint64_t done, N(Slide) * s) {
  for (uint64_t left = (alive | alive << 1) & ~done; left; left &= left - 1) {
    const int j = __builtin_ctzll(left);
    if (j < SIDE)
      N(begin_plane)(B, uniform, j, k, s);
    else
      N(end_plane)(B, uniform, k, s);
  }
}
#endif

/// f = K u in all rows of a block that are alive, in their order.
ALWAYS void N(sweep)(const N(Block) * B, const bool uniform, const N(Take) take, void *to) {
  const uint64_t all = ((uint64_t)1 << (SIDE - 1) << 1) - 1;
  LitheIndex q = B->own.first;
  N(Slide) s;
#if DIM == 3
  N(sweep_under)(B, uniform, -1, uniform ? all : B->own.alive & all, 0, &s);
#endif
  for (int k = 0; k < DEEP; k++) {
    const uint64_t rows = B->own.alive >> k * SIDE, alive = uniform ? all : rows & all;
    N(fetch_ahead)(&B->ahead, &B->samples, k);
    for (uint64_t left = alive; left;) {
      const int from = __builtin_ctzll(left);
      const int end = N(sweep_rows)(B, uniform, from, k, alive, q, &s, take, to);
      q += end - from;
      left = left >> end << end;
    }
#if DIM == 3
    if (k + 1 < DEEP) N(sweep_under)(B, uniform, k, uniform ? all : rows >> SIDE & all, alive, &s);
#endif
  }
}
