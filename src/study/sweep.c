/// Sweeps: a scene run with every combination of values, its main numbers as tables with observed orders.
#include "study/sweep.h"

#include "io/file.h"
#include "io/text.h"
#include "study/orders.h"
#include "study/study_book.h"

#include <stdio.h>
#include <string.h>

#define SWEEPS_MAX 8
#define RUNS_MAX 1000
#define LEVELS_MAX 24 // side by side
#define ORDER_LEAST                                                                                \
  0.5 // below it an extrapolation is further from the last value than that from the one before

typedef struct Grid {
  LthStudyRun *run;
  const LitheStudyDef *def;
  LthSweep *sweep;         ///< the one that refines, if any, is the last    (n)
  int n, n_runs, n_levels; ///< of the last sweep
  bool refines;
  LthStudyResult *result; ///< (n_runs)
  LthMainNumber *number;
  int n_numbers;
} Grid;

/// Value of sweep s in run r: the last sweep varies fastest.
static int value_of(const Grid *g, int r, int s) {
  for (int k = g->n - 1; k > s; k--) r /= g->sweep[k].n;
  return r % g->sweep[s].n;
}

/// The refining sweep comes last, so that a block of consecutive runs refines.
static void put_refining_last(Grid *g) {
  for (int s = g->n - 1; s >= 0; s--) {
    if (g->sweep[s].kind == LTH_SWEEP_PLAIN) continue;
    LthSweep refining = g->sweep[s];
    for (int k = s; k + 1 < g->n; k++) g->sweep[k] = g->sweep[k + 1];
    g->sweep[g->n - 1] = refining;
    g->refines = true;
    return;
  }
}

static LitheStatus parse_sweeps(Grid *g) {
  LitheCtx *ctx = g->run->ctx;
  if (g->def->n_sweeps < 1 || g->def->n_sweeps > SWEEPS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%d sweeps; expected 1 to %d, as in --sweep bodies.0.method.cells=8,16,32",
               g->def->n_sweeps, SWEEPS_MAX);
  g->n = g->def->n_sweeps;
  g->n_runs = 1;
  g->sweep = lth_arena_take(&g->run->arena, sizeof *g->sweep * (size_t)g->n);
  if (!g->sweep) LITHE_FAIL(ctx, LITHE_NO_MEMORY, "out of memory in a sweep");
  for (int s = 0; s < g->n; s++) {
    LITHE_TRY(lth_sweep_parse(g->run, g->def->sweeps[s], g->sweep + s));
    g->n_runs *= g->sweep[s].n;
    if (g->n_runs > RUNS_MAX)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "over %d combinations of values to run", RUNS_MAX);
  }
  put_refining_last(g);
  g->n_levels = g->sweep[g->n - 1].n;
  return LITHE_OK;
}

/// "cells=8 poisson_ratio=0.3" of sweeps [first, last) in a run.
static const char *label_of(const Grid *g, int r, int first, int last) {
  const char *label = "";
  for (int s = first; s < last; s++)
    label = lth_study_print(g->run, "%s%s%s=%s", label, *label ? " " : "", g->sweep[s].key,
                            g->sweep[s].value[value_of(g, r, s)].text);
  return label;
}

/// Read the scene with the overrides of run r.
static LitheStatus read_scene(const Grid *g, int r, LitheScene **scene) {
  const LitheStudyDef *d = g->def;
  int n = d->n_overrides + g->n;
  const char **sets = lth_arena_take(&g->run->arena, sizeof *sets * (size_t)n);
  if (!sets) LITHE_FAIL(g->run->ctx, LITHE_NO_MEMORY, "out of memory in a sweep");
  for (int i = 0; i < d->n_overrides; i++) sets[i] = d->overrides[i];
  for (int s = 0; s < g->n; s++)
    sets[d->n_overrides + s] = lth_study_print(g->run, "%s=%s", g->sweep[s].path,
                                               g->sweep[s].value[value_of(g, r, s)].text);
  LitheSceneDef def = lithe_scene_def_default();
  def.file = d->name;
  def.overrides = sets;
  def.n_overrides = n;
  return lithe_scene_read(g->run->ctx, &def, scene);
}

