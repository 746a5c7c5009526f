/// `lithe run`: run a scene and say where the result lies.
#include "app.h"

#include <stdio.h>

static void print_summary(const LitheScene *scene, const LitheResult *result, LitheStatus status) {
  LitheRunSummary s = lithe_result_summary(result);
  printf("%s: %s after %.3g s", lithe_scene_name(scene),
         status == LITHE_OK ? "done" : lithe_status_text(status), s.seconds);
  if (s.simulated > 0) printf(" (%.6g s simulated)", s.simulated);
  printf("\n  elements          %d, %lld unknowns\n", s.elements, (long long)s.unknowns);
  printf("  output times      %d\n", s.frames);
  printf("  max displacement  %.6g m\n", s.max_displacement);
  printf("  max von Mises     %.6g Pa\n", s.max_von_mises);
  if (s.penetration > 0) printf("  max penetration   %.3g m\n", s.penetration);
  printf("  result            %s/result.json\n", lithe_result_folder(result));
}

/// True where the status comes with a valid result.json.
static bool has_result(LitheStatus status) {
  return status == LITHE_OK || status == LITHE_NOT_CONVERGED || status == LITHE_INTERRUPTED;
}

int cmd_run(const Args *args) {
  App app;
  LitheResult *result = NULL;
  LitheStatus status = app_open(&app, args);
  if (status == LITHE_OK && args->resume)
    status = lithe_resume(app.ctx, app.scene, args->resume, &result);
  else if (status == LITHE_OK)
    status = lithe_run(app.ctx, app.scene, args->out, &result);
  progress_end(&app.progress);
  if (result && has_result(status) && *lithe_result_json(result)) {
    if (args->json)
      fputs(lithe_result_json(result), stdout);
    else if (!args->quiet)
      print_summary(app.scene, result, status);
  }
  if (app.ctx) lithe_result_destroy(app.ctx, &result);
  return app_close(&app, status);
}
