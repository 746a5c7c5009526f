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

static void find_neighbors(LthSparseGrid *g) {
  int deep = g->dim == 3;
  for (LitheIndex b = 0; b < g->n_blocks; b++) {
    const LitheIndex *p = g->place + 3 * (LitheCount)b;
    LitheIndex *to = g->neighbor + (LitheCount)b * g->n_neighbors;
    for (int dz = -deep; dz <= deep; dz++)
      for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
          *to++ = lth_sparse_grid_block(g, p[0] + dx, p[1] + dy, p[2] + dz);
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

// Most steps stay in a block.
LitheCount lth_sparse_grid_step(const LthSparseGrid *g, LitheCount slot, const int d[3]) {
  const int bits = lth_sparse_grid_bits(g), side = 1 << bits, mask = side - 1,
            in_block = g->dim * bits;
  const LitheIndex local = (LitheIndex)(slot & (((LitheCount)1 << in_block) - 1));
  const int x = (local & mask) + d[0], y = (local >> bits & mask) + d[1],
            z = g->dim == 3 ? (local >> (2 * bits)) + d[2] : 0;
  if (g->dim == 2 && d[2] != 0) return -1;
  if (((x | y | z) & ~mask) == 0) return slot + d[0] + d[1] * side + d[2] * side * side;
  const int dx = x < 0 ? -1 : x >= side, dy = y < 0 ? -1 : y >= side, dz = z < 0 ? -1 : z >= side;
  const LitheCount block = slot >> in_block;
  const LitheIndex to =
      g->neighbor[block * g->n_neighbors + g->n_neighbors / 2 + 9 * dz + 3 * dy + dx];
  if (to < 0) return -1;
  return ((LitheCount)to << in_block) + ((((LitheCount)(z & mask) << bits) + (y & mask)) << bits) +
         (x & mask);
}
