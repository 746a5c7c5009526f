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
#define CELLS (SIDE * SIDE * DEEP)
#define BLOCK_ROWS (SIDE * DEEP)
#define WIDTH (DIM * SIDE) // values of a row of vectors
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

ALWAYS void N(find_plane)(const LitheIndex *below, const LitheIndex *here, const LitheIndex *above,
                          const REAL *values, LitheCount stride, const REAL **to) {
  to[0] = values + below[SIDE - 1] * stride;
  for (int j = 0; j < SIDE; j++) to[j + 1] = values + here[j] * stride;
  to[SIDE + 1] = values + above[0] * stride;
}

/// Rows of vectors around a block, whose own number and those of its neighbours are given, -1 where there is none.
ALWAYS void N(find_rows)(const LthFastLevel *L, const LitheIndex block[N_NEAR], const REAL *values,
                         LitheCount stride, N(Rows) * rows) {
  static const LitheIndex no_rows[BLOCK_ROWS];
  const LitheIndex *near[N_NEAR];
  for (int i = 0; i < N_NEAR; i++)
    near[i] = block[i] < 0 ? no_rows : L->row + block[i] * (LitheCount)BLOCK_ROWS;
  for (int k = FIRST_K; k < DEEP - FIRST_K; k++) {
    const LitheIndex *const *plane = near + 9 * (k < 0 ? 0 : k >= DEEP ? 2 : DIM == 3);
    const int at = (k & (DEEP - 1)) * SIDE;
    for (int x = 0; x < 3; x++) N(find_plane)
    (plane[x] + at, plane[3 + x] + at, plane[6 + x] + at, values, stride, rows->at[x] + ROW(-1, k));
  }
}

/// Component c of the unknowns i, i + 1, ... of row r, and of those one place down and up.
ALWAYS N(Lane) N(own)(const N(Rows) * rows, int c, int r, int i) {
  return N(load)(rows->at[1][r] + c * SIDE + i);
}
ALWAYS N(Lane) N(low)(const N(Rows) * rows, int c, int r, int i) {
  if (i > 0) return N(load)(rows->at[1][r] + c * SIDE + i - 1);
  return N(shift_down)(N(load)(rows->at[0][r] + c * SIDE + SIDE - LANES), N(own)(rows, c, r, 0));
}
ALWAYS N(Lane) N(high)(const N(Rows) * rows, int c, int r, int i) {
  if (i + LANES < SIDE) return N(load)(rows->at[1][r] + c * SIDE + i + 1);
  return N(shift_up)(N(own)(rows, c, r, i), N(load)(rows->at[2][r] + c * SIDE));
}

/// What is wanted soon, in rows: processors do not guess where the next block begins.
typedef struct N(Ahead) {
  const REAL *at[3];
  LitheCount stride[3];
  int n;
} N(Ahead);

/// Fetch a row of vectors into the second cache.
ALWAYS void N(fetch_row)(const REAL *at) {
  for (int i = 0; i < WIDTH; i += 64 / (int)sizeof(REAL)) __builtin_prefetch(at + i, 0, 2);
}

/// Fetch row `row` of all that is wanted.
ALWAYS void N(fetch)(const N(Ahead) * ahead, int row) {
  for (int v = 0; v < ahead->n; v++) N(fetch_row)(ahead->at[v] + row * ahead->stride[v]);
}

/// Fetch the rows that a block reads of those that follow it along y and z: nobody has touched them before.
ALWAYS void N(fetch_margin)(const LthFastLevel *L, LitheIndex block, const REAL *values,
                            LitheCount stride) {
  const LitheIndex *to = L->grid->neighbor + (LitheCount)block * N_NEAR + (DIM == 3 ? 9 : 0);
  const LitheIndex *y = to[7] < 0 ? NULL : L->row + to[7] * (LitheCount)BLOCK_ROWS;
  for (int k = 0; y && k < DEEP; k++) N(fetch_row)(values + y[k * SIDE] * stride);
#if DIM == 3
  const LitheIndex *z = to[9 + 4] < 0 ? NULL : L->row + to[9 + 4] * (LitheCount)BLOCK_ROWS;
  for (int j = 0; z && j < SIDE; j++) N(fetch_row)(values + z[j] * stride);
#endif
}

/// y = A u in a row of a block where coefficients are constant: laplacian and gradient of the divergence.
typedef struct N(Constant) {
  REAL inertia, side[DIM][DIM], cross[3]; ///< cross[a + b - 1]
} N(Constant);

