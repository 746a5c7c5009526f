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

/// Give the cells of constraint i that no earlier one has to it.
static LitheStatus mark(LitheCtx *ctx, const LthBody *body, LitheIndex i,
                        LitheIndex *constraint_of) {
  LitheStatus status = LITHE_OK;
  const LthSceneConstraint *c = body->def->constraints + i;
  uint8_t *chosen = NULL;
  bool any = false;
  if (c->normal_only || !(c->fixed[0] && c->fixed[1] && c->fixed[2]))
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "%s: strong and interior constraints hold all three components; for `null` "
               "components and rollers use `enforce: weak` without `interior`",
               c->place);
  LTH_NEW_OR(done, ctx, chosen, body->mesh->n_cells);
  LITHE_TRY_OR(done, lth_select_cells(ctx, body->mesh, &c->where, chosen));
  for (LitheIndex k = 0; k < body->mesh->n_cells; k++) {
    any = any || chosen[k];
    if (chosen[k] && constraint_of[k] < 0) constraint_of[k] = i;
  }
  if (!any)
    status =
        lth_fail(ctx, LITHE_BAD_INPUT,
                 "%s.where: selects no element; the body reaches from (%g, %g, %g) to (%g, %g, %g)",
                 c->place, body->box[0], body->box[1], body->box[2], body->box[3], body->box[4],
                 body->box[5]);

done:
  lth_free(ctx, chosen);
  return status;
}

static LitheStatus build_strong(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LitheIndex *constraint_of = NULL, n = body->def->n_constraints;
  LthStrongMotion *motions = NULL;
  LTH_NEW_OR(done, ctx, constraint_of, body->mesh->n_cells);
  LTH_NEW_OR(done, ctx, motions, n);
  for (LitheIndex k = 0; k < body->mesh->n_cells; k++) constraint_of[k] = -1;
  for (LitheIndex i = 0; i < n; i++) {
    const LthSceneConstraint *c = body->def->constraints + i;
    motions[i].is_position = c->is_position;
    for (int a = 0; a < 3; a++) motions[i].value[a] = c->value[a];
    if (is_strong(c)) LITHE_TRY_OR(done, mark(ctx, body, i, constraint_of));
  }
  LITHE_TRY_OR(done,
               lth_dg_strong_create(ctx, body->space, constraint_of, n, motions, &body->strong));
done:
  lth_free(ctx, constraint_of);
  lth_free(ctx, motions);
  return status;
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
  return any_strong ? build_strong(ctx, body) : LITHE_OK;
}
