/// What the commands of the program share: a context with progress and signals, scenes, messages.
#include "app.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

static LitheCtx *interrupted_ctx;

/// The first Ctrl-C asks the run to stop and leave valid files; a second one kills.
static void on_interrupt(int number) {
  lithe_ctx_cancel(interrupted_ctx); // NOLINT(bugprone-signal-handler): sets an atomic flag
  signal(number, SIG_DFL);
}

static void catch_signals(LitheCtx *ctx) {
  interrupted_ctx = ctx;
  signal(SIGINT, on_interrupt);
  signal(SIGTERM, on_interrupt);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN); // a file beyond the limit is a failed write like any other
}

static void print_scene_errors(const LitheScene *scene) {
  for (LitheIndex i = 0; i < lithe_scene_error_count(scene); i++)
    fprintf(stderr, "%s\n", lithe_scene_error(scene, i));
}

static LitheStatus read_scene(App *app) {
  const Args *args = app->args;
  const char *overrides[ARGS_MAX_SETS + 1];
  char threads[40];
  LitheSceneDef def = lithe_scene_def_default();
  memcpy(overrides, args->sets, sizeof args->sets);
  def.file = args->scene;
  def.overrides = overrides;
  def.n_overrides = args->n_sets;
  def.defects_path = "defects.ply";
  if (args->threads > 0) {
    snprintf(threads, sizeof threads, "solver.threads=%d", args->threads);
    overrides[def.n_overrides++] = threads;
  }
  if (args->resume) return lithe_resume_read(app->ctx, args->resume, &def, &app->scene);
  return lithe_scene_read(app->ctx, &def, &app->scene);
}

LitheStatus app_open_context(App *app, const Args *args) {
  *app = (App){.args = args};
  progress_start(&app->progress, args->quiet);
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = args->threads;
  def.progress = progress_tell;
  def.progress_user = &app->progress;
  app->ctx = lithe_ctx_create(&def);
  if (!app->ctx) return LITHE_NO_MEMORY;
  catch_signals(app->ctx);
  return LITHE_OK;
}

LitheStatus app_open(App *app, const Args *args) {
  LitheStatus status = app_open_context(app, args);
  return status == LITHE_OK ? read_scene(app) : status;
}

static void print_failure(const App *app, LitheStatus status) {
  if (status == LITHE_OK) return;
  if (app->scene && lithe_scene_error_count(app->scene) > 0) {
    print_scene_errors(app->scene);
    return;
  }
  const char *message = app->ctx ? lithe_ctx_message(app->ctx) : "";
  fprintf(stderr, "lithe: %s\n", *message ? message : lithe_status_text(status));
}

int app_close(App *app, LitheStatus status) {
  progress_end(&app->progress);
  if (app->ctx && !app->args->quiet)
    for (LitheIndex i = 0; i < lithe_ctx_warning_count(app->ctx); i++)
      fprintf(stderr, "warning: %s\n", lithe_ctx_warning(app->ctx, i));
  print_failure(app, status);
  if (app->ctx) lithe_scene_destroy(app->ctx, &app->scene);
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
  lithe_ctx_destroy(&app->ctx);

  // a result that could not be printed is a result that is missing
  if (fflush(stdout) != 0 && status == LITHE_OK) {
    fprintf(stderr, "lithe: standard output cannot be written\n");
    status = LITHE_NO_SPACE;
  }
  return lithe_status_exit(status);
}
