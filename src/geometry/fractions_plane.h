/// Areas of shapes of the plane inside boxes.
#pragma once

#include "geometry/convex_cell.h"
#include "geometry/shape_probe.h"

/// Area of a probe's shape inside a box, z = 0 [m^2]; thread-safe. To rounding for boxes, polygons, images that were not
/// smoothed, disks and annuli, and for combinations but for places where two circles meet, which are halved down to
/// 2^-22 of the box. Circles that touch over a length, implicit shapes and smoothed images are replaced by lines in
/// 1/16 of the box.
double lth_plane_area(const LthProbe *probe, const double min[2], const double max[2]);
