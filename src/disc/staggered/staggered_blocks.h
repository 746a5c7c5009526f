/// What the solver does with one block, for DIM = 2 or 3: rows in single and double precision, transfers. Compiled once
/// for every instruction set, whose name is ISA.
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

#define JOIN2(a, b) a##_##b
#define JOIN(a, b) JOIN2(a, b)

// Bytes of a register. gcc takes wider vectors apart through memory, three to six times slower.
#if defined(__AVX512F__)
#define REGISTER 64
#elif defined(__AVX__)
#define REGISTER 32
#else
#define REGISTER 16
#endif

/// Block that comes so many later in memory, if there is one.
static inline LitheIndex block_later(const LthSparseGrid *g, LitheIndex block, LitheIndex by) {
  return block + by < g->n_blocks ? block + by : block;
}

#if DIM == 3 && REGISTER == 64
#define LANES_F 8
#else
#define LANES_F (REGISTER / 4)
#endif
#define LANES_D (REGISTER / 8)
#define REAL float
#define LANES LANES_F
#define N(name) JOIN(name, f)
#include "disc/staggered/staggered_rows.h"
#undef REAL
#undef LANES
#undef N
#define REAL double
#define LANES LANES_D
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
  B->own = find_near_f(L, block);
  B->kind[0] = L->alive[block] & ~L->plain[block];
  B->kind[1] = L->plain[block];
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
  find_rows_f(L, near, L->x.at, L->x.stride, false, &B->rows);
  look_ahead_f(L, block, L->x.at, L->x.stride, &B->ahead);
  if (uniform) begin_planes_f(B);
}

/// f = A x from place i on in a row of a general block, in vectors row q.
ALWAYS void fast_row(const LthFastLevel *L, LitheIndex block, const Block_f *B, const bool plain,
                     int row, int i, LitheIndex q, Lane_f f[DIM]) {
  row_f(B, plain, row, i, f);
  if (!L->inertia) return;
  const float *m = L->inertia + (L->number[block] + q - B->own.first) * (LitheCount)WIDTH + i;
  UNROLL
  for (int a = 0; a < DIM; a++)
    f[a] += load_f(m + a * SIDE) * load_f(row_of(L->x, q) + i + a * SIDE);
}

// Rows of general blocks come kind by kind, so that processors guess right what comes next; what is fetched ahead goes by
// their count.
#define EACH_KIND(plain)                                                                           \
  UNROLL                                                                                           \
  for (int plain = 0; plain < 2; plain++)
#define EACH_PART(real, i) UNROLL_SIDE for (int i = 0; i < SIDE; i += LANES_##real)
#define EACH_ROW(rows, row)                                                                        \
  for (uint64_t left_ = (rows), row = 0; left_ && (row = (uint64_t)__builtin_ctzll(left_), true);  \
       left_ &= left_ - 1)