static LitheStatus run_one(Grid *g, int r) {
  LitheCtx *ctx = g->run->ctx;
  LitheScene *scene = NULL;
  LitheResult *out = NULL;
  const char *folder = lth_study_print(g->run, "%s/run-%03d", g->run->folder, r + 1);
  LitheStatus status = read_scene(g, r, &scene);
  if (status == LITHE_OK) status = lithe_run(ctx, scene, folder, &out);
  if (status == LITHE_OK || status == LITHE_NOT_CONVERGED) {
    g->result[r].status = status;
    status = lth_study_parse(g->run, lithe_result_json(out), &g->result[r].json);
  }
  lithe_result_destroy(ctx, &out);
  lithe_scene_destroy(ctx, &scene);
  return status;
}

/// All scenes are read before the first is run: what is wrong with the last is told at once.
static LitheStatus run_all(Grid *g) {
  g->result = lth_arena_take(&g->run->arena, sizeof *g->result * (size_t)g->n_runs);
  if (!g->result) LITHE_FAIL(g->run->ctx, LITHE_NO_MEMORY, "out of memory in a sweep");
  for (int r = 0; r < g->n_runs; r++) {
    LitheScene *scene = NULL;
    LitheStatus status = read_scene(g, r, &scene);
    lithe_scene_destroy(g->run->ctx, &scene);
    LITHE_TRY(status);
  }
  for (int r = 0; r < g->n_runs; r++) {
    lth_progress(g->run->ctx, label_of(g, r, 0, g->n), (double)r / g->n_runs);
    LITHE_TRY(run_one(g, r));
  }
  return LITHE_OK;
}

static double number_at(const Grid *g, int r, int k) {
  return lth_study_number(g->result + r, g->number[k].path);
}

/// Components that are nothing but rounding beside the others of their vector say nothing.
static bool is_rounding(const Grid *g, int k) {
  const char *path = g->number[k].path, *dot = strrchr(path, '.');
  double own = 0, all = 0;
  if (!g->number[k].is_field || !dot || strlen(dot) != 2) return false;
  for (int j = 0; j < g->n_numbers; j++) {
    const char *other = g->number[j].path;
    bool same = strncmp(other, path, (size_t)(dot - path) + 1) == 0;
    for (int r = 0; r < g->n_runs && same; r++) all = fmax(all, fabs(number_at(g, r, j)));
  }
  for (int r = 0; r < g->n_runs; r++) own = fmax(own, fabs(number_at(g, r, k)));
  return own <= 1e-9 * all;
}

/// Drops what is rounding. Paths of vectors keep their component.
static LitheStatus find_numbers(Grid *g) {
  LthArena *arena = &g->run->arena;
  g->number = lth_arena_take(arena, sizeof *g->number * LTH_MAIN_NUMBERS_MAX);
  bool *drop = lth_arena_take(arena, LTH_MAIN_NUMBERS_MAX);
  if (!g->number || !drop) LITHE_FAIL(g->run->ctx, LITHE_NO_MEMORY, "out of memory in a sweep");
  g->n_numbers = lth_main_numbers(g->run, g->result[0].json, g->number);
  for (int k = 0; k < g->n_numbers; k++) drop[k] = is_rounding(g, k);
  int n = 0;
  for (int k = 0; k < g->n_numbers; k++)
    if (!drop[k]) g->number[n++] = g->number[k];
  g->n_numbers = n;
  return LITHE_OK;
}

/// Every run a row: what the file holds.
static LthTable *tabulate_runs(Grid *g, int *x) {
  double row[SWEEPS_MAX + LTH_MAIN_NUMBERS_MAX + 1];
  LthTable *t = lth_study_table(&g->run->report, "runs", "Every run", "run");
  t->is_long = true;
  for (int s = 0; s < g->n; s++) lth_table_column(t, g->sweep[s].path, "", 6);
  *x = g->n - 1;
  for (int k = 0; k < g->n_numbers; k++)
    lth_table_column(t, g->number[k].path, g->number[k].unit, g->number[k].digits);
  for (int r = 0; r < g->n_runs; r++) {
    for (int s = 0; s < g->n; s++) row[s] = g->sweep[s].value[value_of(g, r, s)].number;
    for (int k = 0; k < g->n_numbers; k++) row[g->n + k] = number_at(g, r, k);
    lth_table_row(t, label_of(g, r, 0, g->n), row);
  }
  return t;
}

