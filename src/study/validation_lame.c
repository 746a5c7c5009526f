/// Validation: walls under pressure and a plate with a hole, whose displacement is known everywhere.
#include "study/validation_studies.h"

#define YOUNG 1e6
#define POISSON 0.3
#define INNER 1.0
#define OUTER 2.0
#define PRESSURE 1e3
#define PULL 1e3  ///< far from the hole [Pa]
#define PLATE 4.0 ///< side of the quarter [m]

#define MATERIAL "{model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}"
#define NEAR_X                                                                                     \
  "{and: [{normal: [-1, 0, 0], within: 1 deg}, {plane: {point: [1 um, 0, 0], normal: [-1, 0, "     \
  "0]}}]}"
#define NEAR_Y                                                                                     \
  "{and: [{normal: [0, -1, 0], within: 1 deg}, {plane: {point: [0, 1 um, 0], normal: [0, -1, "     \
  "0]}}]}"
#define NEAR_Z                                                                                     \
  "{and: [{normal: [0, 0, -1], within: 1 deg}, {plane: {point: [0, 0, 1 um], normal: [0, 0, "      \
  "-1]}}]}"
#define BOTH_Z "{or: [{normal: [0, 0, 1]}, {normal: [0, 0, -1]}]}"
#define HELD(where, displacement) "      - {where: " where ", displacement: " displacement "}\n"
#define END                                                                                        \
  "gravity: [0, 0, 0]\n"                                                                           \
  "time: {kind: static}\n"                                                                         \
  "output: {every: last, fields: none}\n"

static const char error_reason[] =
    "1 % of the largest displacement is what an engineer asks for; the finest level has some "
    "hundred elements";
static const char stress_reason[] = "stress is one order below displacement";

// --- cylinder ---

static void cylinder_map(int block, const double at[3], double x[3]) {
  (void)block;
  double r = INNER + (OUTER - INNER) * at[0], angle = M_PI / 2 * at[1];
  x[0] = r * cos(angle), x[1] = r * sin(angle), x[2] = 0.5 * at[2];
}

static const LthBlockModel cylinder = {1, cylinder_map, {2, 3, 1}, false};

static const char cylinder_scene[] =
    "lithe: 1\n"
    "title: Thick-walled cylinder under inner pressure (plane strain)\n"
    "bodies:\n"
    "  - name: wall\n"
    "    shape: {mesh: {file: body.obj}}\n"
    "    material: " MATERIAL "\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n" HELD(NEAR_X, "[0, null, null]") HELD(NEAR_Y, "[null, 0, null]")
        HELD(BOTH_Z, "[null, null, 0]") "    loads: # the flat sides are held: what is left of the "
                                        "boundary in there is the inner wall\n"
                                        "      - {where: {cylinder: {from: [0, 0, -1], to: [0, 0, "
                                        "2], radius: 1.2}}, pressure: 1 kPa}\n"
                                        "exact: {displacement: [\"x*(%.17g+%.17g/(x^2+y^2))\", "
                                        "\"y*(%.17g+%.17g/(x^2+y^2))\", \"0\"]}\n"
                                        "probes: [{name: inner, point: [0.8, 0.8, 0.25]}]\n" END;

/// Lame: u_r = A r + B / r; sigma_rr, sigma_tt = p a^2 / (b^2 - a^2) (1 -+ b^2 / r^2), sigma_zz = nu of their sum.
LitheStatus lth_study_cylinder(LthStudyRun *run) {
  double a2 = INNER * INNER, b2 = OUTER * OUTER, share = PRESSURE * a2 / (b2 - a2), r2 = 2 * 0.64;
  double A = (1 + POISSON) * (1 - 2 * POISSON) * share / YOUNG,
         B = (1 + POISSON) * share * b2 / YOUNG, s[3];
  s[0] = share * (1 - b2 / r2), s[1] = share * (1 + b2 / r2), s[2] = POISSON * (s[0] + s[1]);
  LthCase c = {
      .name = "cylinder",
      .scene = lth_study_print(run, cylinder_scene, A, B, A, B),
      .model = &cylinder,
      .surface_level = 12,
      .n_quantities = 2,
      .quantity = {{"displacement (root mean square)", "m", "error.l2", 0,
                    (A * INNER + B / INNER) * sqrt(M_PI / 4 * (b2 - a2) * 0.5), 0.01, error_reason},
                   {"von Mises at the inner probe", "Pa", "probes.inner.von_mises",
                    sqrt(0.5 * ((s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) +
                                (s[2] - s[0]) * (s[2] - s[0]))),
                    0, 0.03, stress_reason}},
      .n_methods = 4,
      .method = {lth_case_dg_sliced(4, 8, 16), lth_case_dg_mesh(2, 4, 8), lth_case_cg_mesh(1, 2, 4),
                 lth_case_staggered(16, 32, 64)}};
  return lth_case_run(run, &c);
}

