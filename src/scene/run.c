/// Running a scene from its first to its last step, and the result that remains.
#include "lithe/run.h"

#include "io/file.h"
#include "io/matrix_market.h"
#include "scene/adapt.h"
#include "scene/change.h"
#include "scene/checkpoint.h"
#include "scene/cut.h"
#include "scene/result.h"
#include "scene/run_look.h"
#include "scene/scene_public.h"

#include <math.h>
#include <string.h>

#define SMALL_UNKNOWNS 3000
#define SMALL_POINTS 5000

struct LitheResult {
  char *folder, *json;
  LitheRunSummary summary;
};

const char *lithe_result_json(const LitheResult *result) {
  return result->json ? result->json : "";
}
const char *lithe_result_folder(const LitheResult *result) { return result->folder; }
LitheRunSummary lithe_result_summary(const LitheResult *result) { return result->summary; }

void lithe_result_destroy(LitheCtx *ctx, LitheResult **result) {
  if (!*result) return;
  lth_free(ctx, (*result)->folder);
  lth_free(ctx, (*result)->json);
  lth_free(ctx, *result);
  *result = NULL;
}

/// Everything that a run holds while it runs.
typedef struct Run {
  const LthScene *scene;
  const char *folder;
  LthWorld *world;
  LthSchedule schedule;
  LthOutput out;
  LthTimes times;
  double start;
  LthCheckpoint checkpoint;
  LthResume *resume;      ///< or NULL: from the beginning
  LthPlace place;         ///< of the step that comes
  const LthRunLook *look; ///< or NULL
  char reason[400];       ///< why a step found no solution, where it said so
} Run;

static LitheStatus write_frame(LitheCtx *ctx, Run *run) {
  LITHE_TRY(lth_output_frame(ctx, &run->out, run->world));
  if (!run->look) return LITHE_OK;
  return run->look->look(run->look->user, ctx, run->world, run->out.n_frames - 1);
}

static LitheStatus renew_output(LitheCtx *ctx, Run *run) {
  LITHE_TRY(lth_output_renew(ctx, &run->out, run->world));
  lth_world_cost_add(run->world, LTH_COST_OUTPUT);
  return LITHE_OK;
}

/// Cuts that are due before the step to the time `to`.
static LitheStatus change(LitheCtx *ctx, Run *run, double to) {
  bool changed;
  LITHE_TRY(lth_world_cut_due(ctx, run->world, to, &changed));
  return changed ? renew_output(ctx, run) : LITHE_OK;
}

/// Look at the elements after a solve that led `dt` on (0: equilibrium). `*changed`: they are others now.
static LitheStatus adapt(LitheCtx *ctx, Run *run, double dt, int round, bool *changed) {
  LITHE_TRY(lth_adapt_look(ctx, run->world, dt, round, changed));
  return *changed ? renew_output(ctx, run) : LITHE_OK;
}

/// A step to the time `to`. An expression that came out undefined is bad input, whatever the solver made
/// of it.
static LitheStatus step(LitheCtx *ctx, Run *run, double dt, double to) {
#ifdef LITHE_ASSERTS
  const bool is_renewed = run->world->cost.waits;
#endif
  double factor = lth_simulation_report(run->world->sim)->processor_factor;
  LitheStatus status = run->schedule.kind == LTH_TIME_DYNAMIC
                           ? lth_simulation_step(ctx, run->world->sim, dt)
                           : lth_simulation_equilibrium(ctx, run->world->sim, to);
  lth_world_cost_tell(run->world,
                      lth_simulation_report(run->world->sim)->processor_factor - factor);
#ifdef LITHE_ASSERTS
  if (is_renewed && status == LITHE_OK)
    LITHE_TRY(lth_simulation_check_matrix(ctx, run->world->sim));
#endif
  if (status == LITHE_NOT_CONVERGED)
    snprintf(run->reason, sizeof run->reason, "%s", lithe_ctx_message(ctx));
  if (status == LITHE_OK || status == LITHE_NOT_CONVERGED)
    LITHE_TRY(lth_scene_check_values(ctx, run->scene));
  return status;
}

