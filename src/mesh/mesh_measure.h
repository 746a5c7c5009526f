/// Areas, normals, centroids, volumes and boxes of a mesh, by fans of triangles and tetrahedra.
#pragma once

#include "mesh/mesh.h"

/// Fill face_normal, face_area and face_centroid. LITHE_BAD_INPUT: a face without area.
LitheStatus lth_mesh_measure_faces(LitheCtx *ctx, LthMesh *mesh);

/// Fill cell_volume, cell_centroid and cell_box. A fan about each face's first point makes the faces of
/// a cell a closed set of triangles however its points are rounded.
LitheStatus lth_mesh_measure_cells(LitheCtx *ctx, LthMesh *mesh);

/// |sum of area times outward normal| of a cell [m^2]; adds the cell's area to *area.
double lth_mesh_cell_gap(const LthMesh *mesh, LitheIndex cell, double *area);
