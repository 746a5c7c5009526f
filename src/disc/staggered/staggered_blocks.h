/// What the solver does with one block, for DIM = 2 or 3: rows in single and double precision, transfers.
#include "base/clones.h"
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

#define JOIN2(a, b) a##_##b
#define JOIN(a, b) JOIN2(a, b)

/// Block that comes so many later in memory, if there is one.
static inline LitheIndex block_later(const LthSparseGrid *g, LitheIndex block, LitheIndex by) {
  return block + by < g->n_blocks ? block + by : block;
}

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

ALWAYS float *row_of(LthFastVector v, LitheIndex row) { return v.at + row * v.stride; }

/// The operator in a block.
ALWAYS void fast_block(const LthFastLevel *L, LitheIndex block, Block_f *B) {
  enum { SAMPLES = N_SHEAR + 2, STRIDE = SAMPLES * SIDE };
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const float ratio[3] = {1, (float)L->ratio[1], (float)L->ratio[2]};
  const float *c = L->constant + 3 * (LitheCount)block, *s = L->sample;
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  B->plain = L->plain[block];
  B->same = constant_f(c[0], c[1], uniform ? c[2] : 0, ratio);
  B->samples.lambda = s;
  B->samples.mu = s + SIDE;
  B->samples.stride = STRIDE;
  B->samples.scale = 1;
  UNROLL
  for (int a = 0; a < DIM; a++) B->samples.ratio[a] = ratio[a];
  UNROLL
  for (int e = 0; e < N_SHEAR; e++)
    B->samples.shear[e] = s + (2 + (DIM == 3 ? (e + 1) % 3 : 0)) * SIDE;
  if (!uniform) find_samples_f(L->level, near, &B->samples);
  find_rows_f(L, near, L->x.at, L->x.stride, &B->rows);
  look_ahead_f(L, block, L->x.at, L->x.stride, &B->ahead);
}

/// f = A x in row q of vectors, in a block that is uniform or not.
ALWAYS void fast_row(const LthFastLevel *L, LitheIndex block, Block_f *B, const bool uniform,
                     LitheIndex q, Lane_f f[DIM]) {
  const LitheIndex number = q - L->first[block];
  row_f(B, uniform, uniform ? number : L->local[q], 0, f);
  if (uniform || !L->inertia) return;
  const float *m = L->inertia + (L->number[block] + number) * (LitheCount)WIDTH;
  UNROLL
  for (int a = 0; a < DIM; a++) f[a] += load_f(m + a * SIDE) * load_f(row_of(L->x, q) + a * SIDE);
}

/// With row q of a block, fetch what is wanted soon.
ALWAYS void fast_fetch(const LthFastLevel *L, const Block_f *B, LitheIndex block,
                       const bool uniform, LitheIndex q) {
  const LitheIndex number = q - L->first[block];
  fetch_row_f(row_of(L->x, q + 2 * SOON)); // neighbours read it before
  fetch_row_f(row_of(L->y, q + SOON));
  fetch_row_f(row_of(L->b, q + SOON));
  fetch_ahead_f(&B->ahead, &B->samples, uniform ? number : L->local[q]);
  if (!uniform) fetch_row_f(L->inverse + (L->number[block] + number + SOON) * (LitheCount)WIDTH);
}

/// Inverse of the diagonal of a component in a uniform block.
ALWAYS float inverse_diagonal(const LthFastLevel *L, LitheIndex block, int a) {
  const float *c = L->constant + 3 * (LitheCount)block;
  float d = c[2];
  UNROLL
  for (int b = 0; b < DIM; b++)
    d += 2 * (b == a ? 2 * c[1] + c[0] : c[1]) * (float)(L->ratio[b] * L->ratio[b]);
  return 1 / d;
}

typedef double Wide __attribute__((vector_size(LANES_F * sizeof(double))));

ALWAYS double sum_wide(Wide lane) {
  double sum = 0;
  for (int i = 0; i < LANES_F; i++) sum += lane[i];
  return sum;
}

