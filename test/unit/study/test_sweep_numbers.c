/// Values of sweeps, and the numbers of a result that are compared.
#include "check.h"
#include "study/sweep.h"

#include <string.h>

static LitheCtx *ctx;
static LthStudyRun run;

static int open_run(void **state) {
  (void)state;
  ctx = test_ctx();
  run = (LthStudyRun){.ctx = ctx, .arena = {.ctx = ctx}, .folder = ""};
  run.report.arena = &run.arena;
  return 0;
}

static int close_run(void **state) {
  (void)state;
  lth_arena_free(&run.arena);
  lithe_ctx_destroy(&ctx);
  return 0;
}

static void values_end_at_commas_outside_brackets(void **state) {
  (void)state;
  LthSweep sweep;
  CHECK_OK(ctx,
           lth_sweep_parse(&run, "bodies.0.method.cells=[8, 4, 2],16,{a: [1, 2]},\"a,b\"", &sweep));
  assert_int_equal(sweep.n, 4);
  assert_string_equal(sweep.path, "bodies.0.method.cells");
  assert_string_equal(sweep.key, "cells");
  assert_string_equal(sweep.value[0].text, "[8, 4, 2]");
  assert_string_equal(sweep.value[2].text, "{a: [1, 2]}");
  CHECK_NEAR(sweep.value[0].number, 8, 0);
  CHECK_NEAR(lth_sweep_length(&sweep, 1), 1. / 16, 0);
  assert_true(isnan(sweep.value[3].number));
}

static void lengths_understand_units_and_fractions(void **state) {
  (void)state;
  LthSweep sweep;
  CHECK_OK(ctx, lth_sweep_parse(&run, "time.step=1/120,5 ms,0.25", &sweep));
  assert_int_equal(sweep.kind, LTH_SWEEP_LENGTH);
  CHECK_NEAR(lth_sweep_length(&sweep, 0), 1. / 120, 0);
  CHECK_NEAR(lth_sweep_length(&sweep, 1), 5e-3, 1e-18);
  CHECK_NEAR(lth_sweep_length(&sweep, 2), 0.25, 0);
}

static void other_keys_refine_nothing(void **state) {
  (void)state;
  LthSweep sweep;
  CHECK_OK(ctx, lth_sweep_parse(&run, "bodies.0.material.poisson_ratio=0.3,0.45", &sweep));
  assert_true(isnan(lth_sweep_length(&sweep, 0)));
}

static void what_is_no_sweep_is_refused(void **state) {
  (void)state;
  LthSweep sweep;
  assert_int_equal(lth_sweep_parse(&run, "cells", &sweep), LITHE_BAD_INPUT);
  assert_int_equal(lth_sweep_parse(&run, "=1,2", &sweep), LITHE_BAD_INPUT);
  assert_int_equal(lth_sweep_parse(&run, "cells=1,,2", &sweep), LITHE_BAD_INPUT);
  assert_int_equal(lth_sweep_parse(&run, "cells=1,", &sweep), LITHE_BAD_INPUT);
}

static void main_numbers_have_their_units(void **state) {
  (void)state;
  const LthNode *json;
  LthMainNumber numbers[LTH_MAIN_NUMBERS_MAX];
  CHECK_OK(ctx, lth_study_parse(&run,
                                "{\"scene\": \"12\", \"bodies\": [{\"dofs\": 12, \"mass\": 2}],\n"
                                " \"displacement\": {\"max\": 0.5},\n"
                                " \"probes\": {\"tip\": {\"displacement\": [1, 2, 3]}},\n"
                                " \"error\": {\"l1\": 1e-3, \"stress\": {\"l2\": 7}},\n"
                                " \"time\": {\"read\": 1, \"total\": 2}}",
                                &json));
  int n = lth_main_numbers(&run, json, numbers);
  assert_int_equal(n, 8);
  assert_string_equal(numbers[0].path, "bodies.0.dofs");
  assert_string_equal(numbers[1].path, "displacement.max");
  assert_string_equal(numbers[1].unit, "m");
  assert_true(numbers[1].is_field && !numbers[1].is_error);
  assert_string_equal(numbers[4].path, "probes.tip.displacement.2");
  assert_string_equal(numbers[6].path, "error.stress.l2");
  assert_true(numbers[6].is_error);
  assert_string_equal(numbers[7].path, "time.total");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_end_at_commas_outside_brackets),
      cmocka_unit_test(lengths_understand_units_and_fractions),
      cmocka_unit_test(other_keys_refine_nothing),
      cmocka_unit_test(what_is_no_sweep_is_refused),
      cmocka_unit_test(main_numbers_have_their_units),
  };
  return cmocka_run_group_tests(tests, open_run, close_run);
}
