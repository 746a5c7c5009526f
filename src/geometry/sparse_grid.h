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

/// log2 of the cells along a block: divisions by a side that compilers do not know took most of the time of output.
static inline int lth_sparse_grid_bits(const LthSparseGrid *g) { return g->dim == 3 ? 3 : 4; }

/// Block at a place among blocks, -1 where there is none.
static inline LitheIndex lth_sparse_grid_block(const LthSparseGrid *g, LitheIndex i, LitheIndex j,
                                               LitheIndex k) {
  if ((i | j | k) < 0 || i >= g->n_block[0] || j >= g->n_block[1] || k >= g->n_block[2]) return -1;
  return g->block_at[i + (LitheCount)g->n_block[0] * (j + (LitheCount)g->n_block[1] * k)];
}

/// Block that holds a cell, -1 where there is none.
static inline LitheIndex lth_sparse_grid_block_of(const LthSparseGrid *g, LitheIndex i,
                                                  LitheIndex j, LitheIndex k) {
  const int bits = lth_sparse_grid_bits(g); // what is below 0 stays so
  return lth_sparse_grid_block(g, i >> bits, j >> bits, g->dim == 3 ? k >> bits : k);
}

/// Slot of a cell, -1 where there is none (also beyond the grid).
static inline LitheCount lth_sparse_grid_slot(const LthSparseGrid *g, LitheIndex i, LitheIndex j,
                                              LitheIndex k) {
  const LitheIndex block = lth_sparse_grid_block_of(g, i, j, k);
  if (block < 0) return -1;
  const int bits = lth_sparse_grid_bits(g), mask = (1 << bits) - 1;
  const LitheIndex layer = g->dim == 3 ? k & mask : 0;
  return (LitheCount)block * g->block_cells + (((layer << bits) + (j & mask)) << bits) + (i & mask);
}

/// Cell of a slot. Slots of the last blocks may lie beyond n.
static inline void lth_sparse_grid_cell(const LthSparseGrid *g, LitheCount slot,
                                        LitheIndex cell[3]) {
  const int bits = lth_sparse_grid_bits(g), mask = (1 << bits) - 1, in_block = g->dim * bits;
  const LitheIndex *place = g->place + 3 * (slot >> in_block);
  const LitheIndex local = (LitheIndex)(slot & (((LitheCount)1 << in_block) - 1));
  cell[0] = (place[0] << bits) + (local & mask);
  cell[1] = (place[1] << bits) + (local >> bits & mask);
  cell[2] = g->dim == 3 ? (place[2] << bits) + (local >> (2 * bits)) : 0;
}

/// Slot of the cell `by` cells further along an axis, or -1.
static inline LitheCount lth_sparse_grid_along(const LthSparseGrid *g, const LitheIndex cell[3],
                                               int axis, LitheIndex by) {
  LitheIndex c[3] = {cell[0], cell[1], cell[2]};
  c[axis] += by;
  return lth_sparse_grid_slot(g, c[0], c[1], c[2]);
}

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
