/// What the solver does with one block, for DIM = 2 or 3: rows in single and double precision, transfers. Compiled once
/// for every instruction set, whose name is ISA.
#include "disc/staggered/staggered_fast.h"

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
ALWAYS void fast_block(const LthFastLevel *L, LitheIndex block, const bool uniform, Block_f *B) {
  enum { SAMPLES = N_SHEAR + 2, STRIDE = SAMPLES * SIDE };
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const float *c = L->constant + 3 * (LitheCount)block, *s = L->sample;
  B->own = find_near_f(L, block);
  B->lambda = same_f(c[0]);
  B->mu = same_f(c[1]);
  B->samples.lambda = s;
  B->samples.mu = s + SIDE;
  B->samples.stride = STRIDE;
  UNROLL
  for (int a = 0; a < DIM; a++) B->step[a] = B->ratio[a] = (float)L->ratio[a];
  UNROLL
  for (int e = 0; e < N_SHEAR; e++)
    B->samples.shear[e] = s + (2 + (DIM == 3 ? (e + 1) % 3 : 0)) * SIDE;
  if (!uniform) find_samples_f(L->level, near, &B->samples);
  find_rows_f(L, near, L->x.at, L->x.stride, false, &B->rows);
  look_ahead_f(L, block, L->x.at, L->x.stride, &B->ahead);
}

/// f += M x in row q of vectors, from place i on.
ALWAYS void fast_inertia(const LthFastLevel *L, LitheIndex block, const bool uniform, LitheIndex q,
                         int i, Lane_f f[DIM]) {
  if (!L->inertia) return;
  const float *x = row_of(L->x, q) + i;
  const float *m =
      uniform ? NULL
              : L->inertia + (L->number[block] + q - L->first[block]) * (LitheCount)WIDTH + i;
  const float same = L->constant[3 * (LitheCount)block + 2];
  UNROLL
  for (int a = 0; a < DIM; a++)
    f[a] += (uniform ? same_f(same) : load_f(m + a * SIDE)) * load_f(x + a * SIDE);
}

#define EACH_PART(real, i) UNROLL_SIDE for (int i = 0; i < SIDE; i += LANES_##real)

/// With row q, fetch what is wanted soon.
ALWAYS void fast_fetch(const LthFastLevel *L, LitheIndex q) {
  fetch_row_f(row_of(L->x, q + 2 * SOON)); // neighbours read it before
  fetch_row_f(row_of(L->y, q + SOON));
  fetch_row_f(row_of(L->b, q + SOON));
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
  const LthFastLevel *L;
  LitheIndex block;
  bool uniform;
  LthFastStep by;
  float same[DIM]; ///< length D^-1, where it is the same in all rows
  Lane_d product;
} Step;

/// y = keep x - old y + length D^-1 (b - f) in row q, from place i on.
ALWAYS void smooth_row(Step *step, const float *stored, LitheIndex q, int i, const Lane_f f[DIM]) {
  const LthFastLevel *L = step->L;
  const float keep = 1 + step->by.momentum, old = step->by.momentum, length = step->by.length;
  const float *x = row_of(L->x, q), *b = row_of(L->b, q);
  float *y = row_of(L->y, q);
  UNROLL
  for (int a = 0; a < DIM; a++) {
    const int at = a * SIDE + i;
    const Lane_f r = load_f(b + at) - f[a];
    Lane_f z =
        keep * load_f(x + at) + (stored ? length * load_f(stored + at) * r : step->same[a] * r);
    if (!step->by.fresh) z -= old * load_f(y + at);
    store_f(y + at, z);
    for (int n = at; step->by.product && n < at + LANES_F; n += LANES_D)
      step->product += widen(b + n) * widen(y + n);
  }
}

/// A step in row q.
ALWAYS void take_step(void *to, int row, LitheIndex q, Lane_f f[][DIM]) {
  Step *step = to;
  const LthFastLevel *L = step->L;
  (void)row;
  fast_fetch(L, q);
  const float *inverse = step->uniform ? NULL : inverse_of(L, step->block, q);
  if (!step->uniform) fetch_row_f(inverse + SOON * WIDTH);
  EACH_PART(F, i) {
    fast_inertia(L, step->block, step->uniform, q, i, f[i / LANES_F]);
    smooth_row(step, inverse, q, i, f[i / LANES_F]);
  }
}

