/// Closed triangle surface where a function changes sign, by marching tetrahedra on Kuhn's lattice.
#pragma once

#include "geometry/surface.h"

/// f(x) <= 0 inside. Thread-safe.
typedef double (*LthIsoFunction)(const void *self, const double x[3]);

/// Where f changes sign between a and b, as a part of the way; thread-safe.
typedef double (*LthIsoCrossing)(const void *self, const double a[3], const double b[3],
                                 bool starts_inside);

/// Points (n x 3) and triangles (n x 3) of the surface f = 0 within [min, max], edges of about
/// `resolution`; caller frees both. Every lattice edge whose ends differ in sign carries one point, found
/// by `crossing` (NULL: bisection) and kept 1e-4 of the edge away from its ends, so that the surface is
/// closed, manifold, without crossings and without edges of no length whatever f is. f is taken as positive on the
/// lattice's own border, which lies beyond the box. No triangles at all: n_tris = 0.
LitheStatus lth_isosurface(LitheCtx *ctx, LthIsoFunction f, LthIsoCrossing crossing,
                           const void *self, const double min[3], const double max[3],
                           double resolution, LitheIndex *n_points, double **points,
                           LitheIndex *n_tris, LitheIndex **tris);
