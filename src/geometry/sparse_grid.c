/// A grid of which only blocks that hold something take memory.
#include "geometry/sparse_grid.h"

#include <string.h>

static void number_blocks(LthSparseGrid *g, const uint8_t *wanted) {
  LitheCount at = 0;
  for (LitheIndex k = 0; k < g->n_block[2]; k++)
    for (LitheIndex j = 0; j < g->n_block[1]; j++)
      for (LitheIndex i = 0; i < g->n_block[0]; i++, at++) {
        g->block_at[at] = -1;
        if (wanted && !wanted[at]) continue;
        LitheIndex *place = g->place + 3 * (LitheCount)g->n_blocks;
        place[0] = i;
        place[1] = j;
        place[2] = k;
        g->block_at[at] = g->n_blocks++;
      }
}

static LitheIndex block_at(const LthSparseGrid *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  if (i < 0 || j < 0 || k < 0 || i >= g->n_block[0] || j >= g->n_block[1] || k >= g->n_block[2])
    return -1;
  return g->block_at[i + (LitheCount)g->n_block[0] * (j + (LitheCount)g->n_block[1] * k)];
}

static void find_neighbors(LthSparseGrid *g) {
  int deep = g->dim == 3;
  for (LitheIndex b = 0; b < g->n_blocks; b++) {
    const LitheIndex *p = g->place + 3 * (LitheCount)b;
    LitheIndex *to = g->neighbor + (LitheCount)b * g->n_neighbors;
    for (int dz = -deep; dz <= deep; dz++)
      for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) *to++ = block_at(g, p[0] + dx, p[1] + dy, p[2] + dz);
  }
}

static LitheIndex count_wanted(LitheCount n, const uint8_t *wanted) {
  LitheIndex count = 0;
  for (LitheCount i = 0; i < n; i++) count += !wanted || wanted[i];
  return count;
}

static LitheStatus build(LitheCtx *ctx, LthSparseGrid *g, const uint8_t *wanted) {
  LitheCount n = (LitheCount)g->n_block[0] * g->n_block[1] * g->n_block[2];
  LitheIndex n_blocks = count_wanted(n, wanted);
  LTH_NEW(ctx, g->block_at, n);
  LTH_NEW(ctx, g->place, 3 * (LitheCount)n_blocks);
  LTH_NEW(ctx, g->neighbor, (LitheCount)g->n_neighbors * n_blocks);
  number_blocks(g, wanted);
  find_neighbors(g);
  g->n_slots = (LitheCount)g->n_blocks * g->block_cells;
  return LITHE_OK;
}

LitheStatus lth_sparse_grid_create(LitheCtx *ctx, int dim, const double origin[3],
                                   const double h[3], const LitheIndex n[3], const uint8_t *wanted,
                                   LthSparseGrid **grid) {
  LTH_NEW(ctx, *grid, 1);
  LthSparseGrid *g = *grid;
  g->dim = dim;
  g->side = dim == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D;
  g->block_cells = g->side * g->side * (dim == 3 ? g->side : 1);
  g->n_neighbors = dim == 3 ? 27 : 9;
  for (int a = 0; a < 3; a++) {
    bool flat = dim == 2 && a == 2;
    g->origin[a] = flat ? -0.5 : origin[a];
    g->h[a] = flat ? 1 : h[a];
    g->n[a] = flat ? 1 : n[a];
    g->n_block[a] = lth_sparse_grid_blocks(dim, a, g->n[a]);
  }
  LitheStatus status = build(ctx, g, wanted);
  if (status != LITHE_OK) lth_sparse_grid_destroy(ctx, grid);
  return status;
}

void lth_sparse_grid_destroy(LitheCtx *ctx, LthSparseGrid **grid) {
  if (!*grid) return;
  lth_free(ctx, (*grid)->block_at);
  lth_free(ctx, (*grid)->place);
  lth_free(ctx, (*grid)->neighbor);
  lth_free(ctx, *grid);
  *grid = NULL;
}

LitheCount lth_sparse_grid_slot(const LthSparseGrid *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  if (i < 0 || j < 0 || k < 0) return -1;
  int s = g->side, deep = g->dim == 3 ? s : 1;
  LitheIndex block = block_at(g, i / s, j / s, k / deep);
  if (block < 0) return -1;
  return (LitheCount)block * g->block_cells + i % s + s * (j % s + s * (k % deep));
}

void lth_sparse_grid_cell(const LthSparseGrid *g, LitheCount slot, LitheIndex cell[3]) {
  const LitheIndex *place = g->place + 3 * (slot / g->block_cells);
  LitheIndex local = (LitheIndex)(slot % g->block_cells), s = g->side;
  cell[0] = place[0] * s + local % s;
  cell[1] = place[1] * s + local / s % s;
  cell[2] = g->dim == 3 ? place[2] * s + local / (s * s) : 0;
}

LitheCount lth_sparse_grid_step(const LthSparseGrid *g, LitheCount slot, const int d[3]) {
  LitheIndex c[3];
  lth_sparse_grid_cell(g, slot, c);
  return lth_sparse_grid_slot(g, c[0] + d[0], c[1] + d[1], c[2] + d[2]);
}
