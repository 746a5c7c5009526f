/// The steps that turn a polygon soup into a clean surface; lth_surface_from_soup() calls them in order.
#pragma once

#include "geometry/bvh.h"
#include "geometry/surface.h"

#include <math.h>

/// A surface in the making. Half-edge 3 t + k goes from corner k of triangle t to the next.
typedef struct LthCleaner {
  LitheCtx *ctx;
  const char *name;
  const LthSoup *soup;
  LthDefects *defects;

  double min[3], max[3], size; ///< box of the points that polygons use, its diagonal [m]
  LitheIndex n_points;
  double *points;         ///< welded                                   (n_points x 3)
  LitheIndex *soup_point; ///< welded point of each soup point, -1 unused

  LitheIndex n_tris;
  LitheIndex *tris, *tri_poly; ///< (n_tris x 3), (n_tris)
  bool *tri_is_mixed;          ///< its shell's triangles did not agree in orientation
  LitheIndex *tri_shell;

  LitheIndex n_edges;    ///< of lth_clean_edges(), between the same two points
  LitheIndex *edge_off;  ///< start in edge_half                       (n_edges + 1)
  LitheIndex *edge_half; ///< half-edges sorted by edge                (3 n_tris)
  LitheIndex *half_edge; ///< edge of each half-edge                   (3 n_tris)

  LitheIndex n_shells;

  LitheIndex n_pairs; ///< crossing pairs of triangles, the first LTH_DEFECTS_KEPT
  LitheIndex *pair;   ///< (n_pairs x 2)
  LitheCount pair_cap;
} LthCleaner;

static inline const double *lth_clean_point(const LthCleaner *c, LitheIndex p) {
  return c->points + 3 * (size_t)p;
}

/// The two points of a half-edge.
static inline LitheIndex lth_clean_from(const LthCleaner *c, LitheIndex half) {
  return c->tris[half];
}
static inline LitheIndex lth_clean_to(const LthCleaner *c, LitheIndex half) {
  return c->tris[half % 3 == 2 ? half - 2 : half + 1];
}

/// Box of a triangle given by its points: min, max.
static inline void lth_clean_box(const LthCleaner *c, const LitheIndex t[3], double box[6]) {
  for (int i = 0; i < 3; i++) {
    double x = lth_clean_point(c, t[0])[i], y = lth_clean_point(c, t[1])[i],
           z = lth_clean_point(c, t[2])[i];
    box[i] = fmin(fmin(x, y), z);
    box[3 + i] = fmax(fmax(x, y), z);
  }
}

static inline bool lth_boxes_meet(const double a[6], const double b[6]) {
  for (int i = 0; i < 3; i++)
    if (a[i] > b[3 + i] || b[i] > a[3 + i]) return false;
  return true;
}

/// Points equal or nearer than 1e-9 of the size become one; unused points are left out.
LitheStatus lth_clean_weld(LthCleaner *c);
/// Polygons to triangles; those with repeated points are dropped.
LitheStatus lth_clean_triangulate(LthCleaner *c);
/// Find the edges of the present triangles.
LitheStatus lth_clean_edges(LthCleaner *c);
/// Drop pairs of equal triangles with opposite orientation and stray triangles without area, where that
/// leaves no edge open; then find the edges. LITHE_BAD_INPUT where nothing is left.
LitheStatus lth_clean_reduce(LthCleaner *c);
/// Replace triangles without area (closed manifold only): each lies on its longest side, so turning
/// that side in the two triangles around it leaves the same surface. *n_turned counts.
LitheStatus lth_clean_needles(LthCleaner *c, LitheIndex *n_turned);
/// Make orientation agree over edges, find shells (connected over edges).
LitheStatus lth_clean_orient(LthCleaner *c);
/// Open and non-manifold edges into defects.
LitheStatus lth_clean_find_bad_edges(LthCleaner *c);
/// Crossing and overlapping triangles into defects; `bvh` is over `boxes` (n_tris x 6).
LitheStatus lth_clean_find_crossings(LthCleaner *c, const double *boxes, const LthBvh *bvh);
/// Change the triangles of crossing pairs where that helps and hardly moves the surface; *n_changes counts
/// them, *moved grows to the largest distance [m]. Only for a manifold without other defects.
LitheStatus lth_clean_mend(LthCleaner *c, const LthBvh *bvh, LitheIndex *n_changes, double *moved);
/// Decide which shells are cavities and turn triangles outwards; refuse shells without volume.
LitheStatus lth_clean_nest(LthCleaner *c, const LthBvh *bvh);

/// LITHE_BAD_INPUT with counts, places and remedies if there is any defect.
LitheStatus lth_defects_check(LitheCtx *ctx, const LthDefects *defects, const char *name);

/// Record a defect between two points; beyond LTH_DEFECTS_KEPT of a kind they are only counted.
LitheStatus lth_defects_add(LitheCtx *ctx, LthDefects *defects, LthDefectKind kind,
                            const double a[3], const double b[3]);
