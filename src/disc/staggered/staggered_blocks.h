/// What the solver does with one block, for DIM = 2 or 3: rows in single and double precision, transfers.
#include "base/clones.h"
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

#define JOIN2(a, b) a##_##b
#define JOIN(a, b) JOIN2(a, b)

#define REAL float
#define LANES (DIM == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D)
#define N(name) JOIN(name, f)
#include "disc/staggered/staggered_rows.h"
#undef REAL
#undef LANES
#undef N
#define REAL double
#define LANES 8
#define N(name) JOIN(name, d)
#include "disc/staggered/staggered_rows.h"
#undef REAL
#undef LANES
#undef N

#define BLOCK (DIM * CELLS)
#define HALF (SIDE / 2)
#define DEEP_HALF (DIM == 3 ? DEEP / 2 : 1)

static const float no_values_f[BLOCK];
static const double no_values_d[BLOCK];

/// Block that comes two later in memory: the next one is read by this one's margin.
ALWAYS LitheIndex block_ahead(const LthSparseGrid *g, LitheIndex block) {
  return block + 2 < g->n_blocks ? block + 2 : block;
}

ALWAYS float *block_of(LthFastVector v, LitheIndex block) { return v.at + block * v.stride; }

/// Sum of lanes in fixed order.
ALWAYS double sum_lanes(const double lane[SIDE]) {
  double sum = 0;
  for (int i = 0; i < SIDE; i++) sum += lane[i];
  return sum;
}

/// (A x) of a block; its own x is in the middle of `u`.
ALWAYS void fast_rows(const LthFastLevel *L, LitheIndex block, float y[DIM][CELLS]) {
  _Alignas(64) float u[DIM][PADDED];
  const float *near[N_NEAR];
  find_near_f(L->grid, block, L->x.at, L->x.stride, no_values_f, near);
  const LitheIndex next = block_ahead(L->grid, block);
  for (int a = 0; a < DIM; a++) pad_f(near, a * CELLS, block_of(L->x, next), u[a]);
  const float ratio[3] = {1, (float)L->ratio[1], (float)L->ratio[2]};
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    const float *c = L->constant + 3 * (LitheCount)block;
    uniform_rows_f(u, c[0], c[1], c[2], ratio, y);
    return;
  }
  const LitheCount n = L->n_sample / (DIM == 3 ? 5 : 3);
  const float *s = L->sample + (LitheCount)L->number[block] * L->n_sample;
  const int side = SIDE + 1;
  const Samples_f c = {
      .lambda = s,
      .mu = s + n,
      .shear = {DIM == 3 ? s + 3 * n : NULL, DIM == 3 ? s + 4 * n : NULL, s + 2 * n},
      .cell_shift = 1 + side + (DIM == 3 ? side * side : 0),
      .edge_shift = 0,
      .step_y = side,
      .step_z = side * side};
  general_rows_f(u, &c, ratio, y);
  if (!L->inertia) return;
  const float *m = L->inertia + (LitheCount)L->number[block] * BLOCK, *x = block_of(L->x, block);
  for (int at = 0; at < BLOCK; at += SIDE)
    store_f(y[0] + at, load_f(y[0] + at) + load_f(m + at) * load_f(x + at));
}

/// Inverse of the diagonal of a component in a uniform block.
ALWAYS float inverse_diagonal(const LthFastLevel *L, LitheIndex block, int a) {
  const float *c = L->constant + 3 * (LitheCount)block;
  float d = c[2];
  for (int b = 0; b < DIM; b++)
    d += 2 * (b == a ? 2 * c[1] + c[0] : c[1]) * (float)(L->ratio[b] * L->ratio[b]);
  return 1 / d;
}

/// b . (new iterate) of a row, in double precision.
ALWAYS void add_product(Lane_f b, Lane_f x, double lane[SIDE]) {
  for (int i = 0; i < SIDE; i++) lane[i] += (double)b[i] * x[i];
}

