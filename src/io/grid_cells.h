/// Fields on cells of a sparse grid as files: images (.vti) and displaced voxels (.vtu).
#pragma once

#include "geometry/sparse_grid.h"
#include "io/vtk_xml.h"

/// Values of some cells of a grid; all others have none.
typedef struct LthGridCells {
  const LthSparseGrid *grid;
  LitheIndex n_cells;
  const LitheIndex *cell;      ///< number of a slot's cell, -1: none                (n_slots)
  const LitheCount *cell_slot; ///< (n_cells)
  const LthVtuArray *arrays;   ///< of cells                                         (n_arrays)
  int n_arrays;
  double time; ///< [s], the file's TimeValue
} LthGridCells;

/// Write the box of the cells as an image: cell data, Float32, 0 where there is no cell, zlib-compressed. Nothing of
/// the box's size is held in memory. LITHE_BAD_INPUT: it has more cells than readers number.
LitheStatus lth_grid_image_write(LitheCtx *ctx, const char *path, const LthGridCells *cells);

/// Corners of cells, each once. A corner is the low one of a slot of its own.
typedef struct LthGridCorners {
  LitheIndex n;
  LitheIndex *corner; ///< of each cell in VTK's order: 8, in 2D 4             (n_cells x 8 or 4)
  LitheIndex *owner;  ///< a cell that has it                                  (n)
  double *rest;       ///< [m]                                                 (n x 3)
} LthGridCorners;

LitheStatus lth_grid_corners_create(LitheCtx *ctx, const LthGridCells *cells,
                                    LthGridCorners **corners);
void lth_grid_corners_destroy(LitheCtx *ctx, LthGridCorners **corners);

/// Write the cells as hexahedra (2D: quadrilaterals) with their corners at `points` (3 components) and arrays of the corners.
LitheStatus lth_grid_voxels_write(LitheCtx *ctx, const char *path, const LthGridCells *cells,
                                  const LthGridCorners *corners, const LthVtuArray *points,
                                  int n_arrays, const LthVtuArray *arrays);
