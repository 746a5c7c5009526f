/// The JSON writer: structure, escapes, numbers that read back to the same bits.
#include "check.h"
#include "io/json.h"
#include "io/number_text.h"

#include <string.h>

static void writes_nested_objects_and_arrays(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthJson *json;
  const char *text;
  const double v[3] = {1, -0.5, NAN};
  CHECK_OK(ctx, lth_json_create(ctx, &json));
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "name", "bunny");
  lth_json_begin_array(json, "bodies");
  lth_json_begin_object(json, NULL);
  lth_json_integer(json, "elements", 9000000000);
  lth_json_bool(json, "closed", true);
  lth_json_end_object(json);
  lth_json_number(json, NULL, 0.1);
  lth_json_end_array(json);
  lth_json_begin_object(json, "empty");
  lth_json_end_object(json);
  lth_json_vector(json, "at", 3, v);
  lth_json_end_object(json);
  CHECK_OK(ctx, lth_json_text(json, &text));
  assert_string_equal(text, "{\n"
                            "  \"name\": \"bunny\",\n"
                            "  \"bodies\": [\n"
                            "    {\n"
                            "      \"elements\": 9000000000,\n"
                            "      \"closed\": true\n"
                            "    },\n"
                            "    0.1\n"
                            "  ],\n"
                            "  \"empty\": {},\n"
                            "  \"at\": [1, -0.5, null]\n"
                            "}\n");
  lth_json_destroy(ctx, &json);
  assert_null(json);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void escapes_what_json_forbids_in_strings(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthJson *json;
  const char *text;
  CHECK_OK(ctx, lth_json_create(ctx, &json));
  lth_json_begin_array(json, NULL);
  lth_json_string(json, NULL, "a\"b\\c\nd\xc3\xa9");
  lth_json_end_array(json);
  CHECK_OK(ctx, lth_json_text(json, &text));
  assert_string_equal(text, "[\n  \"a\\\"b\\\\c\\u000ad\xc3\xa9\"\n]\n");
  lth_json_destroy(ctx, &json);
  lithe_ctx_destroy(&ctx);
}

static void numbers_read_back_to_the_same_bits(void **state) {
  (void)state;
  uint64_t seed = 7;
  char text[LTH_NUMBER_TEXT_MAX];
  for (int i = 0; i < 1000; i++) {
    double value = (test_random(&seed) - 0.5) * pow(10, 600 * (test_random(&seed) - 0.5));
    assert_true(strtod(lth_number_text(value, text), NULL) == value);
  }
  assert_string_equal(lth_number_text(0.1, text), "0.1");
  assert_string_equal(lth_number_text(-0.0, text), "-0");
  assert_string_equal(lth_number_text(-INFINITY, text), "-inf");
}

static void holds_strings_of_a_megabyte(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthJson *json;
  const char *text;
  CHECK_OK(ctx, lth_json_create(ctx, &json));
  char *huge = malloc(1 << 20);
  memset(huge, 'x', (1 << 20) - 1);
  huge[(1 << 20) - 1] = 0;
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "long", huge);
  lth_json_end_object(json);
  CHECK_OK(ctx, lth_json_text(json, &text));
  assert_int_equal(strlen(text), (1 << 20) - 1 + strlen("{\n  \"long\": \"\"\n}\n"));
  free(huge);
  lth_json_destroy(ctx, &json);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(writes_nested_objects_and_arrays),
      cmocka_unit_test(escapes_what_json_forbids_in_strings),
      cmocka_unit_test(numbers_read_back_to_the_same_bits),
      cmocka_unit_test(holds_strings_of_a_megabyte),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