/// With row q of a block, fetch what is wanted soon.
ALWAYS void fast_fetch(const LthFastLevel *L, const Block_f *B, LitheIndex q, int row) {
  fetch_row_f(row_of(L->x, q + 2 * SOON)); // neighbours read it before
  fetch_row_f(row_of(L->y, q + SOON));
  fetch_row_f(row_of(L->b, q + SOON));
  fetch_ahead_f(&B->ahead, &B->samples, row);
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

ALWAYS double sum_lanes(Lane_d lane) {
  double sum = 0;
  for (int i = 0; i < LANES_D; i++) sum += lane[i];
  return sum;
}

/// As many floats as a register has doubles.
typedef float Narrow
    __attribute__((vector_size(LANES_D * sizeof(float)), aligned(sizeof(float)), may_alias));

ALWAYS Lane_d widen(const float *p) { return __builtin_convertvector(*(const Narrow *)p, Lane_d); }

/// Inverse of the diagonal of a general block's row of vectors.
ALWAYS const float *inverse_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->inverse + (L->number[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// What a step takes, in a block.
typedef struct Step {
  LthFastStep by;
  float same[DIM]; ///< length D^-1, where it is the same in all rows
  Lane_d product;
} Step;

/// y = keep x - old y + length D^-1 (b - f) in row q, from place i on.
ALWAYS void smooth_row(const LthFastLevel *L, Step *step, const bool fresh, const float *stored,
                       LitheIndex q, int i, const Lane_f f[DIM]) {
  const float keep = 1 + step->by.momentum, old = step->by.momentum, length = step->by.length;
  const float *x = row_of(L->x, q), *b = row_of(L->b, q);
  float *y = row_of(L->y, q);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const int at = a * SIDE + i;
    const Lane_f r = load_f(b + at) - f[a];
    Lane_f z =
        keep * load_f(x + at) + (stored ? length * load_f(stored + at) * r : step->same[a] * r);
    if (!fresh) z -= old * load_f(y + at);
    store_f(y + at, z);
    for (int n = at; step->by.product && n < at + LANES_F; n += LANES_D)
      step->product += widen(b + n) * widen(y + n);
  }
}

/// A step, row by row; returns b . y, in double precision.
ALWAYS double smooth_rows(const LthFastLevel *L, LitheIndex block, LthFastStep by, const bool fresh,
                          const bool uniform) {
  const LitheIndex first = L->first[block];
  Block_f B;
  Lane_f f[DIM];
  Step step = {.by = by};
  fast_block(L, block, &B);
  UNROLL
  for (int a = 0; a < DIM; a++)
    step.same[a] = uniform ? by.length * inverse_diagonal(L, block, a) : 0;
  int n = 0;
  EACH_KIND(plain) EACH_ROW(uniform ? 0 : B.kind[plain], row) {
    const LitheIndex q = number_f(B.own, (int)row);
    fast_fetch(L, &B, q, n++);
    fetch_row_f(inverse_of(L, block, q + SOON));
    EACH_PART(F, i) {
      fast_row(L, block, &B, plain, (int)row, i, q, f);
      smooth_row(L, &step, fresh, inverse_of(L, block, q), q, i, f);
    }
  }
  for (int k = 0; uniform && k < DEEP; k++) EACH_PART(F, i) {
      Slide_f slide;
      UNROLL_SIDE
      for (int j = 0; j < SIDE; j++) {
        const LitheIndex q = first + k * SIDE + j;
        if (i == 0) fast_fetch(L, &B, q, k * SIDE + j);
        next_row_f(&B, &slide, j, k, i, f);
        smooth_row(L, &step, fresh, NULL, q, i, f);
      }
    }
  return by.product ? sum_lanes(step.product) : 0;
}

static double smooth(const LthFastLevel *L, LitheIndex block, LthFastStep step) {
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  if (step.fresh && uniform) return smooth_rows(L, block, step, true, true);
  if (uniform) return smooth_rows(L, block, step, false, true);
  if (step.fresh) return smooth_rows(L, block, step, true, false);
  return smooth_rows(L, block, step, false, false);
}

static void start(const LthFastLevel *L, LitheIndex block, float length) {
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  float same[DIM];
  UNROLL
  for (int a = 0; a < DIM; a++) same[a] = uniform ? length * inverse_diagonal(L, block, a) : 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *b = row_of(L->b, q), *stored = uniform ? NULL : inverse_of(L, block, q);
    float *x = row_of(L->x, q);
    UNROLL
    for (int a = 0; a < DIM; a++) EACH_PART(F, i) {
        const int at = a * SIDE + i;
        const Lane_f rhs = load_f(b + at);
        store_f(x + at, uniform ? same[a] * rhs : length * load_f(stored + at) * rhs);
      }
  }
}

ALWAYS const float *scale_of(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return L->scale + (L->scaled[block] + q - L->first[block]) * (LitheCount)WIDTH;
}

/// y = scale (b - f) in row q, from place i on; `scale` is NULL where it is the same in all rows.
ALWAYS void scale_row(const LthFastLevel *L, float same, const float *scale, LitheIndex q, int i,
                      const Lane_f f[DIM]) {
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const int at = a * SIDE + i;
    const Lane_f r = load_f(row_of(L->b, q) + at) - f[a];
    store_f(row_of(L->y, q) + at, scale ? r * load_f(scale + at) : r * same);
  }
}

/// y = scale (b - A x), row by row.
ALWAYS void residual_rows(const LthFastLevel *L, LitheIndex block, const bool uniform) {
  const LitheIndex first = L->first[block];
  const bool varies = L->scaled[block] >= 0;
  const float same = L->same_scale[block];
  Block_f B;
  Lane_f f[DIM];
  fast_block(L, block, &B);
  int n = 0;
  EACH_KIND(plain) EACH_ROW(uniform ? 0 : B.kind[plain], row) {
    const LitheIndex q = number_f(B.own, (int)row);
    fast_fetch(L, &B, q, n++);
    EACH_PART(F, i) {
      fast_row(L, block, &B, plain, (int)row, i, q, f);
      scale_row(L, same, varies ? scale_of(L, block, q) : NULL, q, i, f);
    }
  }
  for (int k = 0; uniform && k < DEEP; k++) EACH_PART(F, i) {
      Slide_f slide;
      UNROLL_SIDE
      for (int j = 0; j < SIDE; j++) {
        const LitheIndex q = first + k * SIDE + j;
        if (i == 0) fast_fetch(L, &B, q, k * SIDE + j);
        next_row_f(&B, &slide, j, k, i, f);
        scale_row(L, same, varies ? scale_of(L, block, q) : NULL, q, i, f);
      }
    }
}

static void residual(const LthFastLevel *L, LitheIndex block) {
  if (L->kind[block] == LTH_BLOCK_UNIFORM)
    residual_rows(L, block, true);
  else
    residual_rows(L, block, false);
}

static void weigh(const LthFastLevel *L, LitheIndex block) {
  const Lane_f none[DIM] = {0};
  const bool varies = L->scaled[block] >= 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *scale = varies ? scale_of(L, block, q) : NULL;
    EACH_PART(F, i) scale_row(L, L->same_scale[block], scale, q, i, none);
  }
}

