/// What a study's report becomes on disk: tables, plots, pictures, pages.
#pragma once

#include "study/study_run.h"

#include <stdio.h>

/// A number as texts and pages show it: `digits` significant ones (a whole number has all of its own); "" for
/// NaN.
#define LTH_SHOWN_MAX 40
const char *lth_shown_number(double value, int digits, char text[LTH_SHOWN_MAX]);

/// "is 1.2e-3, at most 2e-3"; and "holds" or "DOES NOT HOLD".
const char *lth_shown_check(const LthCheck *check, char text[4 * LTH_SHOWN_MAX]);
const char *lth_shown_verdict(bool holds);

/// Verdicts of a report, and how many of them do not hold.
int lth_study_checks(const LthStudyReport *report, int *n_failed);
/// No trouble, and every verdict holds.
bool lth_study_holds(const LthStudyRun *run);

/// FOLDER/<name>.csv of every table, FOLDER/<name>.svg of every picture.
LitheStatus lth_study_write_tables(const LthStudyRun *run);
LitheStatus lth_study_write_pictures(const LthStudyRun *run);

/// FOLDER/<name>.gp of every plot, and gnuplot called to make FOLDER/<name>.svg of it. Where gnuplot is not there a
/// warning names the package, and the report goes on without drawings.
LitheStatus lth_study_draw_plots(LthStudyRun *run);

/// FOLDER/report.txt, and its text into *text (freed by lth_free()).
LitheStatus lth_study_write_text(const LthStudyRun *run, char **text);

/// What stands at the head of pages: how the runs were called and when.
typedef struct LthPageHead {
  const char *title, *command;
  double seconds;
} LthPageHead;

/// One self-contained page index.html of all runs, with every plot and picture inside; and index.md with links to
/// the files beside it.
LitheStatus lth_study_write_page(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                 const LthStudyRun *runs);
LitheStatus lth_study_write_markdown(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                     const LthStudyRun *runs);

/// study.json: every study with its verdicts. *json is freed by lth_free().
LitheStatus lth_study_write_json(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                 const LthStudyRun *runs, char **json);
