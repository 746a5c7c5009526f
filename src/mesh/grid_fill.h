/// Grid cells and what a sliced mesh fills of them.
#pragma once

#include "mesh/mesh.h"

/// Cell of the grid (x fastest) that each cell of a mesh sliced by it lies in.          (n_cells)
void lth_grid_cells(const LthGrid *grid, const LthMesh *mesh, LitheIndex *grid_cell);

/// Mark (1) the grid's cells that are at least half full. Marked cells that hang on the others by edges or
/// corners only, though the solid that they stand for is connected, are taken out again: they would be
/// hinges. `dropped`: how many.                                          keep (cells of the grid)
LitheStatus lth_grid_voxels(LitheCtx *ctx, const LthGrid *grid, const LthMesh *mesh, uint8_t *keep,
                            LitheIndex *dropped);
