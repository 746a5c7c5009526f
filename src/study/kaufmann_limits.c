/// Figure 3: what DG tends to as the penalty grows, and as the material becomes stiff.
#include "study/kaufmann_studies.h"
#include "study/view.h"

static const char bar_scene[] =
    "# A bar of four cubes, clamped on the left, pulled down at its right end (Fig. 3).\n"
    "lithe: 1\n"
    "title: Bar\n"
    "bodies:\n"
    "  - name: bar\n"
    "    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}\n"
    "    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, cells: [8, 2, 2], mesh: tetrahedra}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}\n"
    "    loads:\n"
    "      - {where: {plane: {point: [4, 0, 0], normal: [1, 0, 0]}}, total_force: [0, 0, -0.001]}\n"
    "time: static\n"
    "solver: {linear: cholesky}\n"
    "probes:\n"
    "  - {name: tip, point: [4, 0.5, 0.5]}\n"
    "output: {fields: none}\n";

#define FORCE 0.001 // [N]
#define CELLS 4     // cubes of 1 m

/// `view` may be NULL.
static LitheStatus run_bar(LthStudyRun *run, const char *name, const char *method, double young,
                           LthView *view, double *tip) {
  const LthRunLook look = {lth_view_look, view};
  LthStudyResult r;
  const char *const sets[] = {lth_study_print(run, "bodies.0.method=%s", method),
                              lth_study_print(run, "bodies.0.material.young_modulus=%.17g", young)};
  LITHE_TRY(lth_study_run_with(run, name, bar_scene, 2, sets, view ? &look : NULL, &r));
  *tip = -lth_study_number(&r, "probes.tip.displacement.2");
  return LITHE_OK;
}

static const struct {
  const char *name, *method, *conforming;
} kinds[] = {
    {"BZ, tetrahedra", "{kind: dg, cells: [8, 2, 2], mesh: tetrahedra, flux: bz, penalty: %.17g}",
     "{kind: cg, cells: [8, 2, 2], mesh: tetrahedra}"},
    {"IP, tetrahedra", "{kind: dg, cells: [8, 2, 2], mesh: tetrahedra, flux: ip, penalty: %.17g}",
     "{kind: cg, cells: [8, 2, 2], mesh: tetrahedra}"},
    {"BZ, hexahedra", "{kind: dg, cells: [8, 2, 2], mesh: hexahedra, flux: bz, penalty: %.17g}",
     "{kind: cg, cells: [8, 2, 2], mesh: hexahedra}"}};

enum { BZ_TETS, IP_TETS, BZ_HEXES, N_KINDS };

static const double etas[] = {2, 10, 100, 1e3, 1e4, 1e5};
#define N_ETAS ((int)(sizeof etas / sizeof etas[0]))

enum { VIEW_CG, VIEW_SOFT, VIEW_STIFF, VIEW_RIGID, N_VIEWS };

