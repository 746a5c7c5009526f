/// Rigid clusters in the cycle: coefficients, and the correction that they make.
#include "disc/staggered/staggered_clusters.h"

#include <string.h>

#define CYCLES 3 // of the algebraic levels in one correction
#define LEAST_ROWS                                                                                 \
  8               // clusters of an aggregate on the mean: of fewer the levels of a shell grow dense
#define LEAST 0.1 // eigenvalue of a cycle that they are made for

/// Factor, or make the levels. These are made anew for other coefficients: what an update would need is as much memory as they.
static LitheStatus refill(LitheCtx *ctx, LthStaggeredClusters *C) {
  if (C->factor) return C->engine->factorize(ctx, C->factor, C->A);
  const LthMultilevelDef def = {.A = C->A, .near = C->near, .once = true, .least_rows = LEAST_ROWS};
  lth_multilevel_destroy(ctx, &C->levels);
  return lth_multilevel_create(ctx, &def, &C->levels);
}

/// A little stiffer than the body: for motions without energy.
static void stiffen(LthBlockMatrix *A) {
  for (LitheIndex k = 0; k < A->n_rows; k++) {
    LitheCount m = A->row_off[k + 1] - A->row_off[k];
    double *D = A->values + A->value_off[A->diagonal[k]];
    for (LitheCount i = 0; i < m; i++) D[i * m + i] *= 1 + 1e-3;
  }
}

LitheStatus lth_staggered_clusters_set(LitheCtx *ctx, LthStaggeredClusters *C, double cm, double ck,
                                       double unit) {
  lth_staggered_clusters_fill(C, C->threads, cm, ck, unit);
  LitheStatus status = refill(ctx, C);
  if (status == LITHE_NOT_CONVERGED) {
    stiffen(C->A);
    status = refill(ctx, C);
  }
  return status;
}

static void place_of(const LthSparseGrid *g, LitheIndex block, LitheCount at, double x[3]) {
  const LitheCount slot = (LitheCount)block * g->block_cells + at % g->block_cells;
  lth_cluster_place(g, (int)(at / g->block_cells), slot, x);
}

static float *value_of(const LthFastLevel *L, LthFastVector v, LitheIndex block, LitheCount at) {
  const LitheIndex n = L->grid->block_cells;
  return lth_fast_value(L, v, (LitheCount)block * n + at % n, (int)(at / n));
}

/// Forces on the clusters of a block: b = T^T sum of b_i y_i.
static void gather(LthStaggeredClusters *C, LitheIndex block) {
  const LthFastLevel *L = C->level;
  const LitheCount n = L->grid->dim * L->grid->block_cells;
  for (LitheIndex k = C->first[block]; k < C->first[block + 1]; k++)
    memset(C->motion + 6 * (LitheCount)k, 0, 6 * sizeof *C->motion);
  for (LitheCount at = 0; at < n; at++) {
    LitheIndex k = lth_cluster_at(C, block, at);
    if (k < 0) continue;
    double x[3], value[3], *force = C->motion + 6 * (LitheCount)k;
    int index[3];
    const double y = *value_of(L, L->y, block, at);
    place_of(L->grid, block, at, x);
    lth_cluster_row(L->grid->h[0], (int)(at / L->grid->block_cells), x,
                    C->centre + 3 * (LitheCount)k, index, value);
    for (int i = 0; i < 3; i++) force[index[i]] += value[i] * y;
  }
  for (LitheIndex k = C->first[block]; k < C->first[block + 1]; k++) {
    const double *T = C->T + 36 * (LitheCount)k, *force = C->motion + 6 * (LitheCount)k;
    for (LitheCount r = C->A->row_off[k]; r < C->A->row_off[k + 1]; r++) {
      C->b[r] = 0;
      for (int i = 0; i < 6; i++) C->b[r] += T[6 * i + (r - C->A->row_off[k])] * force[i];
    }
  }
}

