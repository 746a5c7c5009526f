/// Reports of studies: verdicts, tables, numbers as text.
#include "check.h"
#include "study/study_files.h"
#include "study/study_list.h"

#include <string.h>

static void verdict_is_computed(void **state) {
  (void)state;
  LthCheck check = {"error", 1e-3, 2e-3, LTH_AT_MOST, "theory"};
  assert_true(lth_check_holds(&check));
  check.value = 2.1e-3;
  assert_false(lth_check_holds(&check));
  check = (LthCheck){"order", 1.9, 1.8, LTH_AT_LEAST, "theory"};
  assert_true(lth_check_holds(&check));
  check.value = 1.7;
  assert_false(lth_check_holds(&check));
}

static void number_that_is_missing_never_holds(void **state) {
  (void)state;
  LthCheck most = {"error", NAN, 2e-3, LTH_AT_MOST, ""};
  LthCheck least = {"order", NAN, 1.8, LTH_AT_LEAST, ""};
  assert_false(lth_check_holds(&most));
  assert_false(lth_check_holds(&least));
}

static void shown_numbers_keep_their_digits(void **state) {
  (void)state;
  char text[LTH_SHOWN_MAX];
  assert_string_equal(lth_shown_number(0.01921472, 6, text), "0.0192147");
  assert_string_equal(lth_shown_number(1.8e-5, 4, text), "1.800e-05");
  assert_string_equal(lth_shown_number(100, 3, text), "100");
  assert_string_equal(lth_shown_number(2048, 0, text), "2048");
  assert_string_equal(lth_shown_number(NAN, 3, text), "");
}

static void one_verdict_that_fails_fails_the_study(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthStudyRun run = {.ctx = ctx, .arena = {.ctx = ctx}};
  int n_failed;
  run.report.arena = &run.arena;
  lth_study_at_most(&run.report, "a", 1, 2, "b");
  assert_true(lth_study_holds(&run));
  lth_study_at_least(&run.report, "c", 1, 2, "d");
  assert_int_equal(lth_study_checks(&run.report, &n_failed), 2);
  assert_int_equal(n_failed, 1);
  assert_false(lth_study_holds(&run));
  lth_arena_free(&run.arena);
  lithe_ctx_destroy(&ctx);
}

static void tables_keep_rows_beyond_their_first_block(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthArena arena = {.ctx = ctx};
  LthStudyReport report = {.arena = &arena};
  LthTable *table = lth_study_table(&report, "t", "", NULL);
  lth_table_column(table, "a", "m", 3);
  lth_table_column(table, "b", "", 3);
  for (int i = 0; i < 100; i++) lth_table_row(table, NULL, (double[]){i, 2 * i});
  assert_int_equal(table->n_rows, 100);
  for (int i = 0; i < 100; i++) assert_true(lth_table_at(table, i, 1) == 2 * i);
  assert_true(isnan(lth_table_at(table, 100, 0)));
  lth_arena_free(&arena);
  lithe_ctx_destroy(&ctx);
}

static void plots_tell_the_order_of_their_points(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthArena arena = {.ctx = ctx};
  LthStudyReport report = {.arena = &arena};
  LthTable *table = lth_study_table(&report, "t", "", NULL);
  lth_table_column(table, "N", "", 0);
  lth_table_column(table, "e", "", 3);
  for (int n = 8; n <= 64; n *= 2) lth_table_row(table, NULL, (double[]){n, 7. / n / n});
  LthPlot *plot = lth_study_plot(&report, "p", "", "", "");
  plot->orders = LTH_PLOT_ORDERS_OF_CELLS;
  lth_plot_series(plot, "e", table, 0, 1);
  CHECK_NEAR(lth_plot_order(plot, plot->series), 2, 1e-13);
  lth_arena_free(&arena);
  lithe_ctx_destroy(&ctx);
}

static void words_mean_a_study_a_group_or_all(void **state) {
  (void)state;
  const LthStudy study = {.name = "dolny/table5.2"};
  assert_true(lth_study_is_meant(&study, "dolny/table5.2"));
  assert_true(lth_study_is_meant(&study, "dolny"));
  assert_true(lth_study_is_meant(&study, "all"));
  assert_false(lth_study_is_meant(&study, "dol"));
  assert_false(lth_study_is_meant(&study, "dolny/table5"));
  assert_false(lth_study_is_meant(&study, ""));
}

static void names_of_studies_differ(void **state) {
  (void)state;
  for (LitheIndex i = 0; lth_study_at(i); i++) {
    assert_non_null(strchr(lth_study_at(i)->name, '/'));
    for (LitheIndex j = 0; j < i; j++)
      assert_string_not_equal(lth_study_at(i)->name, lth_study_at(j)->name);
  }
}

static void results_are_found_by_path(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthStudyRun run = {.ctx = ctx, .arena = {.ctx = ctx}, .folder = ""};
  LthStudyResult result = {0};
  CHECK_OK(ctx, lth_study_parse(&run,
                                "{\"error\": {\"l1\": 1.5e-3, \"l2\": null},\n"
                                " \"reaction\": {\"bodies.0.constraints.1\": [1, 2, -3.25]},\n"
                                " \"bodies\": [{\"dofs\": 12}]}",
                                &result.json));
  CHECK_NEAR(lth_study_number(&result, "error.l1"), 1.5e-3, 0);
  CHECK_NEAR(lth_study_number(&result, "reaction.bodies.0.constraints.1.2"), -3.25, 0);
  CHECK_NEAR(lth_study_number(&result, "bodies.0.dofs"), 12, 0);
  assert_true(isnan(lth_study_number(&result, "error.l2")));
  assert_true(isnan(lth_study_number(&result, "error.l3")));
  lth_arena_free(&run.arena);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(verdict_is_computed),
      cmocka_unit_test(number_that_is_missing_never_holds),
      cmocka_unit_test(shown_numbers_keep_their_digits),
      cmocka_unit_test(one_verdict_that_fails_fails_the_study),
      cmocka_unit_test(tables_keep_rows_beyond_their_first_block),
      cmocka_unit_test(plots_tell_the_order_of_their_points),
      cmocka_unit_test(words_mean_a_study_a_group_or_all),
      cmocka_unit_test(names_of_studies_differ),
      cmocka_unit_test(results_are_found_by_path),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
