/// VTU files of polyhedral fields (compressed appended data) and the PVD collection.
#pragma once

#include "mesh/mesh.h"

/// A cell or point array of a VTU file.
typedef struct LthVtuArray {
  const char *name;
  int components;       ///< 1, 3, 6 or 9
  const double *data;   ///< (n x components)
} LthVtuArray;

/// A mesh with its points already deformed: points are given per cell corner, so that the jumps of a
/// discontinuous field are visible. Faces with holes are written as simple polygons with bridges.
typedef struct LthVtu {
  const LthMesh *mesh;
  LitheIndex n_points;           ///< rows of points
  const double *points;          ///< (n_points x 3), float in the file
  const LitheCount *cell_point_off; ///< (n_cells + 1) points of a cell
  const LitheIndex *cell_mesh_point; ///< mesh point behind each row           (n_points)
  const LthVtuArray *point_arrays, *cell_arrays;
  int n_point_arrays, n_cell_arrays;
  double time;
} LthVtu;

/// Points of each cell: fills an LthVtu's cell_point_off and cell_mesh_point (caller frees).
LitheStatus lth_vtu_cell_points(LitheCtx *ctx, const LthMesh *mesh, LitheCount **cell_point_off,
                                LitheIndex **cell_mesh_point);

LitheStatus lth_vtu_write(LitheCtx *ctx, const char *path, const LthVtu *vtu);

/// Rewrite a PVD with n time steps: file names relative to it. Atomic, so it is valid at any moment.
LitheStatus lth_pvd_write(LitheCtx *ctx, const char *path, int n, const double *times,
                          const char *const *files);
