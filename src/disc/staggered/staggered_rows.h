/// Rows of the operator in one block, for one precision and dimension: define REAL, LANES (values of a register), DIM
/// and N(name), then include.
// A block is copied with a margin of one cell into an array of its own ("padded"), so that nothing below asks what
// lies where. Formulas: docs/theory/staggered.md, equations (4), (5).

#if DIM == 3
#define SIDE LTH_BLOCK_SIDE_3D
#define DEEP LTH_BLOCK_SIDE_3D
#define PAD_Z (DEEP + 2)
#define AT(i, j, k) (((k) + 1) * (SIDE + 2) * PAD_X + ((j) + 1) * PAD_X + (i) + PAD_LEFT)
#define STEP_Z ((SIDE + 2) * PAD_X)
#define FIRST_K (-1)
#define N_NEAR 27
#else
#define SIDE LTH_BLOCK_SIDE_2D
#define DEEP 1
#define PAD_Z 1
#define AT(i, j, k) (((j) + 1) * PAD_X + (i) + PAD_LEFT)
#define STEP_Z 0
#define FIRST_K 0
#define N_NEAR 9
#endif
#define PAD_LEFT 8 // rows start at a multiple of a register, so that most loads cross no cache line
#define PAD_X (SIDE + 16)
#define STEP_Y PAD_X
#define PADDED (PAD_X * (SIDE + 2) * PAD_Z)
#define CELLS (SIDE * SIDE * DEEP)
#define ALWAYS static inline __attribute__((always_inline))

/// LANES values along x.
typedef REAL N(Lane)
    __attribute__((vector_size(LANES * sizeof(REAL)), aligned(sizeof(REAL)), may_alias));

ALWAYS N(Lane) N(load)(const REAL *p) { return *(const N(Lane) *)p; }
ALWAYS void N(store)(REAL *p, N(Lane) v) { *(N(Lane) *)p = v; }

/// Values of a block (or zeros) around it, by the offsets of LthSparseGrid.neighbor.
ALWAYS void N(find_near)(const LthSparseGrid *g, LitheIndex block, const REAL *values,
                         LitheCount stride, const REAL *zeros, const REAL *near[N_NEAR]) {
  const LitheIndex *to = g->neighbor + (LitheCount)block * N_NEAR;
  for (int i = 0; i < N_NEAR; i++) near[i] = to[i] < 0 ? zeros : values + to[i] * stride;
}

/// Fetch what stands `ahead` of a block's own values: caches do not guess where the next block begins.
ALWAYS void N(fetch)(const REAL *ahead, int write) {
  for (int i = 0; i < SIDE; i += 64 / (int)sizeof(REAL)) {
    if (write)
      __builtin_prefetch(ahead + i, 1, 2);
    else
      __builtin_prefetch(ahead + i, 0, 2);
  }
}

/// Copy `rows` rows of a block, and a value to either side of each.
ALWAYS void N(pad_rows)(const REAL *const side[3], LitheCount at, int rows, const REAL *ahead,
                        REAL *to) {
  const REAL *left = side[0] + at + SIDE - 1, *here = side[1] + at, *right = side[2] + at;
  for (int j = 0; j < rows; j++, left += SIDE, here += SIDE, right += SIDE, to += PAD_X) {
    to[-1] = *left;
    for (int i = 0; i < SIDE; i += LANES) N(store)(to + i, N(load)(here + i));
    to[SIDE] = *right;
    if (ahead) N(fetch)(ahead + j * SIDE, 0);
  }
}

/// Copy a block with its margin; `skip`: values before those of the component. Those of the block `ahead` are fetched.
ALWAYS void N(pad)(const REAL *const near[N_NEAR], LitheCount skip, const REAL *ahead,
                   REAL *padded) {
  ahead += skip;
  for (int k = FIRST_K; k < DEEP - FIRST_K; k++) {
    const REAL *const *plane = near + 9 * (k < 0 ? 0 : k >= DEEP ? 2 : DIM == 3);
    LitheCount at = skip + (k & (DEEP - 1)) * SIDE * SIDE;
    N(pad_rows)(plane, at + (SIDE - 1) * SIDE, 1, NULL, padded + AT(0, -1, k));
    N(pad_rows)
    (plane + 3, at, SIDE, k >= 0 && k < DEEP ? ahead + k * SIDE * SIDE : NULL,
     padded + AT(0, 0, k));
    N(pad_rows)(plane + 6, at, 1, NULL, padded + AT(0, SIDE, k));
  }
}

