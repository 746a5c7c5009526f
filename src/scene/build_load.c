/// Loads of a scene -> loads on boundary patches, at nodes and in the volume.
#include "scene/boundary_parts.h"
#include "scene/change.h"

#include <string.h>

static LthLoad load_from(const LthSceneLoad *from) {
  LthLoad load = {.kind = from->kind, .follower = from->follower};
  memcpy(load.value, from->value, sizeof load.value);
  memcpy(load.stress, from->stress, sizeof load.stress);
  return load;
}

static LitheStatus add_load(LitheCtx *ctx, LthBody *body, const LthLoad *load) {
  LTH_RESERVE(ctx, body->loads, body->cap_loads, body->n_loads + 1);
  body->loads[body->n_loads++] = *load;
  return LITHE_OK;
}

/// Nothing of a load is left on a part: the support takes all of it (or it is zero).
static bool is_taken(const LthLoad *load, const LthBoundaryPart *part) {
  if (load->kind == LTH_LOAD_PRESSURE) return part->blocked_normal && !load->follower;
  if (load->kind == LTH_LOAD_STRESS) return false;
  for (int a = 0; a < 3; a++)
    if (!part->blocked[a] && (load->value[a].eval || load->value[a].constant != 0)) return false;
  return true;
}

/// What acts of a load on boundary: nothing where a constraint holds it, and only the free components where it
/// is held in part. The weak form has the traction of held components as an unknown of its own there; a load
/// beside it would be an error of consistency. (Strong constraints hold whole elements: their unknowns take no
/// force, wherever it acts.)
static LitheStatus add_parts(LitheCtx *ctx, LthBody *body, const LthSceneLoad *from,
                             const LthBoundaryParts *parts) {
  LitheIndex before = body->n_loads;
  double area = 0;
  for (LitheCount i = 0; i < parts->n; i++)
    for (LitheIndex p = 0; p < parts->items[i].patches->n; p++)
      area += parts->items[i].patches->area[p];
  for (LitheCount i = 0; i < parts->n; i++) {
    const LthBoundaryPart *part = parts->items + i;
    LthLoad load = load_from(from);
    load.patches = part->patches;
    memcpy(load.blocked, part->blocked, sizeof load.blocked);
    load.blocked_normal = part->blocked_normal;
    load.area = area;
    if (!is_taken(&load, part)) LITHE_TRY(add_load(ctx, body, &load));
  }
  static const LthBoundaryPart nothing_held = {0};
  LthLoad whole = load_from(from);
  bool is_loss;
  if (body->n_loads > before || (parts->n > 0 && is_taken(&whole, &nothing_held))) return LITHE_OK;
  LITHE_TRY(lth_body_lose(ctx, body, from->place, &is_loss));
  if (is_loss) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects only boundary that a constraint holds, where a load has no effect; "
             "select more, or hold less",
             from->place);
}

static LitheStatus build_boundary(LitheCtx *ctx, LthBody *body, const LthSceneLoad *from,
                                  LitheIndex n_weak, const LitheIndex *weak) {
  LthBoundaryParts parts;
  LitheStatus status =
      lth_boundary_divide(ctx, body, from->place, &from->where, n_weak, weak, &parts);
  if (status == LITHE_OK) status = add_parts(ctx, body, from, &parts);
  lth_free(ctx, parts.items);
  return status;
}

LitheStatus lth_build_loads(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  const LthSceneBody *def = body->def;
  LitheIndex *weak = NULL, n_weak = 0;
  LTH_NEW_OR(done, ctx, weak, def->n_constraints);
  LTH_NEW_OR(done, ctx, body->places, def->n_loads);
  for (LitheIndex i = 0; i < def->n_constraints; i++)
    if (!lth_is_strong(def->constraints + i)) weak[n_weak++] = i;
  for (LitheIndex i = 0; i < def->n_loads; i++) {
    const LthSceneLoad *from = def->loads + i;
    LthLoad load = load_from(from);
    bool at_nodes = from->kind == LTH_LOAD_POINT_FORCE;
    if (at_nodes) LITHE_TRY_OR(done, lth_build_places(ctx, body, from, body->places + i));
    load.places = body->places[i];
    if (at_nodes && !load.places) continue; // lost
    if (at_nodes || from->kind == LTH_LOAD_BODY_FORCE)
      LITHE_TRY_OR(done, add_load(ctx, body, &load));
    else
      LITHE_TRY_OR(done, build_boundary(ctx, body, from, n_weak, weak));
  }
done:
  lth_free(ctx, weak);
  return status;
}
