/// Restriction and prolongation of one block, for DIM = 2 or 3: part of staggered_blocks.h.
// Coarse blocks are copied with a margin of one cell into an array of their own ("padded"), for their parts begin in the
// middle of rows.

#if DIM == 3
#define AT(i, j, k) (((k) + 1) * (SIDE + 2) * PAD_X + ((j) + 1) * PAD_X + (i) + PAD_LEFT)
#else
#define AT(i, j, k) (((j) + 1) * PAD_X + (i) + PAD_LEFT)
#endif
#define PAD_LEFT 8 // rows start at a multiple of a register, so that most loads cross no cache line
#define PAD_X (SIDE + 16)
#define PADDED (PAD_X * (SIDE + 2) * PAD_Z)
#define HALF (SIDE / 2)
#define DEEP_HALF (DIM == 3 ? DEEP / 2 : 1)
#define CHILDREN (1 << DIM)

/// Copy component a of a block with its margin.
ALWAYS void pad(const Rows_f *rows, int a, float *padded) {
  for (int k = FIRST_K; k < DEEP - FIRST_K; k++)
    for (int j = -1; j <= SIDE; j++) {
      const int r = ROW(j, k);
      float *to = padded + AT(0, j, k);
      to[-1] = rows->at[0][r][a * SIDE + SIDE - 1];
      for (int i = 0; i < SIDE; i += LANES_F)
        store_f(to + i, load_f(rows->at[1][r] + a * SIDE + i));
      to[SIDE] = rows->at[2][r][a * SIDE];
    }
}

/// Blocks around a place whose own block may be missing; false where there is none at all.
static bool find_near_place(const LthSparseGrid *g, const LitheIndex place[3],
                            LitheIndex near[N_NEAR]) {
  bool any = false;
  for (int i = 0; i < N_NEAR; i++) {
    near[i] = lth_sparse_grid_block(g, place[0] + i % 3 - 1, place[1] + i / 3 % 3 - 1,
                                    place[2] + (DIM == 3 ? i / 9 - 1 : 0));
    any |= near[i] >= 0;
  }
  return any;
}

/// Fine place and offset in coarse cells of the `child`th part of a coarse block.
static void child_of(const LthSparseGrid *coarse, LitheIndex block, int child, LitheIndex place[3],
                     int offset[3]) {
  for (int a = 0; a < 3; a++) {
    int high = child >> a & 1;
    place[a] = DIM == 2 && a == 2 ? 0 : 2 * coarse->place[3 * (LitheCount)block + a] + high;
    offset[a] = high * HALF;
  }
}

/// Fine blocks below the parts of a coarse block, -1 where there is none.
static void find_children(const LthFastLevel *fine, const LthFastLevel *coarse, LitheIndex block,
                          LitheIndex to[CHILDREN]) {
  for (int child = 0; child < CHILDREN; child++) {
    LitheIndex place[3];
    int offset[3];
    child_of(coarse->grid, block, child, place, offset);
    to[child] = lth_sparse_grid_block(fine->grid, place[0], place[1], place[2]);
  }
}

/// Fetch the n-th row of a fine block.
ALWAYS void fetch_nth(const LthFastLevel *fine, LitheIndex block, LitheIndex n, LthFastVector v) {
  if (block >= 0 && n < fine->first[block + 1] - fine->first[block])
    fetch_row_f(row_of(v, fine->first[block] + n));
}

/// Weighted pair of rows: fine row j from coarse rows around it, along (`own`) or across the component.
ALWAYS void blend(bool own, int j, const float *restrict below, const float *restrict here,
                  const float *restrict above, float *restrict out) {
  if (own && !(j & 1))
    for (int i = 0; i < SIDE; i++) out[i] = here[i];
  else if (own)
    for (int i = 0; i < SIDE; i++) out[i] = 0.5F * (here[i] + above[i]);
  else {
    const float *restrict far = j & 1 ? above : below;
    for (int i = 0; i < SIDE; i++) out[i] = 0.75F * here[i] + 0.25F * far[i];
  }
}

