/// Rows of the operator in one block, for one precision and dimension: define REAL, LANES (values of a register), DIM
/// and N(name), then include.
// Rows along x are read where they stand, in the block or in its neighbours, by tables of their places; a value to the
// side comes from a neighbour's row by a shuffle. Formulas: docs/theory/staggered.md, equation (2).

#if DIM == 3
#define SIDE LTH_BLOCK_SIDE_3D
#define DEEP LTH_BLOCK_SIDE_3D
#define PAD_Z (DEEP + 2)
#define FIRST_K (-1)
#define N_NEAR 27
#else
#define SIDE LTH_BLOCK_SIDE_2D
#define DEEP 1
#define PAD_Z 1
#define FIRST_K 0
#define N_NEAR 9
#endif
#define ROWS_Z (SIDE + 2)                            // rows from plane to plane in a table
#define N_ROWS (ROWS_Z * PAD_Z)                      // a block's rows and those around them
#define ROW(j, k) (((k)-FIRST_K) * ROWS_Z + (j) + 1) // place in a table of row j of plane k
#define UP(a) ((a) == 0 ? 0 : (a) == 1 ? 1 : ROWS_Z) // from a row to the next one along an axis
#define CELLS (SIDE * SIDE * DEEP)
#define BLOCK_ROWS (SIDE * DEEP)
#define WIDTH (DIM * SIDE)   // values of a row of vectors
#define SOON 64              // rows
#define PARTS (SIDE / LANES) // registers of a row
#define UNROLL _Pragma("GCC unroll 3")
#define UNROLL_SIDE _Pragma("GCC unroll 16")
#define ALWAYS static inline __attribute__((always_inline))

/// LANES values along x.
typedef REAL N(Lane)
    __attribute__((vector_size(LANES * sizeof(REAL)), aligned(sizeof(REAL)), may_alias));

ALWAYS N(Lane) N(load)(const REAL *p) { return *(const N(Lane) *)p; }
ALWAYS void N(store)(REAL *p, N(Lane) v) { *(N(Lane) *)p = v; }

/// The value in all places.
ALWAYS N(Lane) N(same)(REAL value) { return value - (N(Lane)){0}; }

// Places in two registers, the second after the first: from the second value on, and from the first one's last.
#if LANES == 2
#define ONE_UP 1, 2
#define ONE_DOWN 1, 2
#elif LANES == 4
#define ONE_UP 1, 2, 3, 4
#define ONE_DOWN 3, 4, 5, 6
#elif LANES == 8
#define ONE_UP 1, 2, 3, 4, 5, 6, 7, 8
#define ONE_DOWN 7, 8, 9, 10, 11, 12, 13, 14
#else
#define ONE_UP 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16
#define ONE_DOWN 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30
#endif

/// Values one place further up: those of v but its first, then the first of `next`; and one place further down.
ALWAYS N(Lane) N(shift_up)(N(Lane) v, N(Lane) next) {
  return __builtin_shufflevector(v, next, ONE_UP);
}
ALWAYS N(Lane) N(shift_down)(N(Lane) before, N(Lane) v) {
  return __builtin_shufflevector(before, v, ONE_DOWN);
}
#undef ONE_UP
#undef ONE_DOWN

/// Where rows of a block and those around it stand: in the blocks before, here and after along x.
typedef struct N(Rows) {
  const REAL *at[3][N_ROWS];
} N(Rows);

/// Rows of one block that are alive follow each other, from `first` on.
typedef struct N(Near) {
  uint64_t alive;
  LitheIndex first;
} N(Near);

/// A block, -1: none.
ALWAYS N(Near) N(find_near)(const LthFastLevel *L, LitheIndex block) {
  return block < 0 ? (N(Near)){0} : (N(Near)){L->alive[block], L->first[block]};
}

/// Number in vectors of a row of a block, 0 where it is not there.
ALWAYS LitheIndex N(number)(N(Near) near, int row) {
  const uint64_t below = near.alive & (((uint64_t)1 << row) - 1);
  return near.alive >> row & 1 ? near.first + (LitheIndex)__builtin_popcountll(below) : 0;
}

/// Where rows first ... first + SIDE - 1 stand.
ALWAYS void N(find_places)(N(Near) near, int first, const REAL *values, LitheCount stride,
                           const REAL **to) {
  const uint64_t all = ((uint64_t)1 << (SIDE - 1) << 1) - 1, alive = near.alive >> first & all;
  LitheCount q = near.first + __builtin_popcountll(near.alive & (((uint64_t)1 << first) - 1));
  if (alive == all) {
    UNROLL_SIDE
    for (int r = 0; r < SIDE; r++) to[r] = values + (q + r) * stride;
    return;
  }
  UNROLL_SIDE
  for (int r = 0; r < SIDE; r++) {
    const LitheCount there = alive >> r & 1;
    to[r] = values + (there ? q : 0) * stride;
    q += there;
  }
}

