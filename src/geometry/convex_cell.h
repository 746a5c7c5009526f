/// Convex polygons of few corners in the plane: cutting by lines, areas, and areas inside circles.
#pragma once

#include "base/ctx.h"

#define LTH_CONVEX_MAX                                                                             \
  60 ///< corners; a cut adds two at most, and twice as many where rounding bends sides

/// Corners counter-clockwise.
typedef struct LthConvex {
  int n;
  double x[LTH_CONVEX_MAX][2]; ///< [m]
} LthConvex;

/// Points with normal . x <= offset are behind the line; `normal` has length 1.
typedef struct LthLine {
  double normal[2], offset;
} LthLine;

LthConvex lth_convex_box(const double min[2], const double max[2]);
double lth_convex_area(const LthConvex *c);
void lth_convex_middle(const LthConvex *c, double middle[2]); ///< mean of its corners
void lth_convex_bounds(const LthConvex *c, double min[2], double max[2]);

/// The range of normal . x - offset over the corners.
void lth_convex_range(const LthConvex *c, const LthLine *line, double *low, double *high);

/// The parts behind and before a line; either may have no corners. The cell has at most
/// LTH_CONVEX_MAX / 2 corners: in each part at most as many come in as there are sides.
void lth_convex_cut(const LthConvex *c, const LthLine *line, LthConvex *behind, LthConvex *before);

/// Area inside a circle: 0 and all of it exactly where the circle does not pass through.
double lth_convex_disk(const LthConvex *c, const double center[2], double radius);

/// Smallest and largest distance of its points from a place.
void lth_convex_distances(const LthConvex *c, const double place[2], double *low, double *high);

/// Length of the part of the segment pq that lies inside.
double lth_convex_chord(const LthConvex *c, const double p[2], const double q[2]);