/// y = keep x - old y + length D^-1 (b - A x), row by row.
ALWAYS void smooth_rows(const LthFastLevel *L, LitheIndex block, LthFastStep step, const bool fresh,
                        const float *Ax, double lane[SIDE]) {
  const float *x = block_of(L->x, block), *b = block_of(L->b, block);
  float *y = block_of(L->y, block);
  const float keep = 1 + step.momentum, old = step.momentum, length = step.length;
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  const float *stored = uniform ? NULL : L->inverse + (LitheCount)L->number[block] * BLOCK;
  for (int a = 0; a < DIM; a++) {
    const float same = uniform ? length * inverse_diagonal(L, block, a) : 0;
    for (int at = a * CELLS; at < (a + 1) * CELLS; at += SIDE) {
      Lane_f rhs = load_f(b + at), r = rhs - load_f(Ax + at);
      Lane_f z = keep * load_f(x + at) + (uniform ? same * r : length * load_f(stored + at) * r);
      if (!fresh) z -= old * load_f(y + at);
      store_f(y + at, z);
      if (step.product) add_product(rhs, z, lane);
    }
  }
}

LTH_CLONES
static double smooth(const LthFastLevel *L, LitheIndex block, LthFastStep step) {
  _Alignas(64) float Ax[DIM][CELLS];
  double lane[SIDE] = {0};
  fast_rows(L, block, Ax);
  if (step.fresh)
    smooth_rows(L, block, step, true, Ax[0], lane);
  else
    smooth_rows(L, block, step, false, Ax[0], lane);
  return step.product ? sum_lanes(lane) : 0;
}

LTH_CLONES
static void start(const LthFastLevel *L, LitheIndex block, float length) {
  const float *b = block_of(L->b, block);
  float *x = block_of(L->x, block);
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    for (int a = 0; a < DIM; a++) {
      const float same = length * inverse_diagonal(L, block, a);
      for (int at = a * CELLS; at < (a + 1) * CELLS; at += SIDE)
        store_f(x + at, same * load_f(b + at));
    }
    return;
  }
  const float *stored = L->inverse + (LitheCount)L->number[block] * BLOCK;
  for (int at = 0; at < BLOCK; at += SIDE)
    store_f(x + at, length * load_f(stored + at) * load_f(b + at));
}

ALWAYS const float *scale_of(const LthFastLevel *L, LitheIndex block) {
  return L->scaled[block] < 0 ? NULL : L->scale + (LitheCount)L->scaled[block] * BLOCK;
}

LTH_CLONES
static void residual(const LthFastLevel *L, LitheIndex block) {
  _Alignas(64) float Ax[DIM][CELLS];
  fast_rows(L, block, Ax);
  const float *b = block_of(L->b, block), *scale = scale_of(L, block), *A = Ax[0];
  const float same = L->same_scale[block];
  float *y = block_of(L->y, block);
  for (int at = 0; at < BLOCK; at += SIDE) {
    Lane_f r = load_f(b + at) - load_f(A + at);
    store_f(y + at, scale ? r * load_f(scale + at) : r * same);
  }
}

LTH_CLONES
static void weigh(const LthFastLevel *L, LitheIndex block) {
  const float *b = block_of(L->b, block), *scale = scale_of(L, block);
  float *y = block_of(L->y, block);
  const float same = L->same_scale[block];
  for (int i = 0; i < BLOCK; i++) y[i] = (scale ? scale[i] : same) * b[i];
}

/// Double coefficients of a general block, with margins.
typedef struct Padded {
  double lambda[PADDED], mu[PADDED], shear[DIM == 3 ? 3 : 1][PADDED];
} Padded;

ALWAYS void pad_samples(const LthFastLevel *L, LitheIndex block, Padded *P, Samples_d *c) {
  const double *near[N_NEAR];
  const LthStaggeredLevel *l = L->level;
  const double *const from[5] = {l->lambda, l->mu, l->shear[2], l->shear[0], l->shear[1]};
  double *const to[5] = {P->lambda, P->mu, P->shear[0], DIM == 3 ? P->shear[DIM - 2] : NULL,
                         DIM == 3 ? P->shear[DIM - 1] : NULL};
  const LitheIndex next = block_ahead(L->grid, block);
  for (int i = 0; i < (DIM == 3 ? 5 : 3); i++) {
    find_near_d(L->grid, block, from[i], CELLS, no_values_d, near);
    pad_d(near, 0, from[i] + (LitheCount)next * CELLS, to[i]);
  }
  *c = (Samples_d){.lambda = P->lambda,
                   .mu = P->mu,
                   .shear = {to[3], to[4], to[2]},
                   .cell_shift = AT(0, 0, 0),
                   .edge_shift = AT(0, 0, 0),
                   .step_y = STEP_Y,
                   .step_z = STEP_Z};
}

