/// All observers of a run together.
#include "scene/output.h"

#include "io/file.h"

#include <unistd.h>

/// A result.json tells a whole run: an old one must not stand beside new files.
static LitheStatus remove_old_result(LitheCtx *ctx, const char *folder) {
  char *path;
  LITHE_TRY(lth_path_join(ctx, folder, "result.json", &path));
  unlink(path);
  lth_free(ctx, path);
  return LITHE_OK;
}

LitheStatus lth_output_open(LitheCtx *ctx, const char *folder, const LthBody *body,
                            const LthSchedule *schedule, LthOutput *out) {
  double start = lth_now();
  LITHE_TRY(lth_folder_make(ctx, folder));
  LITHE_TRY(remove_old_result(ctx, folder));
  LITHE_TRY(lth_history_open(ctx, folder, &out->history));
  LITHE_TRY(lth_probes_open(ctx, folder, body, &out->probes));
  LITHE_TRY(lth_fields_open(ctx, folder, body, &out->fields));
  LITHE_TRY(lth_surface_output_open(ctx, folder, body, schedule->period, &out->surface));
  out->seconds += lth_now() - start;
  return LITHE_OK;
}

LitheStatus lth_output_frame(LitheCtx *ctx, LthOutput *out, const LthBody *body) {
  double start = lth_now();
  lth_simulation_measure(ctx, body->sim);
  LITHE_TRY(lth_history_row(ctx, out->history, body));
  LITHE_TRY(lth_probes_row(ctx, out->probes, body));
  LITHE_TRY(lth_fields_frame(ctx, out->fields, body));
  LITHE_TRY(lth_surface_output_frame(ctx, out->surface, body));
  out->n_frames++;
  out->seconds += lth_now() - start;
  return LITHE_OK;
}

LitheStatus lth_output_close(LitheCtx *ctx, LthOutput *out) {
  LitheStatus all[] = {lth_history_close(ctx, &out->history), lth_probes_close(ctx, &out->probes),
                       lth_fields_close(ctx, &out->fields),
                       lth_surface_output_close(ctx, &out->surface)};
  for (int i = 0; i < 4; i++)
    if (all[i] != LITHE_OK) return all[i];
  return LITHE_OK;
}
