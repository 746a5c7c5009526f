/// Drawings: text that is a picture, colours that can be read in grey, images that come back from their file.
#include "check.h"
#include "study/draw.h"

#include <string.h>

static LitheCtx *ctx;
static LthArena arena;

static int open_arena(void **state) {
  (void)state;
  ctx = test_ctx();
  arena = (LthArena){.ctx = ctx};
  return 0;
}

static int close_arena(void **state) {
  (void)state;
  lth_arena_free(&arena);
  lithe_ctx_destroy(&ctx);
  return 0;
}

static void colours_become_lighter_all_along(void **state) {
  (void)state;
  double before = -1;
  for (int i = 0; i <= 100; i++) {
    uint8_t rgb[3];
    lth_colour_bytes(i / 100., rgb);
    double grey = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    if (!(grey > before)) fail_msg("grey %g after %g at %d", grey, before, i);
    before = grey;
  }
  CHECK_AT_LEAST(before, 200);
}

static void places_stand_upright_in_their_panel(void **state) {
  (void)state;
  LthDrawing d = {.ctx = ctx};
  lth_draw_begin(&d, 100, 100);
  CHECK_NEAR(lth_draw_panel(&d, (double[]){-1, -1, 1, 0}, 10, 20, 80), 40, 1e-12);
  lth_draw_dot(&d, (double[]){-1, -1}, 2, "#ff0000");
  lth_draw_dot(&d, (double[]){1, 0}, 2, "#ff0000");
  lth_draw_words(&d, 5, 5, "a < b");
  const char *text = lth_draw_end(&d, &arena);
  assert_non_null(strstr(text, "cx=\"10.00\" cy=\"60.00\""));
  assert_non_null(strstr(text, "cx=\"90.00\" cy=\"20.00\""));
  assert_non_null(strstr(text, "a &lt; b"));
  assert_non_null(strstr(text, "</svg>"));
}

static void pixels_are_a_picture_file(void **state) {
  (void)state;
  uint8_t rgb[3 * 6] = {255, 0, 0, 0, 255, 0, 0, 0, 255};
  LthDrawing d = {.ctx = ctx};
  lth_draw_begin(&d, 30, 20);
  lth_draw_panel(&d, (double[]){0, 0, 3, 2}, 0, 0, 30);
  lth_draw_pixels(&d, 3, 2, rgb);
  const char *text = lth_draw_end(&d, &arena);
  // signature, length 13, IHDR, width 3, height 2, 8 bits, colours; computed with Python's base64
  assert_non_null(strstr(text, "base64,iVBORw0KGgoAAAANSUhEUgAAAAMAAAACCAIAAAA"));
  const char *begin = strstr(text, "base64,"), *end = strstr(text, "\"/>\n</svg>");
  assert_non_null(end);
  assert_int_equal((end - begin - 7) % 4, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(colours_become_lighter_all_along),
      cmocka_unit_test(places_stand_upright_in_their_panel),
      cmocka_unit_test(pixels_are_a_picture_file),
  };
  return cmocka_run_group_tests(tests, open_arena, close_arena);
}
