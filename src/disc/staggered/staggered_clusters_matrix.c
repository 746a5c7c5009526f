/// Galerkin matrix of rigid clusters, row by row of the level's operator, which is not stored.
#include "disc/staggered/staggered_clusters.h"
#include "disc/staggered/staggered_entries.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#define SEEN 1024 // pairs of clusters met lately

/// Pairs (cluster in its block, other cluster) of one block; twice the same now and then.
typedef struct Pairs {
  uint64_t seen[SEEN];
  uint64_t *pair;
  LitheCount n, capacity;
} Pairs;

static int compare(const void *a, const void *b) {
  uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return x < y ? -1 : x > y;
}

/// Room for all entries of a block's rows.
static LitheCount most_pairs(const LthSparseGrid *g) {
  return (LitheCount)g->dim * g->block_cells * (LTH_STAGGERED_ROW + 1);
}

static void note(Pairs *P, LitheIndex local, LitheIndex other) {
  uint64_t pair = (uint64_t)local << 32 | (uint32_t)other;
  uint64_t *seen = &P->seen[(pair * 0x9E3779B97F4A7C15u) >> 54];
  if (*seen == pair) return;
  *seen = pair;
  P->pair[P->n++] = pair;
}

/// Sorted, each once.
static void find_pairs(const LthStaggeredClusters *C, LitheIndex block, Pairs *P) {
  const LthSparseGrid *g = C->level->grid;
  const LitheIndex n = g->block_cells;
  P->n = 0;
  memset(P->seen, 0xff, sizeof P->seen);
  for (LitheIndex at = 0; at < g->dim * n; at++) {
    LitheIndex k = lth_cluster_at(C, block, at);
    if (k < 0) continue;
    LthStaggeredEntry entry[LTH_STAGGERED_ROW];
    int count =
        lth_staggered_row(C->level->level, 1, 1, at / n, (LitheCount)block * n + at % n, entry);
    for (int e = 0; e < count; e++) {
      LitheIndex to = lth_cluster_at(C, (LitheIndex)(entry[e].slot / n),
                                     (LitheCount)entry[e].b * n + entry[e].slot % n);
      if (to >= 0) note(P, k - C->first[block], to);
    }
  }
  qsort(P->pair, (size_t)P->n, sizeof *P->pair, compare);
  LitheCount kept = 0;
  for (LitheCount i = 0; i < P->n; i++)
    if (i == 0 || P->pair[i] != P->pair[i - 1]) P->pair[kept++] = P->pair[i];
  P->n = kept;
}

/// Count the blocks of every row (off[k + 1]), or list their columns.
static void walk(LthStaggeredClusters *C, Pairs *scratch, LitheCount *off, LitheIndex *col) {
#pragma omp parallel for schedule(static) num_threads(C->threads)
  for (LitheIndex b = 0; b < C->level->grid->n_blocks; b++) {
    if (C->first[b] == C->first[b + 1]) continue;
    Pairs *P = &scratch[omp_get_thread_num()];
    find_pairs(C, b, P);
    for (LitheCount i = 0; i < P->n; i++) {
      LitheIndex row = C->first[b] + (LitheIndex)(P->pair[i] >> 32);
      if (col)
        col[off[C->first[b]] + i] = (LitheIndex)(P->pair[i] & 0xffffffff);
      else
        off[row + 1]++;
    }
  }
}

static LitheStatus make_matrix(LitheCtx *ctx, LthStaggeredClusters *C, const int *rank,
                               Pairs *scratch) {
  LitheStatus status = LITHE_OK;
  LitheCount *row_off = NULL, *block_off = NULL;
  LitheIndex *col = NULL;
  LTH_NEW_OR(done, ctx, row_off, (LitheCount)C->n + 1);
  LTH_NEW_OR(done, ctx, block_off, (LitheCount)C->n + 1);
  walk(C, scratch, block_off, NULL);
  for (LitheIndex k = 0; k < C->n; k++) {
    row_off[k + 1] = row_off[k] + rank[k];
    block_off[k + 1] += block_off[k];
  }
  LTH_NEW_OR(done, ctx, col, block_off[C->n]);
  walk(C, scratch, block_off, col);
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, C->n, row_off, block_off, col, &C->A));
done:
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  lth_free(ctx, col);
  return status;
}

