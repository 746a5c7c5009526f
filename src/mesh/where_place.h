/// A `where` tree asked at places of a solid that has no mesh: unknowns, parts of cells, boundary points.
#pragma once

#include "geometry/shape_foot.h"
#include "mesh/curve_patch.h"
#include "mesh/selection.h"

/// What a place is known to be.
typedef struct LthPlace {
  double x[3];
  bool is_boundary; ///< on or beyond the boundary; otherwise what only that can answer is unknown
  double point[3], normal[3]; ///< of the boundary nearest to it, where `is_boundary`
} LthPlace;

/// Members of one LTH_WHERE_FACE node: triangles of the surface, or points of the curve.
typedef struct LthGrownPatch {
  const LthWhere *node;
  uint8_t *member; ///< (n_tris), (n)
} LthGrownPatch;

typedef struct LthWhereSolid {
  const LthWhere *where; ///< borrowed, as the solid is
  double tolerance;      ///< 1e-9 of the solid's longest side [m]
  bool all_inside;       ///< `all` means the inside too
  const LthBvh *bvh;     ///< of the surface that patches have grown on, or NULL
  LthBvh *own_bvh;
  LthSurface *own_surface;
  LthCurve *curve; ///< of plane solids, where some patch asks for it
  LthGrownPatch *patches;
  LitheIndex n_patches;
  LitheCount cap_patches;
} LthWhereSolid;

/// Make a tree ready. A patch grows on the surface of `bvh`, or where that is NULL on that of the solid with edges of about
/// `resolution` [m]; where `dim` is 2, along the boundary curve in such steps. Free with lth_where_solid_free(), also after a failure.
LitheStatus lth_where_solid_prepare(LitheCtx *ctx, const LthWhere *where, int dim,
                                    const LthShape *solid, const LthBvh *bvh, double resolution,
                                    bool all_inside, LthWhereSolid *ready);
void lth_where_solid_free(LitheCtx *ctx, LthWhereSolid *ready);

/// Does the tree contain the place? Thread-safe.
bool lth_where_solid_contains(const LthWhereSolid *ready, const LthPlace *place);

/// Might it contain a place within `reach` [m] of x? True where only the boundary could answer. Thread-safe.
bool lth_where_solid_is_near(const LthWhereSolid *ready, const double x[3], double reach);
