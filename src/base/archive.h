/// State as bytes in memory: one walk over the fields writes them or reads them back.
#pragma once

#include "base/ctx.h"

/// A walk that cannot disagree with itself: the same function stores and restores. The first failure is kept
/// in `status`; every call after it does nothing. Bytes are in the machine's own order.
typedef struct LthArchive {
  LitheCtx *ctx;
  bool is_reading;
  char *data; ///< (cap) while writing, (size) while reading
  LitheCount
      cap; ///< grown as needed and kept, so that a second walk of the same size allocates nothing
  LitheCount size, at;
  LitheStatus status;
} LthArchive;

/// Start to write from the beginning; keeps the memory of an earlier walk.
void lth_archive_begin(LthArchive *archive, LitheCtx *ctx);
/// Start to read `size` bytes, which are borrowed until the walk ends.
void lth_archive_open(LthArchive *archive, LitheCtx *ctx, char *data, LitheCount size);
/// Free the memory of an archive that was written.
void lth_archive_free(LitheCtx *ctx, LthArchive *archive);

/// Bytes of a value, in or out.
void lth_archive_bytes(LthArchive *archive, void *data, LitheCount n_bytes);
#define LTH_ARCHIVE(archive, value) lth_archive_bytes((archive), &(value), sizeof(value))

/// A mark between parts: reading fails where another name stands there.
void lth_archive_mark(LthArchive *archive, const char *name);

/// An array whose length both sides know: reading fails where another length was written.
void lth_archive_array(LthArchive *archive, void *data, LitheCount n, size_t size);
#define LTH_ARCHIVE_ARRAY(archive, array, n)                                                       \
  lth_archive_array((archive), (array), (n), sizeof *(array))

/// A number of things that is read before the things: not negative, and no more than bytes are left.
void lth_archive_count(LthArchive *archive, LitheCount *n);

/// A text; while reading `*text` becomes a new one, freed by lth_free() (NULL after a failure).
void lth_archive_text(LthArchive *archive, char **text);
