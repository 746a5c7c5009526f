/// A simulation that goes on in the place of another, when a body's unknowns are others than before.
#include "step/simulation_priv.h"

static LitheStatus move_motion(LitheCtx *ctx, const LthStateMove *move, const double *x_from,
                               const double *v_from, double *x, double *v) {
  LITHE_TRY(move->field(ctx, move->self, x_from, x));
  LITHE_TRY(move->field(ctx, move->self, v_from, v));
  return move->motion(ctx, move->self, x_from, v_from, x, v);
}

/// Only the two-step rule needs fields of the past. Newmark's forces belong to the old functions, and are found anew.
static LitheStatus move_stage(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from,
                              const LthStateMove *move) {
  const LthStage *g = &from->stage;
  if (!g->has_old || s->options.integrator != LTH_BDF2) return LITHE_OK;
  LITHE_TRY(lth_stage_begin(ctx, s));
  LITHE_TRY(move_motion(ctx, move, g->x_old, g->v_old, s->stage.x_old, s->stage.v_old));
  s->stage.h_old = g->h_old;
  s->stage.has_old = true;
  return LITHE_OK;
}

/// What the work of the next step begins with: the forces of now, once a step was made.
static LitheStatus find_forces(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from) {
  bool any = false;
  for (LitheCount i = 0; i < from->n && !any; i++) any = from->f_ext[i] != 0;
  if (any) LITHE_TRY(lth_fade_external_force(ctx, s, s->t));
  for (LitheCount i = 0; i < from->n_held && !any; i++) any = from->held_force[i] != 0;
  if (!any || s->n_held == 0) return LITHE_OK;
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  for (LitheCount i = 0, k = 0; i < s->n; i++)
    if (s->system->held[i]) s->held_force[k++] = -s->force[i];
  return LITHE_OK;
}

LitheStatus lth_simulation_inherit(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from,
                                   const LthStateMove *move) {
  s->t = from->t;
  s->report = from->report;
  if (from->v) {
    LITHE_TRY(move_motion(ctx, move, from->x, from->v, s->x, s->v));
  } else {
    LITHE_TRY(move->field(ctx, move->self, from->x, s->x));
  }
  LITHE_TRY(move_stage(ctx, s, from, move));
  LITHE_TRY(lth_fade_inherit(ctx, s, from, move->field, move->self));
  return find_forces(ctx, s, from);
}

void lth_simulation_settle(LthSimulation *s) {
  s->stage.settles = s->options.integrator == LTH_NEWMARK;
}
