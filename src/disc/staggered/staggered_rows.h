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

/// Where rows of a block and those around it stand: in the blocks before, here and after along x.
typedef struct N(Rows) {
  const REAL *at[3][N_ROWS];
} N(Rows);

/// Rows of one block: row r stands at values + row[r] stride.
typedef struct N(Near) {
  const REAL *values;
  const LitheIndex *row;
} N(Near);

/// Whether all rows of a block are there: they follow each other.
ALWAYS bool N(is_full)(const LthFastLevel *L, LitheIndex block) {
  return L->first[block + 1] - L->first[block] == BLOCK_ROWS;
}

/// A block, -1: none. Rows of one that is full are not looked up, nor waited for.
ALWAYS N(Near) N(find_near)(const LthFastLevel *L, LitheIndex block, const REAL *values,
                            LitheCount stride, const LitheIndex in_order[BLOCK_ROWS]) {
  static const LitheIndex no_rows[BLOCK_ROWS];
  if (block < 0) return (N(Near)){values, no_rows};
  if (N(is_full)(L, block)) return (N(Near)){values + L->first[block] * stride, in_order};
  return (N(Near)){values, L->row + block * (LitheCount)BLOCK_ROWS};
}

/// Rows first ... first + n - 1.
ALWAYS void N(find_places)(N(Near) near, int first, int n, LitheCount stride, const REAL **to) {
  for (int r = 0; r < n; r++) to[r] = near.values + near.row[first + r] * stride;
}

/// Rows of vectors around a block, whose own number and those of its neighbours are given, -1 where there is none.
ALWAYS void N(find_rows)(const LthFastLevel *L, const LitheIndex block[N_NEAR], const REAL *values,
                         LitheCount stride, N(Rows) * rows) {
  LitheIndex in_order[BLOCK_ROWS];
  N(Near) near[N_NEAR];
  for (int r = 0; r < BLOCK_ROWS; r++) in_order[r] = r;
  for (int i = 0; i < N_NEAR; i++) near[i] = N(find_near)(L, block[i], values, stride, in_order);
  for (int k = FIRST_K; k < DEEP - FIRST_K; k++) {
    const N(Near) *plane = near + 9 * (k < 0 ? 0 : k >= DEEP ? 2 : DIM == 3);
    const int at = (k & (DEEP - 1)) * SIDE;
    for (int x = 0; x < 3; x++) {
      const REAL **to = rows->at[x] + ROW(-1, k);
      N(find_places)(plane[x], at + SIDE - 1, 1, stride, to);
      N(find_places)(plane[3 + x], at, SIDE, stride, to + 1);
      N(find_places)(plane[6 + x], at, 1, stride, to + 1 + SIDE);
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

/// One of the rows that a block reads of those that follow it along y and z, whom nobody has touched before: all of them
/// as `row` goes over the rows of a block. Returns its block, or -1.
ALWAYS LitheIndex N(margin)(const LitheIndex *near, int row, int *at) {
  if (row % (DIM == 3 ? 4 : SIDE)) return -1;
  const int n = row / 4, plane = DIM == 3 && n >= SIDE;
  *at = plane ? n - SIDE : n * SIDE;
  return near[N_NEAR / 2 + (plane ? 9 : 3)];
}

ALWAYS void N(fetch_margin)(const LthFastLevel *L, const LitheIndex *near, int row,
                            const REAL *values, LitheCount stride) {
  int at;
  const LitheIndex block = N(margin)(near, row, &at);
  if (block < 0) return;
  const LitheIndex to =
      N(is_full)(L, block) ? L->first[block] + at : L->row[block * (LitheCount)BLOCK_ROWS + at];
  N(fetch_row)(values + to * stride);
}

/// The same for numbers of rows of samples, of the block too.
ALWAYS void N(fetch_numbers)(const LthStaggeredLevel *l, const LitheIndex *near, int row) {
  enum { LINE = 64 / (int)sizeof(LitheIndex), LINES = BLOCK_ROWS / LINE };
  if (row % 4 != 2 || row / 4 >= DIM * LINES) return;
  const int n = row / 4, away[3] = {0, 3, 9};
  const LitheIndex block = near[N_NEAR / 2 + away[n / LINES]];
  if (block >= 0)
    __builtin_prefetch(l->row + block * (LitheCount)BLOCK_ROWS + n % LINES * LINE, 0, 2);
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

/// f = A u in row r.
ALWAYS void N(uniform_row)(const N(Rows) * rows, const N(Constant) * c, int r, int i,
                           N(Lane) f[DIM]) {
  const N(Lane) here = N(divergence)(rows, c->ratio, r, 0, i);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const N(Lane) before = N(divergence)(rows, c->ratio, r - UP(a), -(a == 0), i);
    f[a] = c->inertia * N(at)(rows, a, r, 0, i) - c->gradient[a] * (here - before);
    UNROLL
    for (int b = 0; b < DIM; b++)
      f[a] += c->laplacian[b] *
              (N(rise)(rows, a, b, r - UP(b), -(b == 0), i) - N(rise)(rows, a, b, r, 0, i));
  }
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

/// The same for those that a block reads of the ones that follow it along y and z.
ALWAYS void N(fetch_edges)(const N(Samples) * c, const LthStaggeredLevel *l, const LitheIndex *near,
                           int row) {
  int at;
  const LitheIndex block = N(margin)(near, row, &at);
  if (block < 0) return;
  const LitheCount to = c->stride * l->row[block * (LitheCount)BLOCK_ROWS + at];
  UNROLL
  for (int e = 0; e < N_SHEAR; e++) __builtin_prefetch(c->shear[e] + to, 0, 2);
}

/// With row `row` of a block, fetch what is wanted of the surroundings of the next one.
ALWAYS void N(fetch_around)(const LthFastLevel *L, const N(Samples) * c, LitheIndex block, int row,
                            const REAL *values, LitheCount stride) {
  const LitheIndex next = block_later(L->grid, block, 1), later = block_later(L->grid, block, 2);
  const LitheIndex *near = L->grid->neighbor + (LitheCount)next * N_NEAR;
  N(fetch_margin)(L, near, row, values, stride);
  N(fetch_numbers)(L->level, L->grid->neighbor + (LitheCount)later * N_NEAR, row);
  if (L->kind[next] == LTH_BLOCK_GENERAL) N(fetch_edges)(c, L->level, near, row);
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
  uint64_t plain;
} N(Block);

/// f = K u (in plain rows with the inertia of `same`) in a row of the block, `all_plain`: whose rows are all plain.
ALWAYS void N(row)(const N(Block) * B, const bool all_plain, int row, int i, N(Lane) f[DIM]) {
  const int j = row & (SIDE - 1), k = row / SIDE;
  if (all_plain || B->plain >> row & 1)
    N(uniform_row)(&B->rows, &B->same, ROW(j, k), i, f);
  else
    N(general_row)(&B->rows, &B->samples, j, k, i, f);
}
