/// Choosing the reader of a mesh file by its ending.
#include "io/mesh_file.h"

#include "io/file.h"
#include "io/inp_mesh.h"
#include "io/msh_file.h"
#include "io/vtu_file.h"

#include <string.h>
#include <strings.h>

/// The part behind the last dot of a path's last name, "" if there is none.
static const char *ending_of(const char *path) {
  const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
  return dot && (!slash || dot > slash) ? dot + 1 : "";
}

static LitheStatus unknown_format(LitheCtx *ctx, const char *name) {
  return lth_fail(
      ctx, LITHE_BAD_INPUT,
      "%s: the kind of mesh file is not known by its ending, expected .msh (Gmsh), .vtu "
      "or .inp (CalculiX, Abaqus)",
      name);
}

bool lth_mesh_file_has_ending(const char *path) {
  const char *ending = ending_of(path);
  return strcasecmp(ending, "msh") == 0 || strcasecmp(ending, "vtu") == 0 ||
         strcasecmp(ending, "inp") == 0;
}

static LitheStatus parse_built(LitheCtx *ctx, const char *name, const void *data, size_t size,
                               double unit_scale,
                               LitheStatus (*parse)(LthElementBuilder *, const char *, size_t),
                               LthElementMesh **mesh) {
  LthElementBuilder b = {.ctx = ctx, .file = name};
  LitheStatus status = parse(&b, data, size);
  if (status == LITHE_OK) status = lth_builder_take(&b, unit_scale, mesh);
  lth_element_builder_free(&b);
  return status;
}

static LitheStatus take_deck(LitheCtx *ctx, double unit_scale, LthInpDeck **deck,
                             LthElementMesh **mesh) {
  LitheStatus status = lth_inp_mesh_create(ctx, *deck, unit_scale, mesh);
  lth_inp_deck_destroy(ctx, deck);
  return status;
}

LitheStatus lth_mesh_file_parse(LitheCtx *ctx, const char *name, const char *format,
                                const void *data, size_t size, double unit_scale,
                                LthElementMesh **mesh) {
  *mesh = NULL;
  if (strcasecmp(format, "msh") == 0)
    return parse_built(ctx, name, data, size, unit_scale, lth_msh_parse, mesh);
  if (strcasecmp(format, "vtu") == 0)
    return parse_built(ctx, name, data, size, unit_scale, lth_vtu_parse, mesh);
  if (strcasecmp(format, "inp") != 0) return unknown_format(ctx, name);
  LthInpDeck *deck = NULL;
  LITHE_TRY(lth_inp_deck_parse(ctx, name, data, size, &deck));
  return take_deck(ctx, unit_scale, &deck, mesh);
}

LitheStatus lth_mesh_file_read(LitheCtx *ctx, const char *path, double unit_scale,
                               LthElementMesh **mesh) {
  *mesh = NULL;
  if (!lth_mesh_file_has_ending(path)) return unknown_format(ctx, path);
  if (strcasecmp(ending_of(path), "inp") == 0) {
    LthInpDeck *deck = NULL;
    LITHE_TRY(lth_inp_deck_read(ctx, path, &deck));
    return take_deck(ctx, unit_scale, &deck, mesh);
  }
  char *data = NULL;
  size_t size = 0;
  LITHE_TRY(lth_file_read(ctx, path, &data, &size));
  LitheStatus status =
      lth_mesh_file_parse(ctx, path, ending_of(path), data, size, unit_scale, mesh);
  lth_free(ctx, data);
  return status;
}