ALWAYS int N(step)(int axis) { return axis == 0 ? 1 : axis == 1 ? STEP_Y : STEP_Z; }

/// Second difference along the two axes, and mixed difference of another component, of the rows at v.
ALWAYS N(Lane) N(second)(const REAL *v, int step) { return N(load)(v + step) + N(load)(v - step); }
ALWAYS N(Lane) N(mixed)(const REAL *v, int along, int step) {
  return (N(load)(v + step) - N(load)(v)) - (N(load)(v + step - along) - N(load)(v - along));
}

/// Component a of y = A u where coefficients are constant: laplacian and gradient of the divergence.
ALWAYS void N(uniform_component)(REAL u[DIM][PADDED], REAL lambda, REAL mu, REAL inertia,
                                 const REAL ratio[3], const int a, REAL *y) {
  REAL side[3], cross[3], centre = inertia;
  for (int b = 0; b < DIM; b++) {
    side[b] = (b == a ? 2 * mu + lambda : mu) * ratio[b] * ratio[b];
    cross[b] = (lambda + mu) * ratio[a] * ratio[b];
    centre += 2 * side[b];
  }
  const int sa = N(step)(a), b1 = (a + 1) % DIM, s1 = N(step)(b1);
  for (int k = 0; k < DEEP; k++)
    for (int j = 0; j < SIDE; j++)
      for (int i = 0; i < SIDE; i += LANES) {
        const REAL *v = u[a] + AT(i, j, k), *v1 = u[b1] + AT(i, j, k);
        N(Lane)
        sum = centre * N(load)(v) - side[a] * N(second)(v, sa) - side[b1] * N(second)(v, s1) -
              cross[b1] * N(mixed)(v1, sa, s1);
#if DIM == 3
        const int b2 = (a + 2) % DIM, s2 = N(step)(b2);
        const REAL *v2 = u[b2] + AT(i, j, k);
        sum -= side[b2] * N(second)(v, s2) + cross[b2] * N(mixed)(v2, sa, s2);
#endif
        N(store)(y + (k * SIDE + j) * SIDE + i, sum);
      }
}

ALWAYS void N(uniform_rows)(REAL u[DIM][PADDED], REAL lambda, REAL mu, REAL inertia,
                            const REAL ratio[3], REAL y[DIM][CELLS]) {
  N(uniform_component)(u, lambda, mu, inertia, ratio, 0, y[0]);
  N(uniform_component)(u, lambda, mu, inertia, ratio, 1, y[1]);
#if DIM == 3
  N(uniform_component)(u, lambda, mu, inertia, ratio, 2, y[2]);
#endif
}

/// Coefficients of a general block: lambda and mu of cells, shear of edges; all in arrays of one shape, with the
/// place of cell or edge (i, j, k) at shift + i + step_y j + step_z k.
typedef struct N(Samples) {
  const REAL *lambda, *mu, *shear[3];
  int cell_shift, edge_shift, step_y, step_z;
} N(Samples);

/// Stresses of a general block: normal ones of cells from -1 on, shear of edges from 0 on, along y and z.
typedef struct N(Stresses) {
  REAL normal[DIM][DEEP + (DIM == 3)][SIDE + 1][SIDE];
  REAL shear[DIM == 3 ? 3 : 1][DEEP + (DIM == 3)][SIDE + 1][SIDE];
} N(Stresses);

ALWAYS N(Lane) N(strain)(const REAL *u, const REAL ratio[3], int a) {
  return (N(load)(u + N(step)(a)) - N(load)(u)) * ratio[a];
}

/// Normal stresses of the cells at place p of u, q of the coefficients.
ALWAYS void N(normal)(REAL u[DIM][PADDED], const N(Samples) * c, const REAL ratio[3], int p, int q,
                      N(Lane) stress[DIM]) {
  N(Lane) e[DIM], trace = (e[0] = N(strain)(u[0] + p, ratio, 0));
  for (int a = 1; a < DIM; a++) trace += (e[a] = N(strain)(u[a] + p, ratio, a));
  N(Lane) pressure = N(load)(c->lambda + q) * trace, mu2 = 2 * N(load)(c->mu + q);
  for (int a = 0; a < DIM; a++) stress[a] = mu2 * e[a] + pressure;
}

