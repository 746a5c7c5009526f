/// A grid of which only blocks that hold something take memory: where each cell's values stand.
#pragma once

#include "base/ctx.h"

#define LTH_BLOCK_SIDE_3D 8 ///< cells along a block
#define LTH_BLOCK_SIDE_2D 16

/// Cell (i, j, k) is [origin + (i, j, k) h, origin + (i + 1, j + 1, k + 1) h]. The value of a cell stands in its
/// slot: block x (cells of a block) + place in the block, x fastest. In 2D the grid is one cell thick, from
/// z = -1/2 to 1/2 m, so that a volume is an area times 1 m. Immutable once built.
typedef struct LthSparseGrid {
  int dim;          ///< 2 or 3
  int side;         ///< cells along a block; along z too in 3D, else 1
  double origin[3]; ///< low corner of cell (0, 0, 0) [m]
  double h[3];      ///< [m]
  LitheIndex n[3];  ///< cells; n[2] = 1 in 2D
  LitheIndex n_block[3];
  LitheIndex n_blocks; ///< those that are there
  LitheIndex
      *block_at;     ///< of a block's place, x fastest, or -1    (n_block[0] n_block[1] n_block[2])
  LitheIndex *place; ///< block coordinates of a block            (n_blocks x 3)
  LitheIndex *
      neighbor; ///< block at offset (dx, dy, dz) in -1..1, or -1: (dz + 1) 9 + (dy + 1) 3 + dx + 1 in
                ///< 3D, (dy + 1) 3 + dx + 1 in 2D            (n_blocks x n_neighbors)
  int n_neighbors;        ///< 27 or 9
  LitheIndex block_cells; ///< slots of a block
  LitheCount n_slots;     ///< n_blocks block_cells
} LthSparseGrid;

/// `wanted`: which blocks are there, x fastest (n_block[0] n_block[1] n_block[2]), NULL: all. Blocks stand in
/// that order.
LitheStatus lth_sparse_grid_create(LitheCtx *ctx, int dim, const double origin[3],
                                   const double h[3], const LitheIndex n[3], const uint8_t *wanted,
                                   LthSparseGrid **grid);
void lth_sparse_grid_destroy(LitheCtx *ctx, LthSparseGrid **grid);

/// Blocks along an axis of n cells.
static inline LitheIndex lth_sparse_grid_blocks(int dim, int axis, LitheIndex n) {
  int side = dim == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D;
  return dim == 2 && axis == 2 ? 1 : (n + side - 1) / side;
}

/// Slot of a cell, -1 where there is none (also beyond the grid).
LitheCount lth_sparse_grid_slot(const LthSparseGrid *grid, LitheIndex i, LitheIndex j,
                                LitheIndex k);

/// Cell of a slot. Slots of the last blocks may lie beyond n.
void lth_sparse_grid_cell(const LthSparseGrid *grid, LitheCount slot, LitheIndex cell[3]);

/// Slot of the cell at offset d (-1..1 along each axis) from a slot's, or -1.
LitheCount lth_sparse_grid_step(const LthSparseGrid *grid, LitheCount slot, const int d[3]);

/// Place in units of cells behind a cell's low corner: (.5, .5, .5) is its centre, (0, .5, .5) that of its low x face.
static inline void lth_sparse_grid_place(const LthSparseGrid *g, const LitheIndex cell[3],
                                         const double offset[3], double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = g->origin[a] + g->h[a] * (cell[a] + offset[a]);
}

static inline double lth_sparse_grid_cell_volume(const LthSparseGrid *g) {
  return g->h[0] * g->h[1] * g->h[2];
}
