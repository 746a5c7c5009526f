/// Bounding volume tree over boxes: nearest items, and the signed distance of triangle surfaces.
/// The sign is that of the angle-weighted pseudonormal (Baerentzen and Aanaes 2005).
#pragma once

#include "base/ctx.h"
#include "geometry/surface.h"

/// Immutable once built; safe to read from many threads. A node's left child is the next node.
typedef struct LthBvh {
  LitheIndex n_nodes;
  LitheIndex *item;          ///< items in the order of the leaves           (n)
  double *box;               ///< min, max of a node                         (n_nodes x 6)
  LitheIndex *right;         ///< right child of an inner node, -1: a leaf   (n_nodes)
  LitheIndex *first;         ///< a leaf's items item[first[k] ... + count[k]) (n_nodes)
  LitheIndex *count;         ///< (n_nodes)
  const LthSurface *surface; ///< borrowed for life; NULL for a tree over boxes
  double *tri_normal;        ///< unit                                       (n_tris x 3)
  LitheIndex *across;        ///< triangle behind the edge from corner k to k + 1, -1 (n_tris x 3)
  double *point_normal;      ///< weighted by angles                         (n_points x 3)
} LthBvh;

/// A tree over n boxes (n x 6: min, max). Nothing is kept of `boxes`.
LitheStatus lth_bvh_create_boxes(LitheCtx *ctx, LitheIndex n, const double *boxes, LthBvh **bvh);

/// A tree over the triangles of a closed surface, borrowed for life.
LitheStatus lth_bvh_create_surface(LitheCtx *ctx, const LthSurface *surface, LthBvh **bvh);

void lth_bvh_destroy(LitheCtx *ctx, LthBvh **bvh);

/// Squared distance from x to an item; anything >= limit where it is not below limit.
typedef double (*LthBvhDistance2)(void *self, LitheIndex item, const double x[3], double limit);

/// The item nearest to x (the first found of equals), -1 if none is nearer than sqrt(*distance2);
/// *distance2 is the limit on entry and the result on exit.
LitheIndex lth_bvh_nearest(const LthBvh *bvh, const double x[3], LthBvhDistance2 distance,
                           void *self, double *distance2);

/// Call `visit` for every item whose leaf may hold a box within `reach` of x; it returns false to stop.
typedef bool (*LthBvhVisit)(void *self, LitheIndex item);
void lth_bvh_visit(const LthBvh *bvh, const double x[3], double reach, LthBvhVisit visit,
                   void *self);

/// Signed distance to the surface [m], negative inside; `normal` (may be NULL) is its unit gradient,
/// the pseudonormal where x lies on the surface.
double lth_bvh_signed_distance(const LthBvh *bvh, const double x[3], double normal[3]);

/// After the points of the surface moved: boxes and normals anew, the tree stays.
void lth_bvh_refit_surface(LthBvh *bvh);

/// A point of the surface; `part` as lth_closest_on_triangle() says.
typedef struct LthBvhPoint {
  LitheIndex tri;
  int part;
  double point[3], distance; ///< from where it was sought [m]
} LthBvhPoint;

/// False for triangles that are passed over.
typedef bool (*LthBvhAccept)(const void *self, LitheIndex tri);

/// The point of the surface, or of the accepted triangles (NULL: all), that is closest to x; false where
/// none is nearer than `reach` [m].
bool lth_bvh_closest(const LthBvh *bvh, const double x[3], double reach, LthBvhAccept accept,
                     const void *self, LthBvhPoint *closest);

/// lth_bvh_signed_distance() where the closest point is known.
double lth_bvh_gap(const LthBvh *bvh, const double x[3], const LthBvhPoint *closest,
                   double normal[3]);

/// Point of triangle abc closest to x, also of degenerate triangles. Returns the part it lies on:
/// 0, 1, 2 corner; 3, 4, 5 edge from corner part - 3 to the next; 6 inside.
int lth_closest_on_triangle(const double a[3], const double b[3], const double c[3],
                            const double x[3], double closest[3]);

/// Solid angle of triangle abc seen from x [sr]: 4 pi in total for a closed surface seen from inside.
double lth_solid_angle(const double a[3], const double b[3], const double c[3], const double x[3]);

/// Squared distance from x to a box (min, max); 0 inside.
double lth_box_distance2(const double box[6], const double x[3]);