ALWAYS N(Constant) N(constant)(REAL lambda, REAL mu, REAL inertia, const REAL ratio[3]) {
  N(Constant) c = {.inertia = inertia};
  for (int a = 0; a < DIM; a++) {
    for (int b = 0; b < DIM; b++) {
      c.side[a][b] = (b == a ? 2 * mu + lambda : mu) * ratio[b] * ratio[b];
      if (b > a) c.cross[a + b - 1] = (lambda + mu) * ratio[a] * ratio[b];
    }
  }
  return c;
}

ALWAYS void N(uniform_row)(const N(Rows) * rows, const N(Constant) * c, int r, int i, REAL *y) {
  const N(Lane) u = N(own)(rows, 0, r, i), v = N(own)(rows, 1, r, i);
  const N(Lane) ulo = N(low)(rows, 0, r, i), uhi = N(high)(rows, 0, r, i);
  const N(Lane) vlo = N(low)(rows, 1, r, i), vhi = N(high)(rows, 1, r, i);
  const N(Lane) uy0 = N(own)(rows, 0, r - 1, i), uy1 = N(own)(rows, 0, r + 1, i);
  const N(Lane) vy0 = N(own)(rows, 1, r - 1, i), vy1 = N(own)(rows, 1, r + 1, i);
  N(Lane)
  x = c->inertia * u + c->side[0][0] * ((u - ulo) - (uhi - u)) +
      c->side[0][1] * ((u - uy0) - (uy1 - u)) -
      c->cross[0] * ((vy1 - v) - (N(low)(rows, 1, r + 1, i) - vlo));
  N(Lane)
  z1 = c->inertia * v + c->side[1][0] * ((v - vlo) - (vhi - v)) +
       c->side[1][1] * ((v - vy0) - (vy1 - v)) -
       c->cross[0] * ((uhi - u) - (N(high)(rows, 0, r - 1, i) - uy0));
#if DIM == 3
  const N(Lane) w = N(own)(rows, 2, r, i);
  const N(Lane) wlo = N(low)(rows, 2, r, i), whi = N(high)(rows, 2, r, i);
  const N(Lane) wy0 = N(own)(rows, 2, r - 1, i), wy1 = N(own)(rows, 2, r + 1, i);
  const N(Lane) uz0 = N(own)(rows, 0, r - ROWS_Z, i), uz1 = N(own)(rows, 0, r + ROWS_Z, i);
  const N(Lane) vz0 = N(own)(rows, 1, r - ROWS_Z, i), vz1 = N(own)(rows, 1, r + ROWS_Z, i);
  const N(Lane) wz0 = N(own)(rows, 2, r - ROWS_Z, i), wz1 = N(own)(rows, 2, r + ROWS_Z, i);
  x += c->side[0][2] * ((u - uz0) - (uz1 - u)) -
       c->cross[1] * ((wz1 - w) - (N(low)(rows, 2, r + ROWS_Z, i) - wlo));
  z1 += c->side[1][2] * ((v - vz0) - (vz1 - v)) -
        c->cross[2] * ((wz1 - w) - (N(own)(rows, 2, r + ROWS_Z - 1, i) - wy0));
  N(store)
  (y + 2 * SIDE, c->inertia * w + c->side[2][0] * ((w - wlo) - (whi - w)) +
                     c->side[2][1] * ((w - wy0) - (wy1 - w)) +
                     c->side[2][2] * ((w - wz0) - (wz1 - w)) -
                     c->cross[1] * ((uhi - u) - (N(high)(rows, 0, r - ROWS_Z, i) - uz0)) -
                     c->cross[2] * ((vy1 - v) - (N(own)(rows, 1, r - ROWS_Z + 1, i) - vz0)));
#endif
  N(store)(y, x);
  N(store)(y + SIDE, z1);
}

/// y = A u in a block.
ALWAYS void N(uniform_rows)(const N(Rows) * rows, const N(Constant) * c, const N(Ahead) * ahead,
                            REAL *y) {
  for (int k = 0; k < DEEP; k++)
    for (int j = 0; j < SIDE; j++) {
      const int row = k * SIDE + j;
      N(fetch)(ahead, row);
      for (int i = 0; i < SIDE; i += LANES)
        N(uniform_row)(rows, c, ROW(j, k), i, y + row * WIDTH + i);
    }
}

