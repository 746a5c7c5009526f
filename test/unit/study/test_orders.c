/// Observed orders and extrapolation: exact on sequences that follow the law, refused on others.
#include "check.h"
#include "study/orders.h"

static void order_between_two_levels_is_exact(void **state) {
  (void)state;
  // e = 3 h^1.7; two logarithms and a quotient
  CHECK_NEAR(lth_order_between(0.1, 3 * pow(0.1, 1.7), 0.025, 3 * pow(0.025, 1.7)), 1.7, 1e-14);
}

static void order_of_no_error_is_none(void **state) {
  (void)state;
  assert_true(isnan(lth_order_between(0.1, 1, 0.05, 0)));
  assert_true(isnan(lth_order_between(0.1, 1, 0.1, 0.5)));
  assert_true(isnan(lth_order_between(0.1, NAN, 0.05, 0.5)));
}

static void fit_is_that_of_the_thesis(void **state) {
  (void)state;
  // Table 5.1 of Dolny 2025; its text has the two orders the wrong way round
  static const double n[14] = {32, 48, 64, 80, 96, 112, 128, 192, 256, 512, 768, 1024, 1536, 2048};
  static const double l1[14] = {2.97438e-02, 1.17518e-02, 8.46099e-03, 1.21437e-02, 3.34825e-03,
                                3.26758e-03, 3.47968e-03, 9.20504e-04, 1.02894e-03, 2.76219e-04,
                                1.43497e-04, 5.07250e-05, 7.09758e-05, 4.00599e-05};
  double h[14], constant;
  for (int i = 0; i < 14; i++) h[i] = 2 / n[i];
  CHECK_NEAR(lth_order_fit(14, h, l1, &constant), 1.63, 0.005);
}

static void fit_finds_order_and_constant(void **state) {
  (void)state;
  double h[5], e[5], constant;
  for (int i = 0; i < 5; i++) {
    h[i] = pow(0.7, i);
    e[i] = 0.3 * h[i] * h[i];
  }
  e[2] = NAN; // a level that is not there
  CHECK_NEAR(lth_order_fit(5, h, e, &constant), 2, 1e-13);
  CHECK_NEAR(constant, 0.3, 1e-13);
  assert_true(isnan(lth_order_fit(1, h, e, NULL)));
}

static void extrapolation_finds_the_limit_of_uneven_levels(void **state) {
  (void)state;
  double h[3] = {1. / 8, 1. / 12, 1. / 32}, q[3], order, limit;
  for (int i = 0; i < 3; i++) q[i] = 5 - 0.4 * pow(h[i], 1.5);
  assert_true(lth_order_extrapolate(h, q, &order, &limit));
  CHECK_NEAR(order, 1.5, 1e-9); // differences of q lose five digits of fifteen
  CHECK_NEAR(limit, 5, 1e-11);
}

static void sequences_without_a_limit_are_refused(void **state) {
  (void)state;
  double h[3] = {1, 0.5, 0.25}, order, limit;
  assert_false(lth_order_extrapolate(h, (double[]){1, 2, 1.5}, &order, &limit)); // to and fro
  assert_false(lth_order_extrapolate(h, (double[]){1, 2, 4}, &order, &limit));   // away
  assert_false(lth_order_extrapolate(h, (double[]){1, 1, 1}, &order, &limit));
  assert_false(lth_order_extrapolate(h, (double[]){NAN, 1, 2}, &order, &limit));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(order_between_two_levels_is_exact),
      cmocka_unit_test(order_of_no_error_is_none),
      cmocka_unit_test(fit_is_that_of_the_thesis),
      cmocka_unit_test(fit_finds_order_and_constant),
      cmocka_unit_test(extrapolation_finds_the_limit_of_uneven_levels),
      cmocka_unit_test(sequences_without_a_limit_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
