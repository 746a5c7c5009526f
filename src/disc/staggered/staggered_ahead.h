/// What is fetched from memory while a block is computed: part of staggered_force.h.

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

/// What goes with plane k of the block.
ALWAYS void N(fetch_ahead)(const N(Ahead) * A, const N(Samples) * c, int k) {
  enum { LINE = 64 / (int)sizeof(LitheIndex), STATES = CELLS / 64 / DEEP };
  UNROLL
  for (int a = 0; a < DIM; a++) {
    if (A->numbers[a] && k * LINE < BLOCK_ROWS) __builtin_prefetch(A->numbers[a] + k * LINE, 0, 2);
    for (int n = 0; n < STATES && A->state[a]; n++)
      __builtin_prefetch(A->state[a] + (k * STATES + n) * 64, 0, 2);
  }
  UNROLL
  for (int p = 0; p < DIM - 1; p++) {
    const int row = p == 0 ? k * SIDE : k;
    N(fetch_row)(A->values + N(number)(A->near[p], row) * A->stride);
    if (!A->samples[p]) continue;
    UNROLL
    for (int e = 0; e < N_SHEAR; e++)
      __builtin_prefetch(c->shear[e] + A->samples[p][row] * c->stride, 0, 2);
  }
}
