/// CSV tables: header, rows, and a file that is whole after every row.
#include "check.h"
#include "io/csv.h"

#include <string.h>

static void read_back(const char *path, char *text, size_t size) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  size_t n = fread(text, 1, size - 1, file);
  text[n] = 0;
  fclose(file);
}

static void is_whole_after_every_row(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthCsv *csv;
  char text[256];
  const char *const names[3] = {"t", "left, \"upper\" ear", "strain_energy"};
  CHECK_OK(ctx, lth_csv_open(ctx, "test_csv.csv", 3, names, &csv));
  read_back("test_csv.csv", text, sizeof text);
  assert_string_equal(text, "t,\"left, \"\"upper\"\" ear\",strain_energy\n");
  CHECK_OK(ctx, lth_csv_row(ctx, csv, (const double[3]){0, NAN, 1e-7}));
  read_back("test_csv.csv", text, sizeof text);
  assert_string_equal(text, "t,\"left, \"\"upper\"\" ear\",strain_energy\n0,,1e-07\n");
  CHECK_OK(ctx, lth_csv_row(ctx, csv, (const double[3]){1. / 3, -2, INFINITY}));
  CHECK_OK(ctx, lth_csv_close(ctx, &csv));
  assert_null(csv);
  read_back("test_csv.csv", text, sizeof text);
  assert_string_equal(strchr(text, '\n') + 1, "0,,1e-07\n0.3333333333333333,-2,\n");
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void tells_a_full_disk_and_a_missing_folder(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthCsv *csv;
  const char *const names[1] = {"t"};
  assert_int_equal(lth_csv_open(ctx, "/dev/full", 1, names, &csv), LITHE_NO_SPACE);
  assert_null(csv);
  assert_non_null(strstr(lithe_ctx_message(ctx), "/dev/full: cannot be written: No space left"));
  assert_int_equal(lth_csv_open(ctx, "no/such/folder.csv", 1, names, &csv), LITHE_NO_SPACE);
  assert_null(csv);
  CHECK_OK(ctx, lth_csv_close(ctx, &csv));
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(is_whole_after_every_row),
      cmocka_unit_test(tells_a_full_disk_and_a_missing_folder),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
