/// The multilevel preconditioner of a simulation: made once, its coarse levels kept over some steps.
#include "step/simulation_priv.h"

#include <string.h>

LitheStatus lth_step_create_levels(LitheCtx *ctx, LthSimulation *s, double h) {
  LthMultilevelDef def = {.A = s->A,
                          .one = s->system->one,
                          .position = s->x,
                          .n_linear = LTH_STEP_LINEAR,
                          .touch = s->touch};
  if (!s->levels_x) LTH_NEW(ctx, s->levels_x, s->n);
  LITHE_TRY(lth_multilevel_create(ctx, &def, &s->levels));
  memcpy(s->levels_x, s->x, sizeof *s->x * (size_t)s->n);
  s->levels_step = h;
  s->levels_t = s->stage.t1;
  return LITHE_OK;
}

/// Contact's part of the diagonal blocks, or NULL.
static const double *contact_part(LthSimulation *s) {
  if (!s->contact_on) return NULL;
  lth_step_contact_diagonal(s, s->extra);
  return s->extra;
}

static void apply_contact(const void *self, int threads, const double *x, double *y) {
  const LthSimulation *s = self;
  (void)threads;
  lth_step_contact_apply(s, x, y);
  lth_system_zero_held(s->system, y);
}

/// The finest level's residuals have contact itself.
static void add_contact(LthSimulation *s) {
  LthOperator C = {.n = s->n, .apply = apply_contact, .self = s};
  lth_multilevel_add(s->levels, s->contact_on ? &C : NULL);
}

LitheStatus lth_step_update_levels(LitheCtx *ctx, LthSimulation *s) {
  add_contact(s);
  return lth_multilevel_update(ctx, s->levels, s->x, contact_part(s));
}

LitheStatus lth_step_make_levels(LitheCtx *ctx, LthSimulation *s, double h) {
  bool fits = true;
  s->levels_touch = s->contact_on;
  if (s->contact_on)
    LITHE_TRY(lth_step_lump_contact(ctx, s, &fits));
  else if (s->touch)
    lth_step_clear_touch(s);
  if (!fits) {
    bool strong = s->levels && lth_multilevel_is_strong(s->levels);
    lth_multilevel_destroy(ctx, &s->levels);
    memcpy(s->touch_first, s->touch->values,
           sizeof *s->touch_first * (size_t)lth_step_touch_values(s));
    LITHE_TRY(lth_step_create_levels(ctx, s, h));
    if (strong) lth_multilevel_strengthen(s->levels);
  } else if (!s->levels) {
    LITHE_TRY(lth_step_create_levels(ctx, s, h));
    if (!s->contact_on) return LITHE_OK;
  }
  return lth_step_update_levels(ctx, s);
}

LitheStatus lth_step_refresh(LitheCtx *ctx, LthSimulation *s) {
  if (s->own) return LITHE_OK;
  if (s->solver == LTH_LINEAR_MULTIGRID) {
    if (s->contact_on && lth_step_outgrows_levels(s)) {
      LITHE_TRY(lth_step_make_levels(ctx, s, s->factor_step));
      lth_step_date_factor(s, s->factor_step);
      return LITHE_OK;
    }
    add_contact(s);
    return lth_multilevel_refresh(ctx, s->levels, contact_part(s));
  }
  if (s->solver == LTH_LINEAR_PCG)
    return lth_block_jacobi_update(ctx, s->jacobi, s->A, contact_part(s));
  return LITHE_OK;
}
