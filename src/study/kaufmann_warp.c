/// The video's comparison of warped and linear elasticity: a bar that bends far.
#include "study/kaufmann_studies.h"

#define PROBES 9 // along the axis

static const char bar_scene[] =
    "lithe: 1\n"
    "title: Warped bar\n"
    "bodies:\n"
    "  - name: bar\n"
    "    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}\n"
    "    material: {model: corotated, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, cells: [8, 2, 2], mesh: hexahedra, degree: 2}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}\n"
    "gravity: [0, 0, 0]\n"
    "time: static\n"
    "output: {fields: none}\n"
    "probes:\n";

enum {
  WEIGHT,
  LINEAR_LENGTH,
  LINEAR_VOLUME,
  LINEAR_TIP,
  WARPED_LENGTH,
  WARPED_VOLUME,
  WARPED_TIP,
  COLUMNS
};

/// Largest relative growth of a cell's volume, det F - 1 at centroids weighed by volume.
static LitheStatus look_at_volume(void *user, LitheCtx *ctx, const LthWorld *world,
                                  LitheIndex frame) {
  const LthBody *body = world->bodies[0];
  const double *x = lth_body_position(body);
  double now = 0, rest = 0;
  (void)ctx;
  (void)frame;
  for (LitheIndex c = 0; c < body->space->n_cells; c++) {
    double f[9], volume = lth_body_cell_volume(body, c);
    lth_dg_sample_gradient(body->space, c, x, body->space->center + 3 * c, f);
    rest += volume;
    now += volume * (f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
                     f[2] * (f[3] * f[7] - f[4] * f[6]));
  }
  *(double *)user = now / rest - 1;
  return LITHE_OK;
}

/// Growth of length and volume of the bar, and how far its end comes down.
static LitheStatus run_bar(LthStudyRun *run, const char *scene, const char *model, double weight,
                           double out[3]) {
  LthStudyResult r;
  double volume = NAN, at[PROBES][3];
  LthRunLook look = {look_at_volume, &volume};
  const char *const sets[] = {lth_study_print(run, "bodies.0.material.model=%s", model),
                              lth_study_print(run, "gravity=[0, 0, %.17g]", -weight)};
  LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "%s-%g", model, weight), scene, 2, sets,
                               &look, &r));
  double length = 0;
  for (int i = 0; i < PROBES; i++) {
    double step = 0;
    for (int a = 0; a < 3; a++) {
      at[i][a] = (a == 0 ? 4. * i / (PROBES - 1) : 0.5) +
                 lth_study_number(&r, lth_study_print(run, "probes.p%d.displacement.%d", i, a));
      if (i > 0) step += pow(at[i][a] - at[i - 1][a], 2);
    }
    length += sqrt(step);
  }
  out[0] = length / 4 - 1;
  out[1] = volume;
  out[2] = 0.5 - at[PROBES - 1][2];
  return LITHE_OK;
}

LitheStatus lth_study_warping(LthStudyRun *run) {
  static const double weights[] = {0.5, 1, 2, 5, 10};
  LthStudyReport *r = &run->report;
  const char *scene = bar_scene;
  for (int i = 0; i < PROBES; i++)
    scene = lth_study_print(run, "%s  - {name: p%d, point: [%g, 0.5, 0.5]}\n", scene, i,
                            4. * i / (PROBES - 1));
  LthTable *t = lth_study_table(r, "growth",
                                "A clamped bar of 4 x 1 x 1 m, E = 1 kPa, under its weight", NULL);
  lth_table_column(t, "weight", "N/m^3", 2);
  lth_table_column(t, "linear: growth of length", "", 2);
  lth_table_column(t, "linear: growth of volume", "", 2);
  lth_table_column(t, "linear: tip", "m", 4);
  lth_table_column(t, "warped: growth of length", "", 2);
  lth_table_column(t, "warped: growth of volume", "", 2);
  lth_table_column(t, "warped: tip", "m", 4);
  int n = run->quick ? 4 : 5;
  for (int i = 0; i < n; i++) {
    double row[COLUMNS] = {weights[i]};
    LITHE_TRY(run_bar(run, scene, "linear", weights[i], row + LINEAR_LENGTH));
    LITHE_TRY(run_bar(run, scene, "corotated", weights[i], row + WARPED_LENGTH));
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot = lth_study_plot(r, "growth", "Growth of a bending bar", "weight [N/m^3]",
                                 "relative growth [-]");
  plot->log_x = true;
  lth_plot_series(plot, "linear: volume", t, WEIGHT, LINEAR_VOLUME);
  lth_plot_series(plot, "linear: length", t, WEIGHT, LINEAR_LENGTH);
  lth_plot_series(plot, "warped: volume", t, WEIGHT, WARPED_VOLUME);
  lth_plot_series(plot, "warped: length", t, WEIGHT, WARPED_LENGTH);
  const int row = 3; // weight 5
  lth_study_at_least(r, "weight 5: growth of the volume, linear",
                     lth_table_at(t, row, LINEAR_VOLUME), 0.05,
                     "\"an unrealistic increase in volume\"");
  lth_study_at_most(
      r, "weight 5: growth of the volume, warped", lth_table_at(t, row, WARPED_VOLUME), 0.01,
      "turns strain nothing; what is left is second order in the strain, below 10 % here");
  lth_study_at_most(r, "weight 5: growth of the length, warped over linear",
                    lth_table_at(t, row, WARPED_LENGTH) / lth_table_at(t, row, LINEAR_LENGTH), 0.25,
                    "the same");
  lth_study_at_most(r, "weight 5: tip of the warped bar off an independent program's, relative",
                    fabs(lth_table_at(t, row, WARPED_TIP) / 1.72 - 1), 0.01,
                    "1.706 to 1.726 on two finer meshes with another penalty");
  lth_study_at_most(r, "weight 0.5: warped tip off the linear one, relative",
                    fabs(lth_table_at(t, 0, WARPED_TIP) / lth_table_at(t, 0, LINEAR_TIP) - 1), 0.01,
                    "small loads do not tell the two apart");
  return LITHE_OK;
}
