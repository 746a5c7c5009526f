/// An L-shaped solid with a re-entrant edge: what division, degree and both gain over cells of one size. The solution is the
/// singular mode of plane strain (Williams 1952): free at the edge's sides, no body force, given at the other ones.
#include "study/study_run.h"

#include "study/block_model.h"

/// Three blocks around the edge x = y = 0.
static void corner_map(int block, const double at[3], double x[3]) {
  static const double low[3][2] = {{-1, 0}, {0, 0}, {0, -1}};
  x[0] = low[block][0] + at[0], x[1] = low[block][1] + at[1], x[2] = 0.25 * at[2];
}

static const LthBlockModel corner = {3, corner_map, {1, 1, 1}, false};

/// Elastic constants of the scene and the exponent of the mode: alpha sin 2w + sin 2 alpha w = 0 for the half angle w = 3 pi / 4.
#define POISSON 0.3
#define SHEAR (1 / (2 * (1 + POISSON)))
#define EXPONENT 0.54448373678246

/// Energy of the mode in the solid: half the work of its tractions at the sides, by Gauss' rule.
#define EXACT_ENERGY 3.52162

// Radial and tangential displacement over r^alpha / 2 mu are -A cos(A p) + B cos(C p) and A sin(A p) - D sin(C p), p the angle from the
// line that halves the solid.
static const char scene[] =
    "lithe: 1\n"
    "title: The singular mode of an L between smooth plates\n"
    "bodies:\n"
    "  - name: corner\n"
    "    shape: {mesh: {file: corner.obj, unit: m}}\n"
    "    material: {model: linear, young_modulus: 1, poisson_ratio: %g, density: 1}\n"
    "    method: {kind: dg, grid: {min: [-1, -1, 0], max: [1, 1, 0.25], cells: [8, 8, 1]}, degree: "
    "2}\n"
    "    constraints:\n"
    "      - {where: {normal: [0, 0, 1]}, displacement: {normal: 0}}\n"
    "      - {where: {normal: [0, 0, -1]}, displacement: {normal: 0}}\n"
    "      - where:\n"
    "          or:\n"
    "            - {plane: {point: [1, 0, 0], normal: [1, 0, 0]}}\n"
    "            - {plane: {point: [0, 1, 0], normal: [0, 1, 0]}}\n"
    "            - {plane: {point: [-1, 0, 0], normal: [-1, 0, 0]}}\n"
    "            - {plane: {point: [0, -1, 0], normal: [0, -1, 0]}}\n"
    "        displacement: [&ux \"%s\", &uy \"%s\", null]\n"
    "gravity: [0, 0, 0]\n"
    "time: static\n"
    "exact: {displacement: [*ux, *uy, \"0\"]}\n"
    "output: {fields: none}\n";

/// One component of the mode, `along` and `across` the functions of the radial and the tangential direction's angle.
static const char *mode_component(LthStudyRun *run, const char *along, const char *sign,
                                  const char *across) {
  const double a = EXPONENT + 1, w = 0.75 * M_PI;
  const double lambda = 2 * SHEAR * POISSON / (1 - 2 * POISSON);
  const double c1 = -cos(a * w) / cos((EXPONENT - 1) * w),
               c2 = 2 * (lambda + 2 * SHEAR) / (lambda + SHEAR);
  const char *p = "atan2(y-x,x+y)";
  return lth_study_print(
      run,
      "(x*x+y*y)^%.15g*%.15g*((-%.15g*cos(%.15g*%s)+%.15g*cos(%.15g*%s))*%s(%s+pi/4)%s"
      "(%.15g*sin(%.15g*%s)-%.15g*sin(%.15g*%s))*%s(%s+pi/4))",
      EXPONENT / 2, 1 / (2 * SHEAR), a, a, p, (c2 - a) * c1, 1 - EXPONENT, p, along, p, sign, a, a,
      p, (c2 + EXPONENT - 1) * c1, 1 - EXPONENT, p, across, p);
}

static const char *scene_of(LthStudyRun *run) {
  return lth_study_print(run, scene, POISSON, mode_component(run, "cos", "-", "sin"),
                         mode_component(run, "sin", "+", "cos"));
}

enum { UNKNOWNS, ELEMENTS, ERROR, ERROR_L2, ENERGY, COLUMNS };

static LitheStatus solve(LthStudyRun *run, LthTable *t, const char *name, const char *text, int n,
                         const char *const *sets) {
  LthStudyResult r;
  LITHE_TRY(lth_study_run_with(run, name, text, n, sets, NULL, &r));
  double row[COLUMNS] = {lth_study_number(&r, "bodies.0.dofs"),
                         lth_study_number(&r, "bodies.0.elements"),
                         lth_study_number(&r, "error.h1"), lth_study_number(&r, "error.l2"),
                         lth_study_number(&r, "energy.strain")};
  lth_table_row(t, name, row);
  return LITHE_OK;
}

static LitheStatus add_uniform(LthStudyRun *run, LthTable *t, int degree, int n) {
  const char *const sets[] = {
      lth_study_print(run, "bodies.0.method.degree=%d", degree),
      lth_study_print(run, "bodies.0.method.grid.cells=[%d, %d, %d]", n, n, n / 8)};
  return solve(run, t, lth_study_print(run, "degree-%d-cells-%d", degree, n), scene_of(run), 2,
               sets);
}