/// A step, row by row; returns b . y, in double precision.
ALWAYS double smooth_rows(const LthFastLevel *L, LitheIndex block, LthFastStep by, const bool fresh,
                          const bool uniform) {
  by.fresh = fresh;
  Block_f B;
  Step step = {.L = L, .block = block, .uniform = uniform, .by = by};
  fast_block(L, block, uniform, &B);
  UNROLL
  for (int a = 0; a < DIM; a++)
    step.same[a] = uniform ? by.length * inverse_diagonal(L, block, a) : 0;
  sweep_f(&B, uniform, take_step, &step);
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

/// What a residual takes, in a block.
typedef struct Rest {
  const LthFastLevel *L;
  LitheIndex block;
  bool uniform;
} Rest;

/// The residual in row q.
ALWAYS void take_rest(void *to, int row, LitheIndex q, Lane_f f[][DIM]) {
  const Rest *rest = to;
  const LthFastLevel *L = rest->L;
  const float *scale = L->scaled[rest->block] >= 0 ? scale_of(L, rest->block, q) : NULL;
  (void)row;
  fast_fetch(L, q);
  EACH_PART(F, i) {
    fast_inertia(L, rest->block, rest->uniform, q, i, f[i / LANES_F]);
    scale_row(L, L->same_scale[rest->block], scale, q, i, f[i / LANES_F]);
  }
}

/// y = scale (b - A x), row by row.
ALWAYS void residual_rows(const LthFastLevel *L, LitheIndex block, const bool uniform) {
  Block_f B;
  Rest rest = {L, block, uniform};
  fast_block(L, block, uniform, &B);
  sweep_f(&B, uniform, take_rest, &rest);
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
ALWAYS void exact_block(const LthFastLevel *L, LitheIndex block, double stiff, const bool uniform,
                        const double *values, Block_d *B) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex *near = L->grid->neighbor + (LitheCount)block * N_NEAR;
  const LitheCount at = lth_fast_constant(L, block);
  B->own = find_near_d(L, block);
  B->lambda = same_d(l->lambda[at]);
  B->mu = same_d(l->mu[at]);
  B->samples.lambda = l->lambda;
  B->samples.mu = l->mu;
  B->samples.stride = SIDE;
  UNROLL
  for (int a = 0; a < DIM; a++) {
    B->ratio[a] = L->ratio[a];
    B->step[a] = stiff * L->ratio[a];
  }
  UNROLL
  for (int e = 0; e < N_SHEAR; e++) B->samples.shear[e] = l->shear[DIM == 3 ? e : 2];
  if (!uniform) find_samples_d(l, near, &B->samples);
  find_rows_d(L, near, values, WIDTH, false, &B->rows);
  look_ahead_d(L, block, values, WIDTH, &B->ahead);
}

typedef int64_t Bits __attribute__((vector_size(REGISTER)));

// Shifts that bring the lowest bits of bytes to the top of a word.
#if LANES_D == 8
#define TO_TOP 63, 55, 47, 39, 31, 23, 15, 7
#elif LANES_D == 4
#define TO_TOP 63, 55, 47, 39
#else
#define TO_TOP 63, 55
#endif

/// v, from place i of a row on, where unknowns are free, or (`held`) not dead, else 0; `states`: of the row. The lowest bit of a
/// state says that it is free, the next one that it is held.
ALWAYS Lane_d where_counted(Lane_d v, const uint8_t *states, int i, const bool held) {
  int64_t s;
  memcpy(&s, states + i / 8 * 8, 8);
  if (held) s |= s >> 1;
  const Bits lowest = ((Bits){0} + s) << ((Bits){TO_TOP} - i % 8 * 8);
  return (Lane_d)((Bits)v & (lowest < 0));
}

/// What an application takes, in a block.
typedef struct Product {
  const LthFastLevel *L;
  LitheIndex block;
  bool uniform, held;
  double inert;
  const double *values;
  double *result;
  Lane_d product;
} Product;

/// f += m M p, and zero where an unknown does not count (all do in uniform blocks), in a row of slots.
ALWAYS void finish_row(const Product *P, LitheCount row, int i, const double *p, Lane_d f[DIM]) {
  const LthStaggeredLevel *l = P->L->level;
  UNROLL
  for (int a = 0; a < DIM; a++) {
    if (P->inert != 0)
      f[a] += P->inert * load_d(l->mass[a] + l->row[row] * (LitheCount)SIDE + i) *
              load_d(p + a * SIDE + i);
    if (!P->uniform) f[a] = where_counted(f[a], l->state[a] + row * SIDE, i, P->held);
  }
}

/// The same where a row p of a vector gives one of another.
ALWAYS void exact_fetch(const double *p, const double *to) {
  fetch_row_d(p + 2 * SOON * WIDTH); // neighbours read it before
  fetch_row_d(to + SOON * WIDTH);
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

/// A p in row q.
ALWAYS void take_product(void *to, int row, LitheIndex q, Lane_d f[][DIM]) {
  Product *P = to;
  const double *p = P->values + q * (LitheCount)WIDTH;
  double *out = P->result + q * (LitheCount)WIDTH;
  exact_fetch(p, out);
  EACH_PART(D, i) {
    finish_row(P, P->block * (LitheCount)BLOCK_ROWS + row, i, p, f[i / LANES_D]);
    P->product += exact_store(p + i, f[i / LANES_D], out + i);
  }
}

/// q = A p in a block, row by row; returns p . q.
ALWAYS double apply_rows(const LthFastLevel *L, LitheIndex block, double stiff, double inert,
                         const bool held, const bool uniform, const double *values,
                         double *result) {
  Block_d B;
  Product P = {L, block, uniform, held, inert, values, result, {0}};
  exact_block(L, block, stiff, uniform, values, &B);
  sweep_d(&B, uniform, take_product, &P);
  return sum_lanes(P.product);
}

static double apply(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                    const double *values, double *result) {
  const double volume = lth_sparse_grid_cell_volume(L->grid);
  const double stiff = ck * volume / (L->grid->h[0] * L->grid->h[0]), inert = cm * volume;
  if (L->kind[block] == LTH_BLOCK_UNIFORM)
    return apply_rows(L, block, stiff, inert, false, true, values, result);
  if (held) return apply_rows(L, block, stiff, inert, true, false, values, result);
  return apply_rows(L, block, stiff, inert, false, false, values, result);
}

#include "disc/staggered/staggered_transfers.h"

extern const LthFastKernels JOIN(lth_fast_kernels, JOIN(SUFFIX, ISA));
const LthFastKernels JOIN(lth_fast_kernels, JOIN(SUFFIX, ISA)) = {
    smooth, start, residual, weigh, restrict_to, prolong_from, apply};