#define N_EDGE_ROWS ((SIDE + 1) * (DIM == 3 ? SIDE + 1 : 1))
#define CELL_ROW(j, k) (((k)-FIRST_K) * (SIDE + 1) + (j) + 1) // rows -1 ... SIDE - 1
#define EDGE_ROW(j, k) ((k) * (SIDE + 1) + (j))               // rows 0 ... SIDE
#define N_SHEAR (DIM == 3 ? 3 : 1)
#define XY (DIM == 3 ? 2 : 0) // place of a shear in arrays of them; that along x is 0, y 1

/// Coefficients of a general block: rows of cells (from -1 on) and of edges (up to SIDE) by their offsets.
typedef struct N(Samples) {
  const REAL *lambda, *mu, *shear[N_SHEAR];
  LitheCount cell[N_EDGE_ROWS], edge[N_EDGE_ROWS];
  const LthStaggeredLevel *level;
  LitheCount stride;         ///< from row to row of samples
  LitheIndex before, behind; ///< blocks along x, -1: none
} N(Samples);

/// Offset of row (j, k) of a block's samples, of those of the next block where j or k is one beyond.
ALWAYS LitheCount N(sample_row)(const N(Samples) * c, LitheIndex block, int j, int k) {
  const int at = (k & (DEEP - 1)) * SIDE + (j & (SIDE - 1));
  const LthStaggeredLevel *l = c->level;
  return c->stride * (block < 0 ? l->n_rows : l->row[block * (LitheCount)BLOCK_ROWS + at]);
}

ALWAYS void N(find_samples)(LitheIndex block, N(Samples) * c) {
  const LitheIndex *to = c->level->grid->neighbor + (LitheCount)block * N_NEAR;
  for (int k = FIRST_K; k < DEEP; k++) {
    const LitheIndex *plane = to + (DIM == 3 && k >= 0 ? 9 : 0);
    for (int j = -1; j < SIDE; j++)
      c->cell[CELL_ROW(j, k)] = N(sample_row)(c, plane[j < 0 ? 1 : 4], j, k);
  }
  for (int k = 0; k < DEEP - FIRST_K; k++) {
    const LitheIndex *plane = to + (DIM == 3 ? k < DEEP ? 9 : 18 : 0);
    for (int j = 0; j <= SIDE; j++)
      c->edge[EDGE_ROW(j, k)] = N(sample_row)(c, plane[j < SIDE ? 4 : 7], j, k);
  }
  c->before = to[N_NEAR / 2 - 1];
  c->behind = to[N_NEAR / 2 + 1];
}

ALWAYS N(Lane) N(normal_of)(const N(Lane) e[DIM], N(Lane) lambda, N(Lane) mu, N(Lane) s[DIM]) {
  N(Lane) trace = e[0] + e[1];
#if DIM == 3
  trace += e[2];
#endif
  const N(Lane) pressure = lambda * trace, mu2 = mu + mu;
  for (int a = 0; a < DIM; a++) s[a] = mu2 * e[a] + pressure;
  return trace;
}

/// Normal stresses of row (j, k) of cells.
ALWAYS void N(normal)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j, int k,
                      int i, N(Lane) s[DIM]) {
  const int r = ROW(j, k), q = CELL_ROW(j, k);
  N(Lane) e[DIM];
  e[0] = (N(high)(rows, 0, r, i) - N(own)(rows, 0, r, i)) * ratio[0];
  e[1] = (N(own)(rows, 1, r + 1, i) - N(own)(rows, 1, r, i)) * ratio[1];
#if DIM == 3
  e[2] = (N(own)(rows, 2, r + ROWS_Z, i) - N(own)(rows, 2, r, i)) * ratio[2];
#endif
  N(normal_of)(e, N(load)(c->lambda + c->cell[q] + i), N(load)(c->mu + c->cell[q] + i), s);
}

/// Shear stresses of row (j, k) of edges.
ALWAYS N(Lane) N(shear_xy)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                           int k, int i) {
  const int r = ROW(j, k);
  return N(load)(c->shear[XY] + c->edge[EDGE_ROW(j, k)] + i) *
         ((N(own)(rows, 0, r, i) - N(own)(rows, 0, r - 1, i)) * ratio[1] +
          (N(own)(rows, 1, r, i) - N(low)(rows, 1, r, i)) * ratio[0]);
}
#if DIM == 3
ALWAYS N(Lane) N(shear_yz)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                           int k, int i) {
  const int r = ROW(j, k);
  return N(load)(c->shear[0] + c->edge[EDGE_ROW(j, k)] + i) *
         ((N(own)(rows, 1, r, i) - N(own)(rows, 1, r - ROWS_Z, i)) * ratio[2] +
          (N(own)(rows, 2, r, i) - N(own)(rows, 2, r - 1, i)) * ratio[1]);
}
ALWAYS N(Lane) N(shear_zx)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                           int k, int i) {
  const int r = ROW(j, k);
  return N(load)(c->shear[1] + c->edge[EDGE_ROW(j, k)] + i) *
         ((N(own)(rows, 2, r, i) - N(low)(rows, 2, r, i)) * ratio[0] +
          (N(own)(rows, 0, r, i) - N(own)(rows, 0, r - ROWS_Z, i)) * ratio[2]);
}
#endif

