/// Reading a scene from beginning to end, and freeing it.
#include "scene/scene.h"

#include "base/digest.h"
#include "io/file.h"
#include "scene/override.h"
#include "scene/reader.h"
#include "scene/schema.h"
#include "scene/yaml.h"

#include <string.h>
#include <sys/stat.h>

/// What the text came from.
typedef struct Source {
  const char *name; ///< for messages; NULL: unknown, no files are opened
  const char *text;
  size_t length;
  const char *const *overrides;
  int n_overrides;
  const char *defects_path;
  uint64_t inputs; ///< the context's, before the file was read
} Source;

static LitheStatus read_parts(LthReader *r) {
  const LthNode *root = r->root;
  const char *title = lth_read_text(root, "title");
  r->scene->title = lth_arena_text(r->arena, title ? title : "", title ? strlen(title) : 0);
  r->scene->dimension = lth_node_is_text(lth_node_get(root, "dimension"), "2") ? 2 : 3;
  lth_read_vector(root, "gravity", r->scene->gravity);
  lth_read_time(r);
  LITHE_TRY(lth_read_bodies(r));
  LITHE_TRY(lth_read_ties(r));
  LITHE_TRY(lth_read_cuts(r));
  lth_read_adapt(r);
  LITHE_TRY(lth_read_colliders(r));
  lth_read_contact(r);
  lth_read_solver(r);
  lth_read_probes(r);
  lth_read_exact(r);
  lth_read_output(r);
  return LITHE_OK;
}

/// "dir/bunny-drop.yaml": directory "dir", name "bunny-drop".
static void set_names(LthReader *r, const char *file) {
  LthScene *scene = r->scene;
  const char *slash = strrchr(file, '/'), *stem = slash ? slash + 1 : file;
  const char *dot = strrchr(stem, '.');
  size_t stem_length = dot && dot > stem ? (size_t)(dot - stem) : strlen(stem);
  scene->file = lth_arena_text(r->arena, file, strlen(file));
  if (slash)
    scene->directory = lth_arena_text(r->arena, file, slash == file ? 1 : (size_t)(slash - file));
  else
    scene->directory = lth_arena_text(r->arena, ".", 1);
  scene->name = stem_length ? lth_arena_text(r->arena, stem, stem_length)
                            : lth_arena_text(r->arena, "scene", 5);
}

static LitheStatus check_and_read(LthReader *r, const Source *source) {
  LthSchema schema;
  LITHE_TRY(lth_schema_create(r->ctx, r->report, &r->owned->expressions, &schema));
  LthNode *root = lth_yaml_parse(r->report, source->text, source->length, NULL);
  if (!root) {
    if (r->report->n == 0 && !r->arena->failed)
      lth_report_at(r->report, 1, 1,
                    "the file is empty, got nothing; expected a scene that begins with lithe: 1");
    return LITHE_OK;
  }
  if (root->kind != LTH_NODE_MAP) {
    lth_report(r->report, root, "no scene, got %s; expected a mapping that begins with lithe: 1",
               lth_show(r->arena, root));
    return LITHE_OK;
  }
  for (int i = 0; i < source->n_overrides; i++) lth_override(r->report, root, source->overrides[i]);
  LITHE_TRY(lth_schema_check(&schema, root));
  r->root = root;
  return read_parts(r);
}

/// The message of a scene with errors: the only one, or how many and the first.
static LitheStatus fail_with_errors(LthReader *r, LthSceneErrors *errors) {
  LITHE_TRY(lth_report_finish(r->report, r->ctx, errors));
  const char *first = errors->n ? errors->lines[0] : "";
  if (r->report->n == 1) LITHE_FAIL(r->ctx, LITHE_BAD_INPUT, "%s", first);
  LITHE_FAIL(r->ctx, LITHE_BAD_INPUT, "%s has %d errors, the first: %s", r->report->file,
             r->report->n, first);
}

/// Keep the overrides, and what they and all files say, in short. The number of threads changes no bit of a
/// run.
static void keep_identity(LthReader *r, const Source *source, uint64_t inputs) {
  LthScene *scene = r->scene;
  scene->digest = inputs;
  scene->overrides =
      lth_arena_take(r->arena, sizeof *scene->overrides * (size_t)source->n_overrides);
  for (int i = 0; i < source->n_overrides && !r->arena->failed; i++) {
    const char *text = source->overrides[i];
    scene->overrides[scene->n_overrides++] = lth_arena_text(r->arena, text, strlen(text));
    if (strncmp(text, "solver.threads=", 15) != 0)
      scene->digest = lth_digest(text, strlen(text), scene->digest);
  }
}

static LitheStatus read_source(LitheCtx *ctx, const Source *source, LthSceneErrors *errors,
                               LthScene **scene) {
  LitheStatus status = LITHE_OK;
  LthSceneOwned *owned = NULL;
  const char *name = source->name ? source->name : "scene.yaml";
  *scene = NULL;
  LTH_NEW(ctx, *scene, 1);
  LTH_NEW_OR(done, ctx, owned, 1);
  (*scene)->owned = owned;
  owned->arena.ctx = ctx;
  LthReport report = {.arena = &owned->arena, .file = name};
  LthReader reader = {.ctx = ctx,
                      .report = &report,
                      .arena = &owned->arena,
                      .owned = owned,
                      .scene = *scene,
                      .defects_path = source->defects_path,
                      .opens_files = source->name != NULL};
  set_names(&reader, name);
  if (!owned->arena.failed) LITHE_TRY_OR(done, check_and_read(&reader, source));
  keep_identity(&reader, source, lth_inputs(ctx) - source->inputs);
  if (owned->arena.failed)
    status = lth_fail(ctx, LITHE_NO_MEMORY, "out of memory while reading %s", name);
  else if (report.n > 0)
    status = fail_with_errors(&reader, errors);

done:
  if (status != LITHE_OK) lth_scene_destroy(ctx, scene);
  return status;
}

