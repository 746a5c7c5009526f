/// Lines of a text header in front of binary data.
#pragma once

#include "base/ctx.h"

#include <stdio.h>

#define LTH_HEADER_LINE 1024

/// Set ctx, name, data and size; the rest starts at zero.
typedef struct LthHeaderLines {
  LitheCtx *ctx;
  const char *name; ///< of the file, for messages
  const char *data;
  size_t size, at;            ///< bytes, and where the next line starts
  int line;                   ///< number of the present line, from 1
  char text[LTH_HEADER_LINE]; ///< it, without its end and the blanks before that
} LthHeaderLines;

/// The next line; false at the end of the file. LITHE_BAD_INPUT: longer than LTH_HEADER_LINE - 1 bytes.
LitheStatus lth_header_line(LthHeaderLines *lines, bool *is_there);

/// Fail with "NAME:LINE: text".
#define LTH_FAIL_LINE(lines, ...)                                                                  \
  do {                                                                                             \
    char what_[300];                                                                               \
    snprintf(what_, sizeof what_, __VA_ARGS__);                                                    \
    LITHE_FAIL((lines)->ctx, LITHE_BAD_INPUT, "%s:%d: %s", (lines)->name, (lines)->line, what_);   \
  } while (0)
