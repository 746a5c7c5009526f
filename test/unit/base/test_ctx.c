/// The context: messages, warnings, counted memory and failing allocations.
#include "check.h"

static void counts_allocations_and_bytes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LitheCount before = lth_alloc_count(ctx);
  double *block = lth_alloc(ctx, 10, sizeof *block);
  assert_int_equal((uintptr_t)block % 64, 0);
  for (int i = 0; i < 10; i++) CHECK_NEAR(block[i], 0, 0);
  assert_int_equal(lth_alloc_count(ctx), before + 1);
  assert_true(lth_alloc_bytes(ctx) >= 80);
  lth_free(ctx, block);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
  assert_null(ctx);
}

static void remembers_the_most_that_was_held(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  void *first = lth_alloc(ctx, 1000, 8), *second = lth_alloc(ctx, 3000, 8);
  const LitheCount both = lth_alloc_bytes(ctx);
  lth_free(ctx, first);
  void *third = lth_alloc(ctx, 500, 8);
  assert_true(lth_alloc_bytes(ctx) < both);
  assert_int_equal(lth_alloc_peak(ctx), both);
  lth_free(ctx, second);
  lth_free(ctx, third);
  assert_int_equal(lth_alloc_peak(ctx), both);
  lithe_ctx_destroy(&ctx);
}

static void refuses_sizes_that_overflow(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  assert_null(lth_alloc(ctx, INT64_MAX / 2, 1000));
  assert_null(lth_alloc(ctx, -1, 8));
  lithe_ctx_destroy(&ctx);
}

// What is freed is given out again, also a little larger and all zero; afterwards nothing is held.
static void gives_spare_blocks_out_again(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const LitheCount n = 100000;
  lth_keep_spares(ctx, true);
  double *first = lth_alloc(ctx, n, sizeof *first);
  for (LitheCount i = 0; i < n; i++) first[i] = 1;
  lth_free(ctx, first);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  double *again = lth_alloc(ctx, n + n / 10, sizeof *again);
  assert_ptr_equal(again, first);
  for (LitheCount i = 0; i < n + n / 10; i++) assert_true(again[i] == 0);
  double *other = lth_alloc(ctx, n, sizeof *other), *rough = NULL;
  assert_ptr_not_equal(other, again);
  other[n - 1] = 2;
  double *const place = other;
  lth_free(ctx, other);
  assert_int_equal(lth_new_rough_(ctx, (void **)&rough, n, sizeof *rough), LITHE_OK);
  assert_ptr_equal(rough, place); // not cleared: its owner writes it
  assert_true(rough[n - 1] == 2);
  lth_free(ctx, rough);
  for (int i = 0; i < 2; i++) lth_age_spares(ctx); // nobody asked for it
  other = lth_alloc(ctx, n, sizeof *other);
  lth_free(ctx, other);
  lth_keep_spares(ctx, false);
  lth_free(ctx, again);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void keeps_contents_when_growing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LitheCount cap = 0;
  int *list = NULL;
  for (int i = 0; i < 1000; i++) {
    assert_int_equal(lth_reserve_(ctx, (void **)&list, &cap, i + 1, sizeof *list), LITHE_OK);
    list[i] = i;
  }
  for (int i = 0; i < 1000; i++) assert_int_equal(list[i], i);
  lth_free(ctx, list);
  lithe_ctx_destroy(&ctx);
}

static void keeps_equal_warnings_once(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  lth_warn(ctx, "%d points welded", 3);
  lth_warn(ctx, "%d points welded", 3);
  lth_warn(ctx, "%d points welded", 4);
  assert_int_equal(lithe_ctx_warning_count(ctx), 2);
  assert_string_equal(lithe_ctx_warning(ctx, 1), "4 points welded");
  lithe_ctx_destroy(&ctx);
}

static void statuses_have_texts_and_exit_codes(void **state) {
  (void)state;
  assert_int_equal(lithe_status_exit(LITHE_BAD_INPUT), 2);
  assert_int_equal(lithe_status_exit(LITHE_NOT_CONVERGED), 3);
  assert_int_equal(lithe_status_exit(LITHE_NO_SPACE), 4);
  assert_int_equal(lithe_status_exit(LITHE_INTERRUPTED), 130);
  assert_string_equal(lithe_status_text(LITHE_OK), "success");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(counts_allocations_and_bytes),
      cmocka_unit_test(remembers_the_most_that_was_held),
      cmocka_unit_test(refuses_sizes_that_overflow),
      cmocka_unit_test(gives_spare_blocks_out_again),
      cmocka_unit_test(keeps_contents_when_growing),
      cmocka_unit_test(keeps_equal_warnings_once),
      cmocka_unit_test(statuses_have_texts_and_exit_codes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
