/// Validation: bodies between plane sides - constant strain, Timoshenko's cantilever, Cook's membrane.
#include "study/validation_studies.h"

#define LENGTH 8.0 ///< of the cantilever
#define DEPTH 2.0
#define YOUNG 1e6
#define POISSON 0.3
#define FORCE 1e3 ///< at its end, a metre of thickness [N/m]

#define END                                                                                        \
  "gravity: [0, 0, 0]\n"                                                                           \
  "time: {kind: static}\n"                                                                         \
  "output: {every: last, fields: none}\n"

// --- constant strain by a load ---

/// A cube whose cells are crooked inside and straight on its sides.
static void crooked_map(int block, const double at[3], double x[3]) {
  (void)block;
  double bump = sin(M_PI * at[0]) * sin(M_PI * at[1]) * sin(M_PI * at[2]);
  x[0] = at[0] + 0.08 * bump, x[1] = at[1] - 0.06 * bump, x[2] = at[2] + 0.05 * bump;
}

const LthBlockModel lth_crooked_cube = {1, crooked_map, {2, 2, 2}, false};

static const char tension_scene[] =
    "lithe: 1\n"
    "title: A cube that is pulled along x\n"
    "bodies:\n"
    "  - name: cube\n"
    "    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
    "    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, cells: 3, degree: 1}\n"
    "    constraints:\n"
    "      - {where: {normal: [-1, 0, 0]}, displacement: [0, null, "
    "null]}\n"
    "      - {where: {normal: [0, -1, 0]}, displacement: [null, 0, "
    "null]}\n"
    "      - {where: {normal: [0, 0, -1]}, displacement: [null, "
    "null, 0]}\n"
    "    loads:\n"
    "      - {where: {normal: [1, 0, 0]}, traction: [1 kPa, 0, "
    "0]}\n"
    "exact: {displacement: [\"1e-3*x\", \"-0.3e-3*y\", \"-0.3e-3*z\"]}\n"
    "probes: [{name: middle, point: [0.4, 0.55, 0.45]}]\n"
    "solver: {linear: cholesky}\n" END;

LitheStatus lth_study_tension(LthStudyRun *run) {
  static const char reason[] =
      "constant strain is in every space: what is left is rounding times the condition number";
  LthCase c = {
      .name = "tension",
      .scene = tension_scene,
      .model = &lth_crooked_cube,
      .n_quantities = 2,
      .quantity = {{"displacement (largest error)", "m", "error.linf", 0, 1e-3, 1e-9, reason},
                   {"stress xx", "Pa", "probes.middle.stress.0", 1e3, 0, 1e-9, reason}},
      .n_methods = 5,
      .method = {
          {"dg, sliced, degree 1", "{kind: dg, cells: %d, degree: 1}", LTH_CASE_NO_MESH, 1, {3}},
          {"dg, sliced, degree 3", "{kind: dg, cells: %d, degree: 3}", LTH_CASE_NO_MESH, 1, {2}},
          {"dg, crooked mesh",
           "{kind: dg, mesh: {file: hex8-%d.msh}, degree: 1}",
           LTH_CASE_LINEAR_MESH,
           1,
           {1}},
          {"cg, crooked mesh",
           "{kind: cg, mesh: {file: hex8-%d.msh}, degree: 1}",
           LTH_CASE_LINEAR_MESH,
           1,
           {1}},
          {"staggered", "{kind: staggered, cells: %d}", LTH_CASE_NO_MESH, 1, {7}}}};
  return lth_case_run(run, &c);
}

// --- Timoshenko ---

static void cantilever_map(int block, const double at[3], double x[3]) {
  (void)block;
  x[0] = LENGTH * at[0], x[1] = DEPTH * (at[1] - 0.5), x[2] = 0.5 * at[2];
}

static const LthBlockModel cantilever = {1, cantilever_map, {4, 2, 1}, false};

static const char cantilever_scene[] =
    "lithe: 1\n"
    "title: Cantilever with a parabolic shear load at its end (plane strain)\n"
    "bodies:\n"
    "  - name: beam\n"
    "    shape: {box: {min: [0, -1, 0], max: [8, 1, 0.5]}}\n"
    "    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n"
    "      - {where: {normal: [-1, 0, 0]}, displacement: [\"%s\", "
    "\"%s\", null]}\n"
    "      - {where: {or: [{normal: [0, 0, 1]}, {normal: [0, 0, -1]}]}, displacement: "
    "[null, null, 0]}\n"
    "    loads:\n"
    "      - {where: {normal: [1, 0, 0]}, traction: [0, "
    "\"-%.17g*(1-y^2)\", 0]}\n"
    "exact: {displacement: [\"%s\", \"%s\", \"0\"]}\n"
    "probes: [{name: end, point: [7.99, 0, 0.25]}, {name: top, point: [1, 0.9, 0.25]}]\n" END;

