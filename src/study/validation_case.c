/// A validation case: one scene by several methods at refining resolutions, against numbers that are known.
#include "study/validation_case.h"

#include <string.h>

#define ONE_PERCENT 0.01

/// Columns: level, unknowns, seconds, then value and error of each quantity.
enum { LEVEL, UNKNOWNS, SECONDS, FIRST_QUANTITY };

LthCaseMethod lth_case_dg_sliced(int level0, int level1, int level2) {
  return (LthCaseMethod){"dg, sliced",
                         "{kind: dg, cells: %d, degree: 2}",
                         LTH_CASE_NO_MESH,
                         3,
                         {level0, level1, level2}};
}

LthCaseMethod lth_case_dg_mesh(int level0, int level1, int level2) {
  return (LthCaseMethod){"dg, file mesh",
                         "{kind: dg, mesh: {file: hex8-%d.msh}, degree: 2}",
                         LTH_CASE_LINEAR_MESH,
                         3,
                         {level0, level1, level2}};
}

LthCaseMethod lth_case_cg_mesh(int level0, int level1, int level2) {
  return (LthCaseMethod){"cg, file mesh",
                         "{kind: cg, mesh: {file: hex27-%d.msh}, degree: 2}",
                         LTH_CASE_QUADRATIC_MESH,
                         3,
                         {level0, level1, level2}};
}

LthCaseMethod lth_case_staggered(int level0, int level1, int level2) {
  return (LthCaseMethod){
      "staggered", "{kind: staggered, cells: %d}", LTH_CASE_NO_MESH, 3, {level0, level1, level2}};
}

static int error_column(int quantity) { return FIRST_QUANTITY + 2 * quantity + 1; }

static LthTable *make_table(LthStudyRun *run, const LthCase *c) {
  LthTable *t = lth_study_table(&run->report, c->name, "All runs", "method");
  lth_table_column(t, "level", "", 0);
  lth_table_column(t, "unknowns", "", 0);
  lth_table_column(t, "time", "s", 3);
  for (int q = 0; q < c->n_quantities; q++) {
    lth_table_column(t, c->quantity[q].name, c->quantity[q].unit, 6);
    lth_table_column(t, lth_study_print(run, "error of %s", c->quantity[q].name), "%", 3);
  }
  return t;
}

static LitheStatus write_files(LthStudyRun *run, const LthCase *c, const LthCaseMethod *m,
                               int level) {
  if (m->mesh == LTH_CASE_NO_MESH) return LITHE_OK;
  bool is_linear = m->mesh == LTH_CASE_LINEAR_MESH;
  return lth_block_model_mesh(run, c->model, level, is_linear ? 1 : 2,
                              lth_study_print(run, "%s-%d", is_linear ? "hex8" : "hex27", level));
}

static LitheStatus run_level(LthStudyRun *run, const LthCase *c, const LthCaseMethod *m, int level,
                             double *row) {
  LthStudyResult result;
  const char *method = lth_study_print(run, m->set, level);
  const char *set[1] = {lth_study_print(run, "bodies.0.method=%s", method)};
  const char *name = lth_study_print(run, "%s-%d-%d", c->name, (int)(m - c->method) + 1, level);
  LITHE_TRY(write_files(run, c, m, level));
  LITHE_TRY(lth_study_run_with(run, name, c->scene, 1, set, NULL, &result));
  row[LEVEL] = level;
  row[UNKNOWNS] = lth_study_number(&result, "bodies.0.dofs");
  row[SECONDS] = lth_study_number(&result, "time.total");
  for (int q = 0; q < c->n_quantities; q++) {
    const LthCaseQuantity *what = &c->quantity[q];
    double scale = what->scale > 0 ? what->scale : fabs(what->reference);
    double number = lth_study_number(&result, what->path);
    double value = what->slope != 0 ? what->start + what->slope * number : number;
    row[FIRST_QUANTITY + 2 * q] = value;
    row[error_column(q)] = 100 * fabs(value - what->reference) / scale;
  }
  return LITHE_OK;
}

static int levels_of(const LthStudyRun *run, const LthCaseMethod *m) {
  return run->quick && m->n_levels > 1 ? m->n_levels - 1 : m->n_levels;
}

