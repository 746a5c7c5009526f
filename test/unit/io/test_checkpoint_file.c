/// A checkpoint comes back whole or is refused: any bit changed, any byte missing, another version or order.
#include "check.h"
#include "io/checkpoint_file.h"
#include "io/csv.h"
#include "io/file.h"
#include "io/pc2.h"
#include "scratch_folder.h"

#include <string.h>

#define HEAD 32

static char *path_of(LitheCtx *ctx, const char *name) {
  char *path = NULL;
  CHECK_OK(ctx, lth_path_join(ctx, folder, name, &path));
  return path;
}

static void write_bytes(LitheCtx *ctx, const char *path, const char *data, size_t size) {
  LthFileWriter writer;
  CHECK_OK(ctx, lth_file_open(ctx, path, &writer));
  fwrite(data, 1, size, writer.stream);
  CHECK_OK(ctx, lth_file_commit(ctx, &writer));
}

static void refuses(LitheCtx *ctx, const char *path, const char *why) {
  char *data;
  LitheCount size;
  assert_int_equal(lth_checkpoint_read(ctx, path, &data, &size), LITHE_BAD_INPUT);
  assert_null(data);
  assert_non_null(strstr(lithe_ctx_message(ctx), why));
}

static void comes_back_as_written_and_replaces_the_older_one(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char *path = path_of(ctx, "checkpoint"), *data;
  LitheCount size;
  CHECK_OK(ctx, lth_checkpoint_write(ctx, path, "older", 5));
  CHECK_OK(ctx, lth_checkpoint_write(ctx, path, "new\0er", 6));
  CHECK_OK(ctx, lth_checkpoint_read(ctx, path, &data, &size));
  assert_int_equal(size, 6);
  assert_memory_equal(data, "new\0er", 6);
  lth_free(ctx, data);
  lth_free(ctx, path);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void any_damage_is_seen(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char *path = path_of(ctx, "damaged"), *data, *read;
  size_t n;
  LitheCount size;
  CHECK_OK(ctx, lth_checkpoint_write(ctx, path, "0123456789abcdef", 16));
  CHECK_OK(ctx, lth_file_read(ctx, path, &data, &n));
  assert_int_equal(n, HEAD + 16);
  for (size_t bit = 0; bit < 8 * n; bit++) {
    data[bit / 8] ^= (char)(1 << bit % 8);
    write_bytes(ctx, path, data, n);
    assert_int_equal(lth_checkpoint_read(ctx, path, &read, &size), LITHE_BAD_INPUT);
    data[bit / 8] ^= (char)(1 << bit % 8);
  }
  for (size_t length = 0; length < n; length++) {
    write_bytes(ctx, path, data, length);
    refuses(ctx, path, length < HEAD ? "not a checkpoint" : "damaged");
  }
  lth_free(ctx, data);
  lth_free(ctx, path);
  lithe_ctx_destroy(&ctx);
}

static void other_versions_orders_and_files_are_named(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char *path = path_of(ctx, "foreign"), *data;
  size_t n;
  CHECK_OK(ctx, lth_checkpoint_write(ctx, path, "0123", 4));
  CHECK_OK(ctx, lth_file_read(ctx, path, &data, &n));
  data[12]++; // version
  write_bytes(ctx, path, data, n);
  refuses(ctx, path, "format version");
  for (int i = 0; i < 2; i++) { // byte order
    char byte = data[8 + i];
    data[8 + i] = data[11 - i];
    data[11 - i] = byte;
  }
  write_bytes(ctx, path, data, n);
  refuses(ctx, path, "other byte order");
  write_bytes(ctx, path, "a text that somebody called checkpoint", 38);
  refuses(ctx, path, "not a checkpoint of lithe");
  lth_free(ctx, data);
  lth_free(ctx, path);
  char *none = path_of(ctx, "none");
  refuses(ctx, none, "cannot be read");
  lth_free(ctx, none);
  lithe_ctx_destroy(&ctx);
}

/// Write 3 rows, remember the length after 2, go on from there with another third row.
static void a_table_goes_on_where_it_was_remembered(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const char *const names[] = {"a", "b"};
  char *path = path_of(ctx, "table.csv"), *data;
  const double rows[4][2] = {{1, 2}, {3, 4}, {5, 6}, {7, 8}};
  LthArchive out = {0}, in;
  LthCsv *csv;
  size_t n;
  CHECK_OK(ctx, lth_csv_open(ctx, path, 2, names, &csv));
  for (int i = 0; i < 3; i++) {
    CHECK_OK(ctx, lth_csv_row(ctx, csv, rows[i]));
    if (i != 1) continue;
    lth_archive_begin(&out, ctx);
    lth_csv_archive(csv, &out);
  }
  CHECK_OK(ctx, lth_csv_close(ctx, &csv));
  CHECK_OK(ctx, lth_csv_reopen(ctx, path, 2, &csv));
  lth_archive_open(&in, ctx, out.data, out.size);
  lth_csv_archive(csv, &in);
  CHECK_OK(ctx, in.status);
  CHECK_OK(ctx, lth_csv_row(ctx, csv, rows[3]));
  CHECK_OK(ctx, lth_csv_close(ctx, &csv));
  CHECK_OK(ctx, lth_file_read(ctx, path, &data, &n));
  assert_string_equal(data, "a,b\n1,2\n3,4\n7,8\n");
  lth_free(ctx, data);

  write_bytes(ctx, path, "a,b\n", 4);
  CHECK_OK(ctx, lth_csv_reopen(ctx, path, 2, &csv));
  lth_archive_open(&in, ctx, out.data, out.size);
  lth_csv_archive(csv, &in);
  assert_int_equal(in.status, LITHE_BAD_INPUT);
  CHECK_OK(ctx, lth_csv_close(ctx, &csv));
  lth_free(ctx, path);
  path = path_of(ctx, "gone.csv");
  assert_int_equal(lth_csv_reopen(ctx, path, 2, &csv), LITHE_BAD_INPUT);
  lth_free(ctx, path);
  lth_archive_free(ctx, &out);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void a_point_cache_goes_on_where_it_was_remembered(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char *path = path_of(ctx, "cache.pc2"), *whole, *again;
  const double frames[3][3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  LthArchive out = {0}, in;
  LthPc2 *pc2;
  size_t n_whole, n_again;
  CHECK_OK(ctx, lth_pc2_open(ctx, path, 1, 0.5, &pc2));
  CHECK_OK(ctx, lth_pc2_append(ctx, pc2, frames[0]));
  lth_archive_begin(&out, ctx);
  lth_pc2_archive(pc2, &out);
  CHECK_OK(ctx, lth_pc2_append(ctx, pc2, frames[1]));
  CHECK_OK(ctx, lth_file_read(ctx, path, &whole, &n_whole));
  CHECK_OK(ctx, lth_pc2_append(ctx, pc2, frames[2]));
  CHECK_OK(ctx, lth_pc2_close(ctx, &pc2));

  CHECK_OK(ctx, lth_pc2_reopen(ctx, path, 1, &pc2));
  lth_archive_open(&in, ctx, out.data, out.size);
  lth_pc2_archive(pc2, &in);
  CHECK_OK(ctx, in.status);
  CHECK_OK(ctx, lth_pc2_append(ctx, pc2, frames[1]));
  CHECK_OK(ctx, lth_pc2_close(ctx, &pc2));
  CHECK_OK(ctx, lth_file_read(ctx, path, &again, &n_again));
  assert_int_equal(n_again, n_whole);
  assert_memory_equal(again, whole, n_whole);
  lth_free(ctx, whole);
  lth_free(ctx, again);
  lth_free(ctx, path);
  lth_archive_free(ctx, &out);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(comes_back_as_written_and_replaces_the_older_one),
      cmocka_unit_test(any_damage_is_seen),
      cmocka_unit_test(other_versions_orders_and_files_are_named),
      cmocka_unit_test(a_table_goes_on_where_it_was_remembered),
      cmocka_unit_test(a_point_cache_goes_on_where_it_was_remembered),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
