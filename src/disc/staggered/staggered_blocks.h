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

/// Block that comes so many later in memory, if there is one.
ALWAYS LitheIndex block_later(const LthSparseGrid *g, LitheIndex block, LitheIndex by) {
  return block + by < g->n_blocks ? block + by : block;
}

ALWAYS float *row_of(LthFastVector v, LitheIndex row) { return v.at + row * v.stride; }

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

/// Rows of a block that are not plain; and the offset of the first one's samples: those that differ stand in a row.
ALWAYS uint64_t general_of(const LthFastLevel *L, LitheIndex block) {
  return L->alive[block] & ~L->plain[block];
}
ALWAYS LitheCount first_samples(const LthFastLevel *L, LitheIndex block, LitheCount stride) {
  const int first = general_of(L, block) ? __builtin_ctzll(general_of(L, block)) : 0;
  return stride * L->level->row[block * (LitheCount)BLOCK_ROWS + first];
}

/// (A x) of a block, of its rows that are alive.
ALWAYS void fast_rows(const LthFastLevel *L, LitheIndex block, float y[BLOCK]) {
  enum { SAMPLES = N_SHEAR + 2, STRIDE = SAMPLES * SIDE };
  const LitheIndex here = L->first[block], later = L->first[block_later(L->grid, block, 2)];
  const Ahead_f ahead = {{row_of(L->x, later), row_of(L->y, here), row_of(L->b, here)},
                         {L->x.stride, L->y.stride, L->b.stride},
                         3};
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const float ratio[3] = {1, (float)L->ratio[1], (float)L->ratio[2]};
  Rows_f rows;
  find_rows_f(L, near, L->x.at, L->x.stride, &rows);
  fetch_margin_f(L, block_later(L->grid, block, 1), L->x.at, L->x.stride);
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    const float *c = L->constant + 3 * (LitheCount)block;
    const Constant_f constant = constant_f(c[0], c[1], c[2], ratio);
    uniform_rows_f(&rows, &constant, &ahead, y);
    return;
  }
  const float *s = L->sample, *of = L->constant + 3 * (LitheCount)block;
  Samples_f samples = {
      .lambda = s, .mu = s + SIDE, .shear[XY] = s + 2 * SIDE, .level = L->level, .stride = STRIDE};
#if DIM == 3
  samples.shear[0] = s + 3 * SIDE;
  samples.shear[1] = s + 4 * SIDE;
#endif
  const LitheIndex next = block_later(L->grid, block, 1);
  if (L->kind[next] == LTH_BLOCK_GENERAL) {
    const LitheCount rows_there = L->first[next + 1] - L->first[next];
    fetch_all(L->sample + first_samples(L, next, STRIDE),
              4 * STRIDE * __builtin_popcountll(general_of(L, next)));
    fetch_all(L->inverse + L->number[next] * (LitheCount)WIDTH, 4 * WIDTH * rows_there);
  }
  const Constant_f same = constant_f(of[0], of[1], 0, ratio); // inertia follows
  find_samples_f(block, &samples);
  general_rows_f(&rows, &samples, &same, ratio, L->alive[block], L->plain[block], &ahead, y);
  if (!L->inertia) return;
  const float *m = L->inertia + L->number[block] * (LitheCount)WIDTH;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++, m += WIDTH) {
    const float *x = row_of(L->x, q);
    float *to = y + L->local[q] * WIDTH;
    for (int i = 0; i < WIDTH; i += SIDE)
      store_f(to + i, load_f(to + i) + load_f(m + i) * load_f(x + i));
  }
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

