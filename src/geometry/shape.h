/// Shapes of a scene (SCENE: shapes) as a tree, their inside test, and their triangle surface.
#pragma once

#include "base/ctx.h"
#include "base/value.h"
#include "geometry/bvh.h"
#include "geometry/image.h"
#include "geometry/loops.h"
#include "geometry/surface.h"
#include "geometry/wrap.h"

typedef enum LthShapeKind {
  LTH_SHAPE_BOX,      ///< a = min, b = max; in a plane scene z from -INFINITY to INFINITY
  LTH_SHAPE_SPHERE,   ///< a = center, radius
  LTH_SHAPE_CYLINDER, ///< a = from, b = to, radius
  LTH_SHAPE_CAPSULE,  ///< a = from, b = to, radius
  LTH_SHAPE_SHELL,    ///< a = center, radius = outer, inner
  LTH_SHAPE_MESH,     ///< surface (already scaled and fitted)
  LTH_SHAPE_IMPLICIT, ///< value(x) < 0 inside; nothing beyond `box`
  LTH_SHAPE_UNION,
  LTH_SHAPE_INTERSECTION,
  LTH_SHAPE_DIFFERENCE, ///< first child minus the others
  LTH_SHAPE_IMAGE,      ///< inside where the level of an image is negative
  LTH_SHAPE_WRAP,       ///< inside where the winding number is above one half
  LTH_SHAPE_DISK,       ///< of plane scenes, where z does not count: a = center, radius
  LTH_SHAPE_ANNULUS,    ///< the same: a = center, radius = outer, inner
  LTH_SHAPE_POLYGON     ///< the same: loops
} LthShapeKind;

/// Owned by whoever made it; children and strings too (lth_shape_free).
typedef struct LthShape LthShape;
struct LthShape {
  LthShapeKind kind;
  double a[3], b[3];         ///< [m]
  double radius, inner;      ///< [m]
  const LthSoup *soup;       ///< MESH, WRAP: borrowed, original file order in scene axes
  const LthSurface *surface; ///< MESH: borrowed, cleaned
  LthBvh *bvh;           ///< MESH: made by lth_shape_prepare(); NULL: every triangle is looked at
  LthValue value;        ///< IMPLICIT
  double box[6];         ///< IMPLICIT: where to look for the surface: min, max
  const LthImage *image; ///< IMAGE: borrowed
  const LthWrap *wrap;   ///< WRAP: borrowed
  const LthLoops *loops; ///< POLYGON: borrowed
  double resolution;     ///< WRAP: edge length of its surface [m], 0: what the whole shape has
  LthShape *children;
  LitheIndex n_children;
};

void lth_shape_free(LitheCtx *ctx,
                    LthShape *shape); ///< frees children and bvh, not the struct itself

/// Make the search trees of all mesh shapes in the tree, once; afterwards distances to them take
/// logarithmic time. Surfaces must stay where they are until lth_shape_free().
LitheStatus lth_shape_prepare(LitheCtx *ctx, LthShape *shape);

/// Signed distance-like value: negative inside, zero on the boundary, positive outside; exact distance
/// for primitives, a lower bound for combinations. Closed set: 0 counts as inside. Thread-safe.
double lth_shape_value(const LthShape *shape, const double x[3]);

/// Smallest box that holds the shape. Of plane shapes z is 0.
void lth_shape_bounds(const LthShape *shape, double min[3], double max[3]);

/// A closed surface of the shape. A box gives its 12 triangles, a mesh a copy of itself, other
/// primitives are tessellated with edges of about `resolution` [m] (points on the true surface);
/// combinations and implicit shapes have sharp edges where their parts meet (docs/theory/sharp.md; where that fails
/// they are chamfered, with a warning), images and wrapped surfaces are isosurfaces with chamfers. Pieces of the latter two
/// that are smaller than a lattice cell are left out.
/// The result's soup is itself: soup_point and tri_poly are the identity.
/// LITHE_BAD_INPUT: no surface found, no size, far too fine a resolution, or a shape of plane scenes.
LitheStatus lth_shape_tessellate(LitheCtx *ctx, const LthShape *shape, double resolution,
                                 LthSurface **surface);
