/// Nearest boundary points of shapes.
#pragma once

#include "geometry/shape.h"

/// A point of a shape's boundary.
typedef struct LthFoot {
  double point[3], normal[3]; ///< [m], unit and outward
  double distance;            ///< from where it was sought, negative inside [m]
} LthFoot;

/// The boundary point nearest to x, of a prepared shape; thread-safe. Exact for boxes, balls, disks, shells, polygons and surfaces and, away
/// from edges, for other primitives; for combinations that of a part which is on the boundary of all; otherwise by
/// root finding along the gradient, `scale` [m] being the length over which the shape's value is about linear
/// (a cell). False where no boundary is found within some 100 `scale`.
bool lth_shape_foot(const LthShape *shape, const double x[3], double scale, LthFoot *foot);
