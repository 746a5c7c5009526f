/// Manufactured solutions of degree 3 and 4, of mixed degrees, and of materials that differ by a million.
#include "manufactured.h"

static const TestSolution plain = {.poisson = 0.3}, nearly_incompressible = {.poisson = 0.499};

static void check_high_degrees(TestSolution s) {
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, 3, s, (double[2]){0.15, 0.15});
  test_check_orders(TEST_CUBE_TETRAHEDRA, 1, 2, 4, s, (double[2]){0.15, 0.15});
  test_check_orders(TEST_CUBE_SLICED, 4, 2, 3, s, (double[2]){0.4, 0.4});
  test_check_orders(TEST_CUBE_SLICED, 3, 2, 4, s, (double[2]){0.25, 0.25});
}

static void high_degrees_converge(void **state) {
  (void)state;
  check_high_degrees(plain);
  check_high_degrees(nearly_incompressible);
}

static void check_mixed(TestSolution s) {
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, MIXED, s, (double[2]){0.2, 0.1});
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, MIXED + 1, s, (double[2]){0.1, 0.1});
  test_check_orders(TEST_CUBE_SLICED, 4, 2, MIXED, s, (double[2]){0.1, 0.1});
  test_check_orders(TEST_CUBE_SLICED, 4, 2, MIXED + 1, s, (double[2]){0.1, 0.1});
}

static void mixed_degrees_converge_with_the_lowest(void **state) {
  (void)state;
  check_mixed(plain);
  check_mixed(nearly_incompressible);
}

/// A mesh in which some elements have a higher degree is better than one where all have the lowest.
static void higher_neighbours_lower_the_error(void **state) {
  (void)state;
  for (int nu = 0; nu < 2; nu++) {
    TestSolution s = nu ? nearly_incompressible : plain;
    TestErrors linear = test_solve_and_measure(test_cube(TEST_CUBE_TETRAHEDRA, 2, 1), s);
    TestErrors mixed = test_solve_and_measure(test_cube(TEST_CUBE_TETRAHEDRA, 2, MIXED), s);
    CHECK_AT_MOST(mixed.l2, 0.75 * linear.l2);
    CHECK_AT_MOST(mixed.h1, 0.75 * linear.h1);
  }
}

/// Two materials with a plane between them that the mesh follows, one a million times as stiff.
static void check_contrast(TestSolution s) {
  s.contrast = 1e6;
  for (int k = 1; k <= 3; k++)
    test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, k, s, (double[2]){0.15, 0.1});
  test_check_orders(TEST_CUBE_ABOUT_X, 4, 2, 1, s, (double[2]){0.15, 0.1});
  test_check_orders(TEST_CUBE_ABOUT_X, 4, 2, 2, s, (double[2]){0.25, 0.25});
  test_check_orders(TEST_CUBE_ABOUT_X, 2, 2, 3, s, (double[2]){0.25, 0.25});
  test_check_orders(TEST_CUBE_ABOUT_X, 2, 2, 4, s, (double[2]){0.4, 0.4});
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, MIXED, s, (double[2]){0.2, 0.1});
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, MIXED + 1, s, (double[2]){0.1, 0.1});
}

static void a_million_times_stiffer_part_costs_no_order(void **state) {
  (void)state;
  check_contrast(plain);
  check_contrast(nearly_incompressible);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(high_degrees_converge),
      cmocka_unit_test(mixed_degrees_converge_with_the_lowest),
      cmocka_unit_test(higher_neighbours_lower_the_error),
      cmocka_unit_test(a_million_times_stiffer_part_costs_no_order),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
