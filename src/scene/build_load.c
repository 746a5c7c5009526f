/// Loads of a scene -> loads on boundary patches and in the volume.
#include "scene/body.h"

#include <string.h>

LitheStatus lth_build_loads(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  LTH_NEW(ctx, body->loads, def->n_loads);
  for (LitheIndex i = 0; i < def->n_loads; i++) {
    const LthSceneLoad *from = def->loads + i;
    LthPatches **patches = body->patches + def->n_constraints + i;
    LthLoad *load = body->loads + body->n_loads++;
    *load = (LthLoad){.kind = from->kind, .follower = from->follower};
    memcpy(load->value, from->value, sizeof load->value);
    memcpy(load->stress, from->stress, sizeof load->stress);
    if (from->kind == LTH_LOAD_BODY_FORCE) continue;
    LITHE_TRY(lth_build_patches(ctx, body, from->place, &from->where, patches));
    load->patches = *patches;
  }
  return LITHE_OK;
}