LitheStatus lth_scene_read_text(LitheCtx *ctx, const char *name, const char *text, size_t length,
                                const char *const *overrides, int n_overrides,
                                LthSceneErrors *errors, LthScene **scene) {
  Source source = {.name = name,
                   .text = text,
                   .length = length,
                   .overrides = overrides,
                   .n_overrides = n_overrides,
                   .inputs = lth_inputs(ctx)};
  lth_note_input(ctx, lth_digest(text, length, 0));
  return read_source(ctx, &source, errors, scene);
}

/// Devices never end, and a file that large is no scene: told before it is read into memory.
static LitheStatus check_file(LitheCtx *ctx, const char *file) {
  struct stat info;
  if (stat(file, &info) != 0) return LITHE_OK; // the reader says why
  if (S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: it is a device; expected a scene file", file);
  if (S_ISREG(info.st_mode) && info.st_size > LTH_YAML_BYTES_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: too large, got %lld bytes; expected a scene of at most 16 MiB", file,
               (long long)info.st_size);
  return LITHE_OK;
}

LitheStatus lth_scene_read(LitheCtx *ctx, const char *file, const char *const *overrides,
                           int n_overrides, const char *defects_path, LthSceneErrors *errors,
                           LthScene **scene) {
  char *text = NULL;
  *scene = NULL;
  Source source = {.name = file,
                   .overrides = overrides,
                   .n_overrides = n_overrides,
                   .defects_path = defects_path,
                   .inputs = lth_inputs(ctx)};
  LITHE_TRY(check_file(ctx, file));
  LITHE_TRY(lth_file_read(ctx, file, &text, &source.length));
  source.text = text;
  LitheStatus status = read_source(ctx, &source, errors, scene);
  lth_free(ctx, text);
  return status;
}

LitheStatus lth_scene_check_values(LitheCtx *ctx, const LthScene *scene) {
  const LthSceneOwned *owned = scene->owned;
  return owned ? lth_expression_list_check(ctx, &owned->expressions) : LITHE_OK;
}

LitheStatus lth_scene_rename(LitheCtx *ctx, LthScene *scene, const char *file) {
  LthSceneOwned *owned = scene->owned;
  char *name = lth_arena_text(&owned->arena, file, strlen(file));
  if (!name) LITHE_FAIL(ctx, LITHE_NO_MEMORY, "out of memory while reading %s", file);
  scene->file = name;
  return LITHE_OK;
}

static void free_body(LitheCtx *ctx, LthSceneBody *body) {
  lth_shape_free(ctx, &body->shape);
  lth_element_mesh_destroy(ctx, &body->elements);
  for (LitheIndex i = 0; i < body->n_materials; i++) lth_where_free(ctx, &body->materials[i].where);
  for (LitheIndex i = 0; i < body->n_constraints; i++)
    lth_where_free(ctx, &body->constraints[i].where);
  for (LitheIndex i = 0; i < body->n_loads; i++) lth_where_free(ctx, &body->loads[i].where);
}

static void free_owned(LitheCtx *ctx, LthSceneOwned *owned) {
  if (!owned) return;
  for (LitheCount i = 0; i < owned->n_surfaces; i++) lth_surface_destroy(ctx, &owned->surfaces[i]);
  for (LitheCount i = 0; i < owned->n_soups; i++) lth_soup_destroy(ctx, &owned->soups[i]);
  for (LitheCount i = 0; i < owned->n_images; i++) lth_image_destroy(ctx, &owned->images[i]);
  for (LitheCount i = 0; i < owned->n_volumes; i++) lth_volume_destroy(ctx, &owned->volumes[i]);
  for (LitheCount i = 0; i < owned->n_loops; i++) lth_loops_destroy(ctx, &owned->loops[i]);
  lth_free(ctx, owned->loops);
  lth_free(ctx, owned->images);
  lth_free(ctx, owned->volumes);
  for (LitheCount i = 0; i < owned->n_wraps; i++) lth_wrap_destroy(ctx, &owned->wraps[i]);
  lth_free(ctx, owned->wraps);
  lth_free(ctx, owned->surfaces);
  lth_free(ctx, owned->soups);
  lth_expression_list_free(ctx, &owned->expressions);
  lth_arena_free(&owned->arena);
  lth_free(ctx, owned);
}

void lth_scene_destroy(LitheCtx *ctx, LthScene **scene) {
  if (!scene || !*scene) return;
  for (LitheIndex i = 0; i < (*scene)->n_bodies; i++) free_body(ctx, &(*scene)->bodies[i]);
  for (LitheIndex i = 0; i < (*scene)->n_colliders; i++)
    lth_shape_free(ctx, &(*scene)->colliders[i].shape);
  for (LitheIndex i = 0; i < (*scene)->n_ties; i++) lth_where_free(ctx, &(*scene)->ties[i].where);
  for (LitheIndex i = 0; i < (*scene)->n_cuts; i++) {
    lth_shape_free(ctx, &(*scene)->cuts[i].within);
    lth_shape_free(ctx, &(*scene)->cuts[i].carve);
  }
  free_owned(ctx, (*scene)->owned);
  lth_free(ctx, *scene);
  *scene = NULL;
}
