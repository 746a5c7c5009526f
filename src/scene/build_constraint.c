/// Constraints of a scene -> weak constraints on boundary patches, and strong cells.
#include "scene/body.h"

LitheStatus lth_build_patches(LitheCtx *ctx, const LthBody *body, const char *place,
                              const LthWhere *where, LthPatches **patches) {
  const double *box = body->box;
  LITHE_TRY(lth_select_boundary(ctx, body->mesh, where, patches));
  if ((*patches)->n > 0) return LITHE_OK;
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "%s.where: selects nothing of the body's boundary; the body reaches from (%g, %g, %g) to "
      "(%g, %g, %g)",
      place, box[0], box[1], box[2], box[3], box[4], box[5]);
}

static bool is_strong(const LthSceneConstraint *c) { return c->strong || c->interior; }

static LthWeakConstraint weak_from(const LthSceneConstraint *c, const LthPatches *patches) {
  LthWeakConstraint weak = {
      .patches = patches, .normal_only = c->normal_only, .is_position = c->is_position};
  for (int a = 0; a < 3; a++) {
    weak.fixed[a] = c->fixed[a];
    weak.value[a] = c->value[a];
  }
  return weak;
}

LitheStatus lth_build_constraints(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  bool any_strong = false;
  LTH_NEW(ctx, body->patches, def->n_constraints + def->n_loads);
  LTH_NEW(ctx, body->weak, def->n_constraints);
  LTH_NEW(ctx, body->weak_of, def->n_constraints);
  for (LitheIndex i = 0; i < def->n_constraints; i++) {
    const LthSceneConstraint *c = def->constraints + i;
    any_strong = any_strong || is_strong(c);
    if (is_strong(c)) continue;
    LITHE_TRY(lth_build_patches(ctx, body, c->place, &c->where, body->patches + i));
    body->weak_of[body->n_weak] = i;
    body->weak[body->n_weak++] = weak_from(c, body->patches[i]);
  }
  return any_strong ? lth_strong_create(ctx, body, &body->strong) : LITHE_OK;
}
