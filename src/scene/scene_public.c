/// The scene as a public handle: the typed values, or what was wrong with the file.
#include "scene/scene_public.h"

LitheSceneDef lithe_scene_def_default(void) { return (LitheSceneDef){0}; }

LitheStatus lithe_scene_read(LitheCtx *ctx, const LitheSceneDef *def, LitheScene **scene) {
  double start = lth_now();
  LTH_NEW(ctx, *scene, 1);
  LitheStatus status = lth_scene_read(ctx, def->file, def->overrides, def->n_overrides,
                                      def->defects_path, &(*scene)->errors, &(*scene)->scene);
  (*scene)->read_seconds = lth_now() - start;
  return status;
}

LitheIndex lithe_scene_error_count(const LitheScene *scene) { return scene->errors.n; }

const char *lithe_scene_error(const LitheScene *scene, LitheIndex i) {
  return i >= 0 && i < scene->errors.n ? scene->errors.lines[i] : "";
}

const char *lithe_scene_title(const LitheScene *scene) {
  return scene->scene && scene->scene->title ? scene->scene->title : "";
}

const char *lithe_scene_name(const LitheScene *scene) {
  return scene->scene && scene->scene->name ? scene->scene->name : "";
}

void lithe_scene_destroy(LitheCtx *ctx, LitheScene **scene) {
  if (!*scene) return;
  lth_scene_destroy(ctx, &(*scene)->scene);
  lth_scene_errors_free(&(*scene)->errors);
  lth_free(ctx, *scene);
  *scene = NULL;
}
