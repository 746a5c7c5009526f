/// When a run solves and writes: output times are hit, steps are never longer than asked for.
#include "check.h"
#include "scene/schedule.h"

static LthScene dynamic(double duration, double step, double every) {
  return (LthScene){
      .time_kind = LTH_TIME_DYNAMIC, .duration = duration, .step = step, .output_every = every};
}

static void output_times_fall_on_steps(void **state) {
  (void)state;
  LthScene scene = dynamic(2, 1. / 120, 1. / 30);
  LthSchedule s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 60);
  assert_int_equal(lth_schedule_steps(&s, 1), 4);
  assert_int_equal(lth_schedule_total(&s), 240);
  CHECK_NEAR(lth_schedule_time(&s, 60), 2, 0);
}

static void steps_are_shortened_never_stretched(void **state) {
  (void)state;
  LthScene scene = dynamic(1, 0.03, 0.1);
  LthSchedule s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 10);
  assert_int_equal(lth_schedule_steps(&s, 1), 4); // 0.025 s each
}

static void the_last_interval_may_be_shorter(void **state) {
  (void)state;
  LthScene scene = dynamic(1, 0.01, 0.3);
  LthSchedule s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 4);
  assert_int_equal(lth_schedule_steps(&s, 3), 30);
  assert_int_equal(lth_schedule_steps(&s, 4), 10);
  assert_int_equal(lth_schedule_total(&s), 100);
}

static void every_step_or_only_the_last_is_written(void **state) {
  (void)state;
  LthScene each = dynamic(1, 0.1, 0), last = dynamic(1, 0.1, -1), fine = dynamic(1, 0.1, 0.01);
  LthSchedule s = lth_schedule_make(&each);
  assert_int_equal(s.n_outputs, 10);
  s = lth_schedule_make(&last);
  assert_int_equal(s.n_outputs, 1);
  assert_int_equal(lth_schedule_steps(&s, 1), 10);
  s = lth_schedule_make(&fine); // finer than the steps: every step, none shortened
  assert_int_equal(s.n_outputs, 10);
  assert_int_equal(lth_schedule_steps(&s, 1), 1);
}

static void quasistatic_runs_write_at_solves(void **state) {
  (void)state;
  LthScene scene = {
      .time_kind = LTH_TIME_QUASISTATIC, .duration = 1, .steps = 10, .output_every = 0.2};
  LthSchedule s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 5);
  assert_int_equal(lth_schedule_steps(&s, 1), 2);
  scene.output_every = -1;
  s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 1);
  assert_int_equal(lth_schedule_total(&s), 10);
}

static void a_static_run_solves_and_writes_once(void **state) {
  (void)state;
  LthScene scene = {.time_kind = LTH_TIME_STATIC};
  LthSchedule s = lth_schedule_make(&scene);
  assert_int_equal(s.n_outputs, 1);
  assert_int_equal(lth_schedule_total(&s), 1);
  assert_false(s.writes_start);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(output_times_fall_on_steps),
      cmocka_unit_test(steps_are_shortened_never_stretched),
      cmocka_unit_test(the_last_interval_may_be_shorter),
      cmocka_unit_test(every_step_or_only_the_last_is_written),
      cmocka_unit_test(quasistatic_runs_write_at_solves),
      cmocka_unit_test(a_static_run_solves_and_writes_once),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
