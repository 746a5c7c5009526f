/// Figures 1 and 2: consistency, convergence and condition numbers on the Poisson equation in the plane.
#include "study/kaufmann_studies.h"

#include "study/orders.h"
#include "study/poisson.h"

// --- Figure 1 ---

static double square(const double x[2]) { return x[0] * x[0]; }
static double minus_two(const double x[2]) { return x[0] * 0 - 2; }
static const LthPoissonProblem parabola = {square, minus_two};

static const double etas[] = {0.5, 1, 5, 10, 100, 1e3, 1e4};
#define N_ETAS ((int)(sizeof etas / sizeof etas[0]))

enum { ETA, IP_ERROR, BZ_ERROR, IP_SMALLEST, BZ_SMALLEST, ETA_COLUMNS };

static LthTable *start_etas(LthStudyRun *run) {
  LthTable *t = lth_study_table(&run->report, "errors",
                                "u = x^2 by quadratic functions on 4 x 4 squares (Fig. 1)", NULL);
  lth_table_column(t, "eta", "", 3);
  lth_table_column(t, "L2 error, IP", "", 3);
  lth_table_column(t, "L2 error, BZ", "", 4);
  lth_table_column(t, "smallest eigenvalue, IP", "", 3);
  lth_table_column(t, "smallest eigenvalue, BZ", "", 3);
  return t;
}

static void judge_consistency(LthStudyRun *run, const LthTable *t) {
  LthStudyReport *r = &run->report;
  double worst = 0, least = INFINITY, last = t->n_rows - 1;
  for (int row = 0; row < t->n_rows; row++) {
    double e = lth_table_at(t, row, IP_ERROR), s = lth_table_at(t, row, BZ_SMALLEST);
    worst = e <= worst ? worst : e;
    least = s >= least ? least : s;
  }
  lth_study_at_most(r, "error of IP, largest of all eta", worst, 1e-11,
                    "x^2 is one of the functions: rounding times the condition number, below 1e5 "
                    "in the cells' own coordinates");
  lth_study_at_least(r, "error of BZ, smallest of all eta", lth_table_at(t, (int)last, BZ_ERROR),
                     1e-6, "BZ is not consistent: it never gives x^2");
  const double h[2] = {etas[N_ETAS - 2], etas[N_ETAS - 1]};
  double order = -lth_order_between(h[0], lth_table_at(t, N_ETAS - 2, BZ_ERROR), h[1],
                                    lth_table_at(t, N_ETAS - 1, BZ_ERROR));
  lth_study_at_least(r, "order of the error of BZ in 1 / eta, last two", order, 0.99,
                     "increasing eta improves it: springs in series give (1 + c / eta) u, up to "
                     "c^2 / eta^2");
  lth_study_at_most(r, "the same from above", order, 1.01, "and no faster than that");
  lth_study_at_least(r, "smallest eigenvalue of BZ, least of all eta", least, 0,
                     "BZ is positive definite for every eta > 0");
}

/// Where IP turns definite: between 4.2 and 4.4 with this boundary.
static LitheStatus judge_limit(LthStudyRun *run) {
  static const double near[2] = {4.2, 4.4};
  double smallest[2];
  for (int k = 0; k < 2; k++) {
    LthPoissonResult result;
    const LthPoissonDef def = {LTH_POISSON_IP, 2, 4, near[k], false, true};
    LITHE_TRY(lth_poisson_solve(run->ctx, &parabola, &def, &result));
    smallest[k] = result.smallest;
  }
  lth_study_at_most(&run->report, "smallest eigenvalue of IP at eta = 4.2", smallest[0], 0,
                    "the limit of definiteness for quadratic functions here is 4.30: IP is exact "
                    "below it too, but no minimum");
  lth_study_at_least(&run->report, "smallest eigenvalue of IP at eta = 4.4", smallest[1], 0,
                     "the same limit from the other side");
  return LITHE_OK;
}

