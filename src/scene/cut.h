/// Cuts of a scene: when they are due, and what they do to the topology of bodies.
#pragma once

#include "scene/change.h"

/// On meshes on which nothing is built yet: let bodies change that the scene cuts, and make the cuts that are
/// due before the first solve. Those in deformed space of bodies that start deformed come later.
LitheStatus lth_world_cut_first(LitheCtx *ctx, LthWorld *world);

/// Make all cuts due before the step that ends at `end` [s] and renew the world. `*changed`: it was renewed.
LitheStatus lth_world_cut_due(LitheCtx *ctx, LthWorld *world, double end, bool *changed);
