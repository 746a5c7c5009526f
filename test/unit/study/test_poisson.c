/// The Poisson equation in the plane: polynomials that a space holds come out exact, orders are those of theory.
#include "check.h"
#include "study/poisson.h"

static double linear(const double x[2]) { return 1 + 2 * x[0] - 3 * x[1]; }
static double zero(const double x[2]) { return 0 * x[0]; }
static const LthPoissonProblem plane = {linear, zero};

static double bowl(const double x[2]) { return x[0] * x[0] + x[0] * x[1] - 2 * x[1] * x[1]; }
static double bowl_source(const double x[2]) { return 0 * x[0] + 2; }
static const LthPoissonProblem bowls = {bowl, bowl_source};

static double bubble(const double x[2]) { return x[0] * (1 - x[0]) * x[1] * (1 - x[1]); }
static double bubble_source(const double x[2]) {
  return 2 * (x[0] * (1 - x[0]) + x[1] * (1 - x[1]));
}
static const LthPoissonProblem bubbles = {bubble, bubble_source};

static LthPoissonResult solve(const LthPoissonProblem *problem, LthPoissonDef def) {
  LthPoissonResult result;
  LitheCtx *ctx = test_ctx();
  CHECK_OK(ctx, lth_poisson_solve(ctx, problem, &def, &result));
  lithe_ctx_destroy(&ctx);
  return result;
}

static void interior_penalty_reproduces_its_polynomials(void **state) {
  (void)state;
  for (int cells = 1; cells < 6; cells += 2) {
    CHECK_AT_MOST(solve(&plane, (LthPoissonDef){LTH_POISSON_IP, 1, cells, 10, false, false}).l2,
                  1e-12);
    CHECK_AT_MOST(solve(&bowls, (LthPoissonDef){LTH_POISSON_IP, 2, cells, 10, false, false}).l2,
                  1e-12);
  }
}

static void babuska_zlamal_does_not(void **state) {
  (void)state;
  LthPoissonResult r = solve(&bowls, (LthPoissonDef){LTH_POISSON_BZ, 2, 3, 10, false, false});
  CHECK_AT_LEAST(r.l2, 1e-3);
}

static void laplacian_is_that_of_the_solution(void **state) {
  (void)state;
  LthPoissonResult r = solve(&bowls, (LthPoissonDef){LTH_POISSON_IP, 2, 4, 10, false, false});
  CHECK_AT_MOST(r.laplace, 1e-10);
  r = solve(&bowls, (LthPoissonDef){LTH_POISSON_IP, 1, 4, 10, false, false});
  CHECK_NEAR(r.laplace, 2, 1e-12); // no second derivatives: the source's norm
}

static void orders_are_those_of_theory(void **state) {
  (void)state;
  const LthPoissonDef defs[] = {{LTH_POISSON_CG, 1, 0, 0, false, false},
                                {LTH_POISSON_IP, 2, 0, 10, false, false}};
  const double least[] = {1.98, 2.95};
  for (int k = 0; k < 2; k++) {
    LthPoissonDef def = defs[k];
    def.cells = 8;
    double coarse = solve(&bubbles, def).l2;
    def.cells = 16;
    CHECK_AT_LEAST(log2(coarse / solve(&bubbles, def).l2), least[k]);
  }
}

/// One bilinear function on 2 x 2 squares: its matrix is 8/3. Monomials on one cell that is all of the domain and the
/// same in its own coordinates span the same functions: both matrices are definite.
static void eigenvalues_are_those_of_the_matrix(void **state) {
  (void)state;
  LthPoissonResult r = solve(&bubbles, (LthPoissonDef){LTH_POISSON_CG, 1, 2, 0, false, true});
  assert_int_equal(r.unknowns, 1);
  CHECK_NEAR(r.smallest, 8. / 3, 1e-14);
  CHECK_NEAR(r.largest, 8. / 3, 1e-14);
  for (int monomial = 0; monomial < 2; monomial++) {
    r = solve(&bubbles, (LthPoissonDef){LTH_POISSON_IP, 1, 1, 10, monomial, true});
    assert_int_equal(r.unknowns, 3);
    CHECK_AT_LEAST(r.smallest, 0.1);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(interior_penalty_reproduces_its_polynomials),
      cmocka_unit_test(babuska_zlamal_does_not),
      cmocka_unit_test(laplacian_is_that_of_the_solution),
      cmocka_unit_test(orders_are_those_of_theory),
      cmocka_unit_test(eigenvalues_are_those_of_the_matrix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
