/// Whole files: read back as written, atomic, with the system's reason where writing fails.
#include "check.h"
#include "io/file.h"
#include "scratch_folder.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void reads_what_was_written_with_a_zero_behind(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthFileWriter writer;
  char *path = NULL, *data = NULL;
  size_t size = 0;
  CHECK_OK(ctx, lth_path_join(ctx, folder, "a.bin", &path));
  CHECK_OK(ctx, lth_file_open(ctx, path, &writer));
  for (int i = 0; i < 100000; i++) putc(i % 251, writer.stream);
  assert_int_not_equal(access(path, F_OK), 0); // not there before it is whole
  CHECK_OK(ctx, lth_file_commit(ctx, &writer));
  CHECK_OK(ctx, lth_file_read(ctx, path, &data, &size));
  assert_int_equal(size, 100000);
  for (int i = 0; i < 100000; i++) assert_int_equal((unsigned char)data[i], i % 251);
  assert_int_equal(data[size], 0);
  lth_free(ctx, data);
  lth_free(ctx, path);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void an_abandoned_file_leaves_the_old_one(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthFileWriter writer;
  char *path = NULL, *data = NULL;
  size_t size = 0;
  CHECK_OK(ctx, lth_path_join(ctx, folder, "old.txt", &path));
  CHECK_OK(ctx, lth_file_open(ctx, path, &writer));
  fputs("old", writer.stream);
  CHECK_OK(ctx, lth_file_commit(ctx, &writer));
  CHECK_OK(ctx, lth_file_open(ctx, path, &writer));
  fputs("half of a new", writer.stream);
  lth_file_abandon(ctx, &writer);
  CHECK_OK(ctx, lth_file_read(ctx, path, &data, &size));
  assert_string_equal(data, "old");
  lth_free(ctx, data);
  lth_free(ctx, path);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void a_full_disk_is_told(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthFileWriter writer;
  CHECK_OK(ctx, lth_file_open(ctx, "/dev/full", &writer));
  for (int i = 0; i < 100000; i++) putc('x', writer.stream);
  assert_int_equal(lth_file_commit(ctx, &writer), LITHE_NO_SPACE);
  assert_non_null(strstr(lithe_ctx_message(ctx), "No space left"));
  CHECK_OK(ctx, lth_file_open(ctx, "/dev/full", &writer));
  putc('x', writer.stream); // fails only when the buffer is flushed
  assert_int_equal(lth_file_commit(ctx, &writer), LITHE_NO_SPACE);
  assert_int_equal(access("/dev/full", F_OK), 0);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void tells_why_a_file_cannot_be_read_or_written(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthFileWriter writer;
  char *data = NULL;
  size_t size = 0;
  assert_int_equal(lth_file_read(ctx, "/no/such/file", &data, &size), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "/no/such/file: cannot be read: No such file"));
  assert_int_equal(lth_file_read(ctx, folder, &data, &size), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "is a folder"));
  assert_int_equal(lth_file_open(ctx, "/no/such/folder/file", &writer), LITHE_NO_SPACE);
  assert_int_equal(lth_file_open(ctx, folder, &writer), LITHE_NO_SPACE);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void makes_folders_with_their_parents(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthFileWriter writer;
  char *path = NULL, *file = NULL, *below = NULL;
  struct stat info;
  CHECK_OK(ctx, lth_path_join(ctx, folder, "x//y/z/", &path));
  CHECK_OK(ctx, lth_folder_make(ctx, path));
  CHECK_OK(ctx, lth_folder_make(ctx, path)); // again is fine
  assert_int_equal(stat(path, &info), 0);
  assert_true(S_ISDIR(info.st_mode));
  CHECK_OK(ctx, lth_path_join(ctx, path, "file", &file));
  CHECK_OK(ctx, lth_file_open(ctx, file, &writer));
  CHECK_OK(ctx, lth_file_commit(ctx, &writer));
  CHECK_OK(ctx, lth_path_join(ctx, file, "below", &below));
  assert_int_equal(lth_folder_make(ctx, below), LITHE_NO_SPACE);
  lth_free(ctx, path);
  lth_free(ctx, file);
  lth_free(ctx, below);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void joins_paths(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const char *cases[][3] = {
      {"a", "b", "a/b"}, {"a/", "b", "a/b"}, {"", "b", "b"}, {"a", "/b", "/b"}, {"/", "b", "/b"}};
  for (int i = 0; i < 5; i++) {
    char *path = NULL;
    CHECK_OK(ctx, lth_path_join(ctx, cases[i][0], cases[i][1], &path));
    assert_string_equal(path, cases[i][2]);
    lth_free(ctx, path);
  }
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_what_was_written_with_a_zero_behind),
      cmocka_unit_test(an_abandoned_file_leaves_the_old_one),
      cmocka_unit_test(a_full_disk_is_told),
      cmocka_unit_test(tells_why_a_file_cannot_be_read_or_written),
      cmocka_unit_test(makes_folders_with_their_parents),
      cmocka_unit_test(joins_paths),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
