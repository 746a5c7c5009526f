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
#define WIDTH (DIM * SIDE) // values of a row of vectors
#define SOON 64            // rows
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

/// Divergence in the cells of row r, place x, times h_x.
ALWAYS N(Lane) N(divergence)(const N(Rows) * rows, const REAL ratio[3], int r, int x, int i) {
  N(Lane) sum = N(rise)(rows, 0, 0, r, x, i) * ratio[0];
  UNROLL
  for (int a = 1; a < DIM; a++) sum += N(rise)(rows, a, a, r, x, i) * ratio[a];
  return sum;
}

/// A u where coefficients are constant: laplacian and gradient of the divergence.
typedef struct N(Constant) {
  REAL inertia, laplacian[3], gradient[3], ratio[3];
} N(Constant);

ALWAYS N(Constant) N(constant)(REAL lambda, REAL mu, REAL inertia, const REAL ratio[3]) {
  N(Constant) c = {.inertia = inertia};
  UNROLL
  for (int a = 0; a < DIM; a++) {
    c.ratio[a] = ratio[a];
    c.laplacian[a] = mu * ratio[a] * ratio[a];
    c.gradient[a] = (lambda + mu) * ratio[a];
  }
  return c;
}

/// What a row finds when it is its turn along y: its own values, component y of those one place down, how much values grow from
/// the row before, and divergences of that.
typedef struct N(Slide) {
  N(Lane) here[DIM], low, rise[DIM], before;
} N(Slide);

/// Values of row r and how much they grow from the one before.
ALWAYS void N(begin_slide)(const N(Rows) * rows, const N(Constant) * c, int r, int i,
                           N(Slide) * s) {
  UNROLL
  for (int a = 0; a < DIM; a++) {
    s->here[a] = N(at)(rows, a, r, 0, i);
    s->rise[a] = N(rise)(rows, a, 1, r - 1, 0, i);
  }
  s->low = N(at)(rows, 1, r, -1, i);
  s->before = N(divergence)(rows, c->ratio, r - 1, 0, i);
}

/// f = A u in row r, where coefficients are constant; `under`: divergence in the plane before, then in this one.
ALWAYS void N(uniform_row)(const N(Rows) * rows, const N(Constant) * c, int r, int i, N(Slide) * s,
                           N(Lane) * under, N(Lane) f[DIM]) {
  N(Lane) low[DIM], high[DIM], next[DIM], here = {0}, left = {0};
  UNROLL
  for (int a = 0; a < DIM; a++) {
    low[a] = s->here[a] - (a == 1 ? s->low : N(at)(rows, a, r, -1, i));
    high[a] = N(at)(rows, a, r, 1, i) - s->here[a];
    next[a] = N(at)(rows, a, r + 1, 0, i);
    f[a] = c->inertia * s->here[a] + c->laplacian[0] * (low[a] - high[a]);
  }
  here = c->ratio[0] * high[0];
  left = c->ratio[0] * low[0];
  const N(Lane) low_next = N(at)(rows, 1, r + 1, -1, i);
  left += c->ratio[1] * (low_next - s->low);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const N(Lane) rise = next[a] - s->here[a];
    f[a] += c->laplacian[1] * (s->rise[a] - rise);
    s->rise[a] = rise;
  }
  here += c->ratio[1] * s->rise[1];
#if DIM == 3
  left += c->ratio[2] * N(rise)(rows, 2, 2, r, -1, i);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const N(Lane) rise = N(at)(rows, a, r + UP(2), 0, i) - s->here[a];
    f[a] += c->laplacian[2] * (s->here[a] - N(at)(rows, a, r - UP(2), 0, i) - rise);
    if (a == 2) here += c->ratio[2] * rise;
  }
  f[2] -= c->gradient[2] * (here - *under);
#endif
  *under = here;
  f[0] -= c->gradient[0] * (here - left);
  f[1] -= c->gradient[1] * (here - s->before);
  UNROLL
  for (int a = 0; a < DIM; a++) s->here[a] = next[a];
  s->low = low_next;
  s->before = here;
}

