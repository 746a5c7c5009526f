/// Choosing the reader of a surface file by its ending.
#include "io/surface_file.h"

#include "io/file.h"
#include "io/soup_builder.h"

#include <string.h>
#include <strings.h>

static const struct {
  const char *ending;
  LitheStatus (*parse)(LthSoupBuilder *builder, const char *data, size_t size);
} formats[] = {
    {"obj", lth_obj_parse}, {"stl", lth_stl_parse}, {"ply", lth_ply_parse}, {"off", lth_off_parse}};

static int find_format(const char *ending) {
  for (int i = 0; i < (int)(sizeof formats / sizeof formats[0]); i++)
    if (strcasecmp(ending, formats[i].ending) == 0) return i;
  return -1;
}

static LitheStatus unknown_format(LitheCtx *ctx, const char *name) {
  return lth_fail(
      ctx, LITHE_BAD_INPUT,
      "%s: the kind of file is not known by its ending, expected .obj, .stl, .ply or .off", name);
}

LitheStatus lth_soup_parse(LitheCtx *ctx, const char *name, const char *format, const void *data,
                           size_t size, LthSoup **soup) {
  LitheStatus status = LITHE_OK;
  LthSoupBuilder builder = {.ctx = ctx};
  *soup = NULL;
  int found = find_format(format);
  if (found < 0) return unknown_format(ctx, name);
  LITHE_TRY_OR(done, lth_soup_builder_open(ctx, name, &builder));
  LITHE_TRY_OR(done, formats[found].parse(&builder, data, size));
  LITHE_TRY_OR(done, lth_soup_builder_take(&builder, soup));
done:
  lth_soup_builder_close(&builder);
  return status;
}

/// The part behind the last dot of a path's last name, "" if there is none.
static const char *ending_of(const char *path) {
  const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
  return dot && (!slash || dot > slash) ? dot + 1 : "";
}

LitheStatus lth_soup_read(LitheCtx *ctx, const char *path, LthSoup **soup) {
  char *data = NULL;
  size_t size = 0;
  *soup = NULL;
  const char *format = ending_of(path);
  if (find_format(format) < 0) return unknown_format(ctx, path);
  LITHE_TRY(lth_file_read(ctx, path, &data, &size));
  LitheStatus status = lth_soup_parse(ctx, path, format, data, size, soup);
  lth_free(ctx, data);
  return status;
}
