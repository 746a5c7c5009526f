/// Loads of staggered bodies.
#include "scene/staggered_body.h"

#include <string.h>

LitheStatus lth_build_grid_loads(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  for (LitheIndex i = 0; i < def->n_loads; i++) {
    const LthSceneLoad *from = def->loads + i;
    LthLoad load = {.kind = from->kind, .follower = from->follower};
    memcpy(load.value, from->value, sizeof load.value);
    memcpy(load.stress, from->stress, sizeof load.stress);
    LTH_RESERVE(ctx, body->loads, body->cap_loads, body->n_loads + 1);
    body->loads[body->n_loads++] = load;
  }
  return LITHE_OK;
}
