/// The scene reader on any bytes. What stands behind a zero byte is an override of the command line.
#include "scene/scene.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return 0;

  // a copy that ends where the text ends, so that reading behind it is seen
  const uint8_t *zero = size ? memchr(data, 0, size) : NULL;
  size_t length = zero ? (size_t)(zero - data) : size;
  char *text = lth_alloc(ctx, (LitheCount)length, 1);
  char *override = lth_alloc(ctx, (LitheCount)(size - length) + 1, 1);
  if (text && override) {
    memcpy(text, data, length);
    if (zero) memcpy(override, zero + 1, size - length - 1);
    LthSceneErrors errors = {0};
    LthScene *scene = NULL;
    lth_scene_read_text(ctx, NULL, text, length, (const char *const *)&override, zero ? 1 : 0,
                        &errors, &scene);
    lth_scene_errors_free(&errors);
    lth_scene_destroy(ctx, &scene);
  }
  lth_free(ctx, text);
  lth_free(ctx, override);
  lithe_ctx_destroy(&ctx);
  return 0;
}
