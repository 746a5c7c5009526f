/// All studies of one command: gathered while they run, written as one page, counted.
#include "study/study_book.h"

#include "io/file.h"
#include "io/text.h"

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

static void close_book(LthBook *book) {
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
  run->plan = book->plan.n > 0 ? &book->plan : NULL;
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

/// The page, index.md and study.json.
static LitheStatus write_book(LthBook *book, const char *title, const char *command,
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

LitheStatus lth_book_make(LitheCtx *ctx, const char *folder, const char *title, const char *command,
                          LthBookFill fill, void *self, LitheStudyResult **result) {
  LthBook book = {.ctx = ctx, .folder = folder, .start = lth_now()};
  LthTextLocale before = lth_text_locale_begin();
  LitheStatus status = lth_folder_make(ctx, folder);
  if (status == LITHE_OK) status = fill(&book, self);
  if (status == LITHE_OK) status = write_book(&book, title, command, result);
  lth_progress_head(ctx, "");
  close_book(&book);
  lth_text_locale_end(before);
  return status;
}

LitheStatus lth_book_folder(LitheCtx *ctx, const char *given, const char *scene, const char *what,
                            char **folder) {
  const char *slash = strrchr(scene, '/'), *stem = slash ? slash + 1 : scene;
  const char *dot = strrchr(stem, '.');
  char name[300];
  if (given) return lth_copy_text(ctx, given, folder);
  snprintf(name, sizeof name, "out/%.*s-%s", dot && dot > stem ? (int)(dot - stem) : 200, stem,
           what);
  return lth_copy_text(ctx, name, folder);
}