/// Quick runs leave out the finest level: theirs is twice as coarse.
static void judge(LthStudyRun *run, const LthCase *c, const LthCaseMethod *m, const double *row) {
  for (int q = 0; q < c->n_quantities; q++) {
    const LthCaseQuantity *what = &c->quantity[q];
    lth_study_at_most(
        &run->report,
        lth_study_print(run, "%s: error of %s, finest level [%%]", m->name, what->name),
        row[error_column(q)], 100 * what->bound * (run->quick ? 4 : 1),
        run->quick ? lth_study_print(run, "%s; four times as much on a level twice as coarse",
                                     what->reason)
                   : what->reason);
  }
}

/// Column `to` where the error of the first quantity comes down to 1 %, linear between levels in logarithms: the
/// coarsest level's where that is there already; NaN where no level is.
static double at_one_percent(const LthTable *t, int first, int last, int to) {
  double e0 = lth_table_at(t, first, error_column(0)) / 100;
  if (e0 <= ONE_PERCENT) return lth_table_at(t, first, to);
  for (int row = first + 1; row < last; row++) {
    double e1 = lth_table_at(t, row, error_column(0)) / 100;
    double y0 = lth_table_at(t, row - 1, to), y1 = lth_table_at(t, row, to);
    if (e1 <= ONE_PERCENT) {
      double s = e1 > 0 ? log(e0 / ONE_PERCENT) / log(e0 / e1) : 1;
      return y0 * pow(y1 / y0, s);
    }
    e0 = e1;
  }
  return NAN;
}

static LthPlot *plot_errors(LthStudyRun *run, const LthCase *c, const LthTable *t,
                            const int *first) {
  LthPlot *plot =
      lth_study_plot(&run->report, lth_study_print(run, "plot-%s", c->name),
                     lth_study_print(run, "%s: error over unknowns", c->quantity[0].name),
                     "unknowns [-]", "error [%]");
  plot->log_x = plot->log_y = true;
  plot->orders = LTH_PLOT_ORDERS_BESIDE;
  for (int i = 0; i < c->n_methods; i++)
    lth_plot_rows(plot, c->method[i].name, t, UNKNOWNS, error_column(0), first[i], first[i + 1]);
  for (int i = 0; i < plot->n_series; i++) plot->series[i].cells = LEVEL;
  return plot;
}

/// Orders are those of the first quantity in the size of an element, by least squares over the levels.
static void tell_cost(LthStudyRun *run, const LthCase *c, const LthTable *t, const int *first,
                      const LthPlot *plot) {
  LthTable *cost = lth_study_table(
      &run->report, lth_study_print(run, "%s-cost", c->name),
      lth_study_print(run,
                      "Unknowns and seconds to 1 %% in %s (of the coarsest level where that is "
                      "there already; empty where no level is)",
                      c->quantity[0].name),
      "method");
  lth_table_column(cost, "unknowns", "", 3);
  lth_table_column(cost, "time", "s", 2);
  lth_table_column(cost, "observed order of the error in h", "", 3);
  lth_table_column(cost, "error of the finest level", "%", 3);
  for (int i = 0; i < c->n_methods; i++)
    lth_table_row(cost, c->method[i].name,
                  (double[4]){at_one_percent(t, first[i], first[i + 1], UNKNOWNS),
                              at_one_percent(t, first[i], first[i + 1], SECONDS),
                              i < plot->n_series ? lth_plot_order(plot, plot->series + i) : NAN,
                              lth_table_at(t, first[i + 1] - 1, error_column(0))});
}

LitheStatus lth_case_run(LthStudyRun *run, const LthCase *c) {
  int first[LTH_CASE_METHODS_MAX + 1] = {0};
  LthTable *t = make_table(run, c);
  for (int q = 0; q < c->n_quantities; q++)
    if (c->quantity[q].reference != 0)
      lth_study_say(&run->report, "Known: %s = %.6g %s.", c->quantity[q].name,
                    c->quantity[q].reference, c->quantity[q].unit);
  if (c->surface_level > 0)
    LITHE_TRY(lth_block_model_surface(run, c->model, c->surface_level, "body"));
  for (int i = 0; i < c->n_methods; i++) {
    const LthCaseMethod *m = &c->method[i];
    double row[FIRST_QUANTITY + 2 * LTH_CASE_QUANTITIES_MAX];
    for (int k = 0; k < levels_of(run, m); k++) {
      LITHE_TRY(run_level(run, c, m, m->level[k], row));
      lth_table_row(t, m->name, row);
    }
    first[i + 1] = t->n_rows;
    judge(run, c, m, row);
  }
  const LthPlot *plot = plot_errors(run, c, t, first);
  tell_cost(run, c, t, first, plot);
  return LITHE_OK;
}
