/// Running studies one after the other, and what remains of them.
#include "lithe/study.h"

#include "io/file.h"
#include "io/text.h"
#include "study/study_book.h"
#include "study/study_list.h"

#include <stdio.h>
#include <string.h>

LitheStudyDef lithe_study_def_default(void) { return (LitheStudyDef){0}; }

LitheIndex lithe_study_count(void) {
  LitheIndex n = 0;
  while (lth_study_at(n)) n++;
  return n;
}

const char *lithe_study_name(LitheIndex i) {
  const LthStudy *study = lth_study_at(i);
  return study ? study->name : NULL;
}

const char *lithe_study_title(LitheIndex i) {
  const LthStudy *study = lth_study_at(i);
  return study ? study->title : NULL;
}

/// No such study: the message lists those that there are.
static LitheStatus fail_unknown(LitheCtx *ctx, const char *name) {
  char list[1500] = "";
  const LthStudy *study;
  for (LitheIndex i = 0; (study = lth_study_at(i)) != NULL; i++) {
    size_t used = strlen(list);
    snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", study->name);
  }
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "no study is called '%s'; expected one of %s, a group such as validation, all, or a "
             "scene file with --sweep",
             name, list);
}

/// Run one, with its folder empty of an earlier report.
static LitheStatus run_one(LthBook *book, const LthStudy *study, const LitheStudyDef *def) {
  LthStudyRun *run;
  LITHE_TRY(lth_book_add(book, study, study->name, &run));
  lth_study_plan_begin(&book->plan, lth_study_seconds(study->name, def->quick), lth_now());
  lth_study_plan_tell(&book->plan, book->ctx, study->name);
  run->quick = def->quick;
  run->overrides = def->overrides;
  run->n_overrides = def->n_overrides;
  LitheStatus status = study->run(run);
  return lth_book_finish(book, run, status, def);
}

static LitheStatus run_all(LthBook *book, void *self) {
  const LitheStudyDef *def = self;
  const LthStudy *study;
  for (LitheIndex i = 0; (study = lth_study_at(i)) != NULL; i++)
    if (lth_study_is_meant(study, def->name))
      lth_study_plan_add(&book->plan, lth_study_seconds(study->name, def->quick));
  if (book->plan.n == 0) return fail_unknown(book->ctx, def->name);
  for (LitheIndex i = 0; (study = lth_study_at(i)) != NULL; i++)
    if (lth_study_is_meant(study, def->name)) LITHE_TRY(run_one(book, study, def));
  return LITHE_OK;
}

LitheStatus lithe_study(LitheCtx *ctx, const LitheStudyDef *def, LitheStudyResult **result) {
  LitheStudyDef own = *def;
  char title[200], command[300];
  snprintf(title, sizeof title, "Lithe: study %s", def->name);
  snprintf(command, sizeof command, "lithe study %s%s", def->name, def->quick ? " --quick" : "");
  return lth_book_make(ctx, def->folder ? def->folder : "out/study", title, command, run_all, &own,
                       result);
}
