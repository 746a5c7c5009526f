/// PC2 point caches: layout of the bytes, whole frames at any moment. golden/check_pc2.py reads them again.
#include "check.h"
#include "io/pc2.h"

#include <string.h>

#define POINTS 5000 // more than one batch of the writer

static double coordinate(int frame, int i) { return 0.25 * frame + 0.001 * i; }

static void fill(int frame, double *points) {
  for (int i = 0; i < 3 * POINTS; i++) points[i] = coordinate(frame, i);
}

static long size_of(const char *path) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  fseek(file, 0, SEEK_END);
  long size = ftell(file);
  fclose(file);
  return size;
}

static int count_of(const char *path) {
  unsigned char b[4];
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fseek(file, 28, SEEK_SET), 0);
  assert_int_equal(fread(b, 1, 4, file), 4);
  fclose(file);
  return b[0] | b[1] << 8 | b[2] << 16 | b[3] << 24;
}

static void counts_whole_frames_after_each_one(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthPc2 *pc2;
  double *points = malloc(sizeof *points * 3 * POINTS);
  CHECK_OK(ctx, lth_pc2_open(ctx, "test_pc2.pc2", POINTS, 0.04, &pc2));
  assert_int_equal(count_of("test_pc2.pc2"), 0);
  for (int frame = 0; frame < 3; frame++) {
    fill(frame, points);
    CHECK_OK(ctx, lth_pc2_append(ctx, pc2, points));
    assert_int_equal(count_of("test_pc2.pc2"), frame + 1);
    assert_int_equal(size_of("test_pc2.pc2"), 32 + 12L * POINTS * (frame + 1));
  }
  CHECK_OK(ctx, lth_pc2_close(ctx, &pc2));
  assert_null(pc2);
  free(points);
  assert_int_equal(lth_alloc_bytes(ctx), 0);

  FILE *expected = fopen("pc2_expected.json", "w");
  fprintf(expected,
          "{\"file\": \"test_pc2.pc2\", \"points\": %d, \"samples\": 3, \"rate\": 0.04, "
          "\"per_frame\": 0.25, \"per_coordinate\": 0.001}\n",
          POINTS);
  fclose(expected);
  lithe_ctx_destroy(&ctx);
}

static void tells_a_full_disk(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthPc2 *pc2;
  assert_int_equal(lth_pc2_open(ctx, "/dev/full", 3, 0.1, &pc2), LITHE_NO_SPACE);
  assert_null(pc2);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(counts_whole_frames_after_each_one),
      cmocka_unit_test(tells_a_full_disk),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
