/// A simulation that goes on in the place of another, when a body's unknowns are others than before.
#include "step/simulation_priv.h"

/// Only the two-step rule needs fields of the past. Newmark's forces belong to the old functions, and are found anew.
static LitheStatus move_stage(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from,
                              LthFieldMove *move, const void *self) {
  const LthStage *g = &from->stage;
  if (!g->has_old || s->options.integrator != LTH_BDF2) return LITHE_OK;
  LITHE_TRY(lth_stage_begin(ctx, s));
  LITHE_TRY(move(ctx, self, g->x_old, s->stage.x_old));
  LITHE_TRY(move(ctx, self, g->v_old, s->stage.v_old));
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
                                   LthFieldMove *move, const void *self) {
  s->t = from->t;
  s->report = from->report;
  LITHE_TRY(move(ctx, self, from->x, s->x));
  LITHE_TRY(move(ctx, self, from->v, s->v));
  LITHE_TRY(move_stage(ctx, s, from, move, self));
  LITHE_TRY(lth_fade_inherit(ctx, s, from, move, self));
  return find_forces(ctx, s, from);
}
