/// What the solver does with one block, for DIM = 2 or 3: rows in single and double precision, transfers.
#include "base/clones.h"
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

#define JOIN2(a, b) a##_##b
#define JOIN(a, b) JOIN2(a, b)

#if DIM == 3
#define LANES_F 8
#else
#define LANES_F 16
#endif
#define REAL float
#define LANES LANES_F
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

static const float no_values_f[BLOCK];
static const double no_values_d[BLOCK];

/// Block that comes so many later in memory, if there is one.
ALWAYS LitheIndex block_later(const LthSparseGrid *g, LitheIndex block, LitheIndex by) {
  return block + by < g->n_blocks ? block + by : block;
}

ALWAYS float *block_of(LthFastVector v, LitheIndex block) { return v.at + block * v.stride; }

/// Sum of lanes in fixed order.
ALWAYS double sum_lanes(const double lane[SIDE]) {
  double sum = 0;
  for (int i = 0; i < SIDE; i++) sum += lane[i];
  return sum;
}

/// Fetch all of an array.
ALWAYS void fetch_all(const void *at, LitheCount bytes) {
  for (LitheCount i = 0; i < bytes; i += 64) __builtin_prefetch((const char *)at + i, 0, 2);
}

/// Coefficients of a general block: `sample` has a margin of one before cells and behind edges.
ALWAYS void find_samples(const LthFastLevel *L, LitheIndex block, Samples_f *c) {
  const LitheCount n = N_EDGE_ROWS * (SIDE + 1);
  const float *s = L->sample + (LitheCount)L->number[block] * L->n_sample;
  for (int q = 0; q < N_EDGE_ROWS; q++, s += SIDE + 1) {
    c->lambda[q] = s + 1;
    c->mu[q] = s + n + 1;
    c->shear[XY][q] = s + 2 * n;
#if DIM == 3
    c->shear[0][q] = s + 3 * n;
    c->shear[1][q] = s + 4 * n;
#endif
  }
  for (int k = 0; k < DEEP; k++)
    for (int j = 0; j < SIDE; j++) {
      const int at = k * SIDE + j;
      c->lambda_before[at] = c->lambda[CELL_ROW(j, k)][-1];
      c->mu_before[at] = c->mu[CELL_ROW(j, k)][-1];
      c->shear_behind[XY][at] = c->shear[XY][EDGE_ROW(j, k)][SIDE];
      if (DIM == 3) c->shear_behind[1][at] = c->shear[1][EDGE_ROW(j, k)][SIDE];
    }
}

