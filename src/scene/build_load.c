/// Loads of a scene -> loads on boundary patches and in the volume.
#include "scene/body.h"

#include <string.h>

/// True where a constraint prescribes everything weakly: a traction there would be an error of consistency,
/// for the boundary integral of the forces then runs over the rest of the boundary only.
static bool holds_wholly(const LthSceneConstraint *c) {
  return !c->strong && !c->interior && !c->normal_only && c->fixed[0] && c->fixed[1] && c->fixed[2];
}

/// Patches of a load: what it selects less what is held there anyway.
static LitheStatus select_free(LitheCtx *ctx, const LthBody *body, const LthSceneLoad *load,
                               LthPatches **patches) {
  const LthSceneBody *def = body->def;
  LitheStatus status = LITHE_OK;
  LthWhere *held = NULL, part[2] = {load->where, {.kind = LTH_WHERE_NOT, .n_children = 1}};
  LthWhere any = {.kind = LTH_WHERE_OR}, both = {.kind = LTH_WHERE_AND, .children = part};
  LITHE_TRY(lth_build_patches(ctx, body, load->place, &load->where, patches));
  LTH_NEW_OR(done, ctx, held, def->n_constraints);
  for (LitheIndex i = 0; i < def->n_constraints; i++)
    if (holds_wholly(def->constraints + i)) held[any.n_children++] = def->constraints[i].where;
  if (any.n_children == 0) goto done;

  // borrowed parts: nothing of these trees is freed here
  any.children = held;
  part[1].children = &any;
  both.n_children = 2;
  lth_patches_destroy(ctx, patches);
  LITHE_TRY_OR(done, lth_select_boundary(ctx, body->mesh, &both, patches));
  if ((*patches)->n == 0)
    status =
        lth_fail(ctx, LITHE_BAD_INPUT,
                 "%s.where: selects only boundary that a constraint holds, where a load has no "
                 "effect; select more, or hold less",
                 load->place);
done:
  lth_free(ctx, held);
  return status;
}

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
    LITHE_TRY(select_free(ctx, body, from, patches));
    load->patches = *patches;
  }
  return LITHE_OK;
}