/// A step and what follows from it for the elements: equilibria are solved again until these stay as they are.
static LitheStatus step_and_adapt(LitheCtx *ctx, Run *run, double dt, double to) {
  bool is_dynamic = run->schedule.kind == LTH_TIME_DYNAMIC, changed = true;
  LITHE_TRY(lth_adapt_before_step(ctx, run->world));
  for (int round = 0; changed; round++) {
    LITHE_TRY(step(ctx, run, dt, to));
    LITHE_TRY(adapt(ctx, run, is_dynamic ? dt : 0, round, &changed));
    if (is_dynamic) break;
  }
  return LITHE_OK;
}

/// To the next output time.
static LitheStatus advance(LitheCtx *ctx, Run *run) {
  const LthSchedule *s = &run->schedule;
  const LitheIndex k = run->place.output;
  double begin = k > 1 ? lth_schedule_time(s, k - 1) : 0, end = lth_schedule_time(s, k);
  LitheCount n = lth_schedule_steps(s, k);
  for (; run->place.step < n; run->place.step++) {
    double i = (double)run->place.step, done = begin + (end - begin) * i / (double)n;
    LITHE_TRY(lth_checkpoint_take(ctx, &run->checkpoint, run->place, run->world, &run->out));
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    lth_progress(ctx, "simulating", s->duration > 0 ? done / s->duration : -1);
    double dt = (end - begin) / (double)n;
    LITHE_TRY(change(ctx, run, begin + dt * (i + 1)));
    LITHE_TRY(step_and_adapt(ctx, run, dt, begin + dt * (i + 1)));
  }
  lth_simulation_set_time(run->world->sim, end);
  return LITHE_OK;
}

static LitheStatus go_on(LitheCtx *ctx, Run *run) {
  if (!run->resume && run->schedule.writes_start) LITHE_TRY(write_frame(ctx, run));
  for (; run->place.output <= run->schedule.n_outputs; run->place.output++) {
    LITHE_TRY(advance(ctx, run));
    LITHE_TRY(write_frame(ctx, run));
    run->place.step = 0;
  }
  return lth_simulation_report(run->world->sim)->converged ? LITHE_OK : LITHE_NOT_CONVERGED;
}

static LitheStatus simulate(LitheCtx *ctx, Run *run) {
  LitheStatus status = go_on(ctx, run);
  if (status != LITHE_INTERRUPTED || !run->checkpoint.scene) return status;
  LITHE_TRY(lth_checkpoint_write_last(ctx, &run->checkpoint));
  return lth_fail(ctx, status, "interrupted; `lithe run --resume %s` goes on from here",
                  run->folder);
}

/// Condition number and matrix file, where the scene asks for them.
static LitheStatus study_matrix(LitheCtx *ctx, const Run *run, const char *folder,
                                double *condition) {
  const LthBlockMatrix *K = lth_simulation_matrix(run->world->sim);
  *condition = NAN;
  if (run->scene->export_path) {
    char *path;
    LITHE_TRY(lth_path_join(ctx, folder, run->scene->export_path, &path));
    LitheStatus status = lth_matrix_market_write(ctx, path, K);
    lth_free(ctx, path);
    LITHE_TRY(status);
  }
  return run->scene->condition ? lth_simulation_condition(ctx, run->world->sim, condition)
                               : LITHE_OK;
}

static LitheStatus write_json(LitheCtx *ctx, const LitheResult *result) {
  LthFileWriter writer;
  char *path;
  LITHE_TRY(lth_path_join(ctx, result->folder, "result.json", &path));
  LitheStatus status = lth_file_open(ctx, path, &writer);
  if (status == LITHE_OK) {
    fputs(result->json, writer.stream);
    status = lth_file_commit(ctx, &writer);
  }
  lth_free(ctx, path);
  return status;
}

