/// A look at the bodies of a run while they are there: what result.json does not hold.
#pragma once

#include "lithe/run.h"
#include "scene/world.h"

/// Called after every output time, `frame` from 0 on, with the state of that time. The world is borrowed for the call.
typedef struct LthRunLook {
  LitheStatus (*look)(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame);
  void *user;
} LthRunLook;

/// As lithe_run(); `look` may be NULL.
LitheStatus lth_run_looked_at(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                              const LthRunLook *look, LitheResult **result);
