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
  const LthDgSpace *space = body->space;
  int quad_degree = 2 * space->max_degree + 2;
  if (!is_zero(def->initial_velocity))
    LITHE_TRY(lth_dg_project(ctx, space, initial_field, def->initial_velocity, quad_degree,
                             lth_simulation_velocity(body->sim)));
  if (is_zero(def->initial_displacement)) return LITHE_OK;
  double *u = NULL, *x = lth_simulation_position(body->sim);
  LTH_NEW(ctx, u, space->n_dofs);
  LitheStatus status =
      lth_dg_project(ctx, space, initial_field, def->initial_displacement, quad_degree, u);
  for (LitheCount i = 0; status == LITHE_OK && i < space->n_dofs; i++) x[i] += u[i];
  lth_free(ctx, u);
  return status;
}
