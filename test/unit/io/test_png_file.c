/// PNG files: grey, colours, palettes, alpha and few bits become one value a pixel; what is wrong with broken ones.
#include "check.h"

#include "io/volume_file.h"

#include <string.h>
#include <zlib.h>

/// A file being put together.
typedef struct Png {
  char at[4096];
  size_t n;
} Png;

static void put(Png *p, const void *data, size_t n) {
  assert_true(p->n + n <= sizeof p->at);
  if (n > 0) memcpy(p->at + p->n, data, n);
  p->n += n;
}

static void put_big(Png *p, uint32_t value) {
  const uint8_t bytes[4] = {(uint8_t)(value >> 24), (uint8_t)(value >> 16), (uint8_t)(value >> 8),
                            (uint8_t)value};
  put(p, bytes, 4);
}

static void put_chunk(Png *p, const char *name, const void *data, size_t n) {
  put_big(p, (uint32_t)n);
  size_t begin = p->n;
  put(p, name, 4);
  put(p, data, n);
  put_big(p, (uint32_t)crc32(0, (const Bytef *)p->at + begin, (uInt)(p->n - begin)));
}

static void put_start(Png *p, uint32_t width, uint32_t height, int depth, int color,
                      int interlace) {
  Png header = {.n = 0};
  put_big(&header, width);
  put_big(&header, height);
  const uint8_t rest[5] = {(uint8_t)depth, (uint8_t)color, 0, 0, (uint8_t)interlace};
  put(&header, rest, 5);
  p->n = 0;
  put(p, "\x89PNG\r\n\x1a\n", 8);
  put_chunk(p, "IHDR", header.at, header.n);
}

/// Rows (each behind its filter byte) and the end.
static void put_rows(Png *p, const void *rows, size_t n) {
  uint8_t packed[1024];
  uLongf size = sizeof packed;
  assert_int_equal(compress(packed, &size, rows, (uLong)n), Z_OK);
  put_chunk(p, "IDAT", packed, size);
  put_chunk(p, "IEND", NULL, 0);
}

/// The values come out as these, lowest row first.
static void expect_values(const Png *p, LitheIndex width, LitheIndex height, const double *values) {
  LitheCtx *ctx = test_ctx();
  LthVolume *v = NULL;
  CHECK_OK(ctx, lth_volume_parse(ctx, "t.png", "png", p->at, p->n, &v));
  assert_int_equal(v->n[0], width);
  assert_int_equal(v->n[1], height);
  assert_int_equal(v->n[2], 1);
  for (LitheCount i = 0; i < (LitheCount)width * height; i++)
    CHECK_NEAR((double)v->values[i], values[i], 0);
  // pixels of 1 mm, the lower left corner at the origin
  CHECK_NEAR(v->to_world[0], 1e-3, 0);
  CHECK_NEAR(v->to_world[3], 0.5e-3, 0);
  CHECK_NEAR(v->to_world[7], 0.5e-3, 0);
  lth_volume_destroy(ctx, &v);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void grey_values_stay_with_the_first_row_on_top(void **state) {
  (void)state;
  Png p;
  put_start(&p, 3, 2, 8, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 0, 128, 255, 0, 1, 2, 3}, 8);
  expect_values(&p, 3, 2, (const double[]){1, 2, 3, 0, 128, 255});
  put_start(&p, 2, 1, 16, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 0x12, 0x34, 0xff, 0xff}, 5);
  expect_values(&p, 2, 1, (const double[]){0x1234, 65535});
}

static void few_bits_span_black_to_white(void **state) {
  (void)state;
  Png p;
  put_start(&p, 9, 1, 1, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 0xa0, 0x80}, 3);
  expect_values(&p, 9, 1, (const double[]){255, 0, 255, 0, 0, 0, 0, 0, 255});
  put_start(&p, 2, 1, 4, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 0x3f}, 2);
  expect_values(&p, 2, 1, (const double[]){51, 255});
}

