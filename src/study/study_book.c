/// All studies of one command: gathered while they run, written as one page, counted.
#include "study/study_book.h"

#include "io/file.h"

#include <string.h>

struct LitheStudyResult {
  char *folder, *json;
  LitheStudySummary summary;
};

const char *lithe_study_result_folder(const LitheStudyResult *result) {
  return result->folder ? result->folder : "";
}
const char *lithe_study_result_json(const LitheStudyResult *result) {
  return result->json ? result->json : "";
}
LitheStudySummary lithe_study_result_summary(const LitheStudyResult *result) {
  return result->summary;
}

void lithe_study_result_destroy(LitheCtx *ctx, LitheStudyResult **result) {
  if (!*result) return;
  lth_free(ctx, (*result)->folder);
  lth_free(ctx, (*result)->json);
  lth_free(ctx, *result);
  *result = NULL;
}

LitheStatus lth_book_open(LitheCtx *ctx, const char *folder, LthBook *book) {
  *book = (LthBook){.ctx = ctx, .folder = folder, .start = lth_now()};
  return lth_folder_make(ctx, folder);
}

void lth_book_close(LthBook *book) {
  while (book->first) {
    LthStudyRun *run = book->first;
    book->first = run->next;
    lth_arena_free(&run->arena);
    lth_free(book->ctx, run);
  }
}

LitheStatus lth_book_add(LthBook *book, const LthStudy *study, const char *name,
                         LthStudyRun **out) {
  LthStudyRun *run;
  LTH_NEW(book->ctx, run, 1);
  if (book->last)
    book->last->next = run;
  else
    book->first = run;
  book->last = run;
  run->ctx = run->arena.ctx = book->ctx;
  run->report.arena = &run->arena;
  run->study = study;
  run->folder = *name ? lth_study_print(run, "%s/%s", book->folder, name)
                      : lth_study_print(run, "%s", book->folder);
  if (run->arena.failed) LITHE_FAIL(book->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  book->began = lth_now();
  *out = run;
  return lth_folder_make(book->ctx, run->folder);
}

static bool ends_all(LitheStatus status) {
  return status == LITHE_NO_MEMORY || status == LITHE_NO_SPACE || status == LITHE_INTERRUPTED;
}

LitheStatus lth_book_finish(LthBook *book, LthStudyRun *run, LitheStatus status,
                            const LitheStudyDef *def) {
  char *text = NULL;
  if (ends_all(status)) return status;
  if (status != LITHE_OK) run->trouble = lth_study_print(run, "%s", lithe_ctx_message(run->ctx));
  LITHE_TRY(lth_study_write_tables(run));
  LITHE_TRY(lth_study_write_pictures(run));
  LITHE_TRY(lth_study_draw_plots(run));
  run->seconds = lth_now() - book->began;
  LITHE_TRY(lth_study_write_text(run, &text));
  if (def->tell) def->tell(def->tell_user, text);
  lth_free(run->ctx, text);
  if (run->arena.failed) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  return LITHE_OK;
}

static void count(const LthBook *book, LitheStudySummary *summary) {
  for (const LthStudyRun *run = book->first; run; run = run->next) {
    int n_failed;
    summary->checks += lth_study_checks(&run->report, &n_failed);
    summary->failed_checks += n_failed;
    summary->studies++;
    if (!lth_study_holds(run)) summary->failed++;
  }
}

LitheStatus lth_book_write(LthBook *book, const char *title, const char *command,
                           LitheStudyResult **result) {
  LitheCtx *ctx = book->ctx;
  LthPageHead head = {title, command, lth_now() - book->start};
  LTH_NEW(ctx, *result, 1);
  LITHE_TRY(lth_copy_text(ctx, book->folder, &(*result)->folder));
  LITHE_TRY(lth_study_write_page(ctx, book->folder, &head, book->first));
  LITHE_TRY(lth_study_write_markdown(ctx, book->folder, &head, book->first));
  LITHE_TRY(lth_study_write_json(ctx, book->folder, &head, book->first, &(*result)->json));
  LitheStudySummary *summary = &(*result)->summary;
  count(book, summary);
  summary->seconds = head.seconds;
  if (summary->failed == 0) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_FAILED, "%d of %d studies do not hold: see %s/index.html", summary->failed,
             summary->studies, book->folder);
}
