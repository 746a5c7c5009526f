/// Tables as comma-separated text that is valid after every row: history.csv and probes.csv.
#include "io/csv.h"

#include "io/file.h"

#include "io/number_text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct LthCsv {
  FILE *stream;
  char *path;
  int n;
  long whole; ///< bytes up to the end of the last whole row
};

static LitheStatus fail_writing(LitheCtx *ctx, LthCsv *csv) {
  int reason = errno;
  bool is_whole = ftruncate(fileno(csv->stream), csv->whole) == 0;
  LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s%s", csv->path, strerror(reason),
             is_whole ? "" : " (the last row may be torn)");
}

static LitheStatus end_row(LitheCtx *ctx, LthCsv *csv) {
  fputc('\n', csv->stream);
  if (fflush(csv->stream) != 0 || ferror(csv->stream)) return fail_writing(ctx, csv);
  csv->whole = ftell(csv->stream);
  return LITHE_OK;
}

static void put_name(FILE *stream, const char *name) {
  if (!strpbrk(name, ",\"\r\n")) {
    fputs(name, stream);
    return;
  }
  fputc('"', stream);
  for (; *name; name++) {
    if (*name == '"') fputc('"', stream);
    fputc(*name, stream);
  }
  fputc('"', stream);
}

static void release(LitheCtx *ctx, LthCsv **csv) {
  if ((*csv)->stream) fclose((*csv)->stream);
  lth_free(ctx, (*csv)->path);
  lth_free(ctx, *csv);
  *csv = NULL;
}

/// `mode` of fopen(): "wb" for a new file, "r+b" for one that is there.
static LitheStatus create(LitheCtx *ctx, const char *path, int n, const char *mode, LthCsv **csv) {
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, *csv, 1);
  (*csv)->n = n;
  LITHE_TRY_OR(failed, lth_copy_text(ctx, path, &(*csv)->path));
  LITHE_TRY_OR(failed, lth_stream_open(ctx, path, mode, &(*csv)->stream));
  return LITHE_OK;
failed:
  release(ctx, csv);
  return status;
}

LitheStatus lth_csv_open(LitheCtx *ctx, const char *path, int n, const char *const *names,
                         LthCsv **csv) {
  LITHE_TRY(create(ctx, path, n, "wb", csv));
  for (int i = 0; i < n; i++) {
    if (i > 0) fputc(',', (*csv)->stream);
    put_name((*csv)->stream, names[i]);
  }
  LitheStatus status = end_row(ctx, *csv);
  if (status != LITHE_OK) release(ctx, csv);
  return status;
}

LitheStatus lth_csv_reopen(LitheCtx *ctx, const char *path, int n, LthCsv **csv) {
  return create(ctx, path, n, "r+b", csv);
}

void lth_csv_archive(LthCsv *csv, LthArchive *archive) {
  LTH_ARCHIVE(archive, csv->whole);
  if (!archive->is_reading || archive->status != LITHE_OK) return;
  if (fseek(csv->stream, 0, SEEK_END) != 0 || ftell(csv->stream) < csv->whole)
    archive->status = lth_fail(archive->ctx, LITHE_BAD_INPUT,
                               "%s has become shorter since; run the scene anew", csv->path);
  else if (ftruncate(fileno(csv->stream), csv->whole) != 0 ||
           fseek(csv->stream, csv->whole, SEEK_SET) != 0)
    archive->status = lth_fail(archive->ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", csv->path,
                               strerror(errno));
}

LitheStatus lth_csv_row(LitheCtx *ctx, LthCsv *csv, const double *values) {
  for (int i = 0; i < csv->n; i++) {
    char text[LTH_NUMBER_TEXT_MAX];
    if (i > 0) fputc(',', csv->stream);
    if (isfinite(values[i])) fputs(lth_number_text(values[i], text), csv->stream);
  }
  return end_row(ctx, csv);
}

LitheStatus lth_csv_close(LitheCtx *ctx, LthCsv **csv) {
  if (!*csv) return LITHE_OK;
  bool is_closed = fclose((*csv)->stream) == 0;
  LitheStatus status = LITHE_OK;
  if (!is_closed)
    status =
        lth_fail(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", (*csv)->path, strerror(errno));
  lth_free(ctx, (*csv)->path);
  lth_free(ctx, *csv);
  *csv = NULL;
  return status;
}
