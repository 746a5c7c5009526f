/// All studies of one command: gathered while they run, written as one page, counted.
#pragma once

#include "lithe/study.h"
#include "study/study_files.h"
#include "study/study_plan.h"

typedef struct LthBook {
  LitheCtx *ctx;
  const char *folder; ///< borrowed
  LthStudyRun *first, *last;
  double start, began; ///< of all, of the one that runs [s]
  LthStudyPlan plan;   ///< empty where nothing is foreseen
} LthBook;

/// What a command adds to its book.
typedef LitheStatus (*LthBookFill)(LthBook *book, void *self);

/// Open a book in a folder, fill it, write the page, index.md and study.json, and close it, all of it in the language of
/// files. LITHE_FAILED where something does not hold.
LitheStatus lth_book_make(LitheCtx *ctx, const char *folder, const char *title, const char *command,
                          LthBookFill fill, void *self, LitheStudyResult **result);

/// The folder a command on a scene writes into: `given`, or out/<scene's name>-<what>. Caller frees.
LitheStatus lth_book_folder(LitheCtx *ctx, const char *given, const char *scene, const char *what,
                            char **folder);

/// A new run with its own folder FOLDER/<name>; owned by the book.
LitheStatus lth_book_add(LthBook *book, const LthStudy *study, const char *name, LthStudyRun **run);

/// Write what the run reports, whatever `status` it ended with, and tell def->tell of it. Returns what stops the whole
/// command: no memory, no disk, an interruption.
LitheStatus lth_book_finish(LthBook *book, LthStudyRun *run, LitheStatus status,
                            const LitheStudyDef *def);
