/// A level of the fast kernels: its coefficients in single precision, and scales of its interpolation.
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_walls.h"

#include <float.h>
#include <math.h>
#include <string.h>

/// Largest eigenvalue that one cell's or edge's share of the operator may have against its share of the diagonal:
/// four faces around an edge give 4, two dim faces around a cell (8 mu + 4 dim lambda) / (4 mu + 2 lambda).
static double stiffest_of(const LthStaggeredLevel *l) {
  double ratio = 0, d = l->grid->dim;
  for (LitheCount s = 0; s < (LitheCount)l->n_rows * l->grid->side; s++)
    if (l->mu[s] > 0 && l->lambda[s] > ratio * l->mu[s]) ratio = l->lambda[s] / l->mu[s];
  return fmax(4, (8 + 4 * d * ratio) / (4 + 2 * ratio));
}

LitheStatus lth_fast_level_analyse(LitheCtx *ctx, const LthStaggeredLevel *level, LthFastLevel *L) {
  *L = (LthFastLevel){.level = level, .grid = level->grid};
  L->kernels = lth_fast_kernels_for(L->grid->dim, lth_isa());
  for (int a = 0; a < 3; a++) L->ratio[a] = level->grid->h[0] / level->grid->h[a];
  L->stiffest = stiffest_of(level);
  LitheStatus status = lth_fast_level_sort(ctx, L);
  if (status != LITHE_OK) lth_fast_level_free(ctx, L);
  return status;
}

LitheStatus lth_fast_level_reserve(LitheCtx *ctx, LthFastLevel *L, bool with_mass) {
  const LitheCount width = lth_fast_width(L), side = L->grid->side;
  if (!L->constant) LTH_NEW(ctx, L->constant, 3 * (LitheCount)L->grid->n_blocks);
  if (!L->sample)
    LTH_NEW(ctx, L->sample, ((LitheCount)L->level->n_rows + 1) * lth_fast_samples(L) * side);
  if (!L->inverse) LTH_NEW(ctx, L->inverse, L->n_general * width);
  if (!L->inertia && with_mass) LTH_NEW(ctx, L->inertia, L->n_general * width);
  return LITHE_OK;
}

void lth_fast_level_free(LitheCtx *ctx, LthFastLevel *L) {
  lth_free(ctx, L->active);
  lth_free(ctx, L->kind);
  lth_free(ctx, L->row);
  lth_free(ctx, L->alive);
  lth_free(ctx, L->first);
  lth_free(ctx, L->local);
  lth_free(ctx, L->number);
  lth_free(ctx, L->constant);
  lth_free(ctx, L->sample);
  lth_free(ctx, L->inertia);
  lth_free(ctx, L->inverse);
  lth_free(ctx, L->scaled);
  lth_free(ctx, L->same_scale);
  lth_free(ctx, L->scale);
  lth_free(ctx, L->pull);
  *L = (LthFastLevel){0};
}

static void set_samples(LitheCtx *ctx, LthFastLevel *L) {
  const LthStaggeredLevel *l = L->level;
  const double *from[5] = {l->lambda, l->mu, l->shear[2], l->shear[0], l->shear[1]};
  const int n = lth_fast_samples(L), side = L->grid->side;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex r = 0; r < l->n_rows; r++)
    for (int v = 0; v < n; v++)
      for (int i = 0; i < side; i++)
        L->sample[((LitheCount)r * n + v) * side + i] =
            (float)(L->stiff * from[v][(LitheCount)r * side + i]);
}

/// Diagonal entry over stiff.
static double diagonal_of(const LthFastLevel *L, int a, LitheCount s, const LitheIndex cell[3]) {
  const LthStaggeredLevel *l = L->level;
  const LitheCount at = lth_level_at(l, s), before = lth_sparse_grid_along(L->grid, cell, a, -1);
  double d = L->ratio[a] * L->ratio[a] *
             (2 * l->mu[at] + l->lambda[at] + 2 * lth_level_value(l, l->mu, before) +
              lth_level_value(l, l->lambda, before));
  for (int b = 0; b < L->grid->dim; b++) {
    if (b == a) continue;
    const double *shear = l->shear[3 - a - b];
    LitheCount after = lth_sparse_grid_along(L->grid, cell, b, 1);
    d += L->ratio[b] * L->ratio[b] * (shear[at] + lth_level_value(l, shear, after));
  }
  return d;
}

static void set_inverse(LthFastLevel *L, LitheIndex block) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex width = lth_fast_width(L), side = L->grid->side;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const LitheCount from = (L->number[block] + q - L->first[block]) * (LitheCount)width;
    for (LitheIndex i = 0; i < width; i++) {
      LitheCount s = lth_fast_slot(L, block, q) + i % side;
      LitheIndex cell[3], a = i / side;
      lth_sparse_grid_cell(L->grid, s, cell);
      bool alive = l->state[a][s] == LTH_UNKNOWN_FREE;
      double m = L->inert * l->mass[a][lth_level_at(l, s)];
      L->inverse[from + i] = alive ? (float)(1 / (L->stiff * diagonal_of(L, a, s, cell) + m)) : 0;
      if (L->inertia) L->inertia[from + i] = alive ? (float)m : 0;
    }
  }
}