/// (A x) of a block.
ALWAYS void fast_rows(const LthFastLevel *L, LitheIndex block, float y[BLOCK]) {
  const float *near[N_NEAR];
  const Ahead_f ahead = {{block_of(L->x, block_later(L->grid, block, 2)), block_of(L->y, block),
                          block_of(L->b, block)},
                         3};
  const float ratio[3] = {1, (float)L->ratio[1], (float)L->ratio[2]};
  Rows_f rows;
  find_near_f(L->grid, block, L->x.at, L->x.stride, no_values_f, near);
  find_rows_f(near, &rows);
  fetch_margin_f(L->grid, block_later(L->grid, block, 1), L->x.at, L->x.stride, DIM);
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    const float *c = L->constant + 3 * (LitheCount)block;
    const Constant_f constant = constant_f(c[0], c[1], c[2], ratio);
    uniform_rows_f(&rows, &constant, &ahead, y);
    return;
  }
  Samples_f samples;
  if (L->number[block] + 1 < L->n_general) {
    fetch_all(L->sample + (L->number[block] + (LitheCount)1) * L->n_sample, 4 * L->n_sample);
    fetch_all(L->inverse + (L->number[block] + (LitheCount)1) * BLOCK, 4 * BLOCK);
  }
  find_samples(L, block, &samples);
  general_rows_f(&rows, &samples, ratio, &ahead, y);
  if (!L->inertia) return;
  const float *m = L->inertia + (LitheCount)L->number[block] * BLOCK, *x = block_of(L->x, block);
  for (int at = 0; at < BLOCK; at += SIDE)
    store_f(y + at, load_f(y + at) + load_f(m + at) * load_f(x + at));
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
  _Alignas(64) float Ax[BLOCK];
  double lane[SIDE] = {0};
  fast_rows(L, block, Ax);
  if (step.fresh)
    smooth_rows(L, block, step, true, Ax, lane);
  else
    smooth_rows(L, block, step, false, Ax, lane);
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
  _Alignas(64) float Ax[BLOCK];
  fast_rows(L, block, Ax);
  const float *b = block_of(L->b, block), *scale = scale_of(L, block);
  const float same = L->same_scale[block];
  float *y = block_of(L->y, block);
  for (int at = 0; at < BLOCK; at += SIDE) {
    Lane_f r = load_f(b + at) - load_f(Ax + at);
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

/// Rows of a field of cells, and its values before them.
ALWAYS void find_cell_rows(const LthFastLevel *L, LitheIndex block, const double *field,
                           const double **row, double *before) {
  const double *near[N_NEAR];
  find_near_d(L->grid, block, field, CELLS, no_values_d, near);
  for (int k = FIRST_K; k < DEEP; k++) {
    const double *const *plane = near + (DIM == 3 && k >= 0 ? 9 : 0);
    const int at = (k & (DEEP - 1)) * SIDE * SIDE;
    row[CELL_ROW(-1, k)] = plane[1] + at + (SIDE - 1) * SIDE;
    for (int j = 0; j < SIDE; j++) row[CELL_ROW(j, k)] = plane[4] + at + j * SIDE;
    for (int j = 0; k >= 0 && j < SIDE; j++)
      before[k * SIDE + j] = plane[3][at + j * SIDE + SIDE - 1];
  }
}

/// Rows of a field of edges, and its values behind them.
ALWAYS void find_edge_rows(const LthFastLevel *L, LitheIndex block, const double *field,
                           const double **row, double *behind) {
  const double *near[N_NEAR];
  find_near_d(L->grid, block, field, CELLS, no_values_d, near);
  for (int k = 0; k < DEEP - FIRST_K; k++) {
    const double *const *plane = near + (DIM == 3 ? k < DEEP ? 9 : 18 : 0);
    const int at = (k & (DEEP - 1)) * SIDE * SIDE;
    for (int j = 0; j < SIDE; j++) row[EDGE_ROW(j, k)] = plane[4] + at + j * SIDE;
    row[EDGE_ROW(SIDE, k)] = plane[7] + at;
    for (int j = 0; k < DEEP && j < SIDE; j++) behind[k * SIDE + j] = plane[5][at + j * SIDE];
  }
}

/// q = f K u + m M u at the unknowns of a general block that count.
ALWAYS void finish_general(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                           bool held, const double *p, double *q) {
  const uint8_t last = held ? LTH_UNKNOWN_HELD : LTH_UNKNOWN_FREE;
  for (int a = 0; a < DIM; a++, p += CELLS, q += CELLS) {
    const double *m = L->level->mass[a] + (LitheCount)block * CELLS;
    const uint8_t *state = L->level->state[a] + (LitheCount)block * CELLS;
    for (int i = 0; i < CELLS; i++) q[i] *= stiff;
    for (int i = 0; inert != 0 && i < CELLS; i++) q[i] += inert * m[i] * p[i];
    for (int i = 0; i < CELLS; i++)
      q[i] = state[i] != LTH_UNKNOWN_DEAD && state[i] <= last ? q[i] : 0;
  }
}

/// Fetch the coefficients of a general block.
ALWAYS void fetch_coefficients(const LthFastLevel *L, LitheIndex block) {
  const LthStaggeredLevel *l = L->level;
  const LitheCount first = (LitheCount)block * CELLS;
  fetch_all(l->lambda + first, 8 * CELLS);
  fetch_all(l->mu + first, 8 * CELLS);
  for (int e = DIM == 3 ? 0 : 2; e < 3; e++) {
    fetch_all(l->shear[e] + first, 8 * CELLS);
    fetch_margin_d(L->grid, block, l->shear[e], CELLS, 1);
  }
  for (int a = 0; a < DIM; a++) fetch_all(l->state[a] + first, CELLS);
}

LTH_CLONES
static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  const double *near[N_NEAR];
  const double *p = values + (LitheCount)block * BLOCK;
  const LitheIndex next = block_later(L->grid, block, 1);
  const Ahead_d ahead = {{values + (LitheCount)block_later(L->grid, block, 2) * BLOCK,
                          result + (LitheCount)next * BLOCK},
                         2};
  double *q = result + (LitheCount)block * BLOCK;
  const LthStaggeredLevel *l = L->level;
  double volume = lth_sparse_grid_cell_volume(L->grid);
  double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  Rows_d rows;
  find_near_d(L->grid, block, values, BLOCK, no_values_d, near);
  find_rows_d(near, &rows);
  fetch_margin_d(L->grid, next, values, BLOCK, DIM);
  LitheCount first = (LitheCount)block * CELLS;
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    const Constant_d c = constant_d(stiff * l->lambda[first], stiff * l->mu[first],
                                    inert * l->mass[0][first], L->ratio);
    uniform_rows_d(&rows, &c, &ahead, q);
  } else {
    Samples_d c;
    if (L->kind[next] == LTH_BLOCK_GENERAL) fetch_coefficients(L, next);
    find_cell_rows(L, block, l->lambda, c.lambda, c.lambda_before);
    find_cell_rows(L, block, l->mu, c.mu, c.mu_before);
    for (int e = 0; e < N_SHEAR; e++)
      find_edge_rows(L, block, l->shear[DIM == 3 ? e : 2], c.shear[e], c.shear_behind[e]);
    general_rows_d(&rows, &c, L->ratio, &ahead, q);
    finish_general(L, block, stiff, inert, held, p, q);
  }
  double lane[SIDE] = {0};
  for (int r = 0; r < BLOCK; r += SIDE)
    for (int i = 0; i < SIDE; i++) lane[i] += p[r + i] * q[r + i];
  return sum_lanes(lane);
}

#include "disc/staggered/staggered_transfers.h"

const LthFastKernels JOIN(lth_fast_kernels, SUFFIX) = {smooth,      start,        residual, weigh,
                                                       restrict_to, prolong_from, apply};
