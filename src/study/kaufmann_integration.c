/// Figure 4: moments of a corner-cut cube by the divergence theorem, by tetrahedra and by sampling.
#include "study/kaufmann_studies.h"

#include "geometry/moments.h"
#include "geometry/quadrature.h"

#include <string.h>
#include <time.h>

#define DEGREES 5 ///< 0 to 4: linear elements need 2, quadratic ones 4
#define MOMENTS_MAX 35

/// The unit cube without its corner x + y + z > 2.5.
static const double points[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},  {1, 1, 0},  {0, 0, 1},
                                     {1, 0, 1}, {0, 1, 1}, {1, 1, .5}, {1, .5, 1}, {.5, 1, 1}};
static const LitheIndex corners[7][5] = {{0, 2, 3, 1},    {0, 1, 5, 4},    {0, 4, 6, 2},
                                         {1, 3, 7, 8, 5}, {2, 6, 9, 7, 3}, {4, 5, 8, 9, 6},
                                         {7, 9, 8}};
static const int n_corners[7] = {4, 4, 4, 5, 5, 5, 3};
static const double origin[3] = {0, 0, 0}, unit[3] = {1, 1, 1};

static double normal_of(int face, double normal[3]) {
  static const double axis[6][3] = {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0},
                                    {1, 0, 0},  {0, 1, 0},  {0, 0, 1}};
  for (int a = 0; a < 3; a++) normal[a] = face < 6 ? axis[face][a] : 1 / sqrt(3);
  return 0;
}

/// All moments up to degree p by one method; `size` is what the method takes.
typedef void (*Integrate)(int p, int size, double *moments);

static LthFaceView view_of(int face, LitheIndex loop[2], double normal[3]) {
  loop[0] = 0;
  loop[1] = n_corners[face];
  normal_of(face, normal);
  return (LthFaceView){points[0], loop, corners[face], 1, normal};
}

static void by_divergence(int p, int size, double *moments) {
  (void)size;
  for (int face = 0; face < 7; face++) {
    LitheIndex loop[2];
    double normal[3];
    LthFaceView view = view_of(face, loop, normal);
    lth_moments_add_face(p, origin, unit, &view, 1, moments);
  }
}

static void add_point(int p, const double x[3], double w, double *moments) {
  double value[MOMENTS_MAX];
  lth_monomials3_eval(p, x, value);
  for (int q = 0; q < lth_monomials3(p); q++) moments[q] += w * value[q];
}

static LthSimplexRule rules[DEGREES]; // of one to three points a direction

/// Tetrahedra from the origin to the fans of the faces, with a rule exact for degree `size`.
static void by_tetrahedra(int p, int size, double *moments) {
  const LthSimplexRule *rule = rules + size;
  for (int face = 3; face < 7; face++) { // the first three hold the origin
    LitheIndex loop[2], corner[3];
    double normal[3], bary[4];
    LthFaceView view = view_of(face, loop, normal);
    for (LthFan fan = lth_fan(&view); lth_fan_next(&fan, corner);) {
      const double *a = points[corner[0]], *b = points[corner[1]], *c = points[corner[2]];
      double volume = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0])) /
                      6;
      for (int k = 0; k < lth_simplex_rule_points(rule); k++) {
        double x[3], w = volume * lth_simplex_rule_point(rule, k, bary);
        for (int i = 0; i < 3; i++) x[i] = bary[1] * a[i] + bary[2] * b[i] + bary[3] * c[i];
        add_point(p, x, w, moments);
      }
    }
  }
}

/// The middles of size^3 cells that lie inside.
static void by_sampling(int p, int size, double *moments) {
  double h = 1. / size;
  for (int k = 0; k < size; k++)
    for (int j = 0; j < size; j++)
      for (int i = 0; i < size; i++) {
        const double x[3] = {h * (i + 0.5), h * (j + 0.5), h * (k + 0.5)};
        if (x[0] + x[1] + x[2] <= 2.5) add_point(p, x, h * h * h, moments);
      }
}

static double power(double x, int n) {
  double value = 1;
  while (n-- > 0) value *= x;
  return value;
}

static double choose(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; i++) value = value * (n - k + i) / i;
  return value;
}

/// The cube's moment less that of the corner, where x = 1 - s and s t u have sum <= 1/2: binomials and Dirichlet's
/// integral a! b! c! / (a + b + c + 3)! (1/2)^(a + b + c + 3).
static double exact_moment(const int e[3]) {
  double corner = 0;
  for (int a = 0; a <= e[0]; a++)
    for (int b = 0; b <= e[1]; b++)
      for (int c = 0; c <= e[2]; c++) {
        int n = a + b + c;
        corner += ((n & 1) ? -1 : 1) * choose(e[0], a) * choose(e[1], b) * choose(e[2], c) *
                  tgamma(a + 1) * tgamma(b + 1) * tgamma(c + 1) / tgamma(n + 4) * power(0.5, n + 3);
      }
  return 1. / ((e[0] + 1) * (e[1] + 1) * (e[2] + 1)) - corner;
}