LitheStatus lth_study_consistency(LthStudyRun *run) {
  LthTable *t = start_etas(run);
  for (int i = 0; i < N_ETAS; i++) {
    LthPoissonResult ip, bz;
    LthPoissonDef def = {LTH_POISSON_IP, 2, 4, etas[i], false, true};
    LITHE_TRY(lth_poisson_solve(run->ctx, &parabola, &def, &ip));
    def.method = LTH_POISSON_BZ;
    LITHE_TRY(lth_poisson_solve(run->ctx, &parabola, &def, &bz));
    lth_table_row(t, NULL, (double[]){etas[i], ip.l2, bz.l2, ip.smallest, bz.smallest});
  }
  lth_study_say(&run->report,
                "The paper prints pictures: IP gives x^2 for every penalty, BZ comes nearer as eta "
                "grows. Both hold; what the picture does not show is that IP is exact where its "
                "matrix is indefinite as well.");
  LthPlot *plot = lth_study_plot(&run->report, "errors", "u = x^2, quadratic, 4 x 4 squares",
                                 "penalty eta [-]", "L2 error [-]");
  plot->log_x = plot->log_y = true;
  lth_plot_series(plot, "BZ", t, ETA, BZ_ERROR);
  lth_plot_series(plot, "IP", t, ETA, IP_ERROR);
  judge_consistency(run, t);
  return judge_limit(run);
}

// --- Figure 2 ---

static double sines(const double x[2]) { return sin(M_PI * x[0]) * sin(M_PI * x[1]); }
static double sines_source(const double x[2]) { return 2 * M_PI * M_PI * sines(x); }
static const LthPoissonProblem waves = {sines, sines_source};

/// What is compared; `error` and `condition` are those of an independent program at 2, 4, 8, 16 (three digits).
static const struct {
  const char *name;
  LthPoissonMethod method;
  int degree;
  double eta, error[4], monomial[4], local[4];
} kinds[] = {
    {"CG, bilinear",
     LTH_POISSON_CG,
     1,
     0,
     {.122, .0304, .00760, .00190},
     {0},
     {0, 3.2, 12.8, 51.7}},
    {"IP, linear",
     LTH_POISSON_IP,
     1,
     10,
     {.218, .126, .0490, .0146},
     {376, 3.1e3, 2.0e4, 1.0e5},
     {14, 55, 242, 1.0e3}},
    {"IP, quadratic",
     LTH_POISSON_IP,
     2,
     10,
     {.0384, .00478, 5.35e-4, 6.30e-5},
     {3.5e4, 1.2e6, 3.0e7, 6.3e8},
     {54, 137, 463, 1.8e3}},
    {"BZ, linear",
     LTH_POISSON_BZ,
     1,
     10,
     {.176, .0691, .0203, .0422},
     {363, 2.9e3, 1.8e4, 9.2e4},
     {15, 63, 273, 1.1e3}},
    {"BZ, quadratic", LTH_POISSON_BZ, 2, 10, {0, 0, 0, .0565}, {0, 0, 0, 4.8e8}, {0, 0, 0, 2.3e3}},
    {"IP, linear, eta = 1e5", LTH_POISSON_IP, 1, 1e5, {0, .500, .500, .498}, {0}, {0}}};

enum { CG, IP1, IP2, BZ1, BZ2, LOCKED, N_KINDS };

/// A relative difference that is within `digits` of a printed number; nothing is printed where it is 0.
static double difference(double value, double printed) {
  return printed > 0 ? fabs(value / printed - 1) : 0;
}

typedef struct Tables {
  LthTable *error, *monomial, *local;
  double worst_error, worst_condition; ///< against the independent program
  int unknowns[N_KINDS], cells;        ///< of the finest
  double laplace[N_KINDS];             ///< ||Laplace u_h + f|| there
} Tables;

static LthTable *start_table(LthStudyRun *run, const char *name, const char *caption, int n_kinds) {
  LthTable *t = lth_study_table(&run->report, name, caption, NULL);
  lth_table_column(t, "N", "", 0);
  for (int k = 0; k < n_kinds; k++) lth_table_column(t, kinds[k].name, "", 4);
  return t;
}

