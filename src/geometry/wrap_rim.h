/// The rims of triangles that do not bound a solid: the edges over which they do not match. Beside them winding numbers
/// are not whole (docs/theory/winding.md).
#pragma once

#include "geometry/bvh.h"

/// Immutable once built; safe to read from many threads.
typedef struct LthRim {
  LitheIndex n;   ///< edges; 0: every winding number is whole
  double *ends;   ///< of an edge, in the order of the leaves     (n x 6)
  double *length; ///< of the edges below a node, each as often as it is left over [m] (n_nodes)
  double *weight; ///< how often an edge is left over             (n)
  LthBvh *bvh;    ///< NULL where there is no edge
} LthRim;

/// Edges through which triangles do not run as often one way as the other.
LitheStatus lth_rim_create(LitheCtx *ctx, const LthSurface *raw, LthRim **rim);
void lth_rim_destroy(LitheCtx *ctx, LthRim **rim);

/// No less than the slope of the winding number's fractional part in a ball [1/m]: winding.md, equation (6); infinite where
/// a rim is in it.
double lth_rim_slope(const LthRim *rim, const double center[3], double radius);
