/// State as bytes in memory: writing grows a block, reading walks one and checks every length.
#include "base/archive.h"

#include <string.h>

#define MARK_BYTES 16

void lth_archive_begin(LthArchive *a, LitheCtx *ctx) {
  a->ctx = ctx;
  a->is_reading = false;
  a->size = a->at = 0;
  a->status = LITHE_OK;
}

void lth_archive_open(LthArchive *a, LitheCtx *ctx, char *data, LitheCount size) {
  *a = (LthArchive){.ctx = ctx, .is_reading = true, .data = data, .size = size};
}

void lth_archive_free(LitheCtx *ctx, LthArchive *a) {
  if (!a->is_reading) lth_free(ctx, a->data);
  *a = (LthArchive){0};
}

static LitheStatus reserve(LthArchive *a, LitheCount n) {
  LTH_RESERVE(a->ctx, a->data, a->cap, n);
  return LITHE_OK;
}

static void refuse(LthArchive *a, const char *what) {
  if (a->status == LITHE_OK)
    a->status =
        lth_fail(a->ctx, LITHE_BAD_INPUT,
                 "it %s at byte %lld; it is damaged, or another build of the program wrote it",
                 what, (long long)a->at);
}

void lth_archive_bytes(LthArchive *a, void *data, LitheCount n_bytes) {
  if (a->status != LITHE_OK || n_bytes == 0) return;
  if (a->is_reading) {
    if (n_bytes > a->size - a->at) {
      refuse(a, "ends too early");
      return;
    }
    memcpy(data, a->data + a->at, (size_t)n_bytes);
  } else {
    a->status = reserve(a, a->at + n_bytes);
    if (a->status != LITHE_OK) return;
    memcpy(a->data + a->at, data, (size_t)n_bytes);
    a->size = a->at + n_bytes;
  }
  a->at += n_bytes;
}

void lth_archive_mark(LthArchive *a, const char *name) {
  char wanted[MARK_BYTES] = {0}, mark[MARK_BYTES];
  memcpy(wanted, name, strnlen(name, MARK_BYTES));
  memcpy(mark, wanted, MARK_BYTES);
  lth_archive_bytes(a, mark, MARK_BYTES);
  if (a->status == LITHE_OK && memcmp(mark, wanted, MARK_BYTES) != 0)
    refuse(a, "holds another part than expected");
}

void lth_archive_array(LthArchive *a, void *data, LitheCount n, size_t size) {
  LitheCount written = n;
  LTH_ARCHIVE(a, written);
  if (a->status == LITHE_OK && written != n) refuse(a, "holds an array of another length");
  lth_archive_bytes(a, data, n * (LitheCount)size);
}

void lth_archive_count(LthArchive *a, LitheCount *n) {
  LTH_ARCHIVE(a, *n);
  if (a->status == LITHE_OK && a->is_reading && (*n < 0 || *n > a->size - a->at))
    refuse(a, "holds an impossible number of things");
  if (a->status != LITHE_OK && a->is_reading) *n = 0;
}

void lth_archive_text(LthArchive *a, char **text) {
  LitheCount n = a->is_reading || !*text ? 0 : (LitheCount)strlen(*text);
  if (a->is_reading) *text = NULL;
  lth_archive_count(a, &n);
  if (a->status != LITHE_OK) return;
  if (a->is_reading) {
    *text = lth_alloc(a->ctx, n + 1, 1);
    if (!*text) {
      a->status = lth_fail(a->ctx, LITHE_NO_MEMORY, "out of memory");
      return;
    }
  }
  lth_archive_bytes(a, *text, n);
}