/// Shear stress across a and b of the low edges at place p of u, q of the coefficients.
ALWAYS N(Lane) N(shear)(REAL u[DIM][PADDED], const N(Samples) * c, const REAL ratio[3], int a,
                        int b, int p, int q) {
  const REAL *ua = u[a] + p, *ub = u[b] + p;
  return N(load)(c->shear[3 - a - b] + q) * ((N(load)(ua) - N(load)(ua - N(step)(b))) * ratio[b] +
                                             (N(load)(ub) - N(load)(ub - N(step)(a))) * ratio[a]);
}

/// All stresses but those that a row along x needs one cell to its side.
ALWAYS void N(find_stresses)(REAL u[DIM][PADDED], const N(Samples) * c, const REAL ratio[3],
                             N(Stresses) * S) {
  for (int k = 0; k < DEEP + (DIM == 3); k++)
    for (int j = 0; j <= SIDE; j++)
      for (int i = 0; i < SIDE; i += LANES) {
        N(Lane) normal[DIM];
        const int low = DIM == 3 ? k - 1 : 0;
        N(normal)
        (u, c, ratio, AT(i, j - 1, low), c->cell_shift + i + c->step_y * (j - 1) + c->step_z * low,
         normal);
        for (int a = 0; a < DIM; a++) N(store)(S->normal[a][k][j] + i, normal[a]);
        const int p = AT(i, j, k), q = c->edge_shift + i + c->step_y * j + c->step_z * k;
        N(store)(S->shear[DIM == 3 ? 2 : 0][k][j] + i, N(shear)(u, c, ratio, 0, 1, p, q));
#if DIM == 3
        N(store)(S->shear[0][k][j] + i, N(shear)(u, c, ratio, 1, 2, p, q));
        N(store)(S->shear[1][k][j] + i, N(shear)(u, c, ratio, 2, 0, p, q));
#endif
      }
}

/// y = K u with the coefficients of a general block.
ALWAYS void N(general_rows)(REAL u[DIM][PADDED], const N(Samples) * c, const REAL ratio[3],
                            REAL y[DIM][CELLS]) {
  _Alignas(64) N(Stresses) S;
  N(find_stresses)(u, c, ratio, &S);
  for (int k = 0; k < DEEP; k++)
    for (int j = 0; j < SIDE; j++)
      for (int i = 0; i < SIDE; i += LANES) {
        const int p = AT(i, j, k), first = i + c->step_y * j + c->step_z * k,
                  out = (k * SIDE + j) * SIDE + i;
        const int edge = c->edge_shift + first, above = k + (DIM == 3);
        N(Lane) before[DIM];
        N(normal)(u, c, ratio, p - 1, c->cell_shift + first - 1, before);
#define HERE(v) N(load)((v) + i)
#define XY S.shear[DIM == 3 ? 2 : 0]
        N(Lane)
        x = ratio[0] * (before[0] - HERE(S.normal[0][above][j + 1])) -
            ratio[1] * (HERE(XY[k][j + 1]) - HERE(XY[k][j]));
        N(Lane)
        y1 = ratio[1] * (HERE(S.normal[1][above][j]) - HERE(S.normal[1][above][j + 1])) -
             ratio[0] * (N(shear)(u, c, ratio, 0, 1, p + 1, edge + 1) - HERE(XY[k][j]));
#if DIM == 3
        x -= ratio[2] * (HERE(S.shear[1][k + 1][j]) - HERE(S.shear[1][k][j]));
        y1 -= ratio[2] * (HERE(S.shear[0][k + 1][j]) - HERE(S.shear[0][k][j]));
        N(store)
        (y[2] + out,
         ratio[2] * (HERE(S.normal[2][k][j + 1]) - HERE(S.normal[2][k + 1][j + 1])) -
             ratio[0] * (N(shear)(u, c, ratio, 2, 0, p + 1, edge + 1) - HERE(S.shear[1][k][j])) -
             ratio[1] * (HERE(S.shear[0][k][j + 1]) - HERE(S.shear[0][k][j])));
#endif
#undef HERE
#undef XY
        N(store)(y[0] + out, x);
        N(store)(y[1] + out, y1);
      }
}