/// Normal stress along x of the cell before row (j, k).
ALWAYS REAL N(normal_before)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                             int k) {
  const int r = ROW(j, k), last = SIDE - 1;
  const LitheCount at = N(sample_row)(c, c->before, j, k) + last;
  const REAL *const *x = rows->at[0];
  const REAL e = (rows->at[1][r][0] - x[r][last]) * ratio[0];
  REAL trace = e + (x[r + 1][SIDE + last] - x[r][SIDE + last]) * ratio[1];
#if DIM == 3
  trace += (x[r + ROWS_Z][2 * SIDE + last] - x[r][2 * SIDE + last]) * ratio[2];
#endif
  return 2 * c->mu[at] * e + c->lambda[at] * trace;
}

/// Shear stresses of the edges behind row (j, k).
ALWAYS REAL N(xy_behind)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                         int k) {
  const int r = ROW(j, k);
  const REAL *const *x = rows->at[2];
  return c->shear[XY][N(sample_row)(c, c->behind, j, k)] *
         ((x[r][0] - x[r - 1][0]) * ratio[1] +
          (x[r][SIDE] - rows->at[1][r][2 * SIDE - 1]) * ratio[0]);
}
#if DIM == 3
ALWAYS REAL N(zx_behind)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3], int j,
                         int k) {
  const int r = ROW(j, k);
  const REAL *const *x = rows->at[2];
  return c->shear[1][N(sample_row)(c, c->behind, j, k)] *
         ((x[r][2 * SIDE] - rows->at[1][r][3 * SIDE - 1]) * ratio[0] +
          (x[r][0] - x[r - ROWS_Z][0]) * ratio[2]);
}
#endif

/// Stresses of one plane of rows; those of the planes below and above where they are of use.
typedef struct N(Plane) {
  REAL xx[SIDE][SIDE], yy[SIDE + 1][SIDE], xy[SIDE + 1][SIDE];
#if DIM == 3
  REAL zz[2][SIDE][SIDE], yz[2][SIDE + 1][SIDE], zx[2][SIDE][SIDE];
#endif
} N(Plane);

/// A row of which lane 0 (or the last) is another value.
ALWAYS N(Lane) N(all)(REAL value) { return (N(Lane)){0} + value; }
ALWAYS N(Lane) N(row_low)(const REAL *row, int i, REAL before) {
  return i > 0 ? N(load)(row + i - 1) : N(shift_down)(N(all)(before), N(load)(row));
}
ALWAYS N(Lane) N(row_high)(const REAL *row, int i, REAL behind) {
  return i + LANES < SIDE ? N(load)(row + i + 1) : N(shift_up)(N(load)(row + i), N(all)(behind));
}

/// Bits of the rows of plane k among those of a block, none where there is no such plane.
ALWAYS unsigned N(plane_of)(uint64_t rows, int k) {
  return k < 0 || k >= DEEP ? 0 : (unsigned)(rows >> (k * SIDE)) & ((1U << SIDE) - 1);
}

#if DIM == 3
/// Shear stresses of plane k + 1, as far as `wanted` rows of it and of the plane below read them.
ALWAYS void N(next_plane)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3],
                          uint64_t wanted, int k, N(Plane) * P) {
  const int above = (k + 1) & 1;
  const unsigned low = N(plane_of)(wanted, k), high = N(plane_of)(wanted, k + 1);
  const unsigned yz = low | high | high << 1, zx = low | high;
  for (int j = 0; j <= SIDE; j++)
    if (yz >> j & 1) N(store)(P->yz[above][j], N(shear_yz)(rows, c, ratio, j, k + 1, 0));
  for (int j = 0; j < SIDE; j++)
    if (zx >> j & 1) N(store)(P->zx[above][j], N(shear_zx)(rows, c, ratio, j, k + 1, 0));
}
#endif

