/// Gauss rules integrate what they promise, and no more.
#include "check.h"

#include "geometry/quadrature.h"

static double factorial(int n) { return tgamma(n + 1.0); }

/// int_0^1 x^m (1 - x)^a dx
static double beta(int m, int a) { return factorial(m) * factorial(a) / factorial(m + a + 1); }

static void gauss_jacobi_is_exact_to_its_degree(void **state) {
  (void)state;
  for (int a = 0; a <= 2; a++)
    for (int n = 1; n <= LTH_GAUSS_MAX; n++) {
      double x[LTH_GAUSS_MAX], w[LTH_GAUSS_MAX];
      lth_gauss_jacobi(n, a, x, w);
      for (int m = 0; m <= 2 * n; m++) {
        double sum = 0;
        for (int k = 0; k < n; k++) sum += w[k] * pow(x[k], m);
        if (m < 2 * n)
          CHECK_NEAR(sum, beta(m, a), 2e-15);
        else if (n <= 6)
          CHECK_AT_LEAST(fabs(sum - beta(m, a)), 1e-9); // not exact: the test can fail
      }
      for (int k = 0; k < n; k++)
        assert_true(x[k] > 0 && x[k] < 1 && w[k] > 0 && (k == 0 || x[k] > x[k - 1]));
    }
}

static void simplex_rules_are_exact_to_their_degree(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int degree = 0; degree <= 12; degree++) {
    LthSimplexRule rule;
    double bary[4];
    CHECK_OK(ctx, lth_simplex_rule(ctx, 2, degree, &rule));
    for (int a = 0; a <= degree; a++) {
      int b = degree - a;
      double sum = 0;
      for (int k = 0; k < lth_simplex_rule_points(&rule); k++) {
        double w = lth_simplex_rule_point(&rule, k, bary);
        sum += w * pow(bary[0], a) * pow(bary[2], b);
        CHECK_NEAR(bary[0] + bary[1] + bary[2], 1, 1e-15);
      }
      CHECK_NEAR(sum, 2 * factorial(a) * factorial(b) / factorial(degree + 2), 4e-15);
    }
    CHECK_OK(ctx, lth_simplex_rule(ctx, 3, degree, &rule));
    for (int a = 0; a <= degree; a++)
      for (int b = 0; a + b <= degree; b++) {
        int c = degree - a - b;
        double sum = 0;
        for (int k = 0; k < lth_simplex_rule_points(&rule); k++) {
          double w = lth_simplex_rule_point(&rule, k, bary);
          sum += w * pow(bary[1], a) * pow(bary[2], b) * pow(bary[3], c);
        }
        CHECK_NEAR(sum, 6 * factorial(a) * factorial(b) * factorial(c) / factorial(degree + 3),
                   4e-15);
      }
  }
  lithe_ctx_destroy(&ctx);
}

static void refuses_degrees_beyond_its_tables(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSimplexRule rule;
  assert_int_equal(lth_simplex_rule(ctx, 3, -1, &rule), LITHE_BAD_INPUT);
  assert_int_equal(lth_simplex_rule(ctx, 2, 2 * LTH_GAUSS_MAX, &rule), LITHE_BAD_INPUT);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gauss_jacobi_is_exact_to_its_degree),
      cmocka_unit_test(simplex_rules_are_exact_to_their_degree),
      cmocka_unit_test(refuses_degrees_beyond_its_tables),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
