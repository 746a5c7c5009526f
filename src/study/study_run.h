/// A study that runs: its folder, its report, and scenes run through the same door as a user's.
#pragma once

#include "scene/node.h"
#include "scene/run_look.h"
#include "study/study_report.h"

typedef struct LthStudy LthStudy;

/// One study while it runs. Everything it makes lives in the arena.
typedef struct LthStudyRun {
  LitheCtx *ctx;
  const LthStudy *study;
  LthArena arena;
  LthStudyReport report;
  const char *folder; ///< of this study's files
  bool quick;
  const char *const *overrides; ///< put into every scene (n_overrides)
  int n_overrides;
  const char *trouble; ///< why it stopped before its end, or NULL
  double seconds;
  const struct LthStudyPlan *plan; ///< of the command, or NULL
  struct LthStudyRun *next;
} LthStudyRun;

/// A figure or table: reports what it finds. A failure stops it alone, but for memory, disk and interruption.
struct LthStudy {
  const char *name;     ///< "group/name"
  const char *title;    ///< a few words
  const char *question; ///< what it answers
  LitheStatus (*run)(LthStudyRun *run);
};

/// All studies of a group, ended by one without a name. Groups are listed in study_list.c.
extern const LthStudy lth_studies_validation[];
extern const LthStudy lth_studies_dolny[];
extern const LthStudy lth_studies_kaufmann[];
extern const LthStudy lth_studies_adapt[];

/// The figures of a run: result.json, parsed. Lives in the study's arena.
typedef struct LthStudyResult {
  const LthNode *json;
  LitheStatus status; ///< LITHE_OK or LITHE_NOT_CONVERGED
} LthStudyResult;

/// Run a scene given as text: it is written to FOLDER/<name>.yaml and its result to FOLDER/<name>/, so that anyone can
/// run it alone. `look` may be NULL. A run that does not converge is told by result->status.
LitheStatus lth_study_run_text(LthStudyRun *run, const char *name, const char *text,
                               const LthRunLook *look, LthStudyResult *result);

/// The same with the run's own overrides and `n` more, such as "bodies.0.method.cells=8".
LitheStatus lth_study_run_with(LthStudyRun *run, const char *name, const char *text, int n,
                               const char *const *more, const LthRunLook *look,
                               LthStudyResult *result);

/// A number of the result by its path, "error.l1", "probes.tip.displacement.2"; NaN where there is none.
double lth_study_number(const LthStudyResult *result, const char *path);

/// The node behind a path or NULL. Keys that contain dots are found too.
const LthNode *lth_study_node(const LthNode *node, const char *path);

/// Take result.json apart.
LitheStatus lth_study_parse(LthStudyRun *run, const char *json, const LthNode **node);

/// printf into the study's arena; "" where memory is out.
const char *lth_study_print(LthStudyRun *run, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
