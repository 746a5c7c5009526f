/// What the volume fuzz targets share: parse, select, free; nothing may leak.
#pragma once

#include "geometry/image.h"
#include "io/volume_file.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/// libFuzzer's entry; each target defines it.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// Larger volumes would only make the fuzzer slow.
#define FUZZ_VOXELS_MAX 100000

static inline void fuzz_check(bool condition) {
  if (!condition) abort();
}

static inline int fuzz_volume(const char *format, const uint8_t *data, size_t size) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  LthVolume *volume = NULL;
  LthImage *image = NULL;
  LitheStatus status = lth_volume_parse(ctx, "fuzz", format, (const char *)data, size, &volume);
  fuzz_check((status == LITHE_OK) == (volume != NULL));
  if (volume && lth_volume_size(volume) <= FUZZ_VOXELS_MAX) {
    double x[3] = {volume->to_world[3], volume->to_world[7], volume->to_world[11]};
    lth_volume_value(volume, x);
    status = lth_image_create(ctx, volume, 0, NULL, 0, 0, &image);
    fuzz_check((status == LITHE_OK) == (image != NULL));
    if (image) fuzz_check(image->n_islands > 0 && !isnan(lth_image_value(image, x)));
  }
  if (status != LITHE_OK) fuzz_check(lithe_ctx_message(ctx)[0] != 0);
  lth_image_destroy(ctx, &image);
  lth_volume_destroy(ctx, &volume);
  fuzz_check(lth_alloc_bytes(ctx) == 0);
  lithe_ctx_destroy(&ctx);
  return 0;
}
