/// The library in one page: read a scene, run it, read a figure of its result.
///
/// Build against an installed Lithe:  cc run_a_scene.c $(pkg-config --cflags --libs lithe)
/// Try: another scene; an override such as "bodies.0.method.degree=2"; a scene with a mistake in it.
#include "lithe/lithe.h"

#include <stdio.h>

int main(int argc, char **argv) {
  if (argc < 2) return fprintf(stderr, "usage: run_a_scene SCENE [OVERRIDE ...]\n"), 2;

  // everything a program does with Lithe goes through a context: memory, messages, threads
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return 4;

  // all mistakes of a scene are told at once, each with file, line and column
  LitheSceneDef what = lithe_scene_def_default();
  what.file = argv[1];
  what.overrides = (const char *const *)argv + 2;
  what.n_overrides = argc - 2;
  LitheScene *scene = NULL;
  LitheStatus status = lithe_scene_read(ctx, &what, &scene);
  for (LitheIndex i = 0; scene && i < lithe_scene_error_count(scene); i++)
    fprintf(stderr, "%s\n", lithe_scene_error(scene, i));

  LitheResult *result = NULL;
  if (status == LITHE_OK) status = lithe_run(ctx, scene, "out/example", &result);
  if (status == LITHE_OK) {
    LitheRunSummary s = lithe_result_summary(result);
    printf("%d elements moved by up to %g m; %s/result.json says the rest\n", (int)s.elements,
           s.max_displacement, lithe_result_folder(result));
  } else if (!scene || lithe_scene_error_count(scene) == 0) {
    fprintf(stderr, "%s: %s\n", lithe_status_text(status), lithe_ctx_message(ctx));
  }

  lithe_result_destroy(ctx, &result);
  lithe_scene_destroy(ctx, &scene);
  lithe_ctx_destroy(&ctx);
  return lithe_status_exit(status);
}
