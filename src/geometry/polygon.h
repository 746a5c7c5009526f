/// Triangulating polygons in space by clipping ears in the plane that fits best.
#pragma once

#include "base/ctx.h"

#define LTH_POLYGON_MAX 10000 ///< most corners of a polygon

/// Working memory that many polygons share. Zero-initialise; free with lth_polygon_work_free().
typedef struct LthPolygonWork {
  double *xy; ///< projected corners                                     (cap x 2)
  LitheIndex *next, *prev;
  bool *is_reflex;
  LitheCount xy_cap, next_cap, prev_cap, reflex_cap;
} LthPolygonWork;

void lth_polygon_work_free(LitheCtx *ctx, LthPolygonWork *work);

/// Newell's normal about the first corner: twice the area vector [m^2]. `corner`: places in points (n).
void lth_polygon_normal(const double *points, LitheIndex n, const LitheIndex *corner,
                        double normal[3]);

/// Cut a polygon of n >= 3 corners into n - 2 triangles with its orientation. Non-convex and slightly
/// non-planar polygons are fine, corners on straight sides too: no triangle without area is made
/// unless the polygon has none itself. A polygon that crosses itself gives a fan.
/// `corner` are rows of `points` (any x 3); `tris` ((n - 2) x 3) receives rows of `points`.
LitheStatus lth_polygon_triangulate(LitheCtx *ctx, LthPolygonWork *work, const double *points,
                                    LitheIndex n, const LitheIndex *corner, LitheIndex *tris);