/// Inverse of the diagonal of a general block's row of vectors.
ALWAYS const float *inverse_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->inverse + (L->number[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// y = keep x - old y + length D^-1 (b - A x), row by row.
ALWAYS void smooth_rows(const LthFastLevel *L, LitheIndex block, LthFastStep step, const bool fresh,
                        const bool uniform, const float *Ax, double lane[SIDE]) {
  const float keep = 1 + step.momentum, old = step.momentum, length = step.length;
  float same[DIM];
  for (int a = 0; a < DIM; a++) same[a] = uniform ? length * inverse_diagonal(L, block, a) : 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *x = row_of(L->x, q), *b = row_of(L->b, q), *of = Ax + L->local[q] * WIDTH;
    const float *stored = uniform ? NULL : inverse_of(L, block, q);
    float *y = row_of(L->y, q);
    for (int a = 0; a < DIM; a++) {
      const int at = a * SIDE;
      Lane_f rhs = load_f(b + at), r = rhs - load_f(of + at);
      Lane_f z = keep * load_f(x + at) + (uniform ? same[a] * r : length * load_f(stored + at) * r);
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
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  if (step.fresh && uniform)
    smooth_rows(L, block, step, true, true, Ax, lane);
  else if (uniform)
    smooth_rows(L, block, step, false, true, Ax, lane);
  else if (step.fresh)
    smooth_rows(L, block, step, true, false, Ax, lane);
  else
    smooth_rows(L, block, step, false, false, Ax, lane);
  return step.product ? sum_lanes(lane) : 0;
}

LTH_CLONES
static void start(const LthFastLevel *L, LitheIndex block, float length) {
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  float same[DIM];
  for (int a = 0; a < DIM; a++) same[a] = uniform ? length * inverse_diagonal(L, block, a) : 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *b = row_of(L->b, q), *stored = uniform ? NULL : inverse_of(L, block, q);
    float *x = row_of(L->x, q);
    for (int a = 0; a < DIM; a++) {
      const Lane_f rhs = load_f(b + a * SIDE);
      store_f(x + a * SIDE, uniform ? same[a] * rhs : length * load_f(stored + a * SIDE) * rhs);
    }
  }
}

ALWAYS const float *scale_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->scale + (L->scaled[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// y = scale (b - Ax), or (Ax is NULL) y = scale b, row by row.
ALWAYS void scale_rows(const LthFastLevel *L, LitheIndex block, const float *Ax) {
  const bool varies = L->scaled[block] >= 0;
  const float same = L->same_scale[block];
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *b = row_of(L->b, q), *scale = varies ? scale_of(L, block, q) : NULL;
    float *y = row_of(L->y, q);
    for (int at = 0; at < WIDTH; at += SIDE) {
      Lane_f r = load_f(b + at);
      if (Ax) r -= load_f(Ax + L->local[q] * WIDTH + at);
      store_f(y + at, varies ? r * load_f(scale + at) : r * same);
    }
  }
}

LTH_CLONES
static void residual(const LthFastLevel *L, LitheIndex block) {
  _Alignas(64) float Ax[BLOCK];
  fast_rows(L, block, Ax);
  scale_rows(L, block, Ax);
}

LTH_CLONES
static void weigh(const LthFastLevel *L, LitheIndex block) { scale_rows(L, block, NULL); }

/// q = f K u + m M u at the unknowns of a general block that count, from K u of all its rows; returns p . q by lanes.
ALWAYS void finish_general(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                           bool held, const double *Ku, const double *values, double *result,
                           double lane[SIDE]) {
  const LthStaggeredLevel *l = L->level;
  const uint8_t last = held ? LTH_UNKNOWN_HELD : LTH_UNKNOWN_FREE;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const LitheCount row = block * (LitheCount)BLOCK_ROWS + L->local[q], slot = row * SIDE;
    for (int a = 0; a < DIM; a++) {
      const LitheCount at = q * (LitheCount)WIDTH + a * SIDE;
      const double *p = values + at, *f = Ku + L->local[q] * WIDTH + a * SIDE;
      const double *m = l->mass[a] + l->row[row] * (LitheCount)SIDE;
      const uint8_t *state = l->state[a] + slot;
      double *to = result + at;
      for (int i = 0; i < SIDE; i++) {
        const double value = stiff * f[i] + (inert != 0 ? inert * m[i] * p[i] : 0);
        to[i] = state[i] != LTH_UNKNOWN_DEAD && state[i] <= last ? value : 0;
        lane[i] += p[i] * to[i];
      }
    }
  }
}

/// Fetch the coefficients of a general block: rows that differ from others stand one after the other.
ALWAYS void fetch_coefficients(const LthFastLevel *L, LitheIndex block) {
  const LthStaggeredLevel *l = L->level;
  const LitheCount n = 8 * SIDE * __builtin_popcountll(general_of(L, block));
  const LitheCount first = first_samples(L, block, SIDE);
  fetch_all(l->lambda + first, n);
  fetch_all(l->mu + first, n);
  for (int e = DIM == 3 ? 0 : 2; e < 3; e++) fetch_all(l->shear[e] + first, n);
  for (int a = 0; a < DIM; a++) fetch_all(l->state[a] + block * (LitheCount)CELLS, CELLS);
}

/// q = A p in a uniform block, whose rows are all there; returns p . q by lanes.
ALWAYS void apply_uniform(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                          const Rows_d *rows, const Ahead_d *ahead, const double *values,
                          double *result, double lane[SIDE]) {
  const LthStaggeredLevel *l = L->level;
  const LitheCount first = L->first[block] * (LitheCount)WIDTH, at = lth_fast_constant(L, block);
  const Constant_d c =
      constant_d(stiff * l->lambda[at], stiff * l->mu[at], inert * l->mass[0][at], L->ratio);
  uniform_rows_d(rows, &c, ahead, result + first);
  for (LitheCount r = first; r < first + BLOCK; r += SIDE)
    for (int i = 0; i < SIDE; i++) lane[i] += values[r + i] * result[r + i];
}

LTH_CLONES
static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex next = block_later(L->grid, block, 1);
  const LitheIndex later = L->first[block_later(L->grid, block, 2)];
  const Ahead_d ahead = {
      {values + later * (LitheCount)WIDTH, result + L->first[next] * (LitheCount)WIDTH},
      {WIDTH, WIDTH},
      2};
  double volume = lth_sparse_grid_cell_volume(L->grid), lane[SIDE] = {0};
  double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  Rows_d rows;
  find_rows_d(L, L->grid->neighbor + (LitheCount)block * N_NEAR, values, WIDTH, &rows);
  fetch_margin_d(L, next, values, WIDTH);
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    apply_uniform(L, block, stiff, inert, &rows, &ahead, values, result, lane);
    return sum_lanes(lane);
  }
  _Alignas(64) double Ku[BLOCK];
  const LitheCount at = lth_fast_constant(L, block);
  const Constant_d same = constant_d(l->lambda[at], l->mu[at], 0, L->ratio);
  Samples_d c = {.lambda = l->lambda, .mu = l->mu, .level = l, .stride = SIDE};
  for (int e = 0; e < N_SHEAR; e++) c.shear[e] = l->shear[DIM == 3 ? e : 2];
  if (L->kind[next] == LTH_BLOCK_GENERAL) fetch_coefficients(L, next);
  find_samples_d(block, &c);
  general_rows_d(&rows, &c, &same, L->ratio, L->alive[block], L->plain[block], &ahead, Ku);
  finish_general(L, block, stiff, inert, held, Ku, values, result, lane);
  return sum_lanes(lane);
}

#include "disc/staggered/staggered_transfers.h"

const LthFastKernels JOIN(lth_fast_kernels, SUFFIX) = {smooth,      start,        residual, weigh,
                                                       restrict_to, prolong_from, apply};
