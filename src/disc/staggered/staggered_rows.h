/// Rows of the operator in one block, for one precision and dimension: define REAL, LANES (values of a register), DIM
/// and N(name), then include.
// Rows along x are read where they stand, in the block or in its neighbours, by tables of their places; a value to the
// side comes from a neighbour's row by a shuffle. Formulas: docs/theory/staggered.md, equations (4), (5).

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
#define ALWAYS static inline __attribute__((always_inline))

/// LANES values along x.
typedef REAL N(Lane)
    __attribute__((vector_size(LANES * sizeof(REAL)), aligned(sizeof(REAL)), may_alias));

ALWAYS N(Lane) N(load)(const REAL *p) { return *(const N(Lane) *)p; }
ALWAYS void N(store)(REAL *p, N(Lane) v) { *(N(Lane) *)p = v; }

/// Values one place further up: those of v but its first, then the first of `next`; and one place further down.
ALWAYS N(Lane) N(shift_up)(N(Lane) v, N(Lane) next) {
#if LANES == 8
  return __builtin_shufflevector(v, next, 1, 2, 3, 4, 5, 6, 7, 8);
#else
  return __builtin_shufflevector(v, next, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
#endif
}
ALWAYS N(Lane) N(shift_down)(N(Lane) before, N(Lane) v) {
#if LANES == 8
  return __builtin_shufflevector(before, v, 7, 8, 9, 10, 11, 12, 13, 14);
#else
  return __builtin_shufflevector(before, v, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28,
                                 29, 30);
#endif
}

/// Where eight rows stand, and their numbers.
#ifndef PLACES
#define PLACES
typedef intptr_t Places __attribute__((vector_size(64), aligned(8), may_alias));
typedef LitheIndex Numbers __attribute__((vector_size(32), aligned(4), may_alias));
#endif

/// Where rows of a block and those around it stand: in the blocks before, here and after along x.
typedef struct N(Rows) {
  const REAL *at[3][N_ROWS];
} N(Rows);

/// Rows of one block: row r stands at values + row[r] stride; `row` is NULL where they follow each other.
typedef struct N(Near) {
  const REAL *values;
  const LitheIndex *row;
} N(Near);

/// Whether all rows of a block are there: they follow each other.
ALWAYS bool N(is_full)(const LthFastLevel *L, LitheIndex block) {
  return L->first[block + 1] - L->first[block] == BLOCK_ROWS;
}

/// A block, -1: none. Rows of one that is full are not looked up, nor waited for.
ALWAYS N(Near)
    N(find_near)(const LthFastLevel *L, LitheIndex block, const REAL *values, LitheCount stride) {
  static const LitheIndex no_rows[BLOCK_ROWS];
  if (block < 0) return (N(Near)){values, no_rows};
  if (N(is_full)(L, block)) return (N(Near)){values + L->first[block] * stride, NULL};
  return (N(Near)){values, L->row + block * (LitheCount)BLOCK_ROWS};
}

ALWAYS const REAL *N(place)(const N(Near) * near, int row, LitheCount stride) {
  return near->values + (near->row ? near->row[row] : row) * stride;
}

/// Rows first ... first + SIDE - 1, eight at a time.
ALWAYS void N(find_places)(const N(Near) * near, int first, LitheCount stride, const REAL **to) {
  const intptr_t values = (intptr_t)near->values, size = stride * (LitheCount)sizeof(REAL);
  UNROLL
  for (int r = 0; r < SIDE; r += 8) {
    Places row = first + r + (Places){0, 1, 2, 3, 4, 5, 6, 7};
    if (near->row) row = __builtin_convertvector(*(const Numbers *)(near->row + first + r), Places);
    *(Places *)(to + r) = values + row * size;
  }
}

/// Rows of vectors around a block, whose own number and those of its neighbours are given, -1 where there is none.
ALWAYS void N(find_rows)(const LthFastLevel *L, const LitheIndex block[N_NEAR], const REAL *values,
                         LitheCount stride, N(Rows) * rows) {
  for (int i = 0; i < N_NEAR; i++) {
    const N(Near) near = N(find_near)(L, block[i], values, stride);
    const int x = i % 3, y = i / 3 % 3, z = DIM == 3 ? i / 9 : 1;
    const int last = z == 0 ? 0 : z == 2 ? DEEP : DEEP - 1;
    for (int k = z == 0 ? FIRST_K : z == 2 ? DEEP : 0; k < (z == 0 ? 0 : last + 1); k++) {
      const REAL **to = rows->at[x] + ROW(-1, k);
      const int at = (k & (DEEP - 1)) * SIDE;
      if (y == 0) to[0] = N(place)(&near, at + SIDE - 1, stride);
      if (y == 1) N(find_places)(&near, at, stride, to + 1);
      if (y == 2) to[1 + SIDE] = N(place)(&near, at, stride);
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
  return N(beside)(rows->at[0][r] + c * SIDE, rows->at[1][r] + c * SIDE, rows->at[2][r] + c * SIDE,
                   x, i);
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

/// f = A u in row r; returns the divergence there. `before`: where it is known below along y and z, else NULL.
ALWAYS N(Lane) N(uniform_row)(const N(Rows) * rows, const N(Constant) * c, int r, int i,
                              const N(Lane) before[DIM], N(Lane) f[DIM]) {
  const N(Lane) here = N(divergence)(rows, c->ratio, r, 0, i);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const N(Lane) there =
        a > 0 && before ? before[a] : N(divergence)(rows, c->ratio, r - UP(a), -(a == 0), i);
    f[a] = c->inertia * N(at)(rows, a, r, 0, i) - c->gradient[a] * (here - there);
    UNROLL
    for (int b = 0; b < DIM; b++)
      f[a] += c->laplacian[b] *
              (N(rise)(rows, a, b, r - UP(b), -(b == 0), i) - N(rise)(rows, a, b, r, 0, i));
  }
  return here;
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

/// What is fetched while a block is computed: rows that the next one reads of those that follow it along y and z, whom nobody has
/// touched before; of a general one samples there; and numbers of samples of a later one and of those that follow it.
typedef struct N(Ahead) {
  N(Near) near[2];
  LitheCount stride;
  const LitheIndex *samples[2], *numbers[3]; ///< NULL: none
} N(Ahead);

ALWAYS void N(look_ahead)(const LthFastLevel *L, LitheIndex block, const REAL *values,
                          LitheCount stride, N(Ahead) * A) {
  const LthSparseGrid *g = L->grid;
  const LitheIndex *row = L->level->row, next = block_later(g, block, 1);
  const LitheIndex *near = g->neighbor + (LitheCount)next * N_NEAR + N_NEAR / 2;
  const LitheIndex *later =
      g->neighbor + (LitheCount)block_later(g, block, 2) * N_NEAR + N_NEAR / 2;
  const bool general = L->kind[next] == LTH_BLOCK_GENERAL;
  A->stride = stride;
  UNROLL
  for (int i = 0; i < DIM; i++) {
    const int to = i == 0 ? 0 : i == 1 ? 3 : 9;
    A->numbers[i] = later[to] < 0 ? NULL : row + later[to] * (LitheCount)BLOCK_ROWS;
    if (i == 0) continue;
    A->near[i - 1] = N(find_near)(L, near[to], values, stride);
    A->samples[i - 1] = general && near[to] >= 0 ? row + near[to] * (LitheCount)BLOCK_ROWS : NULL;
  }
}

/// What belongs to row `row` of a block.
ALWAYS void N(fetch_ahead)(const N(Ahead) * A, const N(Samples) * c, int row) {
  enum {
    LINE = 64 / (int)sizeof(LitheIndex),
    LINES = BLOCK_ROWS / LINE,
    EVERY = DIM == 3 ? 4 : SIDE
  };
  if (row % 4 == 2 && row / 4 < DIM * LINES) {
    const LitheIndex *numbers = A->numbers[row / 4 / LINES];
    if (numbers) __builtin_prefetch(numbers + row / 4 % LINES * LINE, 0, 2);
  }
  if (row % EVERY) return;
  const int n = row / EVERY, plane = n >= SIDE, at = DIM == 2 ? 0 : plane ? n - SIDE : n * SIDE;
  N(fetch_row)(N(place)(&A->near[plane], at, A->stride));
  if (!A->samples[plane]) return;
  UNROLL
  for (int e = 0; e < N_SHEAR; e++)
    __builtin_prefetch(c->shear[e] + A->samples[plane][at] * c->stride, 0, 2);
}

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

/// f = K u in row (j, k): equation (4).
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
  uint64_t plain;
  N(Lane)
  before[SIDE / LANES], under[SIDE][SIDE / LANES]; ///< divergences, where all rows are plain
} N(Block);

/// f = K u with the inertia of `same` in a row of a block whose rows are all plain, one after the other.
ALWAYS void N(next_row)(N(Block) * B, int j, int k, int i, N(Lane) f[DIM]) {
  const N(Rows) *rows = &B->rows;
  N(Lane) *before = &B->before[i / LANES], *under = &B->under[j][i / LANES];
  if (j == 0) *before = N(divergence)(rows, B->same.ratio, ROW(-1, k), 0, i);
  if (DIM == 3 && k == 0) *under = N(divergence)(rows, B->same.ratio, ROW(j, FIRST_K), 0, i);
#if DIM == 3
  const N(Lane) both[] = {*under, *before, *under};
#else
  const N(Lane) both[] = {*before, *before};
#endif
  *before = *under = N(uniform_row)(rows, &B->same, ROW(j, k), i, both, f);
}

/// f = K u (in plain rows with the inertia of `same`) in a row of the block, `all_plain`: whose rows are all plain.
ALWAYS void N(row)(N(Block) * B, const bool all_plain, int row, int i, N(Lane) f[DIM]) {
  const int j = row & (SIDE - 1), k = row / SIDE;
  if (all_plain)
    N(next_row)(B, j, k, i, f);
  else if (B->plain >> row & 1)
    N(uniform_row)(&B->rows, &B->same, ROW(j, k), i, NULL, f);
  else
    N(general_row)(&B->rows, &B->samples, j, k, i, f);
}
