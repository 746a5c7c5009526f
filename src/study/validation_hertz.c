/// Validation: a rigid sphere pressed into a half space (Hertz).
#include "study/validation_studies.h"

#define YOUNG 1e6
#define POISSON 0.3
#define RADIUS 10.0 ///< of the sphere; the contact's is a hundredth, Hertz takes that for nothing
#define DEPTH 0.001 ///< it goes in
#define SIDE 0.5    ///< of the block, five contact radii

/// Cells towards the contact are smaller.
static void block_map(int block, const double at[3], double x[3]) {
  (void)block;
  x[0] = SIDE * at[0] * at[0], x[1] = SIDE * at[1] * at[1];
  x[2] = -SIDE * (1 - at[2]) * (1 - at[2]);
}

static const LthBlockModel model = {1, block_map, {4, 4, 4}, false};

static const char scene[] =
    "lithe: 1\n"
    "title: A rigid sphere pressed into a half space\n"
    "# A quarter of a block. Its far sides move as they do in the half space under a point force "
    "(Boussinesq).\n"
    "bodies:\n"
    "  - name: block\n"
    "    shape: {box: {min: [0, 0, -0.5], max: [0.5, 0.5, 0]}}\n"
    "    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0.1 mm, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, null, "
    "null]}\n"
    "      - {where: {plane: {point: [0, 0.1 mm, 0], normal: [0, -1, 0]}}, displacement: [null, 0, "
    "null]}\n"
    "      - where: {or: [{plane: {point: [499.9 mm, 0, 0], normal: [1, 0, 0]}}, {plane: {point: "
    "[0, 499.9 mm, 0], normal: [0, 1, 0]}}, "
    "{plane: {point: [0, 0, -499.9 mm], normal: [0, 0, -1]}}]}\n"
    "        displacement: [\"x*%s\", \"y*%s\", \"%s\"]\n"
    "colliders:\n"
    "  - sphere: {center: [0, 0, 9.999], radius: 10}\n"
    "contact: {friction: 0, stiffness: 1e10} # presses in by 0.07 %% of the depth\n"
    "gravity: [0, 0, 0]\n"
    "time: {kind: static}\n"
    "probes: [{name: below, point: [1 mm, 1 mm, -48 mm]}]\n"
    "output: {every: last, fields: none}\n";

/// F = 4/3 E' sqrt(R) d^1.5, E' = E / (1 - nu^2); on the axis at depth z = 0.48 a: sigma_zz = -p0 / (1 + z^2 / a^2).
LitheStatus lth_study_hertz(LthStudyRun *run) {
  double plane = YOUNG / (1 - POISSON * POISSON), mu = YOUNG / (2 * (1 + POISSON));
  double a = sqrt(RADIUS * DEPTH), force = 4. / 3 * plane * sqrt(RADIUS) * pow(DEPTH, 1.5);
  double p0 = 3 * force / (2 * M_PI * a * a), z = 0.048;
  const char *r = "sqrt(x^2+y^2+z^2)";
  const char *side = lth_study_print(run, "%.17g*(-z/%s^3-%.17g/(%s*(%s-z)))",
                                     force / (4 * M_PI * mu), r, 1 - 2 * POISSON, r, r);
  const char *down = lth_study_print(run, "-%.17g*(z^2/%s^3+%.17g/%s)", force / (4 * M_PI * mu), r,
                                     2 * (1 - POISSON), r);
  LthCase c = {
      .name = "hertz",
      .scene = lth_study_print(run, scene, side, side, down),
      .model = &model,
      .n_quantities = 2,
      .quantity =
          {{"force of a quarter", "N", "contact.force", force / 4, 0, 0.05,
            "points touch or do not: the contact's edge is known to a part of a cell; slopes "
            "and the far sides, which are those of a point force, are good for 0.2 %"},
           {"stress zz below the contact", "Pa", "probes.below.stress.2",
            -p0 / (1 + z * z / (a * a)), 0, 0.1,
            "with the force given, a stress at half a contact radius falls by 1.6 times "
            "what the radius is off, which is known to a part of a cell: two to three "
            "cells are the radius here"}},
      .n_methods = 5,
      .method = {lth_case_dg_sliced(6, 9, 12),
                 {"dg, file mesh",
                  "{kind: dg, mesh: {file: hex8-%d.msh}, degree: 1}",
                  LTH_CASE_LINEAR_MESH,
                  3,
                  {2, 3, 4}},
                 {"cg, file mesh, linear",
                  "{kind: cg, mesh: {file: hex8-%d.msh}, degree: 1}",
                  LTH_CASE_LINEAR_MESH,
                  3,
                  {2, 3, 4}},
                 {"cg, file mesh, quadratic",
                  "{kind: cg, mesh: {file: hex27-%d.msh}, degree: 2}",
                  LTH_CASE_QUADRATIC_MESH,
                  2,
                  {1, 2}},
                 {"staggered", "{kind: staggered, cells: %d}", LTH_CASE_NO_MESH, 3, {12, 20, 32}}}};
  return lth_case_run(run, &c);
}
