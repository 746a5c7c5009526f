/// All observers of a run together.
#include "scene/output.h"

#include "io/file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// A result.json tells a whole run: an old one must not stand beside new files.
static LitheStatus remove_old_result(LitheCtx *ctx, const char *folder) {
  char *path;
  LITHE_TRY(lth_path_join(ctx, folder, "result.json", &path));
  unlink(path);
  lth_free(ctx, path);
  return LITHE_OK;
}

LitheStatus lth_output_stem(LitheCtx *ctx, const LthBody *body, const char *what, char **stem) {
  const char *name = body->def->name;
  size_t length = strlen(name), room = length + strlen(what) + 2;
  LTH_NEW(ctx, *stem, (LitheCount)room);
  if (body->scene->n_bodies == 1) length = 0;
  for (size_t i = 0; i < length; i++) (*stem)[i] = strchr("/\\:*?\"<>| ", name[i]) ? '_' : name[i];
  snprintf(*stem + length, room - length, "%s%s", length ? "_" : "", what);
  return LITHE_OK;
}

static LitheStatus open_all(LitheCtx *ctx, const char *folder, const LthWorld *world,
                            const LthSchedule *schedule, LthOutput *out) {
  LITHE_TRY(lth_folder_make(ctx, folder));
  LITHE_TRY(remove_old_result(ctx, folder));
  LITHE_TRY(lth_history_open(ctx, folder, &out->history));
  LITHE_TRY(lth_probes_open(ctx, folder, world, &out->probes));
  LTH_NEW(ctx, out->fields, world->n_bodies);
  LTH_NEW(ctx, out->surface, world->n_bodies);
  out->n_bodies = world->n_bodies;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthBody *body = world->bodies[b];
    LITHE_TRY(lth_fields_open(ctx, folder, body, out->fields + b));
    LITHE_TRY(lth_surface_output_open(ctx, folder, body, schedule->period, out->surface + b));
  }
  return LITHE_OK;
}

LitheStatus lth_output_open(LitheCtx *ctx, const char *folder, const LthWorld *world,
                            const LthSchedule *schedule, LthOutput *out) {
  double start = lth_now();
  LitheStatus status = open_all(ctx, folder, world, schedule, out);
  out->seconds += lth_now() - start;
  return status;
}

LitheStatus lth_output_frame(LitheCtx *ctx, LthOutput *out, const LthWorld *world) {
  double start = lth_now();
  lth_simulation_measure(ctx, world->sim);
  LITHE_TRY(lth_history_row(ctx, out->history, world));
  LITHE_TRY(lth_probes_row(ctx, out->probes, world));
  for (LitheIndex b = 0; b < out->n_bodies; b++) {
    LITHE_TRY(lth_fields_frame(ctx, out->fields[b], world->bodies[b]));
    LITHE_TRY(lth_surface_output_frame(ctx, out->surface[b], world->bodies[b]));
  }
  out->n_frames++;
  out->seconds += lth_now() - start;
  return LITHE_OK;
}

static void keep_first(LitheStatus *first, LitheStatus status) {
  if (*first == LITHE_OK) *first = status;
}

LitheStatus lth_output_close(LitheCtx *ctx, LthOutput *out) {
  LitheStatus first = LITHE_OK;
  keep_first(&first, lth_history_close(ctx, &out->history));
  keep_first(&first, lth_probes_close(ctx, &out->probes));
  for (LitheIndex b = 0; b < out->n_bodies; b++) {
    keep_first(&first, lth_fields_close(ctx, out->fields + b));
    keep_first(&first, lth_surface_output_close(ctx, out->surface + b));
  }
  lth_free(ctx, out->fields);
  lth_free(ctx, out->surface);
  return first;
}
