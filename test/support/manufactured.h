/// Smooth solutions of elasticity for tests of order, with their loads, and the error of a body against them.
#pragma once

#include "dg_body.h"
#include "solids.h"

/// contrast = 0: u = (sin 2x cos y, cos(x + z) - 2 cos 2x sin y, sin(x - y)) / 10 keeps volumes, so that it is
/// one problem for every Poisson's ratio. Else two materials that meet at x = 0, the one at x > 0
/// `contrast` times as stiff: u = s(x) (cos y, sin(y + z), cos z) / 10, s = sin 2x over the stiffness, has the
/// same traction on both sides. E = 1000 (at x < 0).
typedef struct TestSolution {
  double poisson, contrast;
  double lambda, mu; ///< at x < 0, set by test_solution_loads()
} TestSolution;

typedef struct TestComponent {
  const TestSolution *solution;
  int row, column;
} TestComponent;

static inline double test_stiffness(const TestSolution *s, const double x[3]) {
  return s->contrast > 0 && x[0] > 0 ? s->contrast : 1;
}

static inline void test_solution(const TestSolution *s, const double x[3], double u[3]) {
  double wave = 0.1 * sin(2 * x[0]) / test_stiffness(s, x);
  bool two = s->contrast > 0;
  u[0] = two ? wave * cos(x[1]) : 0.1 * sin(2 * x[0]) * cos(x[1]);
  u[1] = two ? wave * sin(x[1] + x[2]) : 0.1 * (cos(x[0] + x[2]) - 2 * cos(2 * x[0]) * sin(x[1]));
  u[2] = two ? wave * cos(x[2]) : 0.1 * sin(x[0] - x[1]);
}

static inline void test_solution_gradient(const TestSolution *s, const double x[3], double H[9]) {
  if (s->contrast > 0) {
    double k = 0.1 / test_stiffness(s, x), f = k * sin(2 * x[0]), d = 2 * k * cos(2 * x[0]);
    double both = cos(x[1] + x[2]);
    H[0] = d * cos(x[1]), H[1] = -f * sin(x[1]), H[2] = 0;
    H[3] = d * sin(x[1] + x[2]), H[4] = f * both, H[5] = f * both;
    H[6] = d * cos(x[2]), H[7] = 0, H[8] = -f * sin(x[2]);
    return;
  }
  double p = sin(2 * x[0]) * sin(x[1]), c = cos(2 * x[0]) * cos(x[1]), d = cos(x[0] - x[1]);
  H[0] = 0.2 * c, H[1] = -0.1 * p, H[2] = 0;
  H[3] = -0.1 * sin(x[0] + x[2]) + 0.4 * p, H[4] = -0.2 * c, H[5] = -0.1 * sin(x[0] + x[2]);
  H[6] = 0.1 * d, H[7] = -0.1 * d, H[8] = 0;
}

static inline double test_solution_value(const void *self, const double x[3], double t) {
  (void)t;
  const TestComponent *c = self;
  double u[3];
  test_solution(c->solution, x, u);
  return u[c->row];
}

static inline double test_solution_stress(const void *self, const double x[3], double t) {
  (void)t;
  const TestComponent *c = self;
  const TestSolution *s = c->solution;
  double H[9];
  test_solution_gradient(s, x, H);
  double trace = c->row == c->column ? s->lambda * (H[0] + H[4] + H[8]) : 0;
  return test_stiffness(s, x) *
         (trace + s->mu * (H[3 * c->row + c->column] + H[3 * c->column + c->row]));
}

/// -(lambda + mu) grad div u - mu laplace u
static inline double test_solution_force(const void *self, const double x[3], double t) {
  (void)t;
  const TestComponent *c = self;
  const TestSolution *s = c->solution;
  if (s->contrast > 0) {
    double f = 0.1 * sin(2 * x[0]), d = 0.2 * cos(2 * x[0]), sum = x[1] + x[2];
    double grad_div[3] = {-4 * f * cos(x[1]) + d * (cos(sum) - sin(x[2])),
                          -d * sin(x[1]) - f * sin(sum), -f * sin(sum) - f * cos(x[2])};
    double laplace[3] = {-5 * f * cos(x[1]), -6 * f * sin(sum), -5 * f * cos(x[2])};
    return -(s->lambda + s->mu) * grad_div[c->row] - s->mu * laplace[c->row];
  }
  double wave = 0.1 * cos(x[0] + x[2]), u[3];
  test_solution(s, x, u);
  double laplace[3] = {-5 * u[0], -2 * wave - 5 * (u[1] - wave), -2 * u[2]};
  return -s->mu * laplace[c->row];
}

/// Boundary that is held, and boundary that is pulled.
static inline bool test_solution_held(const double c[3], const double n[3]) {
  (void)n;
  return c[1] < 0.05;
}
static inline bool test_solution_pulled(const double c[3], const double n[3]) {
  return !test_solution_held(c, n);
}

/// Errors of a solution, those of stiff material times its contrast, for all is smaller there.
typedef struct TestErrors {
  double l2, h1; ///< of the displacement and of its gradient within the elements
} TestErrors;

static inline void test_add_errors(const TestBody *b, const TestSolution *s, LitheIndex cell,
                                   const double x[3], double weight, TestErrors *sum) {
  double got[3], u[3], F[9], H[9], k = test_stiffness(s, x);
  lth_dg_sample(b->space, cell, b->x, x, got);
  lth_dg_sample_gradient(b->space, cell, b->x, x, F);
  test_solution(s, x, u);
  test_solution_gradient(s, x, H);
  for (int a = 0; a < 3; a++) sum->l2 += weight * pow(k * (got[a] - x[a] - u[a]), 2);
  for (int i = 0; i < 9; i++) sum->h1 += weight * pow(k * (F[i] - (i % 4 == 0) - H[i]), 2);
}

