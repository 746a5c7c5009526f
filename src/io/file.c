/// Whole files and folders: reading, writing to a temporary name that is renamed, joining paths.
#include "io/file.h"

#include "base/digest.h"

#include <dirent.h>
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define READ_CHUNK 65536

/// Append everything that `stream` still holds to `*data`.
static LitheStatus read_stream(LitheCtx *ctx, const char *path, FILE *stream, char **data,
                               size_t *size) {
  LitheCount cap = 0, n = 0;
  for (;;) {
    LTH_RESERVE(ctx, *data, cap, n + READ_CHUNK + 1);
    size_t got = fread(*data + n, 1, (size_t)(cap - n - 1), stream);
    n += (LitheCount)got;
    if (ferror(stream))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    if (got == 0) break;
  }
  (*data)[n] = 0;
  *size = (size_t)n;
  return LITHE_OK;
}

LitheStatus lth_file_read(LitheCtx *ctx, const char *path, char **data, size_t *size) {
  *data = NULL;
  *size = 0;
  struct stat info;
  if (stat(path, &info) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
  if (S_ISDIR(info.st_mode))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: is a folder, expected a file", path);
  FILE *stream = fopen(path, "rb");
  if (!stream) LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));

  LitheStatus status = read_stream(ctx, path, stream, data, size);
  fclose(stream);
  if (status == LITHE_OK) {
    lth_note_input(ctx, lth_digest(*data, *size, 0));
  } else {
    lth_free(ctx, *data);
    *data = NULL;
    *size = 0;
  }
  return status;
}

static LitheStatus cannot_write(LitheCtx *ctx, const char *path, int reason) {
  return lth_fail(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", path,
                  reason ? strerror(reason) : "a write was incomplete");
}

/// Only a regular file can be replaced by a rename; a device or a pipe is written to directly.
static bool is_special(const char *path) {
  struct stat info;
  return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

LitheStatus lth_file_open(LitheCtx *ctx, const char *path, LthFileWriter *writer) {
  *writer = (LthFileWriter){0};
  struct stat info;
  if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) return cannot_write(ctx, path, EISDIR);

  LitheStatus status = LITHE_OK;
  size_t length = strlen(path);
  LITHE_TRY_OR(done, lth_copy_text(ctx, path, &writer->path));
  if (!is_special(path)) {
    LTH_NEW_OR(done, ctx, writer->temporary, (LitheCount)length + 32);
    snprintf(writer->temporary, length + 32, "%s.%ld.part", path, (long)getpid());
  }
  writer->stream = fopen(writer->temporary ? writer->temporary : path, "wb");
  if (!writer->stream) status = cannot_write(ctx, path, errno);
done:
  if (status != LITHE_OK) {
    lth_free(ctx, writer->temporary);
    lth_free(ctx, writer->path);
    *writer = (LthFileWriter){0};
  }
  return status;
}

/// Flush and close; 0 or the reason (-1 where the system gives none).
static int close_stream(FILE *stream) {
  errno = 0;
  bool failed = ferror(stream) != 0;
  if (fflush(stream) != 0) failed = true;
  int reason = errno;
  if (fclose(stream) != 0) {
    failed = true;
    if (!reason) reason = errno;
  }
  if (!failed) return 0;
  return reason ? reason : -1;
}

LitheStatus lth_file_commit(LitheCtx *ctx, LthFileWriter *writer) {
  LitheStatus status = LITHE_OK;
  int reason = close_stream(writer->stream);
  writer->stream = NULL;
  if (reason) {
    status = cannot_write(ctx, writer->path, reason > 0 ? reason : 0);
  } else if (writer->temporary) {
    if (rename(writer->temporary, writer->path) != 0) {
      status = cannot_write(ctx, writer->path, errno);
    } else {
      lth_free(ctx, writer->temporary);
      writer->temporary = NULL;
    }
  }
  lth_file_abandon(ctx, writer);
  return status;
}

void lth_file_abandon(LitheCtx *ctx, LthFileWriter *writer) {
  if (writer->stream) fclose(writer->stream);
  if (writer->temporary) remove(writer->temporary);
  lth_free(ctx, writer->temporary);
  lth_free(ctx, writer->path);
  *writer = (LthFileWriter){0};
}

