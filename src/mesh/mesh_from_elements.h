/// What lth_mesh_from_elements() works with: faces while they grow, and which side of an element each came from.
#pragma once

#include "mesh/element_mesh.h"

typedef struct LthElementsAsMesh {
  const LthElementMesh *elements;
  const char *file;
  LthElementSides *sides;
  LitheIndex *node_point; ///< point of a corner node, -1                     (n_nodes)
  double *points;
  LitheIndex *loop_off, *loop_off_of, *loop_point, *face_cell;
  LitheIndex *face_side; ///< side that a face is, or is a part of           (n_faces)
  LitheIndex n_points, n_faces;
  LitheCount n_loop_points;
  LitheCount cap_points, cap_off, cap_loop, cap_cells, cap_sides;
} LthElementsAsMesh;

void lth_elements_as_mesh_free(LitheCtx *ctx, LthElementsAsMesh *work);

/// Give the mesh the groups of its elements.
LitheStatus lth_mesh_groups_from_elements(LitheCtx *ctx, const LthElementsAsMesh *work,
                                          LthMesh *mesh);

/// Warn where boundary faces of two elements lie on each other: the elements are not joined there.
LitheStatus lth_mesh_warn_overlaps(LitheCtx *ctx, const LthElementsAsMesh *work,
                                   const LthMesh *mesh);
