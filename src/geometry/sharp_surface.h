/// Closed triangle surface of a solid with its sharp edges and corners.
#pragma once

#include "geometry/solid.h"

/// Points (n x 3) and triangles (n x 3) of the solid's boundary, edges of about `resolution`; caller frees both. On a lattice of tetrahedra every field is
/// taken as linear in each, which keeps planes: faces, edges and corners of planes are right to rounding whatever the resolution, others are
/// to second order, and their points are moved onto the true surface where that leaves no crossing. Closed, oriented,
/// without crossings; points where parts of the surface touch without being neighbours are there once for each. *n_tris is 0 where there is no surface.
/// *is_sharp is false, and nothing is made, where fields meet in ways that rounding cannot tell apart on any of a few lattices.
LitheStatus lth_sharp_surface(LitheCtx *ctx, const LthSolid *solid, const double min[3],
                              const double max[3], double resolution, bool *is_sharp,
                              LitheIndex *n_points, double **points, LitheIndex *n_tris,
                              LitheIndex **tris);
