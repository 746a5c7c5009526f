/// All bodies of a scene, and the one simulation that moves them.
#pragma once

#include "scene/body.h"

typedef struct LthWorld {
  const LthScene *scene;
  LitheIndex n_bodies;
  LthBody **bodies; ///< in the scene's order                          (n_bodies)
  LthSystem *system;
  LthSimulation *sim;
} LthWorld;

/// Build everything that a run needs. `times` (2): seconds spent on meshes and on all integration.
LitheStatus lth_world_create(LitheCtx *ctx, const LthScene *scene, double *times, LthWorld **world);
void lth_world_destroy(LitheCtx *ctx, LthWorld **world);

/// Only the bodies' meshes.
LitheStatus lth_world_create_meshes(LitheCtx *ctx, const LthScene *scene, LthWorld **world);

/// Whether a world that has its meshes could be run: materials, selections, and in static runs what holds
/// the bodies. Builds what that takes into it.
LitheStatus lth_world_check(LitheCtx *ctx, LthWorld *world);
