/// Validation: two benchmarks of NAFEMS ("The Standard NAFEMS Benchmarks", LE1 and LE10), as solids.
#include "study/validation_studies.h"

#define MATERIAL "{model: linear, young_modulus: 210 GPa, poisson_ratio: 0.3, density: 7800}"
#define SIDES                                                                                      \
  "      - {where: {and: [{normal: [-1, 0, 0], within: 2 deg}, {plane: {point: [1 um, 0, 0], "     \
  "normal: [-1, 0, 0]}}]}, displacement: [0, null, null]}\n"                                       \
  "      - {where: {and: [{normal: [0, -1, 0], within: 2 deg}, {plane: {point: [0, 1 um, 0], "     \
  "normal: [0, -1, 0]}}]}, displacement: [null, 0, null]}\n"
/// Between the ellipses and beyond their middle, but not the flat sides.
#define OUTER_SIDE                                                                                 \
  "{implicit: \"1-(x/2.9)^2-(y/2.3)^2\"}, {not: {or: [{normal: [-1, 0, 0], within: 2 deg}, "       \
  "{normal: [0, -1, 0], within: 2 deg}, {normal: [0, 0, 1]}, {normal: [0, 0, -1]}]}}"
#define END                                                                                        \
  "gravity: [0, 0, 0]\n"                                                                           \
  "time: {kind: static}\n"                                                                         \
  "output: {every: last, fields: none}\n"

/// A quarter between the ellipses (2, 1) and (3.25, 2.75).
static void ellipse(const double at[3], double thickness, double x[3]) {
  double angle = M_PI / 2 * at[1], s = at[0];
  x[0] = ((1 - s) * 2 + s * 3.25) * cos(angle);
  x[1] = ((1 - s) * 1 + s * 2.75) * sin(angle);
  x[2] = thickness * at[2];
}

static void membrane_map(int block, const double at[3], double x[3]) {
  (void)block;
  ellipse(at, 0.1, x);
}

static void plate_map(int block, const double at[3], double x[3]) {
  (void)block;
  ellipse(at, 0.6, x);
}

static const LthBlockModel membrane = {1, membrane_map, {2, 4, 1}, true},
                           plate = {1, plate_map, {2, 4, 1}, false};

static const char membrane_scene[] = "lithe: 1\n"
                                     "title: NAFEMS LE1, elliptic membrane\n"
                                     "bodies:\n"
                                     "  - name: membrane\n"
                                     "    shape: {mesh: {file: body.obj}}\n"
                                     "    material: " MATERIAL "\n"
                                     "    method: {kind: dg, cells: 8, degree: 2}\n"
                                     "    constraints:\n" SIDES "      - {where: {normal: [0, 0, "
                                     "-1], within: 1 deg}, displacement: [null, null, 0]}\n"
                                     "    loads:\n"
                                     "      - {where: {and: [" OUTER_SIDE "]}, pressure: -10 MPa}\n"
                                     "probes: [{name: D, point: [2.001, 0.001, 0.05]}]\n" END;

LitheStatus lth_study_le1(LthStudyRun *run) {
  LthCase c = {
      .name = "le1",
      .scene = membrane_scene,
      .model = &membrane,
      .surface_level = 8,
      .n_quantities = 1,
      .quantity = {{"stress yy at D", "Pa", "probes.D.stress.1", 92.7e6, 0, 0.04,
                    "a stress at a corner of the body; NAFEMS' target is that of plane stress"}},
      .n_methods = 3,
      .method = {lth_case_dg_sliced(16, 32, 64), lth_case_dg_mesh(4, 8, 16),
                 lth_case_cg_mesh(1, 2, 4)}};
  return lth_case_run(run, &c);
}

static const char plate_scene[] =
    "lithe: 1\n"
    "title: NAFEMS LE10, thick plate under pressure\n"
    "bodies:\n"
    "  - name: plate\n"
    "    shape: {mesh: {file: body.obj}}\n"
    "    material: " MATERIAL "\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n" SIDES "      - {where: {and: [" OUTER_SIDE
    "]}, displacement: [0, 0, null]}\n"
    "      # the benchmark holds the middle line of that side\n"
    "      - {where: {and: [" OUTER_SIDE
    ", {box: {min: [-1, -1, 0.25], max: [4, 4, 0.35]}}]}, displacement: [null, null, 0]}\n"
    "    loads:\n"
    "      - {where: {normal: [0, 0, 1], within: 1 deg}, pressure: 1 MPa}\n"
    "probes: [{name: D, point: [2.001, 0.001, 0.6]}]\n" END;

LitheStatus lth_study_le10(LthStudyRun *run) {
  LthCase c = {
      .name = "le10",
      .scene = plate_scene,
      .model = &plate,
      .surface_level = 8,
      .n_quantities = 1,
      .quantity =
          {{"stress yy at D", "Pa", "probes.D.stress.1", -5.38e6, 0, 0.05,
            "a stress at a corner of the body; the line that holds it is a strip of 0.1 m here"}},
      .n_methods = 3,
      .method = {lth_case_dg_sliced(9, 18, 36), lth_case_dg_mesh(2, 4, 8),
                 lth_case_cg_mesh(1, 2, 4)}};
  return lth_case_run(run, &c);
}
