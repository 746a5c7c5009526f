/// Where rows of a block and those around it stand, and the operator in one block (staggered_force.h), for one precision
/// and dimension: define REAL, LANES (values of a register), DIM and N(name), then include.
// Rows along x are read where they stand, in the block or in its neighbours, by tables of their places; a value to the
// side comes from a neighbour's row by a shuffle.

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

/// Component c of the unknowns i, i + 1, ... of row r, or (x = -1, 1) of those one place down or up.
ALWAYS N(Lane) N(at)(const N(Rows) * rows, int c, int r, int x, int i) {
  const REAL *here = rows->at[1][r] + c * SIDE + i;
  if (x < 0 && i == 0)
    return N(shift_down)(N(load)(rows->at[0][r] + (c + 1) * SIDE - LANES), N(load)(here));
  if (x > 0 && i + LANES == SIDE)
    return N(shift_up)(N(load)(here), N(load)(rows->at[2][r] + c * SIDE));
  return N(load)(here + x);
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

#include "disc/staggered/staggered_force.h"
