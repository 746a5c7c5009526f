/// All observers of a run together.
#include "scene/output.h"

#include "io/file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// A result.json tells a whole run: an old one must not stand beside new files, nor a checkpoint.
static LitheStatus remove_old(LitheCtx *ctx, const char *folder, const char *name) {
  char *path;
  LITHE_TRY(lth_path_join(ctx, folder, name, &path));
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
                            const LthSchedule *schedule, bool resumes, LthOutput *out) {
  LITHE_TRY(lth_folder_make(ctx, folder));
  LITHE_TRY(remove_old(ctx, folder, "result.json"));
  if (resumes)
    LITHE_TRY(lth_file_remove_parts(ctx, folder));
  else
    LITHE_TRY(remove_old(ctx, folder, LTH_CHECKPOINT_NAME));
  LITHE_TRY(lth_history_open(ctx, folder, resumes, &out->history));
  LITHE_TRY(lth_probes_open(ctx, folder, world, resumes, &out->probes));
  LTH_NEW(ctx, out->fields, world->n_bodies);
  LTH_NEW(ctx, out->surface, world->n_bodies);
  out->n_bodies = world->n_bodies;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthBody *body = world->bodies[b];
    LITHE_TRY(lth_fields_open(ctx, folder, body, out->fields + b));
    LITHE_TRY(
        lth_surface_output_open(ctx, folder, body, schedule->period, resumes, out->surface + b));
  }
  return LITHE_OK;
}

LitheStatus lth_output_open(LitheCtx *ctx, const char *folder, const LthWorld *world,
                            const LthSchedule *schedule, bool resumes, LthOutput *out) {
  double start = lth_now();
  LitheStatus status = open_all(ctx, folder, world, schedule, resumes, out);
  out->seconds += lth_now() - start;
  return status;
}

LitheStatus lth_output_renew(LitheCtx *ctx, LthOutput *out, const LthWorld *world) {
  LITHE_TRY(lth_probes_renew(ctx, out->probes, world));
  for (LitheIndex b = 0; b < out->n_bodies; b++) {
    const LthBody *body = world->bodies[b];
    if (body->change) LITHE_TRY(lth_fields_renew(ctx, out->fields[b], body));
    LITHE_TRY(lth_surface_output_renew(ctx, out->surface[b], body));
  }
  return LITHE_OK;
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

void lth_output_archive(LthOutput *out, LthArchive *archive) {
  lth_archive_mark(archive, "output");
  LTH_ARCHIVE(archive, out->n_frames);
  lth_history_archive(out->history, archive);
  lth_probes_archive(out->probes, archive);
  for (LitheIndex b = 0; b < out->n_bodies; b++) {
    lth_fields_archive(out->fields[b], archive);
    lth_surface_output_archive(out->surface[b], archive);
  }
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
