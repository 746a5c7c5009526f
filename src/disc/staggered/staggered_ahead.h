/// What is fetched from memory while a block is computed: part of staggered_rows.h.

/// Rows that the next block reads of those that follow it along y and z, whom nobody has touched before; of a general one its
/// states, and samples there; and numbers of samples of a later one and of those that follow it.
typedef struct N(Ahead) {
  const REAL *values;
  LitheCount stride;
  N(Near) near[2];
  const LitheIndex *samples[2], *numbers[3]; ///< NULL: none
  const uint8_t *state[DIM];                 ///< in double precision; NULL: none
} N(Ahead);

ALWAYS void N(look_ahead)(const LthFastLevel *L, LitheIndex block, const REAL *values,
                          LitheCount stride, N(Ahead) * A) {
  const LthSparseGrid *g = L->grid;
  const LitheIndex *row = L->level->row, next = block_later(g, block, 1);
  const LitheIndex *near = g->neighbor + (LitheCount)next * N_NEAR + N_NEAR / 2;
  const LitheIndex *later =
      g->neighbor + (LitheCount)block_later(g, block, 2) * N_NEAR + N_NEAR / 2;
  const bool general = L->kind[next] == LTH_BLOCK_GENERAL;
  A->values = values;
  A->stride = stride;
  UNROLL
  for (int i = 0; i < DIM; i++) {
    const int to = i == 0 ? 0 : i == 1 ? 3 : 9;
    A->state[i] =
        general && sizeof(REAL) == 8 ? L->level->state[i] + next * (LitheCount)CELLS : NULL;
    A->numbers[i] = later[to] < 0 ? NULL : row + later[to] * (LitheCount)BLOCK_ROWS;
    if (i == 0) continue;
    A->near[i - 1] = N(find_near)(L, near[to]);
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
  if (row % 2 && A->state[0] && row / 2 < DIM * CELLS / 64)
    __builtin_prefetch(A->state[row / 2 % DIM] + row / 2 / DIM * 64, 0, 2);
  if (row % EVERY) return;
  const int n = row / EVERY, plane = n >= SIDE, at = DIM == 2 ? 0 : plane ? n - SIDE : n * SIDE;
  N(fetch_row)(A->values + N(number)(A->near[plane], at) * A->stride);
  if (!A->samples[plane]) return;
  UNROLL
  for (int e = 0; e < N_SHEAR; e++)
    __builtin_prefetch(c->shear[e] + A->samples[plane][at] * c->stride, 0, 2);
}