static LitheStatus add_adaptive(LthStudyRun *run, LthTable *t, const char *kind, int level) {
  double threshold = 0.2 / pow(1.8, level);
  const char *p = kind[1] ? lth_study_print(run,
                                            "  p: {criterion: error-estimate, threshold: %.4g, "
                                            "max_degree: 4}\n",
                                            threshold)
                          : "";
  const char *text = lth_study_print(run,
                                     "%sadapt:\n  h: {criterion: error-estimate, threshold: %.4g, "
                                     "max_level: %d}\n%s",
                                     scene_of(run), threshold, level, p);
  return solve(run, t, lth_study_print(run, "%s-level-%d", kind, level), text, 0, NULL);
}

/// Unknowns that a series needs for an error: between its points errors fall as powers of them.
static double unknowns_for(const LthTable *t, int first, int last, double error) {
  for (int i = first; i + 1 < last; i++) {
    double e0 = lth_table_at(t, i, ERROR), e1 = lth_table_at(t, i + 1, ERROR),
           n0 = lth_table_at(t, i, UNKNOWNS), n1 = lth_table_at(t, i + 1, UNKNOWNS);
    if (error <= e0 && error >= e1) return n0 * pow(n1 / n0, log(e0 / error) / log(e0 / e1));
  }
  double e0 = lth_table_at(t, last - 2, ERROR), e1 = lth_table_at(t, last - 1, ERROR),
         n0 = lth_table_at(t, last - 2, UNKNOWNS), n1 = lth_table_at(t, last - 1, UNKNOWNS);
  return n1 * pow(n1 / n0, log(e1 / error) / log(e0 / e1)); // beyond its end as it fell last
}

static LitheStatus study(LthStudyRun *run) {
  LthStudyReport *r = &run->report;
  int n_levels = run->quick ? 3 : 4, first[5] = {0};
  LITHE_TRY(lth_block_model_surface(run, &corner, 1, "corner"));
  LthTable *t =
      lth_study_table(r, "corner", "Errors against the exact solution, L2 over the solid", "cells");
  lth_table_column(t, "unknowns", "", 6);
  lth_table_column(t, "elements", "", 6);
  lth_table_column(t, "error of the gradient", "", 3);
  lth_table_column(t, "error of the displacement", "", 3);
  lth_table_column(t, "strain energy", "J", 6);
  for (int k = 1; k <= 3; k++) {
    int n_cells = k == 1 ? 32 : 16;
    for (int n = 8; n <= n_cells; n *= 2) LITHE_TRY(add_uniform(run, t, k, n));
    first[k] = t->n_rows;
  }
  for (int level = 1; level <= n_levels - 1; level++) LITHE_TRY(add_adaptive(run, t, "h", level));
  first[4] = t->n_rows;
  for (int level = 1; level <= n_levels; level++) LITHE_TRY(add_adaptive(run, t, "hp", level));
  static const char *const names[] = {"one size, degree 1", "one size, degree 2",
                                      "one size, degree 3", "division, degree 2"};
  LthPlot *plot = lth_study_plot(r, "corner", "The singular mode of an L; orders in unknowns",
                                 "unknowns [-]", "L2 error of the gradient [-]");
  plot->log_x = plot->log_y = true;
  for (int i = 0; i < 4; i++)
    lth_plot_rows(plot, names[i], t, UNKNOWNS, ERROR, first[i], first[i + 1]);
  lth_plot_rows(plot, "division and degree", t, UNKNOWNS, ERROR, first[4], t->n_rows);
  plot->orders = LTH_PLOT_ORDERS_BESIDE;
  for (int i = 0; i < plot->n_series; i++) plot->series[i].cells = UNKNOWNS;
  double error = lth_table_at(t, t->n_rows - 1, ERROR),
         unknowns = lth_table_at(t, t->n_rows - 1, UNKNOWNS);
  lth_study_say(r,
                "Cells of one size would need %.3g unknowns of degree 2 for the last error, "
                "division alone %.3g, division and degree %.3g.",
                unknowns_for(t, first[1], first[2], error),
                unknowns_for(t, first[3], first[4], error), unknowns);
  for (int i = 0; i < 3; i++)
    lth_study_at_most(
        r, lth_study_print(run, "unknowns of hp over those of %s, for hp's last error", names[i]),
        unknowns / unknowns_for(t, first[i], first[i + 1], error), 0.1,
        "where one edge limits the order, refinement at the edge alone is due");
  lth_study_at_most(r, "unknowns of hp over those of division alone, for hp's last error",
                    unknowns / unknowns_for(t, first[3], first[4], error), 1,
                    "away from the edge the solution is smooth, and degrees gain more");
  lth_study_at_most(r, "energy of hp's last level against that of the mode",
                    fabs(lth_table_at(t, t->n_rows - 1, ENERGY) / EXACT_ENERGY - 1), 0.002,
                    "its boundary is given to all digits");
  return LITHE_OK;
}

const LthStudy lth_studies_adapt[] = {
    {"adapt/corner", "Division and degree at a re-entrant edge",
     "How many unknowns do cells of one size, division, and division with degree need?", study},
    {0}};