/// q = f K u + m M u at the unknowns of a general block that count.
ALWAYS void finish_general(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                           bool held, const double *p, double *q) {
  for (int a = 0; a < DIM; a++) {
    const double *m = L->level->mass[a] + (LitheCount)block * CELLS;
    const uint8_t *state = L->level->state[a] + (LitheCount)block * CELLS;
    for (int i = 0; i < CELLS; i++) {
      int at = a * CELLS + i;
      double value = stiff * q[at] + inert * m[i] * p[at];
      q[at] = state[i] == LTH_UNKNOWN_FREE || (held && state[i] == LTH_UNKNOWN_HELD) ? value : 0;
    }
  }
}

LTH_CLONES
static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  _Alignas(64) double u[DIM][PADDED];
  const double *near[N_NEAR];
  double(*y)[CELLS] = (double(*)[CELLS])(result + (LitheCount)block * BLOCK);
  const double *p = values + (LitheCount)block * BLOCK;
  const LthStaggeredLevel *l = L->level;
  double volume = lth_sparse_grid_cell_volume(L->grid);
  double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  find_near_d(L->grid, block, values, BLOCK, no_values_d, near);
  const LitheIndex next = block_ahead(L->grid, block);
  for (int a = 0; a < DIM; a++) {
    pad_d(near, a * CELLS, values + (LitheCount)next * BLOCK, u[a]);
    for (int i = 0; i < CELLS; i += SIDE)
      fetch_d(result + (LitheCount)next * BLOCK + a * CELLS + i, 1);
  }
  LitheCount first = (LitheCount)block * CELLS;
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    uniform_rows_d(u, stiff * l->lambda[first], stiff * l->mu[first], inert * l->mass[0][first],
                   L->ratio, y);
  } else {
    Padded P;
    Samples_d c;
    pad_samples(L, block, &P, &c);
    general_rows_d(u, &c, L->ratio, y);
    finish_general(L, block, stiff, inert, held, p, y[0]);
  }
  double lane[SIDE] = {0};
  const double *q = y[0];
  for (int r = 0; r < BLOCK; r += SIDE)
    for (int i = 0; i < SIDE; i++) lane[i] += p[r + i] * q[r + i];
  return sum_lanes(lane);
}

/// Block at a place, -1 where there is none.
static LitheIndex block_at_place(const LthSparseGrid *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  if (i < 0 || j < 0 || k < 0 || i >= g->n_block[0] || j >= g->n_block[1] || k >= g->n_block[2])
    return -1;
  return g->block_at[i + (LitheCount)g->n_block[0] * (j + (LitheCount)g->n_block[1] * k)];
}