static void summarise(const Run *run, LitheResult *result) {
  const LthStepReport *report = lth_simulation_report(run->world->sim);
  for (LitheIndex b = 0; b < run->world->n_bodies; b++) {
    result->summary.elements += lth_body_elements(run->world->bodies[b]);
    result->summary.unknowns += lth_body_unknowns(run->world->bodies[b]);
  }
  result->summary.frames = run->out.n_frames;
  result->summary.simulated = lth_simulation_time(run->world->sim);
  result->summary.penetration = report->penetration;
  result->summary.converged = report->converged;
  result->summary.seconds = run->times.total;
}

/// What is worth telling about a run that ended, ended early or did not converge.
static LitheStatus conclude(LitheCtx *ctx, Run *run, LitheStatus status, LitheResult *result) {
  LthResultInput input = {
      .world = run->world, .probes = run->out.probes, .out = &run->out, .status = status};
  LITHE_TRY(study_matrix(ctx, run, result->folder, &input.condition));
  run->times.output = run->out.seconds;
  run->times.total = run->times.read + lth_now() - run->start;
  input.times = run->times;
  LITHE_TRY(lth_result_text(ctx, &input, &result->summary, &result->json));
  LITHE_TRY(lth_scene_check_values(ctx, run->scene)); // of `exact`
  summarise(run, result);
  return LITHE_OK;
}

static LitheStatus name_folder(LitheCtx *ctx, const LthScene *scene, const char *folder,
                               char **name) {
  if (!folder) return lth_path_join(ctx, "out", scene->name, name);
  return lth_copy_text(ctx, folder, name);
}

/// A status whose files are whole and worth a result.json.
static bool has_result(LitheStatus status) {
  return status == LITHE_OK || status == LITHE_NOT_CONVERGED || status == LITHE_INTERRUPTED;
}

/// A small body is done with a loop before a second thread wakes, which on a busy machine takes long. Results do
/// not depend on it.
static void spare_threads(LitheCtx *ctx, const LthWorld *world) {
  LitheCount points = 0;
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (world->bodies[b]->soup) points += world->bodies[b]->soup->n_points;
  if (world->system->n < SMALL_UNKNOWNS && points < SMALL_POINTS) lth_set_threads(ctx, 1);
}

/// Everything built, and the state that a checkpoint holds put into it: nothing of an earlier run is touched
/// before that has come out well.
static LitheStatus build(LitheCtx *ctx, Run *run) {
  double spent[2];
  uint64_t inputs = lth_inputs(ctx);
  LITHE_TRY(lth_world_create(ctx, run->scene, spent, &run->world));
  if (run->scene->threads == 0) spare_threads(ctx, run->world);
  LITHE_TRY(lth_scene_check_values(ctx, run->scene));
  run->times.mesh = spent[0];
  run->times.integrate = spent[1];
  uint64_t digest = run->scene->digest + (lth_inputs(ctx) - inputs);
  LITHE_TRY(lth_checkpoint_open(ctx, run->scene, run->folder, digest, &run->checkpoint));
  run->place = (LthPlace){.output = 1};
  if (!run->resume) return LITHE_OK;
  LITHE_TRY(lth_resume_check(ctx, run->resume, digest));
  LITHE_TRY(lth_resume_world(ctx, run->resume, run->world));
  run->place = run->resume->place;
  return LITHE_OK;
}

static LitheStatus open_output(LitheCtx *ctx, Run *run) {
  LITHE_TRY(lth_output_open(ctx, run->folder, run->world, &run->schedule, run->resume != NULL,
                            &run->out));
  return run->resume ? lth_resume_output(ctx, run->resume, &run->out) : LITHE_OK;
}

/// An equilibrium in which pieces may lie on others without anything that keeps them from sliding.
static bool may_slide(const Run *run) {
  bool in_pieces = run->world->n_bodies > 1;
  for (LitheIndex b = 0; b < run->world->n_bodies; b++)
    in_pieces |= run->world->bodies[b]->n_parts > 1;
  const LthScene *scene = run->scene;
  return scene->time_kind != LTH_TIME_DYNAMIC && !(scene->contact_friction > 0) &&
         (in_pieces || scene->n_colliders > 0);
}

