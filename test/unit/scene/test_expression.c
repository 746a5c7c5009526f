/// Expressions: values, columns of errors, threads, the locale.
#include "check.h"
#include "scene/expression.h"

#include <locale.h>
#include <omp.h>
#include <string.h>

static double value_of(const char *text, const double x[3], double t) {
  LitheCtx *ctx = test_ctx();
  LthExpression *e = NULL;
  LthExpressionError error;
  if (lth_expression_create(ctx, text, strlen(text), &error, &e) != LITHE_OK)
    fail_msg("%s: column %d: %s", text, error.column, error.text);
  double value = lth_expression_eval(e, x, t);
  lth_expression_destroy(ctx, &e);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
  return value;
}

static void evaluates_what_a_scene_writes(void **state) {
  (void)state;
  const double x[3] = {0.5, 2, 3};
  const double pi = 3.14159265358979323846;
  CHECK_NEAR(value_of("1/120", x, 0), 1.0 / 120, 0);
  CHECK_NEAR(value_of("x + 10*y + 100*z + 1000*t", x, 4), 4320.5, 0);
  CHECK_NEAR(value_of("0.1*t*sin(2*pi*x)", x, 2), 0.2 * sin(pi), 1e-16);
  CHECK_NEAR(value_of("-2^2", x, 0), -4, 0);
  CHECK_NEAR(value_of("2^3^2", x, 0), 512, 0);
  CHECK_NEAR(value_of("+.5e1", x, 0), 5, 0);
  CHECK_NEAR(value_of("x > 0.4 ? y : z", x, 0), 2, 0);
  CHECK_NEAR(value_of("log(y)", x, 0), log(2), 0);
  CHECK_NEAR(value_of("min(x, y, z) + max(x, y)", x, 0), 2.5, 0);
  assert_true(isinf(value_of("1/(x - 0.5)", x, 0)));
}

static void remembers_the_earliest_gap(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthExpression *e = NULL;
  LthExpressionError error;
  LthExpressionGap gap;
  assert_int_equal(lth_expression_create(ctx, "sqrt(1 - t)/x", 13, &error, &e), LITHE_OK);
  lth_expression_eval(e, (const double[3]){1, 2, 3}, 0.5);
  assert_false(lth_expression_gap(e, &gap));
  lth_expression_eval(e, (const double[3]){4, 5, 6}, 2);
  lth_expression_eval(e, (const double[3]){0, 8, 9}, 1.5);
  lth_expression_eval(e, (const double[3]){0, 7, 9}, 0.25);
  lth_expression_eval(e, (const double[3]){0, 6, 9}, 0.5);
  assert_true(lth_expression_gap(e, &gap));
  assert_true(isinf(gap.value));
  CHECK_NEAR(gap.t, 0.25, 0);
  CHECK_NEAR(gap.x[1], 7, 0);
  lth_expression_destroy(ctx, &e);
  lithe_ctx_destroy(&ctx);
}

static void check_error(const char *text, int column, const char *message) {
  LitheCtx *ctx = test_ctx();
  LthExpression *e = NULL;
  LthExpressionError error;
  assert_int_equal(lth_expression_create(ctx, text, strlen(text), &error, &e), LITHE_BAD_INPUT);
  assert_null(e);
  assert_string_equal(error.text, message);
  assert_int_equal(error.column, column);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void names_the_column_of_an_error(void **state) {
  (void)state;
  check_error("0.1*(x", 7, "a closing bracket is missing");
  check_error("x)", 2, "unexpected bracket \")\"");
  check_error("2*", 3, "it ends too early");
  check_error("1 + foo", 5, "unknown name \"foo\"");
  check_error("1 + sn(x)", 5, "unknown name \"sn\", did you mean sin");
  check_error("x=3", 2, "an assignment (=); == compares");
  check_error("1,5", 2, "a comma outside a function's brackets (decimals take a point)");
  check_error("sin()", 5, "too few arguments for sin()");
  check_error("x**2", 3, "unexpected \"*\"");
  check_error("", 1, "it is empty");
  check_error("\"a\"", 1, "a quote inside the expression");
  check_error("1e400", 1, "\"1e400\" is no number of double precision");
  check_error("x ? 1", 6, "the \":\" of a choice ? : is missing");
}

static void knows_what_it_depends_on(void **state) {
  (void)state;
  static const struct {
    const char *text;
    int uses;
  } cases[] = {{"pi", 0}, {"x", 1}, {"y*z", 6}, {"t", 8}, {"x*0 + t", 9}};
  LitheCtx *ctx = test_ctx();
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    LthExpression *e = NULL;
    LthExpressionError error;
    CHECK_OK(ctx, lth_expression_create(ctx, cases[i].text, strlen(cases[i].text), &error, &e));
    assert_int_equal(lth_expression_uses(e), cases[i].uses);
    lth_expression_destroy(ctx, &e);
  }
  lithe_ctx_destroy(&ctx);
}

/// More threads than compiled copies, each with its own arguments: a shared one would mix them up.
static void serves_many_threads_at_once(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthExpression *e = NULL;
  LthExpressionError error;
  const char *text = "x + 10*y + 100*z + 1000*t";
  CHECK_OK(ctx, lth_expression_create(ctx, text, strlen(text), &error, &e));
  int n_wrong = 0;
#pragma omp parallel for num_threads(20) reduction(+ : n_wrong) schedule(static)
  for (int i = 0; i < 20000; i++) {
    const double x[3] = {i % 7, i % 5, i % 3};
    double t = i % 2;
    n_wrong += lth_expression_eval(e, x, t) != x[0] + 10 * x[1] + 100 * x[2] + 1000 * t;
  }
  assert_int_equal(n_wrong, 0);
  lth_expression_destroy(ctx, &e);
  lithe_ctx_destroy(&ctx);
}

static void ignores_the_locale(void **state) {
  (void)state;
  static const char *const comma_locales[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR"};
  const double x[3] = {0};
  bool is_set = false;
  for (int i = 0; i < 4 && !is_set; i++) is_set = setlocale(LC_ALL, comma_locales[i]) != NULL;
  CHECK_NEAR(value_of("0.5 + 1.25", x, 0), 1.75, 0);
  setlocale(LC_ALL, "C");
  if (!is_set) skip();
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(evaluates_what_a_scene_writes), cmocka_unit_test(remembers_the_earliest_gap),
      cmocka_unit_test(names_the_column_of_an_error),  cmocka_unit_test(knows_what_it_depends_on),
      cmocka_unit_test(serves_many_threads_at_once),   cmocka_unit_test(ignores_the_locale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