static LitheStatus run_level(LthStudyRun *run, int level, Tables *all) {
  int cells = 2 << level, limit = run->quick ? 8 : 16;
  bool wants = cells <= limit;
  double error[N_KINDS + 1] = {cells}, monomial[N_KINDS + 1] = {cells},
                         local[N_KINDS + 1] = {cells};
  for (int k = 0; k < N_KINDS; k++) {
    LthPoissonResult r, m = {.smallest = NAN, .largest = NAN};
    LthPoissonDef def = {kinds[k].method, kinds[k].degree, cells,
                         kinds[k].eta,    false,           wants && k != LOCKED};
    LITHE_TRY(lth_poisson_solve(run->ctx, &waves, &def, &r));
    def.is_monomial = true;
    if (def.wants_matrix) LITHE_TRY(lth_poisson_solve(run->ctx, &waves, &def, &m));
    error[k + 1] = r.l2;
    local[k + 1] = lth_poisson_condition(&r);
    monomial[k + 1] = lth_poisson_condition(&m);
    all->unknowns[k] = r.unknowns;
    all->laplace[k] = r.laplace;
    if (level < 4) {
      all->worst_error = fmax(all->worst_error, difference(r.l2, kinds[k].error[level]));
      if (wants && k != LOCKED)
        all->worst_condition =
            fmax(all->worst_condition, fmax(difference(local[k + 1], kinds[k].local[level]),
                                            difference(monomial[k + 1], kinds[k].monomial[level])));
    }
  }
  all->cells = cells;
  lth_table_row(all->error, NULL, error);
  if (wants) lth_table_row(all->monomial, NULL, monomial);
  if (wants) lth_table_row(all->local, NULL, local);
  return LITHE_OK;
}

/// Order between the two finest levels.
static double last_order(const LthTable *t, int kind) {
  int i = t->n_rows - 1;
  return lth_order_between(1 / lth_table_at(t, i - 1, 0), lth_table_at(t, i - 1, kind + 1),
                           1 / lth_table_at(t, i, 0), lth_table_at(t, i, kind + 1));
}

static void judge_orders(LthStudyRun *run, const Tables *all) {
  LthStudyReport *r = &run->report;
  const LthTable *t = all->error;
  int last = t->n_rows - 1;
  lth_study_at_most(r, "errors against an independent program, largest relative difference",
                    all->worst_error, 0.006, "that program's numbers have three digits");
  lth_study_at_most(r, "condition numbers against it", all->worst_condition, 0.05,
                    "that program's numbers have two digits");
  lth_study_at_least(r, "order of CG, last two levels", last_order(t, CG), 1.98,
                     "second order for bilinear functions");
  lth_study_at_least(r, "order of IP, linear, last two levels", last_order(t, IP1),
                     run->quick ? 1.7 : 1.9,
                     "\"at a rate similar to CG\": second order, which coarse grids only approach "
                     "(0.8, 1.4, 1.7, ... with eta = 10)");
  lth_study_at_least(r, "order of IP, quadratic, last two levels", last_order(t, IP2), 2.95,
                     "\"at a faster rate for quadratic ones\": third order");
  lth_study_at_most(r, "order of BZ, linear, last two levels", last_order(t, BZ1), 0.2,
                    "here the paper's claim of a reasonable convergence fails: below the floor of "
                    "its own softness BZ does not converge");
  lth_study_at_most(r, "order of IP, linear, with eta = 1e5, last two levels",
                    last_order(t, LOCKED), 0.2,
                    "here Fig. 3's claim fails: continuous linear functions on squares with zero "
                    "boundary are 0 alone, so that a large penalty locks instead of giving CG");
  double fraction = lth_table_at(t, last, IP1 + 1) * all->unknowns[IP1] /
                    (lth_table_at(t, last, CG + 1) * all->unknowns[CG]);
  lth_study_at_least(r, "error times unknowns, linear IP over CG, finest", fraction, 1,
                     "\"CG is more accurate by a constant factor for the same number of DOFs\"; "
                     "both errors go like one over the unknowns");
  lth_study_at_most(r, "||Laplace u_h + f|| of linear IP at the finest N less pi^2, relative",
                    fabs(all->laplace[IP1] / (M_PI * M_PI) - 1), 1e-9,
                    "the caption of Fig. 2 says that this were plotted: for linear functions it is "
                    "||f|| = pi^2 at every N, so that what is plotted is ||u_h - u||");
}

