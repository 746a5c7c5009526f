/// `lithe study`: figures and tables of papers and the validation book computed anew; sweeps of a scene.
/// `lithe verify`: one scene by all methods.
#include "app.h"

#include <stdio.h>

static void print_list(void) {
  printf("Studies (lithe study NAME; a group such as validation; all):\n");
  for (LitheIndex i = 0; i < lithe_study_count(); i++)
    printf("  %-24s %s\n", lithe_study_name(i), lithe_study_title(i));
  printf("\nA table with observed orders: lithe study SCENE --sweep "
         "bodies.0.method.cells=8,16,32\n");
}

/// Reports come while later parts still run.
static void tell(void *user, const char *text) {
  App *app = user;
  progress_end(&app->progress);
  fputs(text, stdout);
  fputc('\n', stdout);
  fflush(stdout);
}

/// Values of the command line as overrides of every scene; returns how many.
static int list_overrides(const Args *args, const char **overrides, char *threads, size_t size) {
  int n = 0;
  for (; n < args->n_sets; n++) overrides[n] = args->sets[n];
  if (args->threads <= 0) return n;
  snprintf(threads, size, "solver.threads=%d", args->threads);
  overrides[n++] = threads;
  return n;
}

static LitheStudyDef define(const Args *args, App *app) {
  LitheStudyDef def = lithe_study_def_default();
  def.name = args->scene;
  def.folder = args->out;
  def.quick = args->quick;
  def.sweeps = args->sweeps;
  def.n_sweeps = args->n_sweeps;
  if (!args->json && !args->quiet) def.tell = tell;
  def.tell_user = app;
  return def;
}

static int finish(const Args *args, App *app, LitheStatus status, LitheStudyResult **result) {
  progress_end(&app->progress);
  if (*result && (status == LITHE_OK || status == LITHE_FAILED)) {
    if (args->json)
      fputs(lithe_study_result_json(*result), stdout);
    else if (!args->quiet)
      printf("page  %s/index.html\n", lithe_study_result_folder(*result));
  }
  if (app->ctx) lithe_study_result_destroy(app->ctx, result);
  return app_close(app, status);
}

int cmd_study(const Args *args) {
  App app;
  LitheStudyResult *result = NULL;
  const char *overrides[ARGS_MAX_SETS + 1];
  char threads[40];
  if (!args->scene) {
    print_list();
    return fflush(stdout) == 0 ? 0 : lithe_status_exit(LITHE_NO_SPACE);
  }
  LitheStatus status = app_open_context(&app, args);
  LitheStudyDef def = define(args, &app);
  def.overrides = overrides;
  def.n_overrides = list_overrides(args, overrides, threads, sizeof threads);
  if (status == LITHE_OK)
    status = args->n_sweeps > 0 ? lithe_sweep(app.ctx, &def, &result)
                                : lithe_study(app.ctx, &def, &result);
  return finish(args, &app, status, &result);
}

int cmd_verify(const Args *args) {
  App app;
  LitheStudyResult *result = NULL;
  const char *overrides[ARGS_MAX_SETS + 1];
  char threads[40];
  LitheStatus status = app_open_context(&app, args);
  LitheVerifyDef def = lithe_verify_def_default();
  def.scene = args->scene;
  def.folder = args->out;
  def.methods = args->methods;
  def.cells = args->cells;
  def.meshes = args->meshes;
  if (args->tolerance > 0) def.tolerance = args->tolerance;
  def.overrides = overrides;
  def.n_overrides = list_overrides(args, overrides, threads, sizeof threads);
  if (!args->json && !args->quiet) def.tell = tell;
  def.tell_user = &app;
  if (status == LITHE_OK) status = lithe_verify(app.ctx, &def, &result);
  return finish(args, &app, status, &result);
}
