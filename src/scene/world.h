/// All bodies of a scene, and the one simulation that moves them.
#pragma once

#include "couple/tie.h"
#include "scene/body.h"

/// A tie of the scene.
typedef struct LthWorldTie {
  LitheIndex body[2];
  LthPatches *patches[2]; ///< what `where` selects of both
  LthTie *tie;
} LthWorldTie;

/// Two bodies that may touch.
typedef struct LthWorldPair {
  LitheIndex body[2];
  uint8_t *tied[2]; ///< points that a tie holds, or NULL
  LthContact *contact;
} LthWorldPair;

typedef struct LthWorld {
  const LthScene *scene;
  LitheIndex n_bodies;
  LthBody **bodies;  ///< in the scene's order                          (n_bodies)
  LthWorldTie *ties; ///< in the scene's order
  LitheIndex n_ties;
  LthWorldPair *pairs; ///< none where bodies do not collide
  LitheIndex n_pairs;
  LthSystem *system;
  LthSimulation *sim;
} LthWorld;

/// Build everything that a run needs. `times` (2): seconds spent on meshes and on all integration.
LitheStatus lth_world_create(LitheCtx *ctx, const LthScene *scene, double *times, LthWorld **world);
void lth_world_destroy(LitheCtx *ctx, LthWorld **world);

/// What is between bodies that are built (build_pair.c): ties first, then contact of every two.
LitheStatus lth_world_build_ties(LitheCtx *ctx, LthWorld *world);
LitheStatus lth_world_build_pairs(LitheCtx *ctx, LthWorld *world);
void lth_world_free_ties(LitheCtx *ctx, LthWorld *world);
void lth_world_free_pairs(LitheCtx *ctx, LthWorld *world);

/// Only the bodies' meshes.
LitheStatus lth_world_create_meshes(LitheCtx *ctx, const LthScene *scene, LthWorld **world);

/// Whether a world that has its meshes could be run: materials, selections, and in static runs what holds
/// the bodies. Builds what that takes into it.
LitheStatus lth_world_check(LitheCtx *ctx, LthWorld *world);