/// The operator in double precision in a block.
ALWAYS void exact_block(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                        const double *values, Block_d *B) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const LitheCount at = lth_fast_constant(L, block);
  const bool uniform = L->kind[block] == LTH_BLOCK_UNIFORM;
  B->own = find_near_d(L, block);
  B->kind[0] = L->alive[block] & ~L->plain[block];
  B->kind[1] = L->plain[block];
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
  find_rows_d(L, near, values, WIDTH, false, &B->rows);
  look_ahead_d(L, block, values, WIDTH, &B->ahead);
  if (uniform) begin_planes_d(B);
}

typedef uint64_t Bits __attribute__((vector_size(REGISTER)));

// Shifts that bring the lowest bits of bytes to the top of a word.
#if LANES_D == 8
#define TO_TOP 63, 55, 47, 39, 31, 23, 15, 7
#elif LANES_D == 4
#define TO_TOP 63, 55, 47, 39
#else
#define TO_TOP 63, 55
#endif

/// v where unknowns are free, or (`held`) not dead, else 0. The lowest bit of a state says that it is free, the next one
/// that it is held.
ALWAYS Lane_d where_counted(Lane_d v, const uint8_t state[LANES_D], bool held) {
  uint64_t s = 0;
  memcpy(&s, state, LANES_D);
  s |= held ? s >> 1 : 0;
  const Bits lowest = ((Bits){0} + s) << (Bits){TO_TOP};
  return (Lane_d)((Bits)v & -(lowest >> 63));
}

/// f += m M p, and zero where an unknown does not count (all do in plain rows), in a row of slots of a general block.
ALWAYS void finish_row(const LthFastLevel *L, LitheCount row, int i, double inert, bool held,
                       const bool plain, const double *p, Lane_d f[DIM]) {
  const LthStaggeredLevel *l = L->level;
  if (plain && inert == 0) return;
  UNROLL
  for (int a = 0; a < DIM; a++) {
    if (inert != 0)
      f[a] += inert * load_d(l->mass[a] + l->row[row] * (LitheCount)SIDE + i) *
              load_d(p + a * SIDE + i);
    if (!plain) f[a] = where_counted(f[a], l->state[a] + row * SIDE + i, held);
  }
}

/// With row q of vectors of a block, its row `row`, fetch what is wanted soon.
ALWAYS void exact_fetch(const Block_d *B, const double *p, const double *to, int row) {
  fetch_row_d(p + 2 * SOON * WIDTH); // neighbours read it before
  fetch_row_d(to + SOON * WIDTH);
  fetch_ahead_d(&B->ahead, &B->samples, row);
}

/// q = f; returns p . q, both from `i` on in their rows.
ALWAYS Lane_d exact_store(const double *p, const Lane_d f[DIM], double *q) {
  Lane_d product = {0};
  UNROLL
  for (int a = 0; a < DIM; a++) {
    store_d(q + a * SIDE, f[a]);
    product += f[a] * load_d(p + a * SIDE);
  }
  return product;
}

/// q = A p in a block, row by row; returns p . q.
ALWAYS double apply_rows(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                         bool held, const bool uniform, const double *values, double *result) {
  const LitheIndex first = L->first[block];
  Block_d B;
  Lane_d product = {0}, f[DIM];
  exact_block(L, block, stiff, inert, values, &B);
  int n = 0;
  EACH_KIND(plain) EACH_ROW(uniform ? 0 : B.kind[plain], row) {
    const LitheIndex q = number_d(B.own, (int)row);
    const double *p = values + q * (LitheCount)WIDTH;
    double *to = result + q * (LitheCount)WIDTH;
    exact_fetch(&B, p, to, n++);
    EACH_PART(D, i) {
      row_d(&B, plain, (int)row, i, f);
      finish_row(L, block * (LitheCount)BLOCK_ROWS + (int)row, i, inert, held, plain, p, f);
      product += exact_store(p + i, f, to + i);
    }
  }
  for (int k = 0; uniform && k < DEEP; k++) EACH_PART(D, i) {
      Slide_d slide;
      UNROLL_SIDE
      for (int j = 0; j < SIDE; j++) {
        const double *p = values + (first + k * SIDE + j) * (LitheCount)WIDTH;
        double *to = result + (first + k * SIDE + j) * (LitheCount)WIDTH;
        if (i == 0) exact_fetch(&B, p, to, k * SIDE + j);
        next_row_d(&B, &slide, j, k, i, f);
        product += exact_store(p + i, f, to + i);
      }
    }
  return sum_lanes(product);
}

static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  const double volume = lth_sparse_grid_cell_volume(L->grid);
  const double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  if (L->kind[block] == LTH_BLOCK_UNIFORM)
    return apply_rows(L, block, stiff, inert, held, true, values, result);
  return apply_rows(L, block, stiff, inert, held, false, values, result);
}

#include "disc/staggered/staggered_transfers.h"

extern const LthFastKernels JOIN(lth_fast_kernels, JOIN(SUFFIX, ISA));
const LthFastKernels JOIN(lth_fast_kernels, JOIN(SUFFIX, ISA)) = {
    smooth, start, residual, weigh, restrict_to, prolong_from, apply};
