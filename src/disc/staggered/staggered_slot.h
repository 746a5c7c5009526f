/// Slots of neighbours by cell coordinates, without divisions: for loops over a whole level.
#pragma once

#include "geometry/sparse_grid.h"

/// log2 of the cells along a block.
static inline int lth_side_bits(const LthSparseGrid *g) { return g->dim == 3 ? 3 : 4; }

/// Block at a place among blocks, -1 where there is none.
static inline LitheIndex lth_block_at(const LthSparseGrid *g, LitheIndex i, LitheIndex j,
                                      LitheIndex k) {
  if ((i | j | k) < 0 || i >= g->n_block[0] || j >= g->n_block[1] || k >= g->n_block[2]) return -1;
  return g->block_at[i + (LitheCount)g->n_block[0] * (j + (LitheCount)g->n_block[1] * k)];
}

/// Block that holds a cell, -1 where there is none.
static inline LitheIndex lth_block_of(const LthSparseGrid *g, LitheIndex i, LitheIndex j,
                                      LitheIndex k) {
  const int bits = lth_side_bits(g); // what is below 0 stays so
  return lth_block_at(g, i >> bits, j >> bits, g->dim == 3 ? k >> bits : k);
}

/// As lth_sparse_grid_slot().
static inline LitheCount lth_slot_of(const LthSparseGrid *g, LitheIndex i, LitheIndex j,
                                     LitheIndex k) {
  LitheIndex block = lth_block_of(g, i, j, k);
  if (block < 0) return -1;
  int bits = lth_side_bits(g), mask = (1 << bits) - 1;
  LitheIndex deep = g->dim == 3 ? k & mask : 0;
  return (LitheCount)block * g->block_cells + (i & mask) +
         ((((LitheCount)deep << bits) + (j & mask)) << bits);
}

/// As lth_sparse_grid_cell().
static inline void lth_cell_of(const LthSparseGrid *g, LitheCount slot, LitheIndex cell[3]) {
  const LitheIndex *place = g->place + 3 * (slot / g->block_cells);
  int bits = lth_side_bits(g), mask = (1 << bits) - 1;
  LitheIndex local = (LitheIndex)(slot % g->block_cells);
  cell[0] = (place[0] << bits) + (local & mask);
  cell[1] = (place[1] << bits) + ((local >> bits) & mask);
  cell[2] = g->dim == 3 ? (place[2] << bits) + (local >> (2 * bits)) : 0;
}

/// Slot of the cell `by` cells further along an axis.
static inline LitheCount lth_slot_along(const LthSparseGrid *g, const LitheIndex cell[3], int axis,
                                        LitheIndex by) {
  LitheIndex c[3] = {cell[0], cell[1], cell[2]};
  c[axis] += by;
  return lth_slot_of(g, c[0], c[1], c[2]);
}

/// Low and high (inclusive) fine cells under a coarse box: that of a cell, and shifted by half a coarse cell towards
/// lower places along the axes in `shifted`.
static inline void lth_fine_box(int dim, const LitheIndex cell[3], int shifted, LitheIndex low[3],
                                LitheIndex high[3]) {
  for (int a = 0; a < 3; a++) {
    bool flat = dim == 2 && a == 2;
    low[a] = flat ? 0 : 2 * cell[a] - (shifted >> a & 1);
    high[a] = flat ? 0 : low[a] + 1;
  }
}
