/// VTU files of polyhedral fields (compressed appended data) and the PVD collection.
#pragma once

#include "io/vtk_xml.h"
#include "mesh/mesh.h"

/// Compressed cells and faces, the same for all files of a body whose mesh stands.
typedef struct LthVtuTopology LthVtuTopology;

/// A mesh with its points already deformed: points are given per cell corner, so that the jumps of a
/// discontinuous field are visible. Faces with holes are written as simple polygons with bridges.
typedef struct LthVtu {
  const LthMesh *mesh;
  LitheIndex n_points;               ///< rows of points
  const double *points;              ///< (n_points x 3)
  bool wide_points;                  ///< doubles in the file, for meshes that are to be read again
  const LitheCount *cell_point_off;  ///< (n_cells + 1) points of a cell
  const LitheIndex *cell_mesh_point; ///< mesh point behind each row           (n_points)
  const LthVtuArray *point_arrays, *cell_arrays;
  int n_point_arrays, n_cell_arrays;
  double time;                    ///< [s], the file's TimeValue
  const LthVtuTopology *topology; ///< NULL: made for this file alone
} LthVtu;

/// Points of each cell: fills an LthVtu's cell_point_off and cell_mesh_point (caller frees).
LitheStatus lth_vtu_cell_points(LitheCtx *ctx, const LthMesh *mesh, LitheCount **cell_point_off,
                                LitheIndex **cell_mesh_point);

/// Cells and faces of `vtu` (its mesh, n_points and point lists), to be put into it and into those that
/// follow. Free it with lth_vtu_topology_destroy().
LitheStatus lth_vtu_topology_create(LitheCtx *ctx, const LthVtu *vtu, LthVtuTopology **topology);
void lth_vtu_topology_destroy(LitheCtx *ctx, LthVtuTopology **topology);

/// Write one file: VTK_POLYHEDRON cells, points and arrays as Float32 (but for wide_points), zlib-compressed appended data.
/// Atomic. LITHE_NO_SPACE: cannot write.
LitheStatus lth_vtu_write(LitheCtx *ctx, const char *path, const LthVtu *vtu);

/// Rewrite a PVD with n time steps: file names relative to it. Atomic, so it is valid at any moment.
LitheStatus lth_pvd_write(LitheCtx *ctx, const char *path, int n, const double *times,
                          const char *const *files);
