/// All studies of one command: gathered while they run, written as one page, counted.
#pragma once

#include "lithe/study.h"
#include "study/study_files.h"

typedef struct LthBook {
  LitheCtx *ctx;
  const char *folder; ///< borrowed
  LthStudyRun *first, *last;
  double start, began; ///< of all, of the one that runs [s]
} LthBook;

LitheStatus lth_book_open(LitheCtx *ctx, const char *folder, LthBook *book);
void lth_book_close(LthBook *book);

/// A new run with its own folder FOLDER/<name>; owned by the book.
LitheStatus lth_book_add(LthBook *book, const LthStudy *study, const char *name, LthStudyRun **run);

/// Write what the run reports, whatever `status` it ended with, and tell def->tell of it. Returns what stops the whole
/// command: no memory, no disk, an interruption.
LitheStatus lth_book_finish(LthBook *book, LthStudyRun *run, LitheStatus status,
                            const LitheStudyDef *def);

/// The page, index.md and study.json. LITHE_FAILED where something does not hold.
LitheStatus lth_book_write(LthBook *book, const char *title, const char *command,
                           LitheStudyResult **result);
