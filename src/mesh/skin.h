/// The surface of a body that is cut: polygons that follow the boundary of its topology, with points that keep their
/// numbers (Kaufmann et al. 2009, section 9.6; docs/theory/embedding.md, section 5).
#pragma once

#include "mesh/topology.h"

/// What a skin begins with; everything is copied.
typedef struct LthSkinDef {
  const LthTopology *topology; ///< before its first cut
  const LthSoup *soup;         ///< its boundary as polygons
  const bool *is_inward; ///< polygons that run clockwise as seen from outside, NULL: none (n_polys)
  const LitheIndex *point; ///< point of the topology of each of the soup's, -1: none (n_points)
  LitheIndex n_facets;     ///< plane parts of the polygons: triangles
  const LitheIndex *facet_poly; ///< polygon of each                              (n_facets)
  const LitheIndex *face_facet; ///< facet of each face that the topology began with, -1: inside it
  LitheIndex n_faces;
} LthSkinDef;

/// Points of the soup come first and keep their numbers for life; those that cuts add come behind. Polygons that
/// no cut has touched are those of the soup, turned outward; in place of a touched one stand its parts, and
/// behind all others stand those of the cuts, in a group `cut` of their own, with texture coordinates in metres along their
/// plane (the same on both sides of a cut). Where the soup was closed, so is the surface of each part of the body.
typedef struct LthSkin {
  LthSoup *soup; ///< as it is now; its arrays change with lth_skin_update()
  LitheIndex
      *cell; ///< record of a cell of the topology that has the point, -1: none left (n_points)
  LitheIndex n_caps; ///< polygons of cuts: the last ones
  // what it is made from
  LthSoup *first;
  LitheIndex *point; ///< point of the topology, -1                         (n_points)
  double *place;     ///< where that was: it may be given to another         (n_points x 3)
  LitheIndex *facet_poly, *face_facet;
  LitheIndex n_facets, n_faces;
  bool *has_pieces; ///< facets that the body's boundary has; others have no area (n_facets)
  LitheCount points_cap, cell_cap, point_cap, place_cap;
} LthSkin;

LitheStatus lth_skin_create(LitheCtx *ctx, const LthSkinDef *def, LthSkin **skin);
void lth_skin_destroy(LitheCtx *ctx, LthSkin **skin);

/// Give points whose cell died one of those that it became. To be called after operations on the topology,
/// before lth_topology_forget().
LitheStatus lth_skin_follow(LitheCtx *ctx, LthSkin *skin, const LthTopology *topology);

/// Points and polygons as cuts have left them; after lth_skin_follow(). What did not change is the same bit for bit.
LitheStatus lth_skin_update(LitheCtx *ctx, LthSkin *skin, const LthTopology *topology);