/// "name.1234.part", as lth_file_open() calls them.
static bool is_part(const char *name) {
  size_t length = strlen(name);
  if (length < 7 || strcmp(name + length - 5, ".part") != 0) return false;
  const char *at = name + length - 6;
  while (at > name && *at >= '0' && *at <= '9') at--;
  return *at == '.' && at < name + length - 6 && at > name;
}

LitheStatus lth_file_remove_parts(LitheCtx *ctx, const char *folder) {
  DIR *dir = opendir(folder);
  LitheStatus status = LITHE_OK;
  for (struct dirent *entry; dir && status == LITHE_OK && (entry = readdir(dir));) {
    char *path;
    if (!is_part(entry->d_name)) continue;
    status = lth_path_join(ctx, folder, entry->d_name, &path);
    if (status != LITHE_OK) break;
    unlink(path);
    lth_free(ctx, path);
  }
  if (dir) closedir(dir);
  return status;
}

static LitheStatus make_one_folder(LitheCtx *ctx, const char *path) {
  if (mkdir(path, 0777) == 0) return LITHE_OK;
  int reason = errno;
  struct stat info;
  if (reason == EEXIST && stat(path, &info) == 0) {
    if (S_ISDIR(info.st_mode)) return LITHE_OK;
    LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: a folder is to be made here, but a file has this name",
               path);
  }
  LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: folder cannot be made: %s", path, strerror(reason));
}

LitheStatus lth_folder_make(LitheCtx *ctx, const char *path) {
  LitheStatus status = LITHE_OK;
  char *prefix = NULL;
  size_t length = strlen(path);
  if (length == 0) return LITHE_OK;
  LITHE_TRY(lth_copy_text(ctx, path, &prefix));
  for (size_t i = 1; i < length; i++) {
    if (prefix[i] != '/' || prefix[i - 1] == '/') continue;
    prefix[i] = 0;
    LITHE_TRY_OR(done, make_one_folder(ctx, prefix));
    prefix[i] = '/';
  }
  LITHE_TRY_OR(done, make_one_folder(ctx, prefix));
done:
  lth_free(ctx, prefix);
  return status;
}

LitheStatus lth_stream_open(LitheCtx *ctx, const char *path, const char *mode, FILE **stream) {
  *stream = fopen(path, mode);
  if (*stream) return LITHE_OK;
  if (mode[0] == 'r' && errno == ENOENT)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: the file is gone that the run would go on with; run the scene anew", path);
  LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", path, strerror(errno));
}

LitheStatus lth_path_join(LitheCtx *ctx, const char *folder, const char *name, char **path) {
  size_t n_folder = name[0] == '/' ? 0 : strlen(folder), n_name = strlen(name);
  bool needs_slash = n_folder > 0 && folder[n_folder - 1] != '/';
  LTH_NEW(ctx, *path, (LitheCount)(n_folder + n_name + 2));
  memcpy(*path, folder, n_folder);
  if (needs_slash) (*path)[n_folder] = '/';
  memcpy(*path + n_folder + needs_slash, name, n_name + 1);
  return LITHE_OK;
}

LitheStatus lth_path_ending(LitheCtx *ctx, const char *folder, const char *stem, const char *ending,
                            char **path) {
  size_t room = strlen(stem) + strlen(ending) + 2;
  char *name;
  LTH_NEW(ctx, name, (LitheCount)room);
  snprintf(name, room, "%s.%s", stem, ending);
  LitheStatus status = lth_path_join(ctx, folder, name, path);
  lth_free(ctx, name);
  return status;
}

LitheStatus lth_path_numbered(LitheCtx *ctx, const char *folder, const char *stem,
                              LitheIndex number, const char *ending, char **path) {
  size_t room = strlen(stem) + 16;
  char *name;
  LTH_NEW(ctx, name, (LitheCount)room);
  snprintf(name, room, "%s_%04d", stem, number);
  LitheStatus status = lth_path_ending(ctx, folder, name, ending, path);
  lth_free(ctx, name);
  return status;
}

LitheStatus lth_file_remove_numbered(LitheCtx *ctx, const char *folder, const char *stem,
                                     LitheIndex first, const char *ending) {
  for (bool found = true; found; first++) {
    char *path;
    LITHE_TRY(lth_path_numbered(ctx, folder, stem, first, ending, &path));
    found = unlink(path) == 0;
    lth_free(ctx, path);
  }
  return LITHE_OK;
}
