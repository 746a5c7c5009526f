/// Polygons with holes in the plane: closed loops of straight edges.
#pragma once

#include "geometry/bvh.h"

/// Immutable once built; safe to read from many threads. The first loop runs counter-clockwise, the others,
/// its holes, clockwise, so that material is on the left of every edge.
typedef struct LthLoops {
  LitheIndex n_loops, n_points;
  LitheIndex *first; ///< first corner of a loop                 (n_loops + 1)
  LitheIndex *next;  ///< corner behind a corner: edge i runs from corner i to next[i]   (n_points)
  LitheIndex *prev;  ///< corner before it                                              (n_points)
  double *points;    ///< [m]                                                       (n_points x 2)
  double box[4];     ///< min, max
  double area;       ///< [m^2]
  LthBvh *bvh;       ///< over the edges, z = 0
} LthLoops;

/// `first` (n_loops + 1) are rows of `points` (first[n_loops] x 2); either way round, nothing is kept of them. Corners that
/// repeat the one before are left out. LITHE_BAD_INPUT: fewer than three corners, edges that touch or
/// cross, no area, a hole that is not inside the first loop or inside another; the message names the loop and the corner.
LitheStatus lth_loops_create(LitheCtx *ctx, LitheIndex n_loops, const LitheIndex *first,
                             const double *points, LthLoops **loops);
void lth_loops_destroy(LitheCtx *ctx, LthLoops **loops);

/// Signed distance [m], negative inside, 0 on an edge exactly; `nearest` and `normal` (outward, of length 1; either
/// may be NULL) as of lth_shape_foot().
double lth_loops_distance(const LthLoops *loops, const double x[2], double nearest[2],
                          double normal[2]);

/// Area inside a box [m^2]: 0 or all of the box exactly where no edge passes through it, else to rounding.
double lth_loops_area(const LthLoops *loops, const double min[2], const double max[2]);

/// Twice the area that a loop goes round counter-clockwise.
double lth_loop_area2(const LthLoops *loops, LitheIndex loop);
