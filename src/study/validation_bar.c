/// Validation: free vibration of a slender bar that is held at one end.
#include "study/validation_studies.h"

#define YOUNG 1e6
#define DENSITY 1000.0
#define SIDE 0.05  ///< of a bar 1 m long [m]
#define SPEED 1e-3 ///< of the mode at t = 0 [m/s]

static void bar_map(int block, const double at[3], double x[3]) {
  (void)block;
  x[0] = at[0], x[1] = SIDE * (at[1] - 0.5), x[2] = SIDE * (at[2] - 0.5);
}

static const LthBlockModel bar = {1, bar_map, {5, 1, 1}, false};

static const char bar_scene[] =
    "lithe: 1\n"
    "title: A bar that swings in a mode for one period\n"
    "bodies:\n"
    "  - name: bar\n"
    "    shape: {box: {min: [0, -25 mm, -25 mm], max: [1, 25 mm, 25 mm]}}\n"
    "    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0, density: 1000}\n"
    "    method: {kind: dg, cells: 10, degree: 2}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0.1 mm, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, "
    "0]}\n"
    "    initial: {velocity: [\"%s\", \"%s\", 0]}\n"
    "gravity: [0, 0, 0]\n"
    "time: {kind: dynamic, integrator: newmark, duration: %.17g, step: %.17g}\n"
    "probes: [{name: end, point: [0.999, 0, 0]}]\n"
    "output: {every: last, fields: none}\n";

static const char reason[] =
    "after one period of the exact frequency the end is where it started, and the phase that is "
    "left over is the frequency's. 120 steps a period give 2.3e-4, shear and rotation of sections "
    "2e-3 in bending, 8 staggered cells across 4e-3";

/// The phase at the end of a period is that of u = tip / omega sin(phase): f = omega / 2 pi (1 + phase / 2 pi). `u`, `v`: the mode's
/// velocity, `tip` its value at the end.
static LitheStatus swing(LthStudyRun *run, const char *name, double omega, const char *u,
                         const char *v, const char *path, double tip) {
  double period = 2 * M_PI / omega, frequency = 1 / period;
  LthCase c = {
      .name = name,
      .scene = lth_study_print(run, bar_scene, u, v, period, period / 120),
      .model = &bar,
      .n_quantities = 1,
      .quantity = {{lth_study_print(run, "frequency (%s)", name), "Hz", path, frequency, 0, 0.01,
                    reason, frequency, frequency * omega / (2 * M_PI * tip)}},
      .n_methods = 4,
      .method = {
          lth_case_dg_sliced(5, 10, 20),
          {"dg, file mesh",
           "{kind: dg, mesh: {file: hex8-%d.msh}, degree: 2}",
           LTH_CASE_LINEAR_MESH,
           2,
           {1, 2}},
          {"cg", "{kind: cg, cells: %d, degree: 2}", LTH_CASE_NO_MESH, 3, {5, 10, 20}},
          {"staggered",
           "{kind: staggered, grid: {min: [0, -0.025, -0.025], max: [1, 0.025, 0.025], cells: "
           "[%d, 8, 8]}}",
           LTH_CASE_NO_MESH,
           2,
           {20, 40}}}};
  return lth_case_run(run, &c);
}

LitheStatus lth_study_bar(LthStudyRun *run) {
  double speed = sqrt(YOUNG / DENSITY);
  for (int mode = 1; mode <= (run->quick ? 1 : 2); mode++) {
    double k = (2 * mode - 1) * M_PI / 2;
    LITHE_TRY(swing(run, mode == 1 ? "axial-1" : "axial-2", k * speed,
                    lth_study_print(run, "%.17g*sin(%.17g*x)", SPEED, k), "0",
                    "probes.end.displacement.0", SPEED));
  }
  // Euler and Bernoulli: cos(b) cosh(b) = -1
  double b = 1.8751040687119611, sigma = (cosh(b) + cos(b)) / (sinh(b) + sin(b));
  const char *v =
      lth_study_print(run, "%.17g*(cosh(%.17g*x)-cos(%.17g*x)-%.17g*(sinh(%.17g*x)-sin(%.17g*x)))",
                      SPEED, b, b, sigma, b, b);
  const char *u = lth_study_print(
      run, "-%.17g*y*(sinh(%.17g*x)+sin(%.17g*x)-%.17g*(cosh(%.17g*x)-cos(%.17g*x)))", SPEED * b, b,
      b, sigma, b, b);
  return swing(run, "bending-1", b * b * speed * SIDE / sqrt(12), u, v, "probes.end.displacement.1",
               2 * SPEED);
}
