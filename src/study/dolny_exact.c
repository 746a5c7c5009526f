/// Problems with known solutions as scenes: the manufactured one of the thesis, and really free boundaries.
#include "study/dolny.h"

#define INNER 0.325 // radii of the thesis' annulus [m]
#define OUTER 0.8

static const char ring_shape[] = "{annulus: {center: [0, 0], inner: 0.325, outer: 0.8}}";
static const char inner_side[] = "{disk: {center: [0, 0], radius: 0.325}}";

static double shear_modulus(double poisson) { return 1 / (2 * (1 + poisson)); }
static double lame_lambda(double poisson) { return poisson / ((1 + poisson) * (1 - 2 * poisson)); }

LthExactCase lth_exact_manufactured(bool is_held_outside) {
  LthExactCase c = {
      .shape = ring_shape,
      .held = is_held_outside ? "all" : inner_side,
      .displacement = {"cos(2*pi*x)*cos(2*pi*y)-x", "sin(2*pi*x)*sin(2*pi*y)-y"},
      // -div P with (5.1): P is diagonal
      .body_force = {"8*pi^2*cos(2*pi*x)*cos(2*pi*y)", "8*pi^2*sin(2*pi*x)*sin(2*pi*y)"},
      .young = 2.5, // mu = lambda = 1
      .poisson = 0.25};
  if (is_held_outside) return c;
  c.stress[0] = "-4*pi*sin(2*pi*x)*cos(2*pi*y)-4";
  c.stress[1] = c.stress[2] = "0";
  c.stress[3] = "4*pi*sin(2*pi*x)*cos(2*pi*y)-4";
  return c;
}

// u_r = A r + B / r with sigma_rr = 2 (lambda + mu) A - 2 mu B / r^2 = 0 at the outer circle
LthExactCase lth_exact_ring(LthStudyRun *run, double poisson) {
  double mu = shear_modulus(poisson), lambda = lame_lambda(poisson);
  double share = mu / ((lambda + mu) * OUTER * OUTER); // A / B
  double B = 1 / (share * INNER + 1 / INNER), A = share * B;
  LthExactCase c = {.shape = ring_shape, .held = inner_side, .young = 1, .poisson = poisson};
  c.displacement[0] = lth_study_print(run, "x*(%.17g+%.17g/(x^2+y^2))", A, B);
  c.displacement[1] = lth_study_print(run, "y*(%.17g+%.17g/(x^2+y^2))", A, B);
  return c;
}

// Kirsch 1898 in Cartesian coordinates about the hole, kappa = 3 - 4 nu:
//   u_x = T / (8 mu) [ (kappa + 1) X + 2 a^2 ((1 + kappa) X / R + c3 / R^2) - 2 a^4 c3 / R^3 ]
//   u_y = T / (8 mu) [ (kappa - 3) Y + 2 a^2 ((1 - kappa) Y / R + s3 / R^2) - 2 a^4 s3 / R^3 ]
// with R = X^2 + Y^2, c3 = X (X^2 - 3 Y^2), s3 = Y (3 X^2 - Y^2)
LthExactCase lth_exact_hole(LthStudyRun *run, double poisson, double cx, double cy) {
  double kappa = 3 - 4 * poisson, f = 1 / (8 * shear_modulus(poisson)), a2 = INNER * INNER;
  const char *X = lth_study_print(run, "(x-%.17g)", cx), *Y = lth_study_print(run, "(y-%.17g)", cy);
  const char *R = lth_study_print(run, "(%s^2+%s^2)", X, Y);
  const char *c3 = lth_study_print(run, "%s*(%s^2-3*%s^2)", X, X, Y);
  const char *s3 = lth_study_print(run, "%s*(3*%s^2-%s^2)", Y, X, Y);
  static const char form[] = "%.17g*(%.17g*%s+%.17g*(%.17g*%s/%s+%s/%s^2)-%.17g*%s/%s^3)";
  LthExactCase c = {.young = 1, .poisson = poisson};
  c.shape = lth_study_print(run,
                            "{difference: [{box: {min: [-1, -1], max: [1, 1]}}, {disk: {center: "
                            "[%.17g, %.17g], radius: %.17g}}]}",
                            cx, cy, INNER);
  c.held = "{not: {box: {min: [-0.999999, -0.999999], max: [0.999999, 0.999999]}}}"; // the rim
  c.displacement[0] = lth_study_print(run, form, f, kappa + 1, X, 2 * a2, 1 + kappa, X, R, c3, R,
                                      2 * a2 * a2, c3, R);
  c.displacement[1] = lth_study_print(run, form, f, kappa - 3, Y, 2 * a2, 1 - kappa, Y, R, s3, R,
                                      2 * a2 * a2, s3, R);
  return c;
}

