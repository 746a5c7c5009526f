/// history.csv: one row an output time.
#include "io/csv.h"
#include "io/file.h"
#include "scene/measure.h"
#include "scene/observe.h"

struct LthHistory {
  LthCsv *csv;
};

static const char *const columns[] = {"t",
                                      "strain_energy",
                                      "kinetic_energy",
                                      "work",
                                      "volume",
                                      "contacts",
                                      "penetration",
                                      "linear_iterations",
                                      "newton_iterations",
                                      "residual",
                                      "momentum_x",
                                      "momentum_y",
                                      "momentum_z",
                                      "angular_momentum_x",
                                      "angular_momentum_y",
                                      "angular_momentum_z",
                                      "elements",
                                      "unknowns"};

LitheStatus lth_history_open(LitheCtx *ctx, const char *folder, bool resumes,
                             LthHistory **history) {
  const int n = sizeof columns / sizeof columns[0];
  char *path = NULL;
  LTH_NEW(ctx, *history, 1);
  LITHE_TRY(lth_path_join(ctx, folder, "history.csv", &path));
  LitheStatus status = resumes ? lth_csv_reopen(ctx, path, n, &(*history)->csv)
                               : lth_csv_open(ctx, path, n, columns, &(*history)->csv);
  lth_free(ctx, path);
  return status;
}

/// Elements and unknowns of all bodies.
static void count(const LthWorld *world, double n[2]) {
  n[0] = n[1] = 0;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    n[0] += lth_body_elements(world->bodies[b]);
    n[1] += (double)lth_body_unknowns(world->bodies[b]);
  }
}

LitheStatus lth_history_row(LitheCtx *ctx, LthHistory *history, const LthWorld *world) {
  const LthStepReport *r = lth_simulation_report(world->sim);
  double n[2];
  count(world, n);
  const double row[] = {lth_simulation_time(world->sim),
                        r->strain_energy,
                        r->kinetic_energy,
                        r->work,
                        lth_measure_volume(world->n_bodies, world->bodies),
                        r->contacts,
                        r->penetration,
                        r->linear_iterations,
                        r->newton_iterations,
                        r->residual,
                        r->momentum[0],
                        r->momentum[1],
                        r->momentum[2],
                        r->angular_momentum[0],
                        r->angular_momentum[1],
                        r->angular_momentum[2],
                        n[0],
                        n[1]};
  return lth_csv_row(ctx, history->csv, row);
}

void lth_history_archive(LthHistory *history, LthArchive *archive) {
  lth_csv_archive(history->csv, archive);
}

LitheStatus lth_history_close(LitheCtx *ctx, LthHistory **history) {
  if (!*history) return LITHE_OK;
  LitheStatus status = lth_csv_close(ctx, &(*history)->csv);
  lth_free(ctx, *history);
  *history = NULL;
  return status;
}