/// Values around a place whose own block may be missing; false where there is nothing at all.
static bool find_near_place(const LthSparseGrid *g, const LitheIndex place[3], LthFastVector v,
                            const float *near[N_NEAR]) {
  bool any = false;
  for (int i = 0; i < N_NEAR; i++) {
    LitheIndex block = block_at_place(g, place[0] + i % 3 - 1, place[1] + i / 3 % 3 - 1,
                                      place[2] + (DIM == 3 ? i / 9 - 1 : 0));
    near[i] = block < 0 ? no_values_f : block_of(v, block);
    any |= block >= 0;
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

/// Component a of a fine block from the padded coarse one that it is a part of.
ALWAYS void interpolate(const float *c, int a, const int offset[3], float *restrict out) {
  enum { ROWS = HALF + 2, LAYERS = DIM == 3 ? HALF + 2 : 1 };
  _Alignas(64) float x[LAYERS][ROWS][SIDE], xy[LAYERS][SIDE][SIDE];
  for (int K = 0; K < LAYERS; K++)
    for (int J = 0; J < ROWS; J++) {
      const float *from = c + AT(offset[0], offset[1] + J - 1, (DIM == 3 ? offset[2] + K - 1 : 0));
      for (int i = 0; i < HALF; i++) {
        x[K][J][2 * i] = a == 0 ? from[i] : 0.75F * from[i] + 0.25F * from[i - 1];
        x[K][J][2 * i + 1] =
            a == 0 ? 0.5F * (from[i] + from[i + 1]) : 0.75F * from[i] + 0.25F * from[i + 1];
      }
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

LTH_CLONES
static void prolong_from(const LthFastLevel *fine, const LthFastLevel *coarse, LitheIndex block,
                         bool add) {
  _Alignas(64) float c[DIM][PADDED], out[CELLS];
  const float *near[N_NEAR];
  find_near_f(coarse->grid, block, coarse->x.at, coarse->x.stride, no_values_f, near);
  for (int a = 0; a < DIM; a++) pad_f(near, a * CELLS, block_of(coarse->x, block), c[a]);
  if (coarse->pull) {
    find_near_f(coarse->grid, block, coarse->pull, BLOCK, no_values_f, near);
    for (int a = 0; a < DIM; a++) {
      _Alignas(64) float pull[PADDED];
      pad_f(near, a * CELLS, coarse->pull, pull);
      for (int i = 0; i < PADDED; i++) c[a][i] *= pull[i];
    }
  }
  for (int child = 0; child < 1 << DIM; child++) {
    LitheIndex place[3];
    int offset[3];
    child_of(coarse->grid, block, child, place, offset);
    LitheIndex to = block_at_place(fine->grid, place[0], place[1], place[2]);
    if (to < 0 || fine->kind[to] == LTH_BLOCK_EMPTY) continue;
    const float *scale = scale_of(fine, to), same = fine->same_scale[to];
    for (int a = 0; a < DIM; a++) {
      float *restrict x = block_of(fine->x, to) + a * CELLS;
      interpolate(c[a], a, offset, out);
      for (int i = 0; i < CELLS; i++) out[i] *= scale ? scale[a * CELLS + i] : same;
      if (add)
        for (int i = 0; i < CELLS; i++) x[i] += out[i];
      else
        memcpy(x, out, sizeof out);
    }
  }
}

/// Transposed weights along one axis: coarse value I from fine ones 2 I - 1 ... 2 I + 2, `step` apart.
ALWAYS float gather4(const float *at, int step, bool own) {
  return own ? at[0] + 0.5F * (at[-step] + at[step])
             : 0.75F * (at[0] + at[step]) + 0.25F * (at[-step] + at[2 * step]);
}

/// Component a of a part of a coarse block (in coarse cells, SIDE apart) from the padded fine block below it.
ALWAYS void collect(const float *f, int a, float *restrict out) {
  _Alignas(64) float z[DEEP_HALF][SIDE + 2][PAD_X], yz[DEEP_HALF][HALF][PAD_X];
  for (int K = 0; K < DEEP_HALF; K++)
    for (int j = -1; j <= SIDE; j++)
      for (int i = -1; i <= SIDE; i++)
        z[K][j + 1][i + PAD_LEFT] =
            DIM == 3 ? gather4(f + AT(i, j, 2 * K), STEP_Z, a == 2) : f[AT(i, j, 0)];
  for (int K = 0; K < DEEP_HALF; K++)
    for (int J = 0; J < HALF; J++)
      for (int i = -1; i <= SIDE; i++)
        yz[K][J][i + PAD_LEFT] = gather4(&z[K][2 * J + 1][i + PAD_LEFT], PAD_X, a == 1);
  for (int K = 0; K < DEEP_HALF; K++)
    for (int J = 0; J < HALF; J++)
      for (int I = 0; I < HALF; I++)
        out[(K * SIDE + J) * SIDE + I] = gather4(&yz[K][J][2 * I + PAD_LEFT], 1, a == 0);
}

LTH_CLONES
static void restrict_to(const LthFastLevel *fine, const LthFastLevel *coarse, LitheIndex block) {
  _Alignas(64) float f[PADDED];
  const float *near[N_NEAR];
  float *b = block_of(coarse->b, block);
  memset(b, 0, sizeof *b * BLOCK);
  for (int child = 0; child < 1 << DIM; child++) {
    LitheIndex place[3];
    int offset[3];
    child_of(coarse->grid, block, child, place, offset);
    if (!find_near_place(fine->grid, place, fine->y, near)) continue;
    int first = ((DIM == 3 ? offset[2] : 0) * SIDE + offset[1]) * SIDE + offset[0];
    for (int a = 0; a < DIM; a++) {
      pad_f(near, a * CELLS, near[N_NEAR / 2], f);
      collect(f, a, b + a * CELLS + first);
    }
  }
  if (!coarse->pull) return;
  const float *pull = coarse->pull + (LitheCount)block * BLOCK;
  for (int i = 0; i < BLOCK; i++) b[i] *= pull[i];
}

const LthFastKernels JOIN(lth_fast_kernels, SUFFIX) = {smooth,      start,        residual, weigh,
                                                       restrict_to, prolong_from, apply};
