/// The state of a simulation as bytes: what the next step depends on, and nothing that it computes anew.
#include "step/simulation_priv.h"

#include <string.h>

/// Totals and the last step's figures; the names of solvers are the next step's.
static void walk_report(LthSimulation *s, LthArchive *a) {
  LthStepReport report = s->report;
  report.linear = report.linear_reason = NULL;
  LTH_ARCHIVE(a, report);
  if (!a->is_reading || a->status != LITHE_OK) return;
  report.linear = s->report.linear;
  report.linear_reason = s->report.linear_reason;
  s->report = report;
}

/// What a multistep integrator remembers. The vectors are there once a step was made.
static void walk_stage(LthSimulation *s, LthArchive *a) {
  LthStage *g = &s->stage;
  lth_archive_mark(a, "stage");
  LTH_ARCHIVE(a, g->has_old);
  LTH_ARCHIVE(a, g->h_old);
  LTH_ARCHIVE(a, g->settles);
  if (!g->has_old || a->status != LITHE_OK || s->options.integrator < LTH_BDF2) return;
  if (a->is_reading) a->status = lth_stage_begin(a->ctx, s);
  if (a->status != LITHE_OK) return;
  if (s->options.integrator == LTH_NEWMARK) {
    LTH_ARCHIVE_ARRAY(a, g->f_old, s->n);
  } else {
    LTH_ARCHIVE_ARRAY(a, g->x_old, s->n);
    LTH_ARCHIVE_ARRAY(a, g->v_old, s->n);
  }
}

static void walk_memory(const LthSystem *system, LthArchive *a) {
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    LthDisc *disc = system->bodies[b].disc;
    if (disc->table->archive) disc->table->archive(disc, a);
  }
  for (LitheIndex c = 0; c < system->n_contacts; c++) lth_contact_archive(system->contacts[c], a);
  for (LitheIndex c = 0; c < system->n_couplings; c++)
    if (system->couplings[c].archive) system->couplings[c].archive(system->couplings[c].self, a);
}

/// What the choice between solvers has learnt (step_choice.c).
static void walk_choice(LthSimulation *s, LthArchive *a) {
  lth_archive_mark(a, "choice");
  LTH_ARCHIVE(a, s->cost);
  LTH_ARCHIVE(a, s->n_tallied);
  LTH_ARCHIVE(a, s->no_lag);
  LTH_ARCHIVE(a, s->no_levels);
  LTH_ARCHIVE(a, s->kept);
  LTH_ARCHIVE(a, s->has_lagged);
  LTH_ARCHIVE(a, s->fresh);
  LTH_ARCHIVE(a, s->stale);
  LTH_ARCHIVE(a, s->fresh_iterations);
  LTH_ARCHIVE(a, s->age);
  LTH_ARCHIVE(a, s->life);
  LTH_ARCHIVE(a, s->age_cost);
  LTH_ARCHIVE(a, s->factor_step);
  LTH_ARCHIVE(a, s->factor_t);
}

/// The matrix as it was at another state, of a step h that led to time t.
static LitheStatus assemble_again(LitheCtx *ctx, LthSimulation *s, const double *x, double t,
                                  double h) {
  memcpy(s->x, x, sizeof *s->x * (size_t)s->n);
  LITHE_TRY(lth_step_assemble(ctx, s, t, s->x));
  lth_step_combine(ctx, s, h > 0 ? 1 : 0, h > 0 ? h * h : 1, h);
  lth_step_constrain(ctx, s);
  return LITHE_OK;
}

/// The kept factor from the state it was made of: assembling and factoring give the same bits again.
static LitheStatus make_factor_again(LitheCtx *ctx, LthSimulation *s) {
  LITHE_TRY(assemble_again(ctx, s, s->factor_x, s->factor_t, s->factor_step));
  if (s->kept == LTH_LINEAR_MULTIGRID) return lth_multilevel_update(ctx, s->levels, s->x, NULL);
  LITHE_TRY(lth_step_analyse(ctx, s));
  return s->engine->factorize(ctx, s->factor, s->A);
}

static void walk_factor(LthSimulation *s, LthArchive *a) {
  if (!s->has_lagged || s->stale) return;
  LTH_ARCHIVE_ARRAY(a, s->factor_x, s->n);
  if (a->is_reading && a->status == LITHE_OK) a->status = make_factor_again(a->ctx, s);
}

/// What contact was when the levels were created, in the place of what it was when they were last updated, and back.
static void swap_touch(LthSimulation *s) {
  if (!s->touch) return;
  double *values = s->touch->values;
  s->touch->values = s->touch_first;
  s->touch_first = values;
}

/// Aggregates and patterns of the levels come from the state in which they were first made.
static void walk_levels(LthSimulation *s, LthArchive *a) {
  bool exist = s->levels != NULL, strong = exist && lth_multilevel_is_strong(s->levels);
  lth_archive_mark(a, "levels");
  LTH_ARCHIVE(a, exist);
  LTH_ARCHIVE(a, strong);
  LTH_ARCHIVE(a, s->levels_step);
  LTH_ARCHIVE(a, s->levels_t);
  if (!exist || a->status != LITHE_OK) return;
  if (a->is_reading && !s->levels_x)
    a->status = lth_new_(a->ctx, (void **)&s->levels_x, s->n, sizeof *s->levels_x);
  if (a->status != LITHE_OK) return;
  LTH_ARCHIVE_ARRAY(a, s->levels_x, s->n);
  LTH_ARCHIVE(a, s->levels_touch);
  lth_step_touch_archive(s, a);
  if (!a->is_reading || a->status != LITHE_OK) return;
  swap_touch(s);
  const double t1 = s->stage.t1;
  a->status = assemble_again(a->ctx, s, s->levels_x, s->levels_t, s->levels_step);
  s->stage.t1 = s->levels_t;
  lth_multilevel_destroy(a->ctx, &s->levels);
  if (a->status == LITHE_OK) a->status = lth_step_create_levels(a->ctx, s, s->levels_step);
  if (a->status == LITHE_OK && strong) lth_multilevel_strengthen(s->levels);
  s->stage.t1 = t1;
  swap_touch(s);
}

/// What solvers keep is made again in s->x, which waits elsewhere.
static void walk_solvers(LthSimulation *s, LthArchive *a) {
  if (s->own) return;
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  if (a->is_reading) memcpy(s->solution, s->x, bytes);
  walk_choice(s, a);
  walk_levels(s, a);
  walk_factor(s, a);
  if (a->is_reading) memcpy(s->x, s->solution, bytes);
}

void lth_simulation_archive(LthSimulation *s, LthArchive *a) {
  lth_archive_mark(a, "simulation");
  LTH_ARCHIVE(a, s->t);
  LTH_ARCHIVE_ARRAY(a, s->x, s->n);
  if (s->v) LTH_ARCHIVE_ARRAY(a, s->v, s->n);
  walk_stage(s, a);
  walk_memory(s->system, a);
  lth_fade_archive(s, a);
  walk_solvers(s, a);
  LTH_ARCHIVE_ARRAY(a, s->held_force, s->n_held);
  LTH_ARCHIVE_ARRAY(a, s->f_ext, s->n); // the work of the next equilibrium begins with it
  walk_report(s, a);
}
