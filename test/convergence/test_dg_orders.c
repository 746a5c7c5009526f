/// Manufactured solutions: interior penalty converges with order k + 1 in L2 and k in its gradients, on
/// sliced meshes too.
#include "manufactured.h"

static const TestSolution plain = {.poisson = 0.3}, nearly_incompressible = {.poisson = 0.499};

static void tetrahedra_converge(void **state) {
  (void)state;
  test_check_orders(TEST_CUBE_TETRAHEDRA, 3, 2, 1, plain, (double[2]){0.15, 0.1});
  test_check_orders(TEST_CUBE_TETRAHEDRA, 2, 2, 2, plain, (double[2]){0.15, 0.1});
}

static void sliced_meshes_converge(void **state) {
  (void)state;
  test_check_orders(TEST_CUBE_SLICED, 6, 2, 1, plain, (double[2]){0.25, 0.1});
  test_check_orders(TEST_CUBE_SLICED, 5, 2, 2, plain, (double[2]){0.25, 0.1});
}

static void nearly_incompressible_sliced_meshes_converge(void **state) {
  (void)state;
  test_check_orders(TEST_CUBE_SLICED, 6, 2, 1, nearly_incompressible, (double[2]){0.25, 0.25});
  test_check_orders(TEST_CUBE_SLICED, 5, 2, 2, nearly_incompressible, (double[2]){0.15, 0.25});
}

/// As in test_dg_beam, with quadratic functions.
static void quadratic_compliance_agrees_with_independent_codes(void **state) {
  (void)state;
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_IP, 2, 40), 2.94883907e-4, 1e-8 * 3e-4);
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_BZ, 2, 40), 3.02297494e-4, 1e-8 * 3e-4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tetrahedra_converge),
      cmocka_unit_test(sliced_meshes_converge),
      cmocka_unit_test(nearly_incompressible_sliced_meshes_converge),
      cmocka_unit_test(quadratic_compliance_agrees_with_independent_codes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
