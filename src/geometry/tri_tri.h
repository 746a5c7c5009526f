/// Do two triangles of a surface meet anywhere but in the points they share? Decided exactly.
#pragma once

#include "base/ctx.h"

/// `s` and `t` are rows of three different points in `points` (any x 3), neither triangle without area.
/// Points with the same number are shared. True where the closed triangles have a common point beyond
/// a shared corner or a shared edge: crossing, touching, overlapping in a plane, folded onto each other.
/// Two triangles with the same three points are not looked at (false): edges tell them.
bool lth_triangles_cross(const double *points, const LitheIndex s[3], const LitheIndex t[3]);

/// About where they cross: two end points of the common segment, equal where it is a point; for showing.
void lth_triangles_crossing(const double *points, const LitheIndex s[3], const LitheIndex t[3],
                            double segment[6]);
