/// What the faces of cuts hide: where a cut ends inside a body, its two sides are as far from each other as the way around
/// its front (Organ, Fleming, Terry and Belytschko 1996: the diffraction method for cracks).
#pragma once

#include "geometry/bvh.h"
#include "mesh/mesh.h"

/// With more edges ways over two of them are not looked for, and over outlines alone: too many to try.
#define LTH_WAY_FEW_EDGES 32

/// An edge that ways lead around: the front of a cut, or a bend of it.
typedef struct LthWayEdge {
  double end[2][3];
  double along[3], length; ///< unit, from the first end; [m]
  double away[3];          ///< a little away from the cut faces at it
  double normal[2][3];     ///< of two faces at it that bound one side, into the body
} LthWayEdge;

/// A triangle of a cut face.
typedef struct LthHidingTriangle {
  double corner[3], side[2][3]; ///< sides: from that corner
  double normal[3], normal2;    ///< their product, and its square
} LthHidingTriangle;

/// Nothing of it exists where no cut ends inside: then elements that hang together see each other.
typedef struct LthVisibility {
  LitheIndex n_tris, n_edges;
  LthHidingTriangle *tri; ///< of all cut faces                           (n_tris)
  LthBvh *bvh;            ///< over them
  LthWayEdge *edges;      ///< those of fronts first
  LthBvh *edge_bvh;       ///< over them
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

/// An edge that is an outline of what it bounds, as seen from a place: the shortest ways from there bend about such alone.
typedef struct LthOutline {
  LitheIndex edge;
  int side;        ///< 1, 2: the face at the edge that the place is over; 3: either
  double distance; ///< [m]
} LthOutline;

/// The nearest first.
typedef struct LthSight {
  LitheIndex n;
  LthOutline *outline;
  LitheCount cap;
} LthSight;

/// Outlines within reach of a place, whether something hides them or not. The caller frees sight->outline.
LitheStatus lth_visibility_look(LitheCtx *ctx, const LthVisibility *visibility,
                                const double from[3], double reach, LthSight *sight);

/// With few edges ways over two of them are looked for too.
static inline bool lth_visibility_has_few(const LthVisibility *visibility) {
  return visibility->n_edges <= LTH_WAY_FEW_EDGES;
}

/// Length of the way around the ends of cuts, at most two of them, from a to b that is hidden from it; INFINITY where there
/// is none shorter than `limit`. With few edges the result depends on the limit where it is more than that.
/// `hiders` (may be NULL): seen from a; `sight`: from a, as far as the limit at least; NULL: all edges are tried.
double lth_visibility_way(const LthVisibility *visibility, LthHiders *hiders, const LthSight *sight,
                          const double a[3], const double b[3], double limit);