LitheStatus lth_staggered_clusters_pattern(LitheCtx *ctx, LthStaggeredClusters *C,
                                           const int *rank) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = C->level->grid;
  Pairs *scratch = NULL;
  LTH_NEW(ctx, scratch, C->threads);
  for (int t = 0; t < C->threads; t++) LTH_NEW_OR(done, ctx, scratch[t].pair, most_pairs(g));
  LITHE_TRY_OR(done, make_matrix(ctx, C, rank, scratch));
  for (LitheIndex b = 0; b < g->n_blocks; b++) {
    LitheCount blocks = C->A->block_off[C->first[b + 1]] - C->A->block_off[C->first[b]];
    if (blocks > C->most) C->most = blocks;
  }
  LTH_NEW_OR(done, ctx, C->scratch, C->threads * C->most * 36);
done:
  for (int t = 0; t < C->threads; t++) lth_free(ctx, scratch[t].pair);
  lth_free(ctx, scratch);
  return status;
}

/// X += value b_i b_j^T for one row of the operator and all its entries.
static void add_row(const LthStaggeredClusters *C, const LthStaggeredEntry *entry, int count,
                    double unit, LitheIndex row, double *X) {
  const LthSparseGrid *g = C->level->grid;
  const LitheIndex n = g->block_cells;
  double x[3], own[3], other[3];
  int here[3], there[3];
  lth_cluster_place(g, entry[0].b, entry[0].slot, x);
  lth_cluster_row(g->h[0], entry[0].b, x, C->centre + 3 * (LitheCount)row, here, own);
  for (int e = 0; e < count; e++) {
    LitheIndex to = lth_cluster_at(C, (LitheIndex)(entry[e].slot / n),
                                   (LitheCount)entry[e].b * n + entry[e].slot % n);
    if (to < 0) continue;
    lth_cluster_place(g, entry[e].b, entry[e].slot, x);
    lth_cluster_row(g->h[0], entry[e].b, x, C->centre + 3 * (LitheCount)to, there, other);
    double *B = X + 36 * lth_block_matrix_find(C->A, row, to), value = entry[e].value / unit;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) B[6 * here[i] + there[j]] += value * own[i] * other[j];
  }
}

/// T_row^T X T_col into block e.
static void store(LthStaggeredClusters *C, LitheIndex row, LitheCount e, const double X[36]) {
  const LitheIndex col = C->A->block_col[e];
  const int m = (int)(C->A->row_off[row + 1] - C->A->row_off[row]),
            n = (int)(C->A->row_off[col + 1] - C->A->row_off[col]);
  const double *Tr = C->T + 36 * (LitheCount)row, *Tc = C->T + 36 * (LitheCount)col;
  double half[36], *out = C->A->values + C->A->value_off[e];
  for (int i = 0; i < 6; i++)
    for (int c = 0; c < n; c++) {
      half[6 * i + c] = 0;
      for (int k = 0; k < 6; k++) half[6 * i + c] += X[6 * i + k] * Tc[6 * k + c];
    }
  for (int r = 0; r < m; r++)
    for (int c = 0; c < n; c++) {
      double sum = 0;
      for (int k = 0; k < 6; k++) sum += Tr[6 * k + r] * half[6 * k + c];
      out[r * n + c] = sum;
    }
}

void lth_staggered_clusters_fill(LthStaggeredClusters *C, int threads, double cm, double ck,
                                 double unit) {
  const LthSparseGrid *g = C->level->grid;
  const LitheIndex n = g->block_cells;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex b = 0; b < g->n_blocks; b++) {
    const LitheCount from = C->A->block_off[C->first[b]], to = C->A->block_off[C->first[b + 1]];
    double *X = C->scratch + omp_get_thread_num() * C->most * 36;
    memset(X, 0, sizeof *X * (size_t)(36 * (to - from)));
    for (LitheIndex at = 0; at < g->dim * n; at++) {
      LitheIndex k = lth_cluster_at(C, b, at);
      if (k < 0) continue;
      LthStaggeredEntry entry[LTH_STAGGERED_ROW];
      int count =
          lth_staggered_row(C->level->level, cm, ck, at / n, (LitheCount)b * n + at % n, entry);
      add_row(C, entry, count, unit, k, X - 36 * from);
    }
    for (LitheIndex k = C->first[b]; k < C->first[b + 1]; k++)
      for (LitheCount e = C->A->block_off[k]; e < C->A->block_off[k + 1]; e++)
        store(C, k, e, X + 36 * (e - from));
  }
}