// Places in a register, from one before a row of coarse values on: each value twice; and the one that fine values lean to,
// along the component and across.
#if LANES_F == 4
#define TWICE 1, 1, 2, 2
#define ALONG 1, 2, 2, 3
#define ACROSS 0, 2, 1, 3
#elif LANES_F == 8
#define TWICE 1, 1, 2, 2, 3, 3, 4, 4
#define ALONG 1, 2, 2, 3, 3, 4, 4, 5
#define ACROSS 0, 2, 1, 3, 2, 4, 3, 5
#else
#define TWICE 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8
#define ALONG 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8, 9
#define ACROSS 0, 2, 1, 3, 2, 4, 3, 5, 4, 6, 5, 7, 6, 8, 7, 9
#endif

/// Fine values along a row of coarse ones.
ALWAYS void spread(const float *from, bool own, float *to) {
  EACH_PART(F, i) {
    const Lane_f v = load_f(from + i / 2 - 1), near = __builtin_shufflevector(v, v, TWICE);
    store_f(to + i, own ? 0.5F * (near + __builtin_shufflevector(v, v, ALONG))
                        : 0.75F * near + 0.25F * __builtin_shufflevector(v, v, ACROSS));
  }
}

/// Component a of a fine block from the padded coarse one that it is a part of.
ALWAYS void interpolate(const float *c, int a, const int offset[3], float *restrict out) {
  enum { ROWS = HALF + 2, LAYERS = DIM == 3 ? HALF + 2 : 1 };
  _Alignas(64) float x[LAYERS][ROWS][SIDE], xy[LAYERS][SIDE][SIDE];
  for (int K = 0; K < LAYERS; K++)
    for (int J = 0; J < ROWS; J++) {
      const float *from = c + AT(offset[0], offset[1] + J - 1, (DIM == 3 ? offset[2] + K - 1 : 0));
      spread(from, a == 0, x[K][J]);
    }
  for (int K = 0; K < LAYERS; K++)
    for (int j = 0; j < SIDE; j++) {
      int J = j / 2 + 1;
      blend(a == 1, j, x[K][J - 1], x[K][J], x[K][J + 1], DIM == 3 ? xy[K][j] : out + j * SIDE);
    }
#if DIM == 3
  for (int k = 0; k < DEEP; k++)
    for (int j = 0; j < SIDE; j++) {
      int K = k / 2 + 1;
      blend(a == 2, k, xy[K - 1][j], xy[K][j], xy[K + 1][j], out + (k * SIDE + j) * SIDE);
    }
#endif
}

/// x of the rows of a fine block += (or =) scale times values; those of a later one are fetched.
ALWAYS void take_rows(const LthFastLevel *L, LitheIndex block, LitheIndex later, bool add,
                      float out[DIM][CELLS]) {
  const LitheIndex first = L->first[block], behind = L->first[block + 1];
  const bool varies = L->scaled[block] >= 0;
  const float same = L->same_scale[block];
  for (LitheIndex q = first; q < behind; q++) {
    float *x = row_of(L->x, q);
    const float *from = out[0] + L->local[q] * SIDE, *scale = varies ? scale_of(L, block, q) : NULL;
    fetch_nth(L, later, q - first, L->x);
    UNROLL
    for (int a = 0; a < DIM; a++) EACH_PART(F, i) {
        const int at = a * SIDE + i;
        Lane_f v = load_f(from + a * CELLS + i) * (varies ? load_f(scale + at) : same_f(same));
        if (add) v += load_f(x + at);
        store_f(x + at, v);
      }
  }
}

static void prolong_from(const LthFastLevel *fine, const LthFastLevel *coarse, LitheIndex block,
                         bool add) {
  _Alignas(64) float c[DIM][PADDED], out[DIM][CELLS];
  const LitheIndex *near = coarse->grid->neighbor + (LitheCount)block * N_NEAR;
  Rows_f rows;
  find_rows_f(coarse, near, coarse->x.at, coarse->x.stride, true, &rows);
  for (int a = 0; a < DIM; a++) pad(&rows, a, c[a]);
  if (coarse->pull) {
    find_rows_f(coarse, near, coarse->pull, WIDTH, true, &rows);
    for (int a = 0; a < DIM; a++) {
      _Alignas(64) float pull[PADDED];
      pad(&rows, a, pull);
      for (int i = 0; i < PADDED; i++) c[a][i] *= pull[i];
    }
  }
  LitheIndex to[CHILDREN], later[CHILDREN];
  find_children(fine, coarse, block, to);
  find_children(fine, coarse, block_later(coarse->grid, block, 1), later);
  for (int child = 0; child < CHILDREN; child++) {
    LitheIndex place[3];
    int offset[3];
    if (to[child] < 0 || fine->kind[to[child]] == LTH_BLOCK_EMPTY) continue;
    child_of(coarse->grid, block, child, place, offset);
    UNROLL
    for (int a = 0; a < DIM; a++) interpolate(c[a], a, offset, out[a]);
    take_rows(fine, to[child], later[child], add, out);
  }
}

