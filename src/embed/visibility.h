/// What the faces of cuts hide: where a cut ends inside a body, its two sides are as far from each other as the way around
/// its front (Organ, Fleming, Terry and Belytschko 1996: the diffraction method for cracks).
#pragma once

#include "geometry/bvh.h"
#include "mesh/mesh.h"

/// With more edges ways over two of them are not looked for: too many to try.
#define LTH_WAY_FEW_EDGES 32

/// An edge that ways lead around: the front of a cut, or a bend of it.
typedef struct LthWayEdge {
  double end[2][3];
  double along[3], length; ///< unit, from the first end; [m]
  double away[3];          ///< a little away from the cut faces at it
} LthWayEdge;

/// Nothing of it exists where no cut ends inside: then elements that hang together see each other.
typedef struct LthVisibility {
  LitheIndex n_tris, n_edges;
  double *tri;       ///< corners of cut faces' triangles [m]             (n_tris x 9)
  LthBvh *bvh;       ///< over them
  LthWayEdge *edges; ///< those of fronts first
  LthBvh *edge_bvh;  ///< over them
  LitheIndex n_fronts;
  LitheCount cap_tri, cap_edges;
} LthVisibility;

/// The edges alone.
LitheStatus lth_visibility_find_edges(LitheCtx *ctx, const LthMesh *mesh,
                                      LthVisibility *visibility);
LitheStatus lth_visibility_create(LitheCtx *ctx, const LthMesh *mesh, LthVisibility *visibility);
void lth_visibility_free(LitheCtx *ctx, LthVisibility *visibility);

/// Distance from a box (min, max) to the nearest front, or less; INFINITY: there is none.
double lth_visibility_front(const LthVisibility *visibility, const double box[6]);

/// Triangles that have hidden something of late: they are tried first.
#define LTH_HIDERS 8
typedef struct LthHiders {
  LitheIndex tri[LTH_HIDERS];
  int n;
} LthHiders;

/// Does a cut lie between two places? `hiders` (may be NULL) are those seen from one of them.
bool lth_visibility_is_hidden(const LthVisibility *visibility, LthHiders *hiders, const double a[3],
                              const double b[3]);

/// Length of the way around the ends of cuts, at most two of them, from a to b that is hidden from it; INFINITY where there
/// is none shorter than `limit`. `hiders` (may be NULL): seen from a.
double lth_visibility_way(const LthVisibility *visibility, LthHiders *hiders, const double a[3],
                          const double b[3], double limit);

/// A way that is shorter than one limit is the same with any other. But with few edges ways over two are looked for where there
/// is none over one, so there the limit counts.
static inline bool lth_visibility_needs_limit(const LthVisibility *visibility) {
  return visibility->n_edges <= LTH_WAY_FEW_EDGES;
}
