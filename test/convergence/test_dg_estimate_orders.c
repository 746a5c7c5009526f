/// The error estimate against the error in energy of manufactured solutions: how many times as large, and of which order.
#include "manufactured.h"

#include "disc/dg/dg_estimate.h"

typedef struct Measured {
  double error, estimate; ///< in energy: roots of [J]
} Measured;

/// Squared error in energy inside a cell: int 2 mu |eps|^2 + lambda tr^2.
static double strain_error(const TestBody *b, const TestSolution *s, LitheIndex cell) {
  LitheIndex n = 0;
  double *points = NULL, *weights = NULL, sum = 0, lambda, mu;
  lth_lame(b->young[cell], b->poisson[cell], &lambda, &mu);
  CHECK_OK(b->ctx, lth_dg_cell_quadrature(b->ctx, b->mesh, cell, 2 * b->space->degree[cell] + 2, &n,
                                          &points, &weights));
  for (LitheIndex q = 0; q < n; q++) {
    double F[9], H[9], e[9], trace = 0;
    lth_dg_sample_gradient(b->space, cell, b->x, points + 3 * q, F);
    test_solution_gradient(s, points + 3 * q, H);
    for (int i = 0; i < 9; i++) e[i] = F[i] - (i % 4 == 0) - H[i];
    trace = e[0] + e[4] + e[8];
    double density = lambda * trace * trace;
    for (int i = 0; i < 9; i++) density += 2 * mu * pow((e[i] + e[3 * (i % 3) + i / 3]) / 2, 2);
    sum += weights[q] * density;
  }
  lth_free(b->ctx, points);
  lth_free(b->ctx, weights);
  return sum;
}

/// Solve the problem, estimate its error, and measure it: jumps are a part of both.
static Measured measure(TestBody b, TestSolution s) {
  TestComponent component[9];
  test_solution_problem(&b, &s, component);
  test_solve_sparse(&b, b.K, b.f0);
  LthLoad loads[2] = {{.kind = LTH_LOAD_STRESS, .patches = b.patches[3]},
                      {.kind = LTH_LOAD_BODY_FORCE}};
  for (int i = 0; i < 9; i++)
    loads[0].stress[i] = (LthValue){0, test_solution_stress, &component[i]};
  for (int a = 0; a < 3; a++)
    loads[1].value[a] = (LthValue){0, test_solution_force, &component[3 * a]};
  LthDgEstimateDef def = {.op = b.op, .x = b.x, .loads = loads, .n_loads = 2};
  double *parts =
      lth_alloc(b.ctx, LTH_ESTIMATE_PARTS * (LitheCount)b.space->n_cells, sizeof *parts);
  CHECK_OK(b.ctx, lth_dg_estimate(b.ctx, &def, parts));
  Measured m = {0};
  double of_part[LTH_ESTIMATE_PARTS] = {0};
  for (LitheIndex c = 0; c < b.space->n_cells; c++) {
    m.error += strain_error(&b, &s, c) + parts[LTH_ESTIMATE_PARTS * c + LTH_ESTIMATE_JUMPS];
    m.estimate += lth_dg_estimate_sum(parts, c);
    for (int i = 0; i < LTH_ESTIMATE_PARTS; i++) of_part[i] += parts[LTH_ESTIMATE_PARTS * c + i];
  }
  m.error = sqrt(m.error), m.estimate = sqrt(m.estimate);
  print_message("  %6d cells: error %.3g, estimate %.3g = %.2f of it (volume %.2f, faces %.2f, "
                "boundary %.2f, jumps %.2f)\n",
                b.space->n_cells, m.error, m.estimate, m.estimate / m.error,
                sqrt(of_part[0]) / m.error, sqrt(of_part[1]) / m.error, sqrt(of_part[2]) / m.error,
                sqrt(of_part[3]) / m.error);
  lth_free(b.ctx, parts);
  test_body_free(&b);
  return m;
}

/// The estimate is between `low` and `high` times the error on both meshes, and falls with its order.
static void check(TestCube cube, LitheIndex n, int degree, TestSolution s, double low,
                  double high) {
  print_message("cube %d, degree %d, nu %g, contrast %g\n", cube, degree, s.poisson, s.contrast);
  Measured coarse = measure(test_cube(cube, n, degree), s),
           fine = measure(test_cube(cube, 2 * n, degree), s);
  double order = log2(coarse.error / fine.error),
         order_of_estimate = log2(coarse.estimate / fine.estimate);
  print_message("  orders %.2f and %.2f\n", order, order_of_estimate);
  CHECK_AT_LEAST(fmin(coarse.estimate / coarse.error, fine.estimate / fine.error), low);
  CHECK_AT_MOST(fmax(coarse.estimate / coarse.error, fine.estimate / fine.error), high);
  CHECK_NEAR(order_of_estimate, order, 0.2);
}

static void the_estimate_follows_the_error(void **state) {
  (void)state;
  for (int k = 1; k <= 3; k++)
    for (int nu = 0; nu < 2; nu++) {
      TestSolution s = {.poisson = nu ? 0.499 : 0.3};
      check(TEST_CUBE_TETRAHEDRA, 2, k, s, 1, 3);
      check(TEST_CUBE_SLICED, k == 1 ? 6 : 4, k, s, 1, 3);
    }
}

static void a_million_times_stiffer_part_does_not_hide_errors(void **state) {
  (void)state;
  for (int k = 1; k <= 3; k++)
    check(TEST_CUBE_TETRAHEDRA, 2, k, (TestSolution){.poisson = 0.3, .contrast = 1e6}, 1, 3);
}

static void mixed_degrees_are_estimated(void **state) {
  (void)state;
  check(TEST_CUBE_TETRAHEDRA, 2, MIXED, (TestSolution){.poisson = 0.3}, 1, 3);
  check(TEST_CUBE_TETRAHEDRA, 2, MIXED + 1, (TestSolution){.poisson = 0.3}, 1, 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_estimate_follows_the_error),
      cmocka_unit_test(a_million_times_stiffer_part_does_not_hide_errors),
      cmocka_unit_test(mixed_degrees_are_estimated),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
