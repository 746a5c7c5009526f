/// Edges between points of cut faces: where cuts end, bend and come to the surface.
#pragma once

#include "mesh/mesh.h"

/// An edge of a face by its points, low < high.
typedef struct LthCutEdge {
  LitheIndex low, high, face;
} LthCutEdge;

/// A boundary face that a cut has made.
bool lth_is_cut_face(const LthMesh *mesh, LitheIndex face);

/// All edges whose two points are those of cut faces, once for each face that has them (of the boundary alone, or of all), in
/// the order of low, high, face; none where there is no cut. Owned by the caller, who frees them also after an error.
LitheStatus lth_list_cut_edges(LitheCtx *ctx, const LthMesh *mesh, bool of_boundary,
                               LthCutEdge **edges, LitheCount *n);

/// Behind the last of those in the list that have the points of the one at `first`.
LitheCount lth_cut_edge_end(const LthCutEdge *edges, LitheCount first, LitheCount n);
