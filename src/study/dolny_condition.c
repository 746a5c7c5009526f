/// Figure 5.4: condition numbers over Poisson's ratio and Young's modulus, and what the mixed form makes of them.
#include "study/dolny_studies.h"

#include "study/orders.h"

#define CELLS 32
#define CELLS_QUICK 16

static const double ratios[] = {0.1, 0.2, 0.3, 0.4, 0.45, 0.49, 0.495};
static const double moduli[] = {1, 1e2, 1e5};

// of the steps of solvers
static const double step_ratios[] = {0.1, 0.3, 0.45, 0.49, 0.499, 0.5};

#define N_STEP_RATIOS ((int)(sizeof step_ratios / sizeof step_ratios[0]))
#define STEP_CELLS 128
#define STEP_CELLS_QUICK 48
#define N_RATIOS ((int)(sizeof ratios / sizeof ratios[0]))
#define N_MODULI ((int)(sizeof moduli / sizeof moduli[0]))

static LitheStatus run_condition(LthStudyRun *run, double poisson, double young,
                                 double *condition) {
  LthStudyResult result;
  LthExactCase which = lth_exact_manufactured(true);
  LthExactMethod method = {.cells = run->quick ? CELLS_QUICK : CELLS,
                           .fractions = "exact",
                           .more = ", formulation: displacement"};
  which.poisson = poisson;
  which.young = young;
  const char *scene = lth_exact_scene(run, "Condition number", &which, &method);
  const char *const sets[] = {"solver={condition: true, linear: cholesky}"};
  LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "nu-%g-E-%g", poisson, young), scene, 1,
                               sets, NULL, &result));
  *condition = lth_study_number(&result, "solver.condition");
  return LITHE_OK;
}

/// Steps of its solver to a residual of 1e-8 that a formulation takes, and the error it ends with.
static LitheStatus run_steps(LthStudyRun *run, double poisson, const char *formulation,
                             double *steps, double *error) {
  LthStudyResult result;
  LthExactCase which = lth_exact_ring(run, poisson);
  LthExactMethod method = {.cells = run->quick ? STEP_CELLS_QUICK : STEP_CELLS,
                           .fractions = "exact",
                           .more = lth_study_print(run, ", formulation: %s", formulation)};
  const char *scene = lth_exact_scene(run, "Steps of the solver", &which, &method);
  const char *const sets[] = {"solver={linear: multigrid}"};
  LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "%s-nu-%g", formulation, poisson), scene,
                               1, sets, NULL, &result));
  *steps = lth_study_number(&result, "solver.iterations");
  *error = lth_study_number(&result, "error.l2");
  return LITHE_OK;
}

/// What the mixed form makes of the growth: its operator is not definite, so that steps of the solver are compared.
static LitheStatus study_mixed(LthStudyRun *run) {
  double least = INFINITY, most = 0, apart = 0;
  LthTable *t =
      lth_study_table(&run->report, "mixed",
                      "Steps of multigrid's Krylov method to 1e-8, the ring free outside", NULL);
  lth_table_column(t, "nu", "", 4);
  lth_table_column(t, "displacement: steps", "", 3);
  lth_table_column(t, "mixed: steps", "", 3);
  lth_table_column(t, "displacement: L2 error", "m^2", 4);
  lth_table_column(t, "mixed: L2 error", "m^2", 4);
  for (int i = 0; i < N_STEP_RATIOS; i++) {
    double row[5] = {step_ratios[i], NAN, NAN, NAN, NAN};
    if (row[0] < 0.5) LITHE_TRY(run_steps(run, row[0], "displacement", row + 1, row + 3));
    LITHE_TRY(run_steps(run, row[0], "mixed", row + 2, row + 4));
    least = fmin(least, row[2]);
    most = fmax(most, row[2]);
    if (row[0] < 0.5) apart = fmax(apart, fabs(row[4] / row[3] - 1));
    lth_table_row(t, NULL, row);
  }
  lth_study_at_most(&run->report, "steps of the mixed form, most over least for nu from 0.1 to 0.5",
                    most / least, 3,
                    "smoother and coarse levels do not know nu; below 1/2 the residual is that of "
                    "the displacement "
                    "form, which weighs strains by lambda");
  lth_study_at_most(&run->report, "errors of the two forms, relative difference below nu = 0.5",
                    apart, 1e-3, "pressures may be eliminated: the discrete solution is the same");
  return LITHE_OK;
}

static void judge(LthStudyRun *run, const LthTable *t) {
  double spread = 0, h[2], e[2];
  for (int row = 0; row < t->n_rows; row++)
    for (int k = 1; k < N_MODULI; k++) {
      double off = fabs(lth_table_at(t, row, 1 + k) / lth_table_at(t, row, 1) - 1);
      if (run->quick && row % 3 != 0) continue;
      spread = off <= spread ? spread : off;
    }
  lth_study_at_most(&run->report, "change of the condition number with E, relative", spread, 1e-5,
                    "the matrix is E times one that does not know E");
  for (int i = 0; i < 2; i++) {
    int row = N_RATIOS - 2 + i;
    h[i] = 1 - 2 * ratios[row];
    e[i] = lth_table_at(t, row, 1);
  }
  double slope = -lth_order_between(h[0], e[0], h[1], e[1]);
  lth_study_at_least(&run->report, "growth with 1 / (1 - 2 nu), order between the last two nu",
                     slope, 0.95,
                     "lambda = E nu / ((1 + nu) (1 - 2 nu)) rules the largest eigenvalue");
  lth_study_at_most(&run->report, "the same from above", slope, 1.05,
                    "the smallest eigenvalue belongs to modes that keep volume and stays");
}

LitheStatus lth_study_condition(LthStudyRun *run) {
  LthTable *t =
      lth_study_table(&run->report, "condition",
                      run->quick ? "Condition number of the annulus held on both sides, N = 16"
                                 : "Condition number of the annulus held on both sides, N = 32",
                      NULL);
  lth_table_column(t, "nu", "", 3);
  for (int k = 0; k < N_MODULI; k++)
    lth_table_column(t, lth_study_print(run, "E = %g Pa", moduli[k]), "", 6);
  lth_table_column(t, "1 / (1 - 2 nu)", "", 4);
  for (int i = 0; i < N_RATIOS; i++) {
    double row[N_MODULI + 2] = {ratios[i]};
    for (int k = 0; k < N_MODULI; k++) {
      row[1 + k] = NAN;
      if (k > 0 && run->quick && i % 3 != 0) continue; // E drops out at two nu as well as at seven
      LITHE_TRY(run_condition(run, ratios[i], moduli[k], row + 1 + k));
    }
    row[N_MODULI + 1] = 1 / (1 - 2 * ratios[i]);
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot = lth_study_plot(&run->report, "condition", "Condition number (Fig. 5.4)",
                                 "1 / (1 - 2 nu) [-]", "condition number [-]");
  plot->log_x = plot->log_y = true;
  for (int k = 0; k < N_MODULI; k++)
    lth_plot_series(plot, lth_study_print(run, "E = %g Pa", moduli[k]), t, N_MODULI + 1, 1 + k);
  judge(run, t);
  return study_mixed(run);
}
