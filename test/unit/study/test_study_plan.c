/// How long the rest of many studies takes.
#include "check.h"
#include "study/study_plan.h"

static LthStudyPlan three(void) {
  LthStudyPlan plan = {0};
  lth_study_plan_add(&plan, 10);
  lth_study_plan_add(&plan, 30);
  lth_study_plan_add(&plan, 60);
  return plan;
}

static void estimates_stand_before_anything_is_measured(void **state) {
  (void)state;
  LthStudyPlan plan = three();
  lth_study_plan_begin(&plan, 10, 1000);
  CHECK_NEAR(lth_study_plan_left(&plan, 1000), 100, 1e-12);
  CHECK_NEAR(lth_study_plan_left(&plan, 1004), 96, 1e-12);
}

static void slow_machine_stretches_what_is_left(void **state) {
  (void)state;
  LthStudyPlan plan = three();
  lth_study_plan_begin(&plan, 10, 1000);
  lth_study_plan_begin(&plan, 30, 1040); // took 40 instead of 10
  double slower = (40. + 5) / (10 + 5);
  CHECK_NEAR(lth_study_plan_left(&plan, 1040), slower * 90, 1e-9);
  CHECK_NEAR(lth_study_plan_left(&plan, 1050), slower * 90 - 10, 1e-9);
}

static void study_that_overruns_leaves_the_others(void **state) {
  (void)state;
  LthStudyPlan plan = three();
  lth_study_plan_begin(&plan, 10, 0);
  CHECK_NEAR(lth_study_plan_left(&plan, 500), 90, 1e-12);
}

static char heard[300];

static void hear(void *user, const char *phase, double fraction) {
  (void)user;
  (void)fraction;
  snprintf(heard, sizeof heard, "%s", phase);
}

static void progress_says_which_study_and_how_long(void **state) {
  (void)state;
  LitheCtxDef def = lithe_ctx_def_default();
  def.progress = hear;
  LitheCtx *ctx = lithe_ctx_create(&def);
  LthStudyPlan plan = three();
  lth_study_plan_begin(&plan, 10, lth_now());
  lth_study_plan_tell(&plan, ctx, "kaufmann/fig1");
  lth_progress(ctx, "meshing", -1);
  assert_string_equal(heard, "study 1 of 3, about 2 min left, kaufmann/fig1: meshing");
  lth_progress_head(ctx, "");
  lth_progress(ctx, "meshing", -1);
  assert_string_equal(heard, "meshing");
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(estimates_stand_before_anything_is_measured),
      cmocka_unit_test(slow_machine_stretches_what_is_left),
      cmocka_unit_test(study_that_overruns_leaves_the_others),
      cmocka_unit_test(progress_says_which_study_and_how_long),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