// --- sphere ---

/// A third of an octant around an axis: a quadrilateral on the sphere.
static void sphere_map(int block, const double at[3], double x[3]) {
  double corner[4][3] = {{0}}, n[3], length = 0;
  for (int k = 0; k < 3; k++) {
    corner[0][k] = k == block;
    corner[1][k] = k == block || k == (block + 1) % 3;
    corner[2][k] = k == block || k == (block + 2) % 3;
    corner[3][k] = 1;
  }
  for (int c = 0; c < 4; c++) {
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += corner[c][k] * corner[c][k];
    for (int k = 0; k < 3; k++) corner[c][k] /= sqrt(sum);
  }
  for (int k = 0; k < 3; k++) {
    n[k] = (1 - at[1]) * ((1 - at[0]) * corner[0][k] + at[0] * corner[1][k]) +
           at[1] * ((1 - at[0]) * corner[2][k] + at[0] * corner[3][k]);
    length += n[k] * n[k];
  }
  for (int k = 0; k < 3; k++) x[k] = (INNER + (OUTER - INNER) * at[2]) * n[k] / sqrt(length);
}

static const LthBlockModel sphere = {3, sphere_map, {1, 1, 2}, false};

static const char sphere_scene[] =
    "lithe: 1\n"
    "title: Hollow sphere under inner pressure\n"
    "bodies:\n"
    "  - name: wall\n"
    "    shape: {mesh: {file: body.obj}}\n"
    "    material: " MATERIAL "\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n" HELD(NEAR_X, "[0, null, null]") HELD(NEAR_Y, "[null, 0, null]") HELD(
        NEAR_Z, "[null, null, 0]") "    loads: # the flat sides are held: what is left of the "
                                   "boundary in there is the inner wall\n"
                                   "      - {where: {sphere: {center: [0, 0, 0], radius: 1.2}}, "
                                   "pressure: 1 kPa}\n"
                                   "exact: {displacement: [\"x*(%.17g+%.17g/(x^2+y^2+z^2)^1.5)\", "
                                   "\"y*(%.17g+%.17g/(x^2+y^2+z^2)^1.5)\", "
                                   "\"z*(%.17g+%.17g/(x^2+y^2+z^2)^1.5)\"]}\n"
                                   "probes: [{name: inner, point: [0.7, 0.7, 0.7]}]\n" END;

/// Lame: u_r = A r + B / r^2; von Mises is |sigma_rr - sigma_tt| = 3/2 p a^3 / (b^3 - a^3) b^3 / r^3.
LitheStatus lth_study_sphere(LthStudyRun *run) {
  double a3 = pow(INNER, 3), b3 = pow(OUTER, 3), share = PRESSURE * a3 / (b3 - a3);
  double A = (1 - 2 * POISSON) * share / YOUNG, B = (1 + POISSON) * share * b3 / (2 * YOUNG);
  LthCase c = {.name = "sphere",
               .scene = lth_study_print(run, sphere_scene, A, B, A, B, A, B),
               .model = &sphere,
               .surface_level = 16,
               .n_quantities = 2,
               .quantity = {{"displacement (root mean square)", "m", "error.l2", 0,
                             (A * INNER + B / (INNER * INNER)) * sqrt(M_PI / 6 * (b3 - a3)), 0.01,
                             error_reason},
                            {"von Mises at the inner probe", "Pa", "probes.inner.von_mises",
                             1.5 * share * b3 / pow(3 * 0.49, 1.5), 0, 0.03, stress_reason}},
               .n_methods = 4,
               .method = {lth_case_dg_sliced(3, 6, 12), lth_case_dg_mesh(2, 4, 8),
                          lth_case_cg_mesh(1, 2, 4), lth_case_staggered(12, 24, 48)}};
  return lth_case_run(run, &c);
}

// --- plate with a hole ---

