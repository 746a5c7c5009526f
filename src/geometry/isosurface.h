/// Closed triangle surface where a function changes sign, by marching tetrahedra on Kuhn's lattice.
#pragma once

#include "geometry/surface.h"

/// f(x) <= 0 inside. Thread-safe.
typedef double (*LthIsoFunction)(const void *self, const double x[3]);

/// Points (n x 3) and triangles (n x 3) of the surface f = 0 within [min, max], edges of about
/// `resolution`; caller frees both. Every lattice edge whose ends differ in sign carries one point, found
/// by bisection and kept 1e-4 of the edge away from its ends, so that the surface is closed, manifold,
/// without crossings and without edges of no length whatever f is. f is taken as positive on the
/// lattice's own border, which lies beyond the box. No triangles at all: n_tris = 0.
LitheStatus lth_isosurface(LitheCtx *ctx, LthIsoFunction f, const void *self, const double min[3],
                           const double max[3], double resolution, LitheIndex *n_points,
                           double **points, LitheIndex *n_tris, LitheIndex **tris);