static void colours_become_their_luminance(void **state) {
  (void)state;
  Png p;
  put_start(&p, 4, 1, 8, 2, 0);
  put_rows(&p, (const uint8_t[]){0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 77, 77, 77}, 13);
  // 0.2126, 0.7152 and 0.0722 of 255; grey stays exactly what it is
  expect_values(&p, 4, 1, (const double[]){54, 182, 18, 77});
  put_start(&p, 4, 1, 2, 3, 0);
  put_chunk(&p, "PLTE", (const uint8_t[]){0, 0, 0, 255, 255, 255, 9, 9, 9, 0, 255, 0}, 12);
  put_rows(&p, (const uint8_t[]){0, 0x1b}, 2);
  expect_values(&p, 4, 1, (const double[]){0, 255, 9, 182});
}

static void what_is_transparent_counts_as_black(void **state) {
  (void)state;
  Png p;
  put_start(&p, 3, 1, 8, 4, 0);
  put_rows(&p, (const uint8_t[]){0, 200, 255, 200, 0, 200, 51}, 7);
  expect_values(&p, 3, 1, (const double[]){200, 0, 40});
  put_start(&p, 1, 1, 16, 6, 0);
  put_rows(&p, (const uint8_t[]){0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x80, 0}, 9);
  expect_values(&p, 1, 1, (const double[]){32768});
  put_start(&p, 2, 1, 8, 0, 0);
  put_chunk(&p, "tRNS", (const uint8_t[]){0, 6}, 2);
  put_rows(&p, (const uint8_t[]){0, 5, 6}, 3);
  expect_values(&p, 2, 1, (const double[]){5, 0});
}

static void interlaced_rows_come_out_in_order(void **state) {
  (void)state;
  Png p;
  put_start(&p, 2, 2, 8, 0, 1);
  put_rows(&p, (const uint8_t[]){0, 1, 0, 2, 0, 3, 4}, 7);
  expect_values(&p, 2, 2, (const double[]){3, 4, 1, 2});
}

static void expect_error(const char *data, size_t n, const char *words) {
  LitheCtx *ctx = test_ctx();
  LthVolume *v = NULL;
  assert_int_equal(lth_volume_parse(ctx, "t.png", "png", data, n, &v), LITHE_BAD_INPUT);
  assert_null(v);
  if (!strstr(lithe_ctx_message(ctx), words)) fail_msg("%s", lithe_ctx_message(ctx));
  assert_non_null(strstr(lithe_ctx_message(ctx), "t.png"));
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void broken_files_are_refused_in_plain_words(void **state) {
  (void)state;
  Png p;
  put_start(&p, 3, 2, 8, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 0, 128, 255, 0, 1, 2, 3}, 8);
  for (size_t n = 0; n < p.n - 12; n++) expect_error(p.at, n, "t.png");
  expect_error(p.at, 40, "the file ends too early");
  expect_error("no image at all", 15, "no PNG image that can be read");
  p.at[45]++;
  expect_error(p.at, p.n, "no PNG image that can be read");
  put_start(&p, 4, 4, 8, 0, 0);
  put_rows(&p, (const uint8_t[]){0, 1, 2, 3, 4}, 5);
  expect_error(p.at, p.n, "t.png");
}

static void headers_that_promise_too_much_are_refused(void **state) {
  (void)state;
  Png p;
  put_start(&p, 90000, 90000, 16, 6, 0);
  put_rows(&p, (const uint8_t[]){0}, 1);
  expect_error(p.at, p.n, "promises 90000 x 90000 pixels");
  put_start(&p, 200000, 1, 8, 0, 0);
  put_rows(&p, (const uint8_t[]){0}, 1);
  expect_error(p.at, p.n, "t.png");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(grey_values_stay_with_the_first_row_on_top),
      cmocka_unit_test(few_bits_span_black_to_white),
      cmocka_unit_test(colours_become_their_luminance),
      cmocka_unit_test(what_is_transparent_counts_as_black),
      cmocka_unit_test(interlaced_rows_come_out_in_order),
      cmocka_unit_test(broken_files_are_refused_in_plain_words),
      cmocka_unit_test(headers_that_promise_too_much_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
