/// The embedded surface of a body that is cut (docs/theory/embedding.md, section 5).
#pragma once

#include "mesh/skin.h"
#include "scene/body.h"

/// Until a cut, the body's surface is what the scene gave; from then on it is the skin's. A surface that is not the
/// boundary of the body is that of a solid of its own, divided by the planes that divide the body.
typedef struct LthCutSurface {
  LthSkin *skin;
  LitheIndex
      *cell; ///< of the body's present mesh: where each point is, -1: not known (soup->n_points)
  LitheCount cap_cell;
  bool is_cut;       ///< the body's soup is the skin's
  LitheIndex n_cuts; ///< of the body that it has followed
  bool
      has_changed; ///< and other than when the run began: a cache with a fixed number of points has ended

  // of another surface than the body's boundary
  LthTopology *solid;
  LitheIndex *home; ///< element (record) of the body that each point follows
  LitheCount cap_home;
  LitheIndex n_home; ///< points that have one
} LthCutSurface;

/// Begin to follow the elements of a body that has its mesh, and no cuts yet. Without an embedded surface: nothing.
LitheStatus lth_cut_surface_begin(LitheCtx *ctx, LthBody *body);
void lth_cut_surface_end(LitheCtx *ctx, LthCutSurface **surface);

/// Follow the operations in the log of the body's topology, and the planes noted since (they are forgotten).
/// `mesh` is the mesh that the body will have, with the record of each of its cells.
LitheStatus lth_cut_surface_follow(LitheCtx *ctx, LthBody *body, const LthMesh *mesh,
                                   const LitheIndex *cell_record);

/// The solid of a surface that is not the body's boundary (cut_solid.c): what the body's new cut faces do to it.
LitheStatus lth_cut_solid_follow(LitheCtx *ctx, LthBody *body, const LthMesh *mesh,
                                 const LitheIndex *cell_record);

/// All of it, when the body has its topology and its mesh.
void lth_cut_surface_archive(LthBody *body, LthArchive *archive);