/// From the hole to the sides of the square, in two halves, finer towards the hole.
static void plate_map(int block, const double at[3], double x[3]) {
  double angle = M_PI / 4 * (at[1] + block), s = at[0] * (0.4 + 0.6 * at[0]);
  double outer[2] = {block == 0 ? PLATE : PLATE / tan(angle),
                     block == 0 ? PLATE * tan(angle) : PLATE};
  x[0] = (1 - s) * INNER * cos(angle) + s * outer[0];
  x[1] = (1 - s) * INNER * sin(angle) + s * outer[1];
  x[2] = 0.5 * at[2];
}

static const LthBlockModel plate = {2, plate_map, {3, 2, 1}, false};

#define ANGLE "atan2(y,x)"
#define SXX                                                                                        \
  "1000*(1-(1.5*cos(2*" ANGLE ")+cos(4*" ANGLE "))/(x^2+y^2)+1.5*cos(4*" ANGLE ")/(x^2+y^2)^2)"
#define SYY                                                                                        \
  "1000*(-(0.5*cos(2*" ANGLE ")-cos(4*" ANGLE "))/(x^2+y^2)-1.5*cos(4*" ANGLE ")/(x^2+y^2)^2)"
#define SXY                                                                                        \
  "1000*(-(0.5*sin(2*" ANGLE ")+sin(4*" ANGLE "))/(x^2+y^2)+1.5*sin(4*" ANGLE ")/(x^2+y^2)^2)"

#define R2 "(x^2+y^2)"
#define X3 "x*(x^2-3*y^2)"
#define Y3 "y*(3*x^2-y^2)"

static const char plate_scene[] =
    "lithe: 1\n"
    "title: Hole in an infinite plate that is pulled along x (plane strain)\n"
    "bodies:\n"
    "  - name: plate\n"
    "    shape: {mesh: {file: body.obj}}\n"
    "    material: " MATERIAL "\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n" HELD(NEAR_X, "[0, null, null]") HELD(NEAR_Y, "[null, 0, null]") HELD(
        BOTH_Z,
        "[null, null, 0]") "    loads: # the stress of the infinite plate where it was cut out\n"
                           "      - {where: {plane: {point: [3999.9 mm, 0, 0], normal: [1, 0, "
                           "0]}}, traction: [\"" SXX "\", \"" SXY "\", 0]}\n"
                           "      - {where: {plane: {point: [0, 3999.9 mm, 0], normal: [0, 1, "
                           "0]}}, traction: [\"" SXY "\", \"" SYY "\", 0]}\n"
                           "exact: # in powers of x and y: cos(3 t) = (x^3 - 3 x y^2) / r^3\n"
                           "  displacement:\n"
                           "    - \"%.17g*(%.17g*x+2*(%.17g*x+" X3 "/" R2 ")/" R2 "-2*" X3 "/" R2
                           "^3)\"\n"
                           "    - \"%.17g*(%.17g*y+2*(%.17g*y+" Y3 "/" R2 ")/" R2 "-2*" Y3 "/" R2
                           "^3)\"\n"
                           "    - \"0\"\n"
                           "probes: [{name: top, point: [0.02, 1.1, 0.25]}]\n" END;

/// Kirsch, in Muskhelishvili's form with kappa = 3 - 4 nu; radius 1.
LitheStatus lth_study_kirsch(LthStudyRun *run) {
  double kappa = 3 - 4 * POISSON, factor = PULL * (1 + POISSON) / (4 * YOUNG);
  double r2 = 0.02 * 0.02 + 1.1 * 1.1, angle = atan2(1.1, 0.02);
  double sxx =
      PULL * (1 - (1.5 * cos(2 * angle) + cos(4 * angle)) / r2 + 1.5 * cos(4 * angle) / (r2 * r2));
  LthCase c = {
      .name = "kirsch",
      .scene = lth_study_print(run, plate_scene, factor, kappa + 1, 1 + kappa, factor, kappa - 3,
                               1 - kappa),
      .model = &plate,
      .surface_level = 16,
      .n_quantities = 2,
      .quantity = {{"displacement (root mean square)", "m", "error.l2", 0,
                    factor * (kappa + 1) * PLATE * sqrt((PLATE * PLATE - M_PI / 4) * 0.5), 0.01,
                    error_reason},
                   {"stress xx above the hole", "Pa", "probes.top.stress.0", sxx, 0, 0.05,
                    "a tenth of a radius from the hole the stress changes by half over a radius"}},
      .n_methods = 4,
      .method = {lth_case_dg_sliced(8, 16, 32), lth_case_dg_mesh(2, 4, 8),
                 lth_case_cg_mesh(1, 2, 4), lth_case_staggered(32, 64, 128)}};
  return lth_case_run(run, &c);
}
