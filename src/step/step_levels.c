/// The multilevel preconditioner of a simulation: made once, its coarse levels kept over some steps.
#include "step/simulation_priv.h"

#include <string.h>

LitheStatus lth_step_create_levels(LitheCtx *ctx, LthSimulation *s, double h) {
  LthMultilevelDef def = {
      .A = s->A, .one = s->system->one, .position = s->x, .n_linear = LTH_STEP_LINEAR};
  if (!s->levels_x) LTH_NEW(ctx, s->levels_x, s->n);
  if (!s->levels_extra && s->has_contact) LTH_NEW(ctx, s->levels_extra, s->n_extra);
  LITHE_TRY(lth_multilevel_create(ctx, &def, &s->levels));
  memcpy(s->levels_x, s->x, sizeof *s->x * (size_t)s->n);
  s->levels_step = h;
  s->levels_t = s->stage.t1;
  s->levels_touch = false;
  return LITHE_OK;
}

/// Contact's part of the diagonal blocks, or NULL.
static const double *contact_part(LthSimulation *s) {
  if (!s->contact_on) return NULL;
  lth_step_contact_diagonal(s, s->extra);
  return s->extra;
}

LitheStatus lth_step_update_levels(LitheCtx *ctx, LthSimulation *s) {
  const double *extra = contact_part(s);
  s->levels_touch = extra != NULL;
  if (extra) memcpy(s->levels_extra, extra, sizeof *extra * (size_t)s->n_extra);
  return lth_multilevel_update(ctx, s->levels, s->x, extra);
}

LitheStatus lth_step_refresh(LitheCtx *ctx, LthSimulation *s) {
  if (s->own) return LITHE_OK;
  if (s->solver == LTH_LINEAR_MULTIGRID)
    return lth_multilevel_refresh(ctx, s->levels, contact_part(s));
  if (s->solver == LTH_LINEAR_PCG)
    return lth_block_jacobi_update(ctx, s->jacobi, s->A, contact_part(s));
  return LITHE_OK;
}
