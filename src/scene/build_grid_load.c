/// Loads of staggered bodies: what they select is asked at boundary points.
#include "scene/staggered_body.h"

#include <string.h>

static bool selects(const void *self, const double point[3], const double normal[3]) {
  const LthWhereSolid *where = self;
  const LthPlace place = lth_place_at_boundary(point, normal);
  return lth_where_solid_contains(where, &place);
}

/// Act once, to hear what is wrong while it is known which load it is.
static LitheStatus try_load(LitheCtx *ctx, const LthBody *body, const LthSceneLoad *from,
                            const LthLoad *load) {
  const double *box = body->box;
  double *f = NULL;
  LTH_NEW(ctx, f, body->disc->n_dofs);
  LitheStatus status = lth_disc_add_load(ctx, body->disc, load, 0, NULL, f);
  lth_free(ctx, f);
  if (status != LITHE_BAD_INPUT) return status;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects nothing of the body's boundary that is not held; the body reaches "
             "from (%g, %g, %g) to (%g, %g, %g)",
             from->place, box[0], box[1], box[2], box[3], box[4], box[5]);
}

static LitheStatus add(LitheCtx *ctx, LthBody *body, LitheIndex i) {
  const LthSceneLoad *from = body->def->loads + i;
  LthWhereSolid *where = body->staggered->load_where + i;
  LthLoad load = {.kind = from->kind, .follower = from->follower};
  memcpy(load.value, from->value, sizeof load.value);
  memcpy(load.stress, from->stress, sizeof load.stress);
  if (from->kind == LTH_LOAD_POINT_FORCE)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s.point_force: a grid has no nodes on the boundary to act on; expected "
               "total_force on a small patch",
               from->place);
  if (from->kind != LTH_LOAD_BODY_FORCE) {
    body->staggered->n_loads = i + 1;
    LITHE_TRY(lth_staggered_where(ctx, body, &from->where, true, where));
    load.selects = selects;
    load.select_self = where;
    LITHE_TRY(try_load(ctx, body, from, &load));
  }
  LTH_RESERVE(ctx, body->loads, body->cap_loads, body->n_loads + 1);
  body->loads[body->n_loads++] = load;
  return LITHE_OK;
}

LitheStatus lth_build_grid_loads(LitheCtx *ctx, LthBody *body) {
  LTH_NEW(ctx, body->staggered->load_where, body->def->n_loads);
  for (LitheIndex i = 0; i < body->def->n_loads; i++) LITHE_TRY(add(ctx, body, i));
  return LITHE_OK;
}
