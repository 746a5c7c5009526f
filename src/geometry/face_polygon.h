/// Faces as simple polygons, for file formats and pictures that know no holes.
#pragma once

#include "base/ctx.h"
#include "geometry/moments.h"

/// A growing list of polygons, each written as its number of points and the points.
typedef struct LthPolygonList {
  LitheIndex *items;
  LitheCount n, cap;
  LitheIndex n_polygons;
} LthPolygonList;

void lth_polygon_list_free(LitheCtx *ctx, LthPolygonList *list);

/// Append the polygons of a face, counter-clockwise about its normal: a loop as it is, a loop with holes
/// as triangles (the holes are joined to it by bridges first). Areas add up to the face's; every edge of
/// a loop is an edge of one polygon.
LitheStatus lth_face_polygons(LitheCtx *ctx, const LthFaceView *face, LthPolygonList *list);
