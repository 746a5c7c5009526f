/// The smallest user of an installed Lithe.
#include <lithe/lithe.h>
#include <stdio.h>

int main(void) {
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  LitheScene *scene = NULL;
  LitheSceneDef what = lithe_scene_def_default();
  what.file = "no-such-scene.yaml";
  LitheStatus status = lithe_scene_read(ctx, &what, &scene);
  printf("%s %s\n", lithe_version(), lithe_status_text(status));
  lithe_scene_destroy(ctx, &scene);
  lithe_ctx_destroy(&ctx);
  return status == LITHE_BAD_INPUT ? 0 : 1;
}