static inline TestErrors test_errors(const TestBody *b, const TestSolution *s) {
  TestErrors sum = {0};
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    LitheIndex n = 0;
    double *points = NULL, *weights = NULL;
    CHECK_OK(b->ctx, lth_dg_cell_quadrature(b->ctx, b->mesh, c, 2 * b->space->degree[c] + 2, &n,
                                            &points, &weights));
    for (LitheIndex q = 0; q < n; q++) test_add_errors(b, s, c, points + 3 * q, weights[q], &sum);
    lth_free(b->ctx, points);
    lth_free(b->ctx, weights);
  }
  return (TestErrors){sqrt(sum.l2), sqrt(sum.h1)};
}

/// Held on one half of the boundary, pulled on the other; K and b->f are then those of the solution.
static inline void test_solution_problem(TestBody *b, TestSolution *s, TestComponent component[9]) {
  lth_lame(1000, s->poisson, &s->lambda, &s->mu);
  for (int i = 0; i < 9; i++) component[i] = (TestComponent){s, i / 3, i % 3};
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    b->poisson[c] = s->poisson;
    b->young[c] = 1000 * test_stiffness(s, b->mesh->cell_centroid + 3 * c);
  }
  LthWeakConstraint *hold = test_hold(b, test_solution_held);
  for (int a = 0; a < 3; a++)
    hold->value[a] = (LthValue){0, test_solution_value, &component[3 * a]};
  test_assemble(b, 0);
  b->patches[3] = test_patches(b->ctx, b->mesh, test_solution_pulled);
  LthLoad pull = {.kind = LTH_LOAD_STRESS, .patches = b->patches[3]},
          volume = {.kind = LTH_LOAD_BODY_FORCE};
  for (int i = 0; i < 9; i++) pull.stress[i] = (LthValue){0, test_solution_stress, &component[i]};
  for (int a = 0; a < 3; a++)
    volume.value[a] = (LthValue){0, test_solution_force, &component[3 * a]};
  CHECK_OK(b->ctx, lth_dg_add_load(b->ctx, b->space, &pull, 0, NULL, b->f));
  CHECK_OK(b->ctx, lth_dg_add_load(b->ctx, b->space, &volume, 0, NULL, b->f));
}

/// Solve the problem and measure; frees the body.
static inline TestErrors test_solve_and_measure(TestBody b, TestSolution s) {
  TestComponent component[9];
  test_solution_problem(&b, &s, component);
  test_solve_sparse(&b, b.K, b.f0);
  TestErrors errors = test_errors(&b, &s);
  test_body_free(&b);
  return errors;
}

/// A cube about the origin, turned by `angle` about `axis`, cut into n cells a side.
static inline TestBody test_sliced_cube(LitheIndex n, int degree, const double axis[3],
                                        double angle) {
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_box(ctx, (double[3]){-0.4, -0.4, -0.4}, (double[3]){0.4, 0.4, 0.4});
  double R[9];
  lth_m3_rotation(axis, angle, R);
  solid_move(s, R, 1, (double[3]){0, 0, 0});
  LthGrid cells = {.cells = {n, n, n}};
  solid_bounds(s, cells.min, cells.max);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, 0.05, &mesh));
  solid_free(ctx, &s);
  return test_body_of(ctx, mesh, degree);
}

/// The cubes of the tests: off all axes; about x, so that x = 0 is a plane of the grid; tetrahedra.
typedef enum TestCube { TEST_CUBE_SLICED, TEST_CUBE_ABOUT_X, TEST_CUBE_TETRAHEDRA } TestCube;

static inline TestBody test_cube(TestCube cube, LitheIndex n, int degree) {
  static const double skew[3] = {1, 2, 3}, x[3] = {1, 0, 0};
  double half = 0.4, length = sqrt(14),
         axis[3] = {skew[0] / length, skew[1] / length, skew[2] / length};
  if (cube == TEST_CUBE_TETRAHEDRA)
    return test_body(TEST_TETRAHEDRA,
                     (LthGrid){{-half, -half, -half}, {half, half, half}, {n, n, n}}, degree);
  return test_sliced_cube(n, degree, cube == TEST_CUBE_SLICED ? axis : x, 0.5);
}

/// Errors with n and with `ratio` times as many cells a side: the orders between them are at least
/// lowest + 1 (L2) and lowest (gradient), less the slacks.
static inline void test_check_orders(TestCube cube, LitheIndex n, double ratio, int degree,
                                     TestSolution s, const double slack[2]) {
  LitheIndex finer = (LitheIndex)lround(ratio * n);
  TestErrors coarse = test_solve_and_measure(test_cube(cube, n, degree), s);
  TestErrors fine = test_solve_and_measure(test_cube(cube, finer, degree), s);
  double l2 = log(coarse.l2 / fine.l2) / log(ratio), h1 = log(coarse.h1 / fine.h1) / log(ratio);
  int lowest = degree < MIXED ? degree : degree - MIXED + 1;
  print_message(
      "cube %d, degree %d, nu %g, contrast %g, %d and %d cells: L2 %.3g, %.3g, order %.2f; "
      "gradient %.3g, %.3g, order %.2f\n",
      cube, degree, s.poisson, s.contrast, n, finer, coarse.l2, fine.l2, l2, coarse.h1, fine.h1,
      h1);
  CHECK_AT_LEAST(l2, lowest + 1 - slack[0]);
  CHECK_AT_LEAST(h1, lowest - slack[1]);
}
