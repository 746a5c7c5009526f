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

/// The kept factor from the state it was made of: assembling and factoring give the same bits again.
static LitheStatus make_factor_again(LitheCtx *ctx, LthSimulation *s) {
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  double *x = s->solution; // where the state waits
  memcpy(x, s->x, bytes);
  memcpy(s->x, s->factor_x, bytes);
  LitheStatus status = lth_step_analyse(ctx, s);
  if (status == LITHE_OK) status = lth_step_assemble(ctx, s, s->factor_t, s->x);
  if (status == LITHE_OK) {
    lth_step_combine(ctx, s, 1, s->factor_step * s->factor_step, s->factor_step);
    lth_step_constrain(ctx, s);
    status = s->engine->factorize(ctx, s->factor, s->A);
  }
  memcpy(s->x, x, bytes);
  return status;
}

static void walk_factor(LthSimulation *s, LthArchive *a) {
  if (!s->has_lagged || s->stale) return;
  LTH_ARCHIVE_ARRAY(a, s->factor_x, s->n);
  if (a->is_reading && a->status == LITHE_OK) a->status = make_factor_again(a->ctx, s);
}

void lth_simulation_archive(LthSimulation *s, LthArchive *a) {
  lth_archive_mark(a, "simulation");
  LTH_ARCHIVE(a, s->t);
  LTH_ARCHIVE_ARRAY(a, s->x, s->n);
  LTH_ARCHIVE_ARRAY(a, s->v, s->n);
  walk_stage(s, a);
  walk_memory(s->system, a);
  walk_choice(s, a);
  walk_factor(s, a);
  if (s->held_force) LTH_ARCHIVE_ARRAY(a, s->held_force, s->n);
  LTH_ARCHIVE_ARRAY(a, s->f_ext, s->n); // the work of the next equilibrium begins with it
  walk_report(s, a);
}