/// Inverse of the diagonal of a general block's row of vectors.
ALWAYS const float *inverse_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->inverse + (L->number[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// y = keep x - old y + length D^-1 (b - A x), row by row; returns b . y, in double precision.
ALWAYS double smooth_rows(const LthFastLevel *L, LitheIndex block, LthFastStep step,
                          const bool fresh, const bool uniform) {
  const float keep = 1 + step.momentum, old = step.momentum, length = step.length;
  Block_f B;
  Wide product = {0};
  float same[DIM];
  fast_block(L, block, &B);
  UNROLL
  for (int a = 0; a < DIM; a++) same[a] = uniform ? length * inverse_diagonal(L, block, a) : 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *x = row_of(L->x, q), *b = row_of(L->b, q);
    const float *stored = uniform ? NULL : inverse_of(L, block, q);
    float *y = row_of(L->y, q);
    fast_fetch(L, &B, block, uniform, q);
    Lane_f f[DIM];
    fast_row(L, block, &B, uniform, q, f);
    UNROLL
    for (int a = 0; a < DIM; a++) {
      const int at = a * SIDE;
      const Lane_f rhs = load_f(b + at), r = rhs - f[a];
      Lane_f z = keep * load_f(x + at) + (uniform ? same[a] * r : length * load_f(stored + at) * r);
      if (!fresh) z -= old * load_f(y + at);
      store_f(y + at, z);
      if (step.product)
        product += __builtin_convertvector(rhs, Wide) * __builtin_convertvector(z, Wide);
    }
  }
  return step.product ? sum_wide(product) : 0;
}

LTH_CLONES
static double smooth(const LthFastLevel *L, LitheIndex block, LthFastStep step) {
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  if (step.fresh && uniform) return smooth_rows(L, block, step, true, true);
  if (uniform) return smooth_rows(L, block, step, false, true);
  if (step.fresh) return smooth_rows(L, block, step, true, false);
  return smooth_rows(L, block, step, false, false);
}

LTH_CLONES
static void start(const LthFastLevel *L, LitheIndex block, float length) {
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  float same[DIM];
  UNROLL
  for (int a = 0; a < DIM; a++) same[a] = uniform ? length * inverse_diagonal(L, block, a) : 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *b = row_of(L->b, q), *stored = uniform ? NULL : inverse_of(L, block, q);
    float *x = row_of(L->x, q);
    UNROLL
    for (int a = 0; a < DIM; a++) {
      const Lane_f rhs = load_f(b + a * SIDE);
      store_f(x + a * SIDE, uniform ? same[a] * rhs : length * load_f(stored + a * SIDE) * rhs);
    }
  }
}

ALWAYS const float *scale_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->scale + (L->scaled[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// y = scale (b - A x), or (B is NULL) y = scale b, row by row.
ALWAYS void scale_rows(const LthFastLevel *L, LitheIndex block, const bool uniform, Block_f *B) {
  const bool varies = L->scaled[block] >= 0;
  const float same = L->same_scale[block];
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *b = row_of(L->b, q), *scale = varies ? scale_of(L, block, q) : NULL;
    float *y = row_of(L->y, q);
    Lane_f f[DIM] = {0};
    if (B) {
      fast_fetch(L, B, block, uniform, q);
      fast_row(L, block, B, uniform, q, f);
    }
    UNROLL
    for (int a = 0; a < DIM; a++) {
      const Lane_f r = load_f(b + a * SIDE) - f[a];
      store_f(y + a * SIDE, varies ? r * load_f(scale + a * SIDE) : r * same);
    }
  }
}

LTH_CLONES
static void residual(const LthFastLevel *L, LitheIndex block) {
  Block_f B;
  fast_block(L, block, &B);
  if (L->kind[block] == LTH_BLOCK_UNIFORM)
    scale_rows(L, block, true, &B);
  else
    scale_rows(L, block, false, &B);
}

LTH_CLONES
static void weigh(const LthFastLevel *L, LitheIndex block) { scale_rows(L, block, false, NULL); }

/// The operator in double precision in a block.
ALWAYS void exact_block(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                        const double *values, Block_d *B) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const LitheCount at = lth_fast_constant(L, block);
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  B->plain = L->plain[block];
  B->same = constant_d(stiff * l->lambda[at], stiff * l->mu[at],
                       uniform ? inert * l->mass[0][at] : 0, L->ratio);
  B->samples.lambda = l->lambda;
  B->samples.mu = l->mu;
  B->samples.stride = SIDE;
  B->samples.scale = stiff;
  UNROLL
  for (int a = 0; a < DIM; a++) B->samples.ratio[a] = L->ratio[a];
  UNROLL
  for (int e = 0; e < N_SHEAR; e++) B->samples.shear[e] = l->shear[DIM == 3 ? e : 2];
  if (!uniform) find_samples_d(l, near, &B->samples);
  find_rows_d(L, near, values, WIDTH, &B->rows);
  look_ahead_d(L, block, values, WIDTH, &B->ahead);
}