/// Least share of inertia in the diagonal entries of a block's free unknowns.
static double inertia_share(const LthFastLevel *L, LitheIndex block) {
  const float *c = L->constant + 3 * (LitheCount)block;
  double least = 1;
  if (L->kind[block] == LTH_BLOCK_UNIFORM) {
    double sides = 0, wide = 0;
    for (int a = 0; a < L->grid->dim; a++) {
      sides += L->ratio[a] * L->ratio[a];
      wide = fmax(wide, L->ratio[a] * L->ratio[a]);
    }
    return c[2] / (c[2] + 2 * (c[1] * sides + (c[1] + c[0]) * wide));
  }
  const LitheCount width = lth_fast_width(L), first = L->number[block] * width;
  const LitheCount n = (L->first[block + 1] - L->first[block]) * width;
  for (LitheCount i = first; i < first + n; i++)
    if (L->inverse[i] > 0) least = fmin(least, (double)L->inertia[i] * L->inverse[i]);
  return least;
}

/// Inertia is diagonal: its share of the diagonal has the eigenvalue 1.
static double greatest_of(LitheCtx *ctx, const LthFastLevel *L) {
  double share = 1;
  if (L->inert == 0) return L->stiffest;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(min : share)
  for (LitheIndex i = 0; i < L->n_active; i++) share = fmin(share, inertia_share(L, L->active[i]));
  return L->stiffest - (L->stiffest - 1) * share;
}

void lth_fast_level_set(LitheCtx *ctx, LthFastLevel *L, double cm, double ck, double unit) {
  const LthStaggeredLevel *l = L->level;
  double volume = lth_sparse_grid_cell_volume(L->grid);
  L->stiff = volume * ck / (L->grid->h[0] * L->grid->h[0] * unit);
  L->inert = volume * cm / unit;
  set_samples(ctx, L);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < L->n_active; i++) {
    LitheIndex b = L->active[i];
    const LitheCount first = lth_fast_constant(L, b);
    float *c = L->constant + 3 * (LitheCount)b;
    c[0] = (float)(L->stiff * l->lambda[first]);
    c[1] = (float)(L->stiff * l->mu[first]);
    c[2] = (float)(L->inert * l->mass[0][first]);
    if (L->kind[b] == LTH_BLOCK_GENERAL) set_inverse(L, b);
  }
  L->greatest = greatest_of(ctx, L);
}

/// Weights in x.
static void write_pull(LitheCtx *ctx, LthFastLevel *L, double unit) {
  const LitheIndex width = lth_fast_width(L), side = L->grid->side;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < L->grid->n_blocks; b++)
    for (LitheIndex q = L->first[b]; q < L->first[b + 1]; q++)
      for (LitheIndex i = 0; i < width; i++)
        L->x.at[q * L->x.stride + i] =
            (float)lth_staggered_pull(L->level, unit, i / side, lth_fast_slot(L, b, q) + i % side);
}

/// Keep the weights in x of a coarse level.
static LitheStatus keep_pull(LitheCtx *ctx, LthFastLevel *L) {
  const LitheCount width = lth_fast_width(L);
  LTH_NEW(ctx, L->pull, L->n_rows * width);
  for (LitheIndex q = 1; q < L->n_rows; q++)
    memcpy(L->pull + q * width, L->x.at + q * L->x.stride, sizeof(float) * (size_t)width);
  return LITHE_OK;
}

static bool is_free(const LthFastLevel *L, LitheIndex block, LitheIndex q, LitheIndex i) {
  const LitheIndex side = L->grid->side;
  return L->level->state[i / side][lth_fast_slot(L, block, q) + i % side] == LTH_UNKNOWN_FREE;
}

/// Mark the fine blocks in which some unknown may be interpolated from a held coarse one.
static void mark_walls(const LthFastLevel *L, const LthFastLevel *coarse, uint8_t *near) {
  const LthStaggeredWalls *w = coarse->level->walls;
  const LthSparseGrid *g = L->grid;
  const int bits = lth_sparse_grid_bits(g), deep = g->dim == 3;
  for (LitheIndex i = 0; w && i < w->first[coarse->grid->n_blocks]; i++) {
    LitheIndex c[3], low[3], high[3];
    lth_sparse_grid_cell(coarse->grid, w->at[i].slot, c);
    for (int a = 0; a < 3; a++) {
      low[a] = (2 * c[a] - 4 < 0 ? 0 : 2 * c[a] - 4) >> bits;
      high[a] = (2 * c[a] + 4) >> bits;
      if (high[a] >= g->n_block[a]) high[a] = g->n_block[a] - 1;
    }
    for (LitheIndex z = deep ? low[2] : 0; z <= (deep ? high[2] : 0); z++)
      for (LitheIndex y = low[1]; y <= high[1]; y++)
        for (LitheIndex x = low[0]; x <= high[0]; x++) {
          const LitheIndex b = lth_sparse_grid_block(g, x, y, z);
          if (b >= 0) near[b] = 1;
        }
  }
}

