/// What an archive was given comes back bit for bit; what does not fit is refused, never read past its end.
#include "check.h"

#include "base/archive.h"
#include "base/digest.h"

#include <string.h>

typedef struct Thing {
  double a[3];
  int32_t b;
  char *text;
  LitheCount n;
  double list[4];
} Thing;

static void walk(LthArchive *archive, Thing *thing) {
  lth_archive_mark(archive, "thing");
  LTH_ARCHIVE_ARRAY(archive, thing->a, 3);
  LTH_ARCHIVE(archive, thing->b);
  lth_archive_text(archive, &thing->text);
  lth_archive_count(archive, &thing->n);
  for (LitheCount i = 0; i < thing->n && i < 4; i++) LTH_ARCHIVE(archive, thing->list[i]);
  lth_archive_mark(archive, "end");
}

static Thing make_thing(void) {
  return (Thing){{1.0 / 3, -0.0, 1e300}, -7, "a text", 2, {4, 5, 0, 0}};
}

static void gives_back_every_bit(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthArchive out = {0}, in;
  Thing thing = make_thing(), read = {0};
  lth_archive_begin(&out, ctx);
  walk(&out, &thing);
  CHECK_OK(ctx, out.status);
  lth_archive_open(&in, ctx, out.data, out.size);
  walk(&in, &read);
  CHECK_OK(ctx, in.status);
  assert_int_equal(in.at, out.size);
  assert_memory_equal(read.a, thing.a, sizeof read.a);
  assert_int_equal(read.b, -7);
  assert_string_equal(read.text, "a text");
  assert_int_equal(read.n, 2);
  assert_memory_equal(read.list, thing.list, sizeof read.list);
  lth_free(ctx, read.text);
  lth_archive_free(ctx, &out);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void allocates_nothing_the_second_time(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthArchive out = {0};
  Thing thing = make_thing();
  lth_archive_begin(&out, ctx);
  walk(&out, &thing);
  LitheCount before = lth_alloc_count(ctx);
  lth_archive_begin(&out, ctx);
  walk(&out, &thing);
  assert_int_equal(lth_alloc_count(ctx), before);
  lth_archive_free(ctx, &out);
  lithe_ctx_destroy(&ctx);
}

static void refuses_every_truncation_and_every_foreign_length(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthArchive out = {0}, in;
  Thing thing = make_thing();
  lth_archive_begin(&out, ctx);
  walk(&out, &thing);
  for (LitheCount size = 0; size < out.size; size++) {
    Thing read = {0};
    char *copy = lth_alloc(ctx, size, 1); // exact: reading beyond is seen by the sanitizer
    memcpy(copy, out.data, (size_t)size);
    lth_archive_open(&in, ctx, copy, size);
    walk(&in, &read);
    assert_int_equal(in.status, LITHE_BAD_INPUT);
    lth_free(ctx, read.text);
    lth_free(ctx, copy);
  }
  double wrong[2];
  lth_archive_open(&in, ctx, out.data, out.size);
  lth_archive_mark(&in, "thing");
  LTH_ARCHIVE_ARRAY(&in, wrong, 2);
  assert_int_equal(in.status, LITHE_BAD_INPUT);
  lth_archive_open(&in, ctx, out.data, out.size);
  lth_archive_mark(&in, "other");
  assert_int_equal(in.status, LITHE_BAD_INPUT);
  lth_archive_free(ctx, &out);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void digest_sees_every_bit_and_the_length(void **state) {
  (void)state;
  unsigned char data[41] = {0};
  uint64_t all_zero = lth_digest(data, sizeof data, 0);
  for (size_t bit = 0; bit < 8 * sizeof data; bit++) {
    data[bit / 8] ^= (unsigned char)(1u << bit % 8);
    assert_true(lth_digest(data, sizeof data, 0) != all_zero);
    data[bit / 8] ^= (unsigned char)(1u << bit % 8);
  }
  for (size_t n = 0; n < sizeof data; n++) assert_true(lth_digest(data, n, 0) != all_zero);
  assert_true(lth_digest(data, sizeof data, 1) != all_zero);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gives_back_every_bit),
      cmocka_unit_test(allocates_nothing_the_second_time),
      cmocka_unit_test(refuses_every_truncation_and_every_foreign_length),
      cmocka_unit_test(digest_sees_every_bit_and_the_length),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