/// Whether the operator reads rows of a block at offsets (x, y, z): of those beside rows along two axes some alone, for
/// differences of one component along an axis of another.
ALWAYS bool N(is_read)(int x, int y, int z) {
  const int up = (x > 0) + (y > 0) + (z > 0), down = (x < 0) + (y < 0) + (z < 0);
  return up <= 1 && down <= 1;
}

/// Rows of vectors around a block, whose own number and those of its neighbours are given, -1 where there is none: all,
/// or those that the operator reads.
ALWAYS void N(find_rows)(const LthFastLevel *L, const LitheIndex block[N_NEAR], const REAL *values,
                         LitheCount stride, const bool all, N(Rows) * rows) {
  _Pragma("GCC unroll 27") for (int i = 0; i < N_NEAR; i++) {
    const int x = i % 3 - 1, y = i / 3 % 3 - 1, z = DIM == 3 ? i / 9 - 1 : 0;
    if (!all && !N(is_read)(x, y, z)) continue;
    const N(Near) near = N(find_near)(L, block[i]);
    const int first = z < 0 ? FIRST_K : z > 0 ? DEEP : 0, n = z == 0 ? DEEP : 1;
    for (int k = first; k < first + n; k++) {
      const REAL **to = rows->at[x + 1] + ROW(-1, k);
      const int at = (k & (DEEP - 1)) * SIDE;
      if (y < 0) to[0] = values + N(number)(near, at + SIDE - 1) * stride;
      if (y == 0) N(find_places)(near, at, values, stride, to + 1);
      if (y > 0) to[1 + SIDE] = values + N(number)(near, at) * stride;
    }
  }
}

/// Values i, i + 1, ... of a row, or (x = -1, 1) those one place down or up; `before` and `after` it stand other rows.
ALWAYS N(Lane) N(beside)(const REAL *before, const REAL *here, const REAL *after, int x, int i) {
  if (x < 0 && i == 0) return N(shift_down)(N(load)(before + SIDE - LANES), N(load)(here));
  if (x > 0 && i + LANES == SIDE) return N(shift_up)(N(load)(here + i), N(load)(after));
  return N(load)(here + i + x);
}

/// Component c of the unknowns i, i + 1, ... of row r, or (x = -1, 1) of those one place down or up.
ALWAYS N(Lane) N(at)(const N(Rows) * rows, int c, int r, int x, int i) {
  const REAL *before = x < 0 ? rows->at[0][r] + c * SIDE : NULL; // the others may not be known
  const REAL *after = x > 0 ? rows->at[2][r] + c * SIDE : NULL;
  return N(beside)(before, rows->at[1][r] + c * SIDE, after, x, i);
}

// Processors guess that a row follows the one before it, but neither how far to look ahead nor where the neighbours of a
// block stand; and they drop what is asked of them in a rush: a few are fetched with every row, SOON rows ahead.

/// Fetch a row of vectors into the second cache.
ALWAYS void N(fetch_row)(const REAL *at) {
  UNROLL
  for (int i = 0; i < WIDTH; i += 64 / (int)sizeof(REAL)) __builtin_prefetch(at + i, 0, 2);
}

/// How much component c grows along an axis from row r, place x.
ALWAYS N(Lane) N(rise)(const N(Rows) * rows, int c, int axis, int r, int x, int i) {
  return N(at)(rows, c, r + UP(axis), x + (axis == 0), i) - N(at)(rows, c, r, x, i);
}

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

/// Stresses that rows of forces share, as they are found: those at the row before along y, and in the plane before.
typedef struct N(Slide) {
  N(Lane) yy[PARTS], xy[PARTS]; ///< xy: at this row
#if DIM == 3
  N(Lane) zz[SIDE][PARTS], zx[SIDE][PARTS], yz[SIDE + 1][PARTS]; ///< zx, yz: at this plane
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
      const int from = __builtin_ctzll(left),
                to_row = N(sweep_rows)(B, uniform, from, k, alive, q, &s, take, to);
      q += to_row - from;
      left = left >> to_row << to_row;
    }
#if DIM == 3
    if (k + 1 < DEEP) N(sweep_under)(B, uniform, k, uniform ? all : rows >> SIDE & all, alive, &s);
#endif
  }
}
