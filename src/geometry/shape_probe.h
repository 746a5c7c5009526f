/// Asking a shape at millions of places: which boxes are certainly inside or outside, and inside tests by maps.
#pragma once

#include "geometry/shape.h"

typedef enum LthSide { LTH_SIDE_OUTSIDE, LTH_SIDE_INSIDE, LTH_SIDE_MIXED } LthSide;

/// A prepared shape (borrowed for life) with maps of the wrapped surfaces in it. Immutable once built.
typedef struct LthProbe LthProbe;
struct LthProbe {
  const LthShape *shape;
  LthWrapMap *map;    ///< WRAP
  LthProbe *children; ///< (shape->n_children)
};

/// `cell`: of the maps, about that of the grid that will ask [m].
LitheStatus lth_probe_create(LitheCtx *ctx, const LthShape *shape, double cell, LthProbe **probe);
void lth_probe_destroy(LitheCtx *ctx, LthProbe **probe);

/// Is x inside? As lth_shape_value() <= 0, but images that were not smoothed are made of whole voxels.
bool lth_probe_inside(const LthProbe *probe, const double x[3]);

/// Is all of the box center +- half on one side, but for a set of no volume? MIXED: maybe not. Certain where
/// the shape's value changes by no more than the distance; for implicit shapes as far as values at 3 places along
/// each axis tell.
LthSide lth_probe_side(const LthProbe *probe, const double center[3], const double half[3]);

/// Signed distance to the boundary nearby [m]: exact where lth_shape_value() is, else the value over the length of
/// its gradient, by differences over `step` along x, y (and z where dim is 3).
double lth_probe_distance(const LthProbe *probe, const double x[3], int dim, double step);
