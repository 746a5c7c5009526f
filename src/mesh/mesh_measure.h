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

/// Twice the area vector of a face, summed about its first point [m^2].
void lth_mesh_area_vector(const LthFaceView *face, double n[3]);

/// Add six times the volume and 24 times the first moment about o of the cone from o over a face.
void lth_mesh_add_cone(const LthFaceView *face, double sign, const double o[3], double *volume,
                       double moment[3]);
