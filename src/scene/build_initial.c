/// Where a body starts: initial velocity and displacement, projected onto its space.
#include "scene/body.h"

/// Three values as a vector field at t = 0.
static void initial_field(const void *self, const double x[3], double value[3]) {
  const LthValue *v = self;
  for (int a = 0; a < 3; a++) value[a] = lth_value_at(v + a, x, 0);
}

static bool is_zero(const LthValue v[3]) {
  for (int a = 0; a < 3; a++)
    if (v[a].eval || v[a].constant != 0) return false;
  return true;
}

LitheStatus lth_build_initial(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  const LthDisc *disc = body->disc;
  double *v = lth_body_velocity(body);
  if (v && !is_zero(def->initial_velocity))
    LITHE_TRY(disc->table->project(ctx, disc, initial_field, def->initial_velocity, v));
  if (is_zero(def->initial_displacement)) return LITHE_OK;
  double *u = NULL, *x = lth_body_position(body);
  LTH_NEW(ctx, u, disc->n_dofs);
  LitheStatus status = disc->table->project(ctx, disc, initial_field, def->initial_displacement, u);
  for (LitheCount i = 0; status == LITHE_OK && i < disc->n_dofs; i++) x[i] += u[i];
  lth_free(ctx, u);
  return status;
}
