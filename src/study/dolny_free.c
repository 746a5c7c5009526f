/// What the tables of the thesis hide: boundaries that are really free, with and without smoothed fractions.
#include "study/dolny_studies.h"

#define LEVELS_MAX 4

/// The manufactured solution has no volume change, no shear, and its whole stress is given: errors of cut cells cancel.
static const struct {
  const char *name, *title;
  bool moves_hole; ///< the grid stays and the hole moves: its rim is the grid's own
} problems[] = {{"ring", "Lame's ring, free outside", false},
                {"hole", "Kirsch's hole, free", true},
                {"rotating", "rotating ring, free outside", false}};

#define N_PROBLEMS ((int)(sizeof problems / sizeof problems[0]))

static const double shifts[4][2] = {{0, 0}, {0.5, 0.5}, {0.31, 0.17}, {0.73, 0.41}};

enum { CELLS, BOX_L1, BOX_LINF, SMOOTH_L1, SMOOTH_LINF, COLUMNS };

static LthExactCase make_case(LthStudyRun *run, int problem, const double shift[2], double h) {
  if (problem == 0) return lth_exact_ring(run, 0.3);
  if (problem == 2) return lth_exact_rotating(run, 0.3);
  return lth_exact_hole(run, 0.3, shift[0] * h, shift[1] * h);
}

/// Worst errors of all shifts of the grid.
static LitheStatus run_level(LthStudyRun *run, int problem, int cells, int n_shifts,
                             const char *fractions, double worst[2]) {
  worst[0] = worst[1] = 0;
  for (int k = 0; k < n_shifts; k++) {
    LthStudyResult result;
    LthExactMethod method = {.cells = cells, .fractions = fractions};
    LthExactCase which = make_case(run, problem, shifts[k], 2. / cells);
    if (!problems[problem].moves_hole)
      for (int a = 0; a < 2; a++) method.shift[a] = shifts[k][a];
    const char *scene = lth_exact_scene(run, problems[problem].title, &which, &method);
    const char *name =
        lth_study_print(run, "%s-%s-%d-%d", problems[problem].name, fractions, cells, k);
    LITHE_TRY(lth_study_run_text(run, name, scene, NULL, &result));
    double l1 = lth_study_number(&result, "error.l1"),
           linf = lth_study_number(&result, "error.linf");
    worst[0] = l1 <= worst[0] ? worst[0] : l1; // NaN stays
    worst[1] = linf <= worst[1] ? worst[1] : linf;
  }
  return LITHE_OK;
}

static double order(const LthTable *t, int column) {
  const LthPlot plot = {.orders = LTH_PLOT_ORDERS_OF_CELLS};
  const LthSeries s = {.table = t, .x = CELLS, .y = column, .last = t->n_rows};
  return lth_plot_order(&plot, &s);
}

static void judge(LthStudyRun *run, int problem, const LthTable *t) {
  LthStudyReport *r = &run->report;
  const char *title = problems[problem].title;
  int last = t->n_rows - 1;
  lth_study_at_least(r, lth_study_print(run, "%s: order of L1 with smooth fractions", title),
                     order(t, SMOOTH_L1), 1.9, "second order, less the scatter of cuts");
  lth_study_at_least(
      r, lth_study_print(run, "%s: order of Linf with smooth fractions", title),
      order(t, SMOOTH_LINF), 1.6,
      "a smooth profile has almost no aliasing on the grid: what is left of first order, hoop "
      "stress times about 1 / w^2 for a half width of w cells, is small");
  lth_study_at_most(
      r,
      lth_study_print(run, "%s: Linf with smooth over Linf with exact fractions, finest N", title),
      lth_table_at(t, last, SMOOTH_LINF) / lth_table_at(t, last, BOX_LINF), 0.75,
      "a smooth profile has almost no aliasing on the grid");
  lth_study_at_least(
      r, lth_study_print(run, "%s: order of L1 with exact fractions", title), order(t, BOX_L1), 1.5,
      "the error of a strip one cell wide enters the integral with its width: towards two");
  lth_study_at_most(r, lth_study_print(run, "%s: order of Linf with exact fractions", title),
                    order(t, BOX_LINF), 1.4,
                    "first order: in cut cells hoop stress meets two kernels of the same boundary");
}

static LitheStatus run_problem(LthStudyRun *run, int problem) {
  static const int levels[LEVELS_MAX] = {32, 64, 128, 256};
  int n_levels = run->quick ? 3 : LEVELS_MAX, n_shifts = run->quick ? 2 : 4;
  const char *title = problems[problem].title;
  LthTable *t = lth_study_table(
      &run->report, problems[problem].name,
      lth_study_print(run, "%s: worst error of %d shifts of the grid", title, n_shifts), NULL);
  lth_table_column(t, "N", "", 0);
  lth_table_column(t, "L1, exact fractions", "m^3", 4);
  lth_table_column(t, "Linf, exact fractions", "m", 4);
  lth_table_column(t, "L1, smooth", "m^3", 4);
  lth_table_column(t, "Linf, smooth", "m", 4);
  for (int i = 0; i < n_levels; i++) {
    double row[COLUMNS] = {levels[i]};
    LITHE_TRY(run_level(run, problem, levels[i], n_shifts, "exact", row + BOX_L1));
    LITHE_TRY(run_level(run, problem, levels[i], n_shifts, "smooth", row + SMOOTH_L1));
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot =
      lth_study_plot(&run->report, lth_study_print(run, "plot-%s", problems[problem].name), title,
                     "N [cells over 2 m]", "error [m^3, m]");
  plot->log_x = plot->log_y = true;
  plot->orders = LTH_PLOT_ORDERS_OF_CELLS;
  lth_plot_series(plot, "L1, exact", t, CELLS, BOX_L1);
  lth_plot_series(plot, "Linf, exact", t, CELLS, BOX_LINF);
  lth_plot_series(plot, "L1, smooth", t, CELLS, SMOOTH_L1);
  lth_plot_series(plot, "Linf, smooth", t, CELLS, SMOOTH_LINF);
  judge(run, problem, t);
  return LITHE_OK;
}

LitheStatus lth_study_free_boundaries(LthStudyRun *run) {
  lth_study_say(
      &run->report,
      "The manufactured solution of the thesis has no volume change and no shear, and its whole "
      "stress is given at the boundary: what cut cells do wrong cancels. Here nothing is given: "
      "the "
      "boundary is free.");
  for (int problem = 0; problem < N_PROBLEMS; problem++) LITHE_TRY(run_problem(run, problem));
  return LITHE_OK;
}