static void judge_conditions(LthStudyRun *run, const Tables *all) {
  LthStudyReport *r = &run->report;
  int last = all->local->n_rows - 1;
  double least = INFINITY;
  for (int row = 1; row <= last; row++)
    for (int k = IP1; k <= BZ2; k++)
      least = fmin(least, lth_table_at(all->local, row, k + 1) / lth_table_at(all->local, row, 1));
  lth_study_at_least(r, "condition number of DG over that of CG, least of all from N = 4", least, 1,
                     "\"both DG methods lead to higher condition numbers\"");
  double growth =
      lth_table_at(all->monomial, last, IP2 + 1) / lth_table_at(all->local, last, IP2 + 1);
  lth_study_at_least(r, "quadratic IP: condition number with monomials over that with local ones",
                     growth, run->quick ? 1e4 : 1e5,
                     "monomials of x and y themselves, the paper's basis, are nearly dependent on "
                     "a small cell; Lithe's basis is orthonormal on each cell");
  lth_study_at_least(r, "order of quadratic IP's condition number in 1 / N, local coordinates",
                     last_order(all->local, IP2), -2.1, "grows with N squared, as that of CG");
}

/// BZ gives u (1 + 1 / eta): n slabs and n springs in series.
static LitheStatus judge_softness(LthStudyRun *run) {
  static const double eta[] = {1, 10, 100};
  LthTable *t =
      lth_study_table(&run->report, "softness",
                      "BZ, quadratic: error that refinement does not lower, over ||u||", NULL);
  lth_table_column(t, "eta", "", 3);
  lth_table_column(t, "error", "", 3);
  lth_table_column(t, "1 / eta", "", 3);
  double worst = 0;
  for (int i = 0; i < 3; i++) {
    LthPoissonResult result;
    const LthPoissonDef def = {LTH_POISSON_BZ, 2, run->quick ? 16 : 32, eta[i], false, false};
    LITHE_TRY(lth_poisson_solve(run->ctx, &waves, &def, &result));
    double relative = result.l2 / 0.5; // ||sin sin|| = 1/2
    lth_table_row(t, NULL, (double[]){eta[i], relative, 1 / eta[i]});
    worst = fmax(worst, fabs(relative * eta[i] - 1));
  }
  lth_study_at_most(&run->report, "that error times eta less 1, largest", worst,
                    run->quick ? 0.2 : 0.1,
                    "springs in series: u_BZ tends to (1 + 1 / eta) u; the boundary's own spring "
                    "adds one cell in N, so that the rest falls with N");
  return LITHE_OK;
}

static void plot_tables(LthStudyRun *run, const Tables *all) {
  LthPlot *plot =
      lth_study_plot(&run->report, "plot-errors", "Error of sin(pi x) sin(pi y) (Fig. 2)",
                     "N [squares along a side]", "L2 error [-]");
  plot->log_x = plot->log_y = true;
  plot->orders = LTH_PLOT_ORDERS_OF_CELLS;
  for (int k = 0; k < N_KINDS; k++) lth_plot_series(plot, kinds[k].name, all->error, 0, k + 1);
  plot = lth_study_plot(&run->report, "plot-condition", "Condition number of K (Fig. 2)",
                        "N [squares along a side]", "condition number [-]");
  plot->log_x = plot->log_y = true;
  lth_plot_series(plot, kinds[CG].name, all->local, 0, CG + 1);
  for (int k = IP1; k <= BZ2; k++)
    lth_plot_series(plot, lth_study_print(run, "%s, monomials", kinds[k].name), all->monomial, 0,
                    k + 1);
  for (int k = IP1; k <= IP2; k++)
    lth_plot_series(plot, lth_study_print(run, "%s, local", kinds[k].name), all->local, 0, k + 1);
}

LitheStatus lth_study_convergence(LthStudyRun *run) {
  Tables all = {0};
  all.error = start_table(run, "errors", "L2 errors, eta = 10 where nothing is said", N_KINDS);
  all.monomial = start_table(run, "condition-monomials",
                             "Condition number, monomials of x and y (CG: nodes)", LOCKED);
  all.local = start_table(run, "condition-local",
                          "Condition number, monomials of each cell's own coordinates", LOCKED);
  int levels = run->quick ? 4 : 5;
  for (int level = 0; level < levels; level++) LITHE_TRY(run_level(run, level, &all));
  plot_tables(run, &all);
  judge_orders(run, &all);
  judge_conditions(run, &all);
  return judge_softness(run);
}