/// Timoshenko and Goodier's polynomial, with E / (1 - nu^2) and nu / (1 - nu) for plane strain; I = DEPTH^3 / 12.
LitheStatus lth_study_cantilever(LthStudyRun *run) {
  double E = YOUNG / (1 - POISSON * POISSON), nu = POISSON / (1 - POISSON);
  double I = DEPTH * DEPTH * DEPTH / 12, f = FORCE / (6 * E * I), half2 = DEPTH * DEPTH / 4;
  const char *u = lth_study_print(run, "%.17g*y*((%.17g-3*x)*x+%.17g*(y^2-%.17g))", f, 6 * LENGTH,
                                  2 + nu, half2);
  const char *v = lth_study_print(run, "-%.17g*(%.17g*y^2*(%.17g-x)+%.17g*x+(%.17g-x)*x^2)", f,
                                  3 * nu, LENGTH, (4 + 5 * nu) * half2, 3 * LENGTH);
  double x = 7.99, tip = -f * ((4 + 5 * nu) * half2 * x + (3 * LENGTH - x) * x * x);
  LthCase c = {
      .name = "cantilever",
      .scene = lth_study_print(run, cantilever_scene, u, v, FORCE / (2 * I), u, v),
      .model = &cantilever,
      .n_quantities = 2,
      .quantity = {{"displacement at the end", "m", "probes.end.displacement.1", tip, 0, 0.01,
                    "1 % is what an engineer asks for; the solution is cubic"},
                   {"stress xx near the root", "Pa", "probes.top.stress.0",
                    FORCE * (LENGTH - 1) * 0.9 / I, 0, 0.07,
                    "of degree 1 it is one value an element: half its height, 0.06 m, of 0.9 m"}},
      .n_methods = 5,
      .method = {lth_case_dg_sliced(4, 8, 16),
                 {"dg, sliced, degree 1",
                  "{kind: dg, cells: %d, degree: 1}",
                  LTH_CASE_NO_MESH,
                  3,
                  {16, 32, 64}},
                 lth_case_dg_mesh(1, 2, 4),
                 lth_case_cg_mesh(1, 2, 4),
                 lth_case_staggered(32, 64, 128)}};
  return lth_case_run(run, &c);
}

// --- Cook's membrane ---

/// 48 mm long, from 44 mm high at the wall to 16 mm.
static void cook_map(int block, const double at[3], double x[3]) {
  (void)block;
  double low = 44 * at[0], high = 44 + 16 * at[0];
  x[0] = 48 * at[0], x[1] = low + (high - low) * at[1], x[2] = 8 * at[2];
}

static const LthBlockModel cook = {1, cook_map, {2, 2, 1}, false};

static const char cook_scene[] =
    "lithe: 1\n"
    "title: Cook's membrane as a slab between two smooth plates\n"
    "# Plane strain with these numbers is plane stress with E = 1 and nu = 1/3.\n"
    "bodies:\n"
    "  - name: slab\n"
    "    shape: {mesh: {file: body.obj, unit: m}}\n"
    "    material: {model: linear, young_modulus: 0.9375, poisson_ratio: 0.25, density: 1}\n"
    "    method: {kind: dg, cells: 8, degree: 2}\n"
    "    constraints:\n"
    "      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0]}\n"
    "      - {where: {or: [{normal: [0, 0, 1]}, {normal: [0, 0, -1]}]}, displacement: "
    "[null, null, 0]}\n"
    "    loads:\n"
    "      - {where: {normal: [1, 0, 0]}, total_force: [0, 8, 0]}\n"
    "probes: [{name: end, point: [47.99, 52, 4]}]\n" END;

LitheStatus lth_study_cook(LthStudyRun *run) {
  LthCase c = {
      .name = "cook",
      .scene = cook_scene,
      .model = &cook,
      .surface_level = 1,
      .n_quantities = 1,
      .quantity =
          {{"displacement at the middle of the end", "m", "probes.end.displacement.1", 23.96, 0,
            0.01,
            "23.96 is what the literature gives as the limit; 1 % is what an engineer asks for"}},
      .n_methods = 4,
      .method = {lth_case_dg_sliced(4, 8, 16), lth_case_dg_mesh(1, 2, 4), lth_case_cg_mesh(1, 2, 4),
                 lth_case_staggered(32, 64, 128)}};
  return lth_case_run(run, &c);
}
