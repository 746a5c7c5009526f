/// What the surface fuzz targets share: parse, clean, write what is wrong, free; nothing may leak.
#pragma once

#include "io/surface_file.h"

#include <stdint.h>
#include <stdlib.h>

/// libFuzzer's entry; each target defines it.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// Larger soups would only make the fuzzer slow.
#define FUZZ_CORNERS_MAX 3000

static inline void fuzz_check(bool condition) {
  if (!condition) abort();
}

/// A clean surface has exactly one opposite for every directed edge, so its sum of areas vanishes.
static inline void fuzz_check_surface(const LthSurface *surface) {
  fuzz_check(surface->n_tris >= 4 && surface->n_points >= 4 && surface->n_shells >= 1);
  for (LitheIndex i = 0; i < 3 * surface->n_tris; i++)
    fuzz_check(surface->tris[i] >= 0 && surface->tris[i] < surface->n_points);
  for (LitheIndex i = 0; i < surface->n_soup_points; i++)
    fuzz_check(surface->soup_point[i] >= -1 && surface->soup_point[i] < surface->n_points);
  fuzz_check(lth_surface_volume(surface) > 0);
}

static inline int fuzz_surface(const char *format, const uint8_t *data, size_t size) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  LthSoup *soup = NULL;
  LthSurface *surface = NULL;
  LthDefects defects = {0};
  LitheStatus status = lth_soup_parse(ctx, "fuzz", format, data, size, &soup);
  if (status == LITHE_OK && soup->poly_off[soup->n_polys] <= FUZZ_CORNERS_MAX) {
    status = lth_surface_from_soup(ctx, soup, "fuzz", &defects, &surface);
    if (status == LITHE_OK) fuzz_check_surface(surface);
  }
  if (status != LITHE_OK) fuzz_check(lithe_ctx_message(ctx)[0] != 0);
  lth_defects_free(ctx, &defects);
  lth_surface_destroy(ctx, &surface);
  lth_soup_destroy(ctx, &soup);
  fuzz_check(lth_alloc_bytes(ctx) == 0);
  lithe_ctx_destroy(&ctx);
  return 0;
}