/// Transposed weights along one axis: a coarse value from four fine ones, of which the second is the nearest.
ALWAYS Lane_f gather4(Lane_f before, Lane_f here, Lane_f after, Lane_f far, bool own) {
  return own ? here + 0.5F * (before + after) : 0.75F * (here + after) + 0.25F * (before + far);
}

/// Along z: component a of the rows j = -1 ... SIDE around plane 2 K, in the block before, here, and behind along x.
ALWAYS void collect_planes(const Rows_f *rows, int a, int K, float z[SIDE + 2][3 * SIDE]) {
  for (int j = -1; j <= SIDE; j++)
    for (int x = 0; x < 3; x++) EACH_PART(F, i) {
        const float *const *at = rows->at[x] + ROW(j, 2 * K);
        const int from = a * SIDE + i;
        Lane_f v = load_f(at[0] + from);
#if DIM == 3
        v = gather4(load_f(at[-ROWS_Z] + from), v, load_f(at[ROWS_Z] + from),
                    a == 2 ? v : load_f(at[2 * ROWS_Z] + from), a == 2);
#endif
        store_f(z[j + 1] + x * SIDE + i, v);
      }
}

/// Component a of a part of a coarse block (in coarse cells, SIDE apart) from the fine block below it: along z and y in the
/// block and those before and behind it, then along x.
ALWAYS void collect(const Rows_f *rows, int a, float *restrict out) {
  _Alignas(64) float z[SIDE + 2][3 * SIDE], y[3 * SIDE];
  for (int K = 0; K < DEEP_HALF; K++) {
    collect_planes(rows, a, K, z);
    for (int J = 0; J < HALF; J++) {
      const float(*at)[3 * SIDE] = (const float(*)[3 * SIDE]) z + 2 * J;
      for (int i = 0; i < 3 * SIDE; i += LANES_F)
        store_f(y + i, gather4(load_f(at[0] + i), load_f(at[1] + i), load_f(at[2] + i),
                               load_f(at[a == 1 ? 0 : 3] + i), a == 1));
      for (int i = 0; i < HALF; i++) {
        const float *x = y + SIDE + 2 * i;
        out[(K * SIDE + J) * SIDE + i] =
            a == 0 ? x[0] + 0.5F * (x[-1] + x[1]) : 0.75F * (x[0] + x[1]) + 0.25F * (x[-1] + x[2]);
      }
    }
  }
}

static void restrict_to(const LthFastLevel *fine, const LthFastLevel *coarse, LitheIndex block) {
  _Alignas(64) float sum[BLOCK];
  LitheIndex later[CHILDREN];
  memset(sum, 0, sizeof sum);
  find_children(fine, coarse, block_later(coarse->grid, block, 1), later);
  for (int child = 0; child < CHILDREN; child++) {
    LitheIndex place[3], near[N_NEAR];
    int offset[3];
    child_of(coarse->grid, block, child, place, offset);
    const LitheIndex l = later[child], behind = l < 0 ? 0 : fine->first[l + 1];
    for (LitheIndex q = l < 0 ? 0 : fine->first[l]; q < behind; q++)
      fetch_row_f(row_of(fine->y, q));
    if (!find_near_place(fine->grid, place, near)) continue;
    int first = ((DIM == 3 ? offset[2] : 0) * SIDE + offset[1]) * SIDE + offset[0];
    Rows_f rows;
    find_rows_f(fine, near, fine->y.at, fine->y.stride, true, &rows);
    for (int a = 0; a < DIM; a++) collect(&rows, a, sum + a * CELLS + first);
  }
  for (LitheIndex q = coarse->first[block]; q < coarse->first[block + 1]; q++) {
    const float *from = sum + coarse->local[q] * SIDE;
    const float *pull = coarse->pull ? coarse->pull + q * (LitheCount)WIDTH : NULL;
    float *b = row_of(coarse->b, q);
    for (int a = 0; a < DIM; a++, from += CELLS)
      for (int i = 0; i < SIDE; i++)
        b[a * SIDE + i] = pull ? pull[a * SIDE + i] * from[i] : from[i];
  }
}