/// Order and limit of number k over the levels that begin at run r; NaN where there is none.
static void extrapolate(const Grid *g, int r, int k, double *order, double *limit) {
  const LthSweep *s = g->sweep + g->n - 1;
  int n = g->n_levels;
  *order = *limit = NAN;
  if (!g->refines || n < 2) return;
  if (g->number[k].is_error) {
    *order = lth_order_between(lth_sweep_length(s, n - 2), number_at(g, r + n - 2, k),
                               lth_sweep_length(s, n - 1), number_at(g, r + n - 1, k));
    return;
  }
  if (!g->number[k].is_field || n < 3) return;
  double h[3], q[3], p, end;
  for (int i = 0; i < 3; i++) {
    h[i] = lth_sweep_length(s, n - 3 + i);
    q[i] = number_at(g, r + n - 3 + i, k);
  }
  if (!lth_order_extrapolate(h, q, &p, &end) || p < ORDER_LEAST) return;
  *order = p;
  *limit = end;
}

/// The levels of the last sweep side by side, from run r on.
static void tabulate_block(Grid *g, int r, int block) {
  const LthSweep *s = g->sweep + g->n - 1;
  const char *rest = label_of(g, r, 0, g->n - 1);
  const char *caption = *rest ? lth_study_print(g->run, "%s for %s", s->path, rest) : s->path;
  LthTable *t = lth_study_table(&g->run->report, lth_study_print(g->run, "levels-%d", block + 1),
                                caption, "");
  double row[LEVELS_MAX + 2];
  for (int i = 0; i < g->n_levels; i++)
    lth_table_column(t, lth_study_print(g->run, "%s=%s", s->key, s->value[i].text), "", 6);
  if (g->refines) lth_table_column(t, "order", "", 3);
  if (g->refines) lth_table_column(t, "extrapolated", "", 7);
  for (int k = 0; k < g->n_numbers; k++) {
    for (int i = 0; i < g->n_levels; i++) row[i] = number_at(g, r + i, k);
    extrapolate(g, r, k, row + g->n_levels, row + g->n_levels + 1);
    const LthMainNumber *m = g->number + k;
    lth_table_row(t, lth_study_print(g->run, *m->unit ? "%s [%s]" : "%s", m->path, m->unit), row);
  }
}

static LthPlot *start_plot(Grid *g, const char *name, const char *title, const char *y_label) {
  const LthSweep *s = g->sweep + g->n - 1;
  LthPlot *plot = lth_study_plot(&g->run->report, name, title, s->path, y_label);
  plot->log_x = g->refines;
  plot->log_y = g->refines;
  if (g->refines)
    plot->orders = s->kind == LTH_SWEEP_CELLS ? LTH_PLOT_ORDERS_OF_CELLS : LTH_PLOT_ORDERS_OF_H;
  return plot;
}

/// Number k of every block as a series; `column` is that of number 0 in the table.
static void plot_number(Grid *g, LthPlot *plot, const LthTable *t, int x, int column, int k) {
  for (int r = 0; r < g->n_runs && plot->n_series < LTH_PLOT_SERIES_MAX; r += g->n_levels) {
    const char *rest = label_of(g, r, 0, g->n - 1);
    const char *name =
        lth_study_print(g->run, "%s%s%s", g->number[k].path, *rest ? ", " : "", rest);
    lth_plot_rows(plot, name, t, x, column + k, r, r + g->n_levels);
  }
}

/// How far the numbers of each level are from what they tend to, as a share of it.
static const LthTable *tabulate_distances(Grid *g) {
  double row[LTH_MAIN_NUMBERS_MAX + 1], order, limit;
  LthTable *t = lth_study_table(&g->run->report, "distances",
                                "Distance from the extrapolated value, as a share of it", "run");
  t->is_long = true;
  lth_table_column(t, g->sweep[g->n - 1].path, "", 6);
  for (int k = 0; k < g->n_numbers; k++) lth_table_column(t, g->number[k].path, "", 4);
  for (int r = 0; r < g->n_runs; r++) {
    int begin = r / g->n_levels * g->n_levels;
    row[0] = g->sweep[g->n - 1].value[value_of(g, r, g->n - 1)].number;
    for (int k = 0; k < g->n_numbers; k++) {
      extrapolate(g, begin, k, &order, &limit);
      double distance = fabs(number_at(g, r, k) - limit) / fabs(limit);
      row[1 + k] = distance > 0 ? distance : NAN; // none at all has no place on a logarithmic axis
    }
    lth_table_row(t, label_of(g, r, 0, g->n), row);
  }
  return t;
}