/// The same for a row alone.
ALWAYS void N(lone_row)(const N(Rows) * rows, const N(Constant) * c, int r, int i, N(Lane) f[DIM]) {
  N(Slide) s;
  N(begin_slide)(rows, c, r, i, &s);
  N(Lane) under = DIM == 3 ? N(divergence)(rows, c->ratio, r - UP(DIM - 1), 0, i) : (N(Lane)){0};
  N(uniform_row)(rows, c, r, i, &s, &under, f);
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
  REAL ratio[3], scale;                              ///< scale: of the result
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

/// Fetch coefficients: rows that differ stand one after the other.
ALWAYS void N(fetch_samples)(const N(Samples) * c, LitheCount at) {
  __builtin_prefetch(c->lambda + at, 0, 2);
  __builtin_prefetch(c->mu + at, 0, 2);
  UNROLL
  for (int e = 0; e < N_SHEAR; e++) __builtin_prefetch(c->shear[e] + at, 0, 2);
}

#include "disc/staggered/staggered_ahead.h"

/// Normal stress along axis a in the cells of row r, place x.
ALWAYS N(Lane) N(normal)(const N(Rows) * rows, const N(Samples) * c, N(Lane) lambda, N(Lane) mu,
                         int a, int r, int x, int i) {
  const N(Lane) pressure = lambda * N(divergence)(rows, c->ratio, r, x, i);
  return (mu + mu) * (N(rise)(rows, a, a, r, x, i) * c->ratio[a]) + pressure;
}

/// Shear stress between axes a and b at the edges of row r, place x.
ALWAYS N(Lane) N(shear)(const N(Rows) * rows, const N(Samples) * c, N(Lane) mu, int a, int b, int r,
                        int x, int i) {
  return mu * (N(rise)(rows, a, b, r - UP(b), x - (b == 0), i) * c->ratio[b] +
               N(rise)(rows, b, a, r - UP(a), x - (a == 0), i) * c->ratio[a]);
}

/// f = K u in row (j, k): equation (2).
ALWAYS void N(general_row)(const N(Rows) * rows, const N(Samples) * c, int j, int k, int i,
                           N(Lane) f[DIM]) {
  const int r = ROW(j, k), row = k * SIDE + j;
  const LitheCount own = c->here[r] * c->stride;
  const LitheCount before = c->before[row] * c->stride, behind = c->behind[row] * c->stride;
  const REAL *l = c->lambda, *m = c->mu;
  const N(Lane) lambda = N(load)(l + own + i), mu = N(load)(m + own + i);
  N(fetch_samples)(c, own + i + SOON / 2 * c->stride);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const LitheCount low = c->here[r - UP(a)] * c->stride;
    const int x = -(a == 0);
    f[a] = N(normal)(rows, c, N(beside)(l + before, l + low, NULL, x, i),
                     N(beside)(m + before, m + low, NULL, x, i), a, r - UP(a), x, i);
    f[a] = (f[a] - N(normal)(rows, c, lambda, mu, a, r, 0, i)) * c->ratio[a];
  }
  UNROLL
  for (int b = 0; b < DIM; b++) {
    const LitheCount high = c->here[r + UP(b)] * c->stride;
    const int x = b == 0;
    UNROLL
    for (int a = 0; a < DIM; a++) {
      if (a == b) continue;
      const REAL *s = c->shear[SHEAR(a, b)];
      const N(Lane) there = N(beside)(NULL, s + high, s + behind, x, i);
      f[a] -= (N(shear)(rows, c, there, a, b, r + UP(b), x, i) -
               N(shear)(rows, c, N(load)(s + own + i), a, b, r, 0, i)) *
              c->ratio[b];
    }
  }
  UNROLL
  for (int a = 0; a < DIM; a++) f[a] *= c->scale;
}

/// The operator in a block.
typedef struct N(Block) {
  N(Rows) rows;
  N(Constant) same; ///< in plain rows
  N(Samples) samples;
  N(Ahead) ahead;
  N(Near) own;
  uint64_t kind[2]; ///< rows that are alive: those that are not plain, and those that are
  N(Lane) under[SIDE][SIDE / LANES]; ///< divergences of a plane
} N(Block);

/// Divergences of the plane before a block whose rows are all plain.
ALWAYS void N(begin_planes)(N(Block) * B) {
  for (int j = 0; DIM == 3 && j < SIDE; j++)
    for (int i = 0; i < SIDE; i += LANES)
      B->under[j][i / LANES] = N(divergence)(&B->rows, B->same.ratio, ROW(j, FIRST_K), 0, i);
}

/// f = K u with the inertia of `same` in row (j, k) of such a block, one after the other.
ALWAYS void N(next_row)(N(Block) * B, N(Slide) * s, int j, int k, int i, N(Lane) f[DIM]) {
  if (j == 0) N(begin_slide)(&B->rows, &B->same, ROW(0, k), i, s);
  N(uniform_row)(&B->rows, &B->same, ROW(j, k), i, s, &B->under[j][i / LANES], f);
}

/// f = K u (in plain rows with the inertia of `same`) in a row of a block that has others, too.
ALWAYS void N(row)(const N(Block) * B, const bool plain, int row, int i, N(Lane) f[DIM]) {
  const int j = row & (SIDE - 1), k = row / SIDE;
  if (plain)
    N(lone_row)(&B->rows, &B->same, ROW(j, k), i, f);
  else
    N(general_row)(&B->rows, &B->samples, j, k, i, f);
}
