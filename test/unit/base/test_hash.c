/// The hash table keeps first values, finds all keys and survives growth.
#include "check.h"

#include "base/hash.h"

static void finds_every_key_and_keeps_the_first_value(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthHash hash = {0};
  LitheIndex kept = 0;
  assert_int_equal(lth_hash_find(&hash, 1, 2), -1);
  for (int i = 0; i < 5000; i++) {
    CHECK_OK(ctx, lth_hash_insert(ctx, &hash, (uint64_t)(i % 71), (uint64_t)(i / 71), i, &kept));
    assert_int_equal(kept, i);
  }
  for (int i = 0; i < 5000; i++) {
    CHECK_OK(ctx, lth_hash_insert(ctx, &hash, (uint64_t)(i % 71), (uint64_t)(i / 71), 9999, &kept));
    assert_int_equal(kept, i);
    assert_int_equal(lth_hash_find(&hash, (uint64_t)(i % 71), (uint64_t)(i / 71)), i);
  }
  assert_int_equal(hash.n, 5000);
  assert_int_equal(lth_hash_find(&hash, 71, 0), -1);
  lth_hash_free(ctx, &hash);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(finds_every_key_and_keeps_the_first_value),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