/// Other stresses of plane k, as far as `wanted` rows of it and of the plane above read them.
ALWAYS void N(find_plane_stresses)(const N(Rows) * rows, const N(Samples) * c, const REAL ratio[3],
                                   uint64_t wanted, int k, N(Plane) * P) {
  const unsigned here = N(plane_of)(wanted, k), above = N(plane_of)(wanted, k + 1);
  const unsigned cells = here | here << 1 | above << 1,
                 edges = here | here << 1; // cells: row j at bit j + 1
  for (int j = -1; j < SIDE; j++)
    for (int i = 0; (cells >> (j + 1) & 1) && i < SIDE; i += LANES) {
      N(Lane) s[DIM];
      N(normal)(rows, c, ratio, j, k, i, s);
      N(store)(P->yy[j + 1] + i, s[1]);
      if (j < 0) continue;
      N(store)(P->xx[j] + i, s[0]);
#if DIM == 3
      N(store)(P->zz[k & 1][j], s[2]);
#endif
    }
  for (int j = 0; j <= SIDE; j++)
    for (int i = 0; (edges >> j & 1) && i < SIDE; i += LANES)
      N(store)(P->xy[j] + i, N(shear_xy)(rows, c, ratio, j, k, i));
}

/// Row (j, k) from the stresses around it.
ALWAYS void N(add_row)(const N(Plane) * P, const N(Rows) * rows, const N(Samples) * c,
                       const REAL ratio[3], int j, int k, REAL *y) {
  const REAL before = N(normal_before)(rows, c, ratio, j, k),
             xy_behind = N(xy_behind)(rows, c, ratio, j, k);
#if DIM == 3
  const REAL zx_behind = N(zx_behind)(rows, c, ratio, j, k);
#endif
  for (int i = 0; i < SIDE; i += LANES) {
    const N(Lane) xy = N(load)(P->xy[j] + i);
    N(Lane)
    fx = (N(row_low)(P->xx[j], i, before) - N(load)(P->xx[j] + i)) * ratio[0] -
         (N(load)(P->xy[j + 1] + i) - xy) * ratio[1];
    N(Lane)
    fy = (N(load)(P->yy[j] + i) - N(load)(P->yy[j + 1] + i)) * ratio[1] -
         (N(row_high)(P->xy[j], i, xy_behind) - xy) * ratio[0];
#if DIM == 3
    const int here = k & 1, above = here ^ 1;
    const N(Lane) yz = N(load)(P->yz[here][j]), zx = N(load)(P->zx[here][j]);
    fx -= (N(load)(P->zx[above][j]) - zx) * ratio[2];
    fy -= (N(load)(P->yz[above][j]) - yz) * ratio[2];
    N(store)
    (y + 2 * SIDE, (N(load)(P->zz[above][j]) - N(load)(P->zz[here][j])) * ratio[2] -
                       (N(row_high)(P->zx[here][j], 0, zx_behind) - zx) * ratio[0] -
                       (N(load)(P->yz[here][j + 1]) - yz) * ratio[1]);
#endif
    N(store)(y + i, fx);
    N(store)(y + SIDE + i, fy);
  }
}

/// y = K u in the rows of a general block that are alive: plain ones with constant coefficients.
ALWAYS void N(general_rows)(const N(Rows) * rows, const N(Samples) * c, const N(Constant) * same,
                            const REAL ratio[3], uint64_t alive, uint64_t plain,
                            const N(Ahead) * ahead, REAL *y) {
  const uint64_t wanted = alive & ~plain;
  N(Plane) P;
#if DIM == 3
  for (int j = 0; j < SIDE; j++) {
    if (!(wanted >> j & 1)) continue;
    N(Lane) s[DIM];
    N(normal)(rows, c, ratio, j, -1, 0, s);
    N(store)(P.zz[1][j], s[2]);
  }
  N(next_plane)(rows, c, ratio, wanted, -1, &P);
#endif
  for (int k = 0; k < DEEP; k++) {
    for (int j = 0; j < SIDE; j++) N(fetch)(ahead, k * SIDE + j);
    N(find_plane_stresses)(rows, c, ratio, wanted, k, &P);
#if DIM == 3
    N(next_plane)(rows, c, ratio, wanted, k, &P);
#endif
    for (int j = 0; j < SIDE; j++) {
      const int row = k * SIDE + j;
      REAL *to = y + row * WIDTH;
      if (wanted >> row & 1) N(add_row)(&P, rows, c, ratio, j, k, to);
      for (int i = 0; (plain >> row & 1) && i < SIDE; i += LANES)
        N(uniform_row)(rows, same, ROW(j, k), i, to + i);
    }
  }
}