typedef uint64_t Bits __attribute__((vector_size(64)));

/// v where unknowns are free, or (`held`) not dead, else 0. The lowest bit of a state says that it is free, the next one
/// that it is held.
ALWAYS Lane_d where_counted(Lane_d v, const uint8_t state[8], bool held) {
  uint64_t s;
  memcpy(&s, state, 8);
  s |= held ? s >> 1 : 0;
  const Bits lowest = ((Bits){0} + s) << (Bits){63, 55, 47, 39, 31, 23, 15, 7};
  return (Lane_d)((Bits)v & -(lowest >> 63));
}

/// f += m M p, and zero where an unknown does not count (all do in plain rows), in row q of a general block.
ALWAYS void finish_row(const LthFastLevel *L, LitheIndex block, LitheIndex q, int i, double inert,
                       bool held, bool plain, const double *p, Lane_d f[DIM]) {
  const LthStaggeredLevel *l = L->level;
  const LitheCount row = block * (LitheCount)BLOCK_ROWS + L->local[q];
  UNROLL
  for (int a = 0; a < DIM; a++) {
    __builtin_prefetch(l->state[a] + row * SIDE + CELLS, 0, 2);
    if (inert != 0)
      f[a] += inert * load_d(l->mass[a] + l->row[row] * (LitheCount)SIDE + i) *
              load_d(p + a * SIDE + i);
    if (!plain) f[a] = where_counted(f[a], l->state[a] + row * SIDE + i, held);
  }
}

/// q = A p in a block, row by row; returns p . q.
ALWAYS double apply_rows(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                         bool held, const bool uniform, const double *values, double *result) {
  const LitheIndex first = L->first[block], behind = L->first[block + 1];
  Block_d B;
  Lane_d product = {0};
  exact_block(L, block, stiff, inert, values, &B);
  for (LitheIndex q = first; q < behind; q++) {
    const double *p = values + q * (LitheCount)WIDTH;
    double *to = result + q * (LitheCount)WIDTH;
    const int row = uniform ? q - first : L->local[q];
    fetch_row_d(p + 2 * SOON * WIDTH); // neighbours read it before
    fetch_row_d(to + SOON * WIDTH);
    fetch_ahead_d(&B.ahead, &B.samples, row);
    for (int i = 0; i < SIDE; i += 8) {
      Lane_d f[DIM];
      row_d(&B, uniform, row, i, f);
      if (!uniform) finish_row(L, block, q, i, inert, held, B.plain >> row & 1, p, f);
      UNROLL
      for (int a = 0; a < DIM; a++) {
        store_d(to + a * SIDE + i, f[a]);
        product += f[a] * load_d(p + a * SIDE + i);
      }
    }
  }
  double sum = 0;
  for (int i = 0; i < 8; i++) sum += product[i];
  return sum;
}

LTH_CLONES
static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  const double volume = lth_sparse_grid_cell_volume(L->grid);
  const double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  if (L->kind[block] == LTH_BLOCK_UNIFORM)
    return apply_rows(L, block, stiff, inert, held, true, values, result);
  return apply_rows(L, block, stiff, inert, held, false, values, result);
}

#include "disc/staggered/staggered_transfers.h"

const LthFastKernels JOIN(lth_fast_kernels, SUFFIX) = {smooth,      start,        residual, weigh,
                                                       restrict_to, prolong_from, apply};