/// Beside walls: the inverse of what interpolation is to multiply by, in the place of sums of weights.
static void set_wall_sums(const LthFastLevel *L, const LthFastLevel *coarse, double unit,
                          LitheIndex block) {
  const LitheIndex side = L->grid->side;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++)
    for (LitheIndex i = 0; i < lth_fast_width(L); i++) {
      if (!is_free(L, block, q, i)) continue;
      LitheIndex cell[3];
      lth_sparse_grid_cell(L->grid, lth_fast_slot(L, block, q) + i % side, cell);
      const double scale = lth_staggered_wall_scale(coarse->level, L->level, unit, i / side, cell);
      if (scale > 0) L->x.at[q * L->x.stride + i] = (float)(1 / scale);
    }
}

/// Inverse of the sums of weights in x where they are the same for all unknowns, and these free; else 0. Sums of equal
/// weights differ by rounding, which single precision does not tell from what it does itself.
static float same_scale(const LthFastLevel *L, LitheIndex block) {
  const float *first = L->x.at + L->first[block] * L->x.stride;
  if (!(first[0] > 0)) return 0;
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *sum = L->x.at + q * L->x.stride;
    for (LitheIndex i = 0; i < lth_fast_width(L); i++)
      if (fabsf(sum[i] - first[0]) > 4 * FLT_EPSILON * first[0] || !is_free(L, block, q, i))
        return 0;
  }
  return 1 / first[0];
}

static void set_scale(LthFastLevel *L, LitheIndex block) {
  const LitheIndex width = lth_fast_width(L);
  for (LitheIndex q = L->first[block]; q < L->first[block + 1]; q++) {
    const float *sum = L->x.at + q * L->x.stride;
    float *scale = L->scale + (L->scaled[block] + q - L->first[block]) * (LitheCount)width;
    for (LitheIndex i = 0; i < width; i++)
      scale[i] = is_free(L, block, q, i) && sum[i] > 0 ? 1 / sum[i] : 0;
  }
}

LitheStatus lth_fast_level_link(LitheCtx *ctx, LthFastLevel *L, LthFastLevel *coarse) {
  const LthFastKernels *k = L->kernels;
  double unit = lth_staggered_modulus_unit(coarse->level);
  uint8_t *near = NULL;
  LTH_NEW(ctx, near, L->grid->n_blocks);
  mark_walls(L, coarse, near);
  write_pull(ctx, coarse, unit);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < coarse->grid->n_blocks; b++) k->prolong_from(L, coarse, b, false);
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < L->grid->n_blocks; b++)
    if (near[b]) set_wall_sums(L, coarse, unit, b);
  lth_free(ctx, near);
  for (LitheIndex i = 0; i < L->n_active; i++) {
    LitheIndex b = L->active[i];
    float same = same_scale(L, b);
    L->scaled[b] = same > 0 ? -1 : L->n_scaled;
    L->n_scaled += same > 0 ? 0 : L->first[b + 1] - L->first[b];
    L->same_scale[b] = same > 0 ? same : 1;
  }
  if (unit > 0) LITHE_TRY(keep_pull(ctx, coarse));
  LTH_NEW(ctx, L->scale, (LitheCount)L->n_scaled * lth_fast_width(L));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < L->n_active; i++)
    if (L->scaled[L->active[i]] >= 0) set_scale(L, L->active[i]);
  return LITHE_OK;
}

void lth_fast_level_unlink(LitheCtx *ctx, LthFastLevel *L) {
  lth_free(ctx, L->scale);
  L->scale = NULL;
  L->n_scaled = 0;
  for (LitheIndex b = 0; b < L->grid->n_blocks; b++) {
    L->scaled[b] = -1;
    L->same_scale[b] = 1;
  }
}

/// All zero, as before a solve.
void lth_fast_level_clear(LitheCtx *ctx, LthFastLevel *L) {
  const size_t bytes = sizeof(float) * (size_t)lth_fast_width(L);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex q = 0; q < L->n_rows; q++) {
    memset(L->x.at + q * L->x.stride, 0, bytes);
    memset(L->y.at + q * L->y.stride, 0, bytes);
    memset(L->b.at + q * L->b.stride, 0, bytes);
  }
}

LitheCount lth_fast_level_bytes(const LthFastLevel *L) {
  const LthSparseGrid *g = L->grid;
  LitheCount n = g->n_blocks, rows = L->n_general * (L->inertia ? 2 : 1) + L->n_scaled;
  LitheCount samples = L->sample ? (LitheCount)lth_fast_samples(L) * g->side : 0;
  rows += L->pull ? L->n_rows : 0;
  return 4 * (3 * n + rows * lth_fast_width(L) + (L->level->n_rows + 1) * samples) +
         4 * g->n_slots / g->side + 37 * n + L->n_rows + 4 * (LitheCount)L->n_active;
}