static LitheStatus run_scene(LitheCtx *ctx, Run *run, LitheResult *result) {
  LITHE_TRY(build(ctx, run));
  LitheStatus status = open_output(ctx, run);
  if (status == LITHE_OK) status = simulate(ctx, run);
  if (has_result(status)) {
    LitheStatus concluded = conclude(ctx, run, status, result);
    if (concluded != LITHE_OK) status = concluded;
  }
  LitheStatus closed = lth_output_close(ctx, &run->out);
  if (closed != LITHE_OK && has_result(status)) status = closed;

  // last of all: a result.json stands only beside files that are whole
  if (has_result(status)) {
    LitheStatus written = write_json(ctx, result);
    if (written != LITHE_OK) status = written;
  }
  if (status == LITHE_NOT_CONVERGED && run->reason[0])
    lth_fail(ctx, status, "%s: %s; %s/result.json has the figures", run->scene->file, run->reason,
             result->folder);
  else if (status == LITHE_NOT_CONVERGED)
    lth_fail(ctx, status,
             "%s: a solve did not converge; %s/result.json has the figures. What helps: smaller "
             "steps of time or load, more solver.newton.iterations, solver.linear: cholesky%s",
             run->scene->file, result->folder,
             may_slide(run) ? ", and contact.friction or a constraint for what lies on something "
                              "else and may slide off without an end"
                            : "");
  return status;
}

static LitheStatus start(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                         LthResume *resume, const LthRunLook *look, LitheResult **result) {
  Run run = {.scene = scene->scene, .start = lth_now(), .resume = resume, .look = look};
  LTH_NEW(ctx, *result, 1);
  LITHE_TRY(name_folder(ctx, run.scene, folder, &(*result)->folder));
  run.folder = (*result)->folder;
  int threads = lth_threads(ctx);
  if (run.scene->threads > 0) lth_set_threads(ctx, run.scene->threads);
  run.times.read = scene->read_seconds;
  run.schedule = lth_schedule_make(run.scene);
  LitheStatus status = run_scene(ctx, &run, *result);
  lth_checkpoint_close(ctx, &run.checkpoint);
  lth_world_destroy(ctx, &run.world);
  lth_set_threads(ctx, threads);
  return status;
}

LitheStatus lithe_run(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                      LitheResult **result) {
  return start(ctx, scene, folder, NULL, NULL, result);
}

LitheStatus lth_run_looked_at(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                              const LthRunLook *look, LitheResult **result) {
  return start(ctx, scene, folder, NULL, look, result);
}

LitheStatus lithe_resume(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                         LitheResult **result) {
  LthResume resume;
  LitheStatus status = lth_resume_open(ctx, folder, &resume);
  if (status == LITHE_OK) status = start(ctx, scene, folder, &resume, NULL, result);
  lth_resume_close(ctx, &resume);
  return status;
}

/// The overrides of the run and those of `def` behind them.
static LitheStatus read_again(LitheCtx *ctx, const LthResume *resume, const LitheSceneDef *def,
                              LitheScene **scene) {
  const char **overrides = NULL;
  LitheCount n = resume->n_overrides;
  LTH_NEW(ctx, overrides, n + def->n_overrides);
  for (LitheCount i = 0; i < n; i++) overrides[i] = resume->overrides[i];
  for (int i = 0; i < def->n_overrides; i++) overrides[n + i] = def->overrides[i];
  LitheSceneDef again = *def;
  again.file = resume->scene_path;
  again.overrides = overrides;
  again.n_overrides = (int)n + def->n_overrides;
  LitheStatus status = lithe_scene_read(ctx, &again, scene);
  if (status == LITHE_OK) status = lth_scene_rename(ctx, (*scene)->scene, resume->scene_file);
  lth_free(ctx, overrides);
  return status;
}

LitheStatus lithe_resume_read(LitheCtx *ctx, const char *folder, const LitheSceneDef *def,
                              LitheScene **scene) {
  LthResume resume;
  *scene = NULL;
  LitheStatus status = lth_resume_open(ctx, folder, &resume);
  if (status == LITHE_OK) status = read_again(ctx, &resume, def, scene);
  lth_resume_close(ctx, &resume);
  return status;
}
