/// The patch of boundary around a point, as far as the surface does not bend sharply.
#pragma once

#include "mesh/mesh.h"

/// Mark (1) the boundary face nearest to `point` and all that are reached from it across shared edges where
/// the normal turns by at most `angle` [rad] from face to face; others are set to 0. `member` (n_faces).
LitheStatus lth_face_patch_grow(LitheCtx *ctx, const LthMesh *mesh, const double point[3],
                                double angle, uint8_t *member);