static LitheStatus run_penalties(LthStudyRun *run, LthView views[N_VIEWS]) {
  LthStudyReport *r = &run->report;
  double conforming[N_KINDS];
  LthTable *t = lth_study_table(r, "penalty", "Deflection over that of CG on the same mesh", NULL);
  lth_table_column(t, "eta", "", 0);
  for (int k = 0; k < N_KINDS; k++) {
    lth_table_column(t, kinds[k].name, "", 5);
    LITHE_TRY(run_bar(run, lth_study_print(run, "cg-%d", k + 1), kinds[k].conforming, 1,
                      k == BZ_TETS ? views + VIEW_CG : NULL, conforming + k));
  }
  for (int i = 0; i < N_ETAS; i++) {
    double row[N_KINDS + 1] = {etas[i]};
    for (int k = 0; k < N_KINDS; k++) {
      LthView *view = i == 0 ? views + VIEW_SOFT : i == N_ETAS - 1 ? views + VIEW_STIFF : NULL;
      LITHE_TRY(run_bar(run, lth_study_print(run, "dg-%d-eta-%g", k + 1, etas[i]),
                        lth_study_print(run, kinds[k].method, etas[i]), 1,
                        k == BZ_TETS ? view : NULL, row + k + 1));
      row[k + 1] /= conforming[k];
    }
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot =
      lth_study_plot(r, "plot-penalty", "Towards CG as the penalty grows (Fig. 3, left)",
                     "penalty eta [-]", "deflection over that of CG [-]");
  plot->log_x = true;
  for (int k = 0; k < N_KINDS; k++) lth_plot_series(plot, kinds[k].name, t, 0, k + 1);
  int last = N_ETAS - 1;
  for (int k = BZ_TETS; k <= IP_TETS; k++) {
    double off = fabs(lth_table_at(t, last, k + 1) - 1),
           before = fabs(lth_table_at(t, last - 1, k + 1) - 1);
    lth_study_at_most(
        r, lth_study_print(run, "%s: off CG at the largest penalty, relative", kinds[k].name), off,
        1e-3,
        "continuous linear functions on tetrahedra are those of CG; the "
        "rest falls like 1 / eta");
    lth_study_at_most(
        r, lth_study_print(run, "%s: that over the one at a tenth of the penalty", kinds[k].name),
        off / before, 0.11, "like 1 / eta");
  }
  double shear = FORCE * CELLS * 2 * (1 + 0.3); // F L / (mu A), E = 1 Pa
  lth_study_at_most(
      r, "BZ, hexahedra: off a bar with one linear function, at the largest penalty, relative",
      fabs(lth_table_at(t, last, BZ_HEXES + 1) * conforming[BZ_HEXES] / shear - 1), 1e-3,
      "here the figure's claim fails: linear functions that are continuous across hexahedra are "
      "one linear function in all of the bar, which can shear but not bend: a large penalty locks "
      "(CG bends twenty times more). Lithe's own penalty holds the mean jump only and leaves the "
      "hinge its stiffness");
  return LITHE_OK;
}

// --- rigid cells ---

#define ETA 10. ///< of (20) to the letter [Pa m]

/// Rigid cubes with glue on their common faces, p = 2 eta in cubes of 1 m, and 4 eta towards the wall: each face gives
/// way by force / (p A) and turns by moment / (p I).
static double rigid_deflection(void) {
  double sum = 0;
  for (int face = 0; face < CELLS; face++) {
    double p = face == 0 ? 4 * ETA : 2 * ETA, arm = CELLS - face;
    sum += FORCE / p * (1 + arm * arm * 12);
  }
  return sum;
}

static LitheStatus run_stiffness(LthStudyRun *run, LthView *rigid_view) {
  static const double young[] = {1, 10, 1e2, 1e3, 1e4, 1e5, 1e6};
  const int n = (int)(sizeof young / sizeof young[0]);
  LthStudyReport *r = &run->report;
  double rigid = rigid_deflection();
  LthTable *t = lth_study_table(r, "stiffness",
                                "Deflection of four cubes, BZ with eta = 10 Pa m, over that of "
                                "rigid cells with the same glue",
                                NULL);
  lth_table_column(t, "E", "Pa", 0);
  lth_table_column(t, "deflection over rigid", "", 6);
  for (int i = 0; i < n; i++) {
    double row[2] = {young[i]};
    LITHE_TRY(run_bar(run, lth_study_print(run, "rigid-E-%g", young[i]),
                      lth_study_print(run,
                                      "{kind: dg, cells: [%d, 1, 1], mesh: hexahedra, flux: "
                                      "bz, penalty: {eta: %g, scale: none}}",
                                      CELLS, ETA),
                      young[i], i == n - 1 ? rigid_view : NULL, row + 1));
    row[1] /= rigid;
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot = lth_study_plot(
      r, "plot-stiffness", "Towards rigid cells as the material stiffens (Fig. 3, right)",
      "Young's modulus E [Pa]", "deflection over that of rigid cells [-]");
  plot->log_x = true;
  lth_plot_series(plot, "BZ, four cubes", t, 0, 1);
  double off = fabs(lth_table_at(t, n - 1, 1) - 1), before = fabs(lth_table_at(t, n - 2, 1) - 1);
  lth_study_at_most(r, "off rigid cells with glue (PriMo) at E = 1e6 Pa, relative", off, 1e-4,
                    "what the cells themselves give is of order eta / E");
  lth_study_at_most(r, "that over the one at E = 1e5 Pa", off / before, 0.11, "like 1 / E");
  return LITHE_OK;
}

LitheStatus lth_study_limits(LthStudyRun *run) {
  LthView views[N_VIEWS] = {
      {.run = run, .label = "CG", .times = 4},
      {.run = run, .label = "BZ, eta = 2", .times = 4},
      {.run = run, .label = "BZ, eta = 1e5", .times = 4},
      {.run = run, .label = "BZ, E = 1e6 Pa", .times = 80},
  };
  LITHE_TRY(run_penalties(run, views));
  LITHE_TRY(run_stiffness(run, views + VIEW_RIGID));
  return lth_views_draw(
      run, N_VIEWS, views, (const double[]){0.3, -1, 0.4}, (const double[]){0, 0, 1}, "bars",
      "The bar's elements where they are, displacements drawn 4 times as large: CG, DG with a "
      "small "
      "and with a large penalty; and stiff cells with glue, drawn 80 times as large");
}
