/// Finding the cell of a mesh that holds a point.
#pragma once

#include "geometry/bvh.h"
#include "mesh/mesh.h"

/// A tree over the boxes of all cells. Immutable once built; safe to read from many threads.
typedef struct LthCellSearch {
  const LthMesh *mesh; ///< borrowed for life
  LthBvh *bvh;
} LthCellSearch;

LitheStatus lth_cell_search_create(LitheCtx *ctx, const LthMesh *mesh, LthCellSearch **search);
void lth_cell_search_destroy(LitheCtx *ctx, LthCellSearch **search);

/// The cell that contains x (the lowest of those around a point on faces), else the nearest one, -1 only
/// in a mesh without cells; `inside` may be NULL.
LitheIndex lth_cell_search_find(const LthCellSearch *search, const double x[3], bool *inside);

/// Winding number of a cell's surface about x: 1 inside, 0 outside, the part of the full angle that the
/// cell takes on its boundary.
double lth_cell_winding(const LthMesh *mesh, LitheIndex cell, const double x[3]);

/// Squared distance from x to the nearest face of a cell [m^2].
double lth_cell_distance2(const LthMesh *mesh, LitheIndex cell, const double x[3]);