// (lambda + 2 mu) (u'' + u' / r - u / r^2) = -rho omega^2 r: u = A r - r^3 / (8 (lambda + 2 mu)), sigma_rr = 0 outside
LthExactCase lth_exact_rotating(LthStudyRun *run, double poisson) {
  double mu = shear_modulus(poisson), lambda = lame_lambda(poisson), m = lambda + 2 * mu;
  double A = OUTER * OUTER * (2 * lambda + 3 * mu) / (8 * m * (lambda + mu));
  LthExactCase c = {.shape = ring_shape,
                    .held = inner_side,
                    .body_force = {"x", "y"},
                    .young = 1,
                    .poisson = poisson};
  c.displacement[0] = lth_study_print(run, "x*(%.17g-%.17g*(x^2+y^2))", A, 1 / (8 * m));
  c.displacement[1] = lth_study_print(run, "y*(%.17g-%.17g*(x^2+y^2))", A, 1 / (8 * m));
  return c;
}

static const char *put_loads(LthStudyRun *run, const LthExactCase *c) {
  const char *text = "";
  if (!c->stress[0] && !c->body_force[0]) return text;
  text = "    loads:\n";
  if (c->stress[0])
    text = lth_study_print(
        run, "%s      - {where: {not: %s}, stress: [[\"%s\", \"%s\"], [\"%s\", \"%s\"]]}\n", text,
        c->held, c->stress[0], c->stress[1], c->stress[2], c->stress[3]);
  if (c->body_force[0])
    text = lth_study_print(run, "%s      - {body_force: [\"%s\", \"%s\"]}\n", text,
                           c->body_force[0], c->body_force[1]);
  return text;
}

/// The square of the thesis, moved by less than a cell and with a cell more on both sides then.
static const char *put_grid(LthStudyRun *run, const LthExactMethod *m) {
  double h = 2. / m->cells, low[2], high[2];
  int n[2];
  for (int a = 0; a < 2; a++) {
    bool is_moved = m->shift[a] != 0;
    n[a] = m->cells + (is_moved ? 2 : 0);
    low[a] = -1 + h * (m->shift[a] - (is_moved ? 1 : 0));
    high[a] = low[a] + n[a] * h;
  }
  return lth_study_print(run, "{min: [%.17g, %.17g], max: [%.17g, %.17g], cells: [%d, %d]}", low[0],
                         low[1], high[0], high[1], n[0], n[1]);
}

static const char *put_constraints(LthStudyRun *run, const LthExactCase *c,
                                   const LthExactMethod *m) {
  const char *text = lth_study_print(run, "      - {where: %s, displacement: [\"%s\", \"%s\"]}\n",
                                     c->held, c->displacement[0], c->displacement[1]);
  if (!m->held_too) return text;
  return lth_study_print(run,
                         "%s      - {where: %s, interior: true, displacement: [\"%s\", \"%s\"]}\n",
                         text, m->held_too, c->displacement[0], c->displacement[1]);
}

const char *lth_exact_scene(LthStudyRun *run, const char *title, const LthExactCase *c,
                            const LthExactMethod *m) {
  return lth_study_print(run,
                         "lithe: 1\n"
                         "title: %s, N = %d\n"
                         "dimension: 2\n"
                         "bodies:\n"
                         "  - name: solid\n"
                         "    shape: %s\n"
                         "    material: {model: linear, young_modulus: %.17g, poisson_ratio: "
                         "%.17g, density: 1000}\n"
                         "    method: {kind: staggered, grid: %s, fractions: %s%s}\n"
                         "    constraints:\n%s%s"
                         "time: static\n"
                         "solver: {tolerance: 1e-10}\n"
                         "exact: {displacement: [\"%s\", \"%s\"]}\n"
                         "output: {fields: none}\n",
                         title, m->cells, c->shape, c->young, c->poisson, put_grid(run, m),
                         m->fractions, m->more ? m->more : "", put_constraints(run, c, m),
                         put_loads(run, c), c->displacement[0], c->displacement[1]);
}