static bool is_extrapolated(const Grid *g, int k) {
  double order, limit;
  for (int r = 0; r < g->n_runs; r += g->n_levels) {
    extrapolate(g, r, k, &order, &limit);
    if (isfinite(limit)) return true;
  }
  return false;
}

static void plot_distances(Grid *g) {
  int n = 0;
  for (int k = 0; k < g->n_numbers; k++) n += is_extrapolated(g, k);
  if (n == 0) return;
  const LthTable *t = tabulate_distances(g);
  LthPlot *plot = start_plot(g, "distances", "Distance from the extrapolated values", "share [1]");
  plot->orders =
      LTH_PLOT_NO_ORDERS; // the last level's distance follows from the order, not the other way round
  for (int k = 0; k < g->n_numbers; k++)
    if (is_extrapolated(g, k)) plot_number(g, plot, t, 0, 1, k);
}

static void plot_errors(Grid *g, const LthTable *runs, int x) {
  LthPlot *plot = NULL;
  for (int k = 0; k < g->n_numbers; k++) {
    if (!g->number[k].is_error) continue;
    if (!plot) plot = start_plot(g, "errors", "Errors", "error");
    plot_number(g, plot, runs, x, g->n, k);
  }
}

/// Without refinement: how the largest displacement goes with the values.
static void plot_plain(Grid *g, const LthTable *runs, int x) {
  for (int i = 0; i < g->n_levels; i++)
    if (!isfinite(g->sweep[g->n - 1].value[i].number)) return;
  for (int k = 0; k < g->n_numbers; k++) {
    if (strcmp(g->number[k].path, "displacement.max") != 0) continue;
    LthPlot *plot = start_plot(g, "displacement", "Largest displacement", "displacement [m]");
    plot_number(g, plot, runs, x, g->n, k);
  }
}

static LitheStatus report(Grid *g) {
  int x, n_bad = 0;
  LITHE_TRY(find_numbers(g));
  if (g->n_levels <= LEVELS_MAX)
    for (int r = 0; r < g->n_runs; r += g->n_levels) tabulate_block(g, r, r / g->n_levels);
  const LthTable *runs = tabulate_runs(g, &x);
  if (g->refines) {
    plot_errors(g, runs, x);
    plot_distances(g);
  } else {
    plot_plain(g, runs, x);
  }
  for (int r = 0; r < g->n_runs; r++) n_bad += g->result[r].status != LITHE_OK;
  lth_study_at_most(&g->run->report, "runs that did not converge", n_bad, 0,
                    "numbers of a solve that was not finished say nothing");
  return LITHE_OK;
}

/// The command as a person would write it again.
static void write_command(const LitheStudyDef *def, char *text, size_t size) {
  snprintf(text, size, "lithe study %s", def->name);
  for (int s = 0; s < def->n_sweeps; s++) {
    size_t used = strlen(text);
    snprintf(text + used, size - used, " --sweep '%s'", def->sweeps[s]);
  }
}

/// The one study of a sweep; as LthBookFill.
typedef struct Sweep {
  const LitheStudyDef *def;
  LthStudy study;
} Sweep;

static LitheStatus sweep_into(LthBook *book, void *self) {
  Sweep *s = self;
  LthStudyRun *run;
  s->study = (LthStudy){
      .name = "sweep",
      .title = s->def->name,
      .question = "How do the main numbers go with the values, and what do they tend to?"};
  LITHE_TRY(lth_book_add(book, &s->study, "", &run));
  Grid grid = {.run = run, .def = s->def};
  LITHE_TRY(parse_sweeps(&grid));
  LITHE_TRY(run_all(&grid));
  return lth_book_finish(book, run, report(&grid), s->def);
}

LitheStatus lithe_sweep(LitheCtx *ctx, const LitheStudyDef *def, LitheStudyResult **result) {
  Sweep sweep = {.def = def};
  char *folder, title[300], command[1000];
  snprintf(title, sizeof title, "Lithe: sweep of %s", def->name);
  write_command(def, command, sizeof command);
  LITHE_TRY(lth_book_folder(ctx, def->folder, def->name, "sweep", &folder));
  LitheStatus status = lth_book_make(ctx, folder, title, command, sweep_into, &sweep, result);
  lth_free(ctx, folder);
  return status;
}
