/// Whole files: read into memory, written to a temporary name and renamed, folders made.
#pragma once

#include "base/ctx.h"

#include <stdio.h>

/// Read a whole file and note its contents among the context's inputs; `*data` (size + 1 bytes, 0 at the end) is freed by lth_free().
LitheStatus lth_file_read(LitheCtx *ctx, const char *path, char **data, size_t *size);

/// A file being written: it appears under its name only when it is complete.
typedef struct LthFileWriter {
  FILE *stream;
  char *path, *temporary;
} LthFileWriter;

LitheStatus lth_file_open(LitheCtx *ctx, const char *path, LthFileWriter *writer);
/// Flush, check, rename; on any failure the temporary file is removed. LITHE_NO_SPACE with the reason.
LitheStatus lth_file_commit(LitheCtx *ctx, LthFileWriter *writer);
void lth_file_abandon(LitheCtx *ctx, LthFileWriter *writer);

/// Remove temporary files in a folder that a killed program left behind.
LitheStatus lth_file_remove_parts(LitheCtx *ctx, const char *folder);

/// Make a folder and its parents.
LitheStatus lth_folder_make(LitheCtx *ctx, const char *path);

/// "a/b" from "a" and "b" (an absolute "b" stays as it is); freed by lth_free().
LitheStatus lth_path_join(LitheCtx *ctx, const char *folder, const char *name, char **path);

/// fopen() for a file that grows while a run goes on: `mode` "wb" makes it new, "r+b" takes one that is there.
/// LITHE_BAD_INPUT where that is gone.
LitheStatus lth_stream_open(LitheCtx *ctx, const char *path, const char *mode, FILE **stream);

/// "folder/stem.ending"; freed by lth_free().
LitheStatus lth_path_ending(LitheCtx *ctx, const char *folder, const char *stem, const char *ending,
                            char **path);

/// "folder/stem_0007.ending"; freed by lth_free().
LitheStatus lth_path_numbered(LitheCtx *ctx, const char *folder, const char *stem,
                              LitheIndex number, const char *ending, char **path);

/// Remove what a longer run left behind: numbered files from `first` on.
LitheStatus lth_file_remove_numbered(LitheCtx *ctx, const char *folder, const char *stem,
                                     LitheIndex first, const char *ending);
