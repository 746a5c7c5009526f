/// What a cut costs in a run: a box sliced by a grid into 1 000, 10 000 and 100 000 hexahedra falls, and a plane passes through
/// it between two steps. Parts are those of `topology` in result.json, in milliseconds of the processor; the first plane finds its
/// memory, the second is told. One core; the least of several runs for each part.
/// `--csv` prints rows; `--cells N` takes N^3 hexahedra alone; `--model linear` that one alone; `--runs N`.
#include "scene/change.h"
#include "scene/cut.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCENE                                                                                      \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: box\n"                                                                                \
  "    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"                                           \
  "    material: {model: %s, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}\n"             \
  "    method: {kind: dg, cells: %d, degree: 1}\n"                                                 \
  "    initial: {velocity: [\"y\", \"-x\", 0]}\n"                                                  \
  "gravity: [0, 0, -9.81]\n"                                                                       \
  "cuts:\n"                                                                                        \
  "  - {at: 0.005, plane: {point: [0.3012, 0.2979, 0.2031], normal: [0.02, 0.03, 1]}, space: "     \
  "rest}\n"                                                                                        \
  "  - {at: 0.015, plane: {point: [0.5012, 0.4979, 0.5031], normal: [0.02, 0.03, 1]}, space: "     \
  "rest}\n"                                                                                        \
  "time: {kind: dynamic, duration: 1, step: 0.01}\n"                                               \
  "solver: {linear: pcg, tolerance: 1e-4}\n"

typedef struct Row {
  LitheIndex elements, split, merged;
  double least[LTH_COST_COUNT]; ///< [s]
} Row;

/// Nothing here can go on after a failure.
static void check(LitheCtx *ctx, LitheStatus status) {
  if (status == LITHE_OK) return;
  fprintf(stderr, "bench_cut: %s\n", lithe_ctx_message(ctx));
  exit(lithe_status_exit(status));
}

/// The cuts that are due, and the step after them.
static void cut_and_step(LitheCtx *ctx, LthWorld *world, double end) {
  bool changed;
  check(ctx, lth_world_cut_due(ctx, world, end, &changed));
  double factor = lth_simulation_report(world->sim)->processor_factor;
  check(ctx, lth_simulation_step(ctx, world->sim, 0.01));
  lth_world_cost_tell(world, lth_simulation_report(world->sim)->processor_factor - factor);
}

static void time_run(LitheCtx *ctx, const char *model, int cells, Row *row) {
  char text[2000];
  double times[2];
  LthSceneErrors errors = {0};
  LthScene *scene = NULL;
  LthWorld *world = NULL;
  snprintf(text, sizeof text, SCENE, model, cells);
  check(ctx, lth_scene_read_text(ctx, "box.yaml", text, strlen(text), NULL, 0, &errors, &scene));
  check(ctx, lth_world_create(ctx, scene, times, &world));
  row->elements = world->bodies[0]->mesh->n_cells;
  for (int i = 0; i < 2; i++) cut_and_step(ctx, world, 0.01 * (i + 1));
  const LthChangeNote *note = world->notes + world->n_notes - 1;
  row->split = note->n_split;
  row->merged = note->n_merged;
  for (int p = 0; p < LTH_COST_COUNT; p++)
    if (row->least[p] == 0 || note->seconds[p] < row->least[p]) row->least[p] = note->seconds[p];
  lth_world_destroy(ctx, &world);
  lth_scene_errors_free(&errors);
  lth_scene_destroy(ctx, &scene);
}

static void print_row(const char *model, const Row *r, bool csv) {
  double sum = 0;
  printf(csv ? "%s,%d,%d,%d" : "%-10s %8d %6d %6d", model, r->elements, r->split, r->merged);
  for (int p = 0; p < LTH_COST_COUNT; p++) {
    sum += r->least[p];
    printf(csv ? ",%.2f" : " %11.2f", 1e3 * r->least[p]);
  }
  printf(csv ? ",%.2f\n" : " %8.2f\n", 1e3 * sum);
  fflush(stdout);
}

static void print_head(bool csv) {
  printf(csv ? "model,elements,split,merged" : "%-10s %8s %6s %6s", "model", "elements", "split",
         "merged");
  for (int p = 0; p < LTH_COST_COUNT; p++)
    printf(csv ? ",%s ms" : " %11s", lth_cost_name((LthCostPart)p));
  printf(csv ? ",%s ms\n" : " %8s\n", "all");
}

int main(int argc, char **argv) {
  static const int sizes[] = {10, 22, 46};
  static const char *const models[] = {"corotated", "linear"};
  const char *model = NULL;
  int only = 0, runs = 3;
  bool csv = false;
  for (int i = 1; i < argc; i++) {
    csv = csv || strcmp(argv[i], "--csv") == 0;
    if (strcmp(argv[i], "--cells") == 0 && i + 1 < argc) only = atoi(argv[++i]);
    if (strcmp(argv[i], "--model") == 0 && i + 1 < argc) model = argv[++i];
    if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) runs = atoi(argv[++i]);
  }
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  print_head(csv);
  for (int m = 0; m < 2; m++) {
    if (model && strcmp(model, models[m]) != 0) continue;
    for (int i = 0; i < (only > 0 ? 1 : 3); i++) {
      Row row = {0};
      for (int run = 0; run < (sizes[i] > 30 && runs > 2 ? 2 : runs); run++)
        time_run(ctx, models[m], only > 0 ? only : sizes[i], &row);
      print_row(models[m], &row, csv);
    }
  }
  lithe_ctx_destroy(&ctx);
  return 0;
}