/// x += b_i . T x_cluster
static void scatter(LthStaggeredClusters *C, LitheIndex block) {
  const LthFastLevel *L = C->level;
  const LitheCount n = L->grid->dim * L->grid->block_cells;
  for (LitheIndex k = C->first[block]; k < C->first[block + 1]; k++) {
    const double *T = C->T + 36 * (LitheCount)k;
    double *motion = C->motion + 6 * (LitheCount)k;
    const LitheCount first = C->A->row_off[k], rank = C->A->row_off[k + 1] - first;
    for (int i = 0; i < 6; i++) {
      motion[i] = 0;
      for (LitheCount r = 0; r < rank; r++) motion[i] += T[6 * i + r] * C->x[first + r];
    }
  }
  for (LitheCount at = 0; at < n; at++) {
    LitheIndex k = lth_cluster_at(C, block, at);
    if (k < 0) continue;
    double x[3], value[3], sum = 0;
    const double *motion = C->motion + 6 * (LitheCount)k;
    int index[3];
    place_of(L->grid, block, at, x);
    lth_cluster_row(L->grid->h[0], (int)(at / L->grid->block_cells), x,
                    C->centre + 3 * (LitheCount)k, index, value);
    for (int i = 0; i < 3; i++) sum += value[i] * motion[index[i]];
    *value_of(L, L->x, block, at) += (float)sum;
  }
}

/// x of A x = b: Chebyshev's iteration on the algebraic cycle, whose eigenvalues are at most 1. A fixed symmetric operator.
static void iterate(LthStaggeredClusters *C, int threads) {
  const LthOperator M = lth_multilevel_operator(C->levels);
  const double half = 0.5 * (1 - LEAST), middle = 0.5 * (1 + LEAST), sigma = middle / half;
  double rho = 1 / sigma;
  M.apply(M.self, threads, C->b, C->z);
  for (LitheCount i = 0; i < C->A->n; i++) C->x[i] = C->p[i] = C->z[i] / middle;
  for (int cycle = 1; cycle < CYCLES; cycle++) {
    lth_block_matrix_apply(C->A, threads, C->x, C->r);
    const double next = 1 / (2 * sigma - rho), keep = rho * next, step = 2 * next / half;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheCount i = 0; i < C->A->n; i++) C->r[i] = C->b[i] - C->r[i];
    M.apply(M.self, threads, C->r, C->z);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheCount i = 0; i < C->A->n; i++) {
      C->p[i] = keep * C->p[i] + step * C->z[i];
      C->x[i] += C->p[i];
    }
    rho = next;
  }
}

static LitheStatus solve(LitheCtx *ctx, LthStaggeredClusters *C) {
  if (C->factor) return C->engine->solve(ctx, C->factor, C->b, C->x);
  iterate(C, lth_block_matrix_is_large(C->A) ? lth_threads(ctx) : 1);
  return LITHE_OK;
}

LitheStatus lth_staggered_clusters_correct(LitheCtx *ctx, LthStaggeredClusters *C) {
  const LthFastLevel *L = C->level;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < L->n_active; i++) gather(C, L->active[i]);
  LITHE_TRY(solve(ctx, C));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < L->n_active; i++) scatter(C, L->active[i]);
  return LITHE_OK;
}

LitheCount lth_staggered_clusters_bytes(const LthStaggeredClusters *C) {
  const LthSparseGrid *g = C->level->grid;
  const LthBlockMatrix *A = C->A;
  LitheCount blocks = A->block_off[A->n_rows];
  LitheCount bytes = 4 * (LitheCount)g->n_blocks;
  bytes += 2 * (LitheCount)C->level->n_rows * lth_fast_width(C->level);
  bytes += (LitheCount)C->n * 8 * (3 + 36 + 36 + 6 + 3) + 40 * A->n;
  bytes += 8 * A->value_off[blocks] + 12 * blocks + C->threads * C->most * 36 * 8;
  return bytes + (C->levels ? lth_multilevel_bytes(C->levels) : 0);
}