/// Largest relative error of all moments, and the least seconds of five trials of a millisecond.
static double error_of(Integrate integrate, int p, int size, double *seconds) {
  double moments[MOMENTS_MAX] = {0}, worst = 0;
  integrate(p, size, moments);
  for (int q = 0; q < lth_monomials3(p); q++)
    worst = fmax(worst, fabs(moments[q] / exact_moment(lth_monomial3_exponents()[q]) - 1));
  *seconds = INFINITY;
  for (int trial = 0; trial < 5; trial++) {
    struct timespec from, to;
    int n = 0;
    double spent = 0;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    for (; spent < 1e-3; n++) {
      integrate(p, size, moments);
      clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
      spent = (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
    }
    *seconds = fmin(*seconds, spent / n);
  }
  return worst;
}

enum { TIME, ERROR, COLUMNS };

/// A sweep over `size`, as rows of a table of its own.
static LthTable *tabulate(LthStudyRun *run, const char *name, const char *caption,
                          Integrate integrate, int p, int n, const int *sizes) {
  LthTable *t = lth_study_table(&run->report, name, caption, NULL);
  lth_table_column(t, "time", "us", 3);
  lth_table_column(t, "largest relative error", "", 3);
  lth_table_column(t, "size", "", 0);
  for (int i = 0; i < n; i++) {
    double seconds, error = error_of(integrate, p, sizes[i], &seconds);
    // a plot with logarithmic axes shows no zeros
    lth_table_row(t, NULL, (double[]){1e6 * seconds, fmax(error, 1e-17), sizes[i]});
  }
  return t;
}

/// Error of sampling for what `time` pays: the last row that is not dearer.
static double error_for(const LthTable *t, double time) {
  double error = lth_table_at(t, 0, ERROR);
  for (int row = 0; row < t->n_rows && lth_table_at(t, row, TIME) <= time; row++)
    error = lth_table_at(t, row, ERROR);
  return error;
}

static LitheStatus run_degree(LthStudyRun *run, int p) {
  static const int one[] = {0}, tets[] = {1, 2, 3, 4}, grids[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
  LthStudyReport *r = &run->report;
  const LthTable *exact =
      tabulate(run, lth_study_print(run, "divergence-%d", p),
               lth_study_print(run, "Divergence theorem, moments to degree %d", p), by_divergence,
               p, 1, one);
  const LthTable *tet = tabulate(run, lth_study_print(run, "tetrahedra-%d", p),
                                 "Tetrahedra, size: degree of the rule", by_tetrahedra, p, 4, tets);
  const LthTable *grid =
      tabulate(run, lth_study_print(run, "sampling-%d", p), "Sampling, size: cells along a side",
               by_sampling, p, run->quick ? 8 : 10, grids);
  LthPlot *plot =
      lth_study_plot(r, lth_study_print(run, "plot-%d", p),
                     lth_study_print(run, "Moments of a corner-cut cube to degree %d (Fig. 4)", p),
                     "time [us]", "largest relative error [-]");
  plot->log_x = plot->log_y = true;
  lth_plot_series(plot, "sampling", grid, TIME, ERROR);
  lth_plot_series(plot, "tetrahedra", tet, TIME, ERROR);
  lth_plot_series(plot, "divergence theorem", exact, TIME, ERROR);
  double cost = lth_table_at(exact, 0, TIME);
  lth_study_at_most(
      r,
      lth_study_print(run, "degree %d: error of the divergence theorem, largest of all moments", p),
      lth_table_at(exact, 0, ERROR), 1e-14, "exact up to rounding");
  lth_study_at_least(r, lth_study_print(run, "degree %d: error of sampling at equal cost", p),
                     error_for(grid, cost), 1e-3,
                     "\"about 10^-2 for the same computation time\", within an order");
  lth_study_at_least(
      r,
      lth_study_print(run, "degree %d: error of tetrahedra at half the cost of the exact rule", p),
      lth_table_at(tet, 0, ERROR), 1e-2, "one point for each tetrahedron is all that fits there");
  lth_study_at_least(
      r,
      lth_study_print(run,
                      "degree %d: time of tetrahedra with an exact rule over that of the "
                      "divergence theorem",
                      p),
      lth_table_at(tet, p - 1, TIME) / cost, 0.5,
      "sub-tessellation is exact as well, but dearer as the degree grows; half: "
      "clocks of a shared machine");
  return LITHE_OK;
}

LitheStatus lth_study_integration(LthStudyRun *run) {
  for (int degree = 1; degree < DEGREES; degree++)
    LITHE_TRY(lth_simplex_rule(run->ctx, 3, degree, rules + degree));
  LITHE_TRY(run_degree(run, 2));
  return run_degree(run, 4);
}
