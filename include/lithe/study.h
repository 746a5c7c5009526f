/// Studies: figures and tables of papers and the validation book, computed anew; and sweeps of a scene's values.
#pragma once

#include "lithe/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The studies that this build has, in the order in which they run.
LITHE_API LitheIndex lithe_study_count(void);
/// "dolny/table5.2", and what it is in a few words. NULL where `i` is out of range.
LITHE_API const char *lithe_study_name(LitheIndex i);
LITHE_API const char *lithe_study_title(LitheIndex i);

/// What to study. Start from lithe_study_def_default() and set `name`. Nothing is kept.
typedef struct LitheStudyDef {
  const char *name;             ///< a study, a group ("dolny") or "all"; of a sweep the scene file
  const char *folder;           ///< where everything is written; NULL: out/study, out/<scene>-sweep
  bool quick;                   ///< coarser and shorter: the same questions in under a minute
  const char *const *overrides; ///< put into every scene that is run            (n_overrides)
  int n_overrides;
  const char *const *sweeps; ///< of a sweep: "bodies.0.method.cells=8,16,32"       (n_sweeps)
  int n_sweeps;
  void (*tell)(void *user,
               const char *text); ///< gets the report of each part when it is done; may be NULL
  void *tell_user;
} LitheStudyDef;

LITHE_API LitheStudyDef lithe_study_def_default(void);

/// What came out in short; study.json and the page index.html in the folder have it all.
typedef struct LitheStudySummary {
  LitheIndex studies, failed; ///< that ran; of which some verdict does not hold or that stopped
  LitheIndex checks, failed_checks;
  double seconds;
} LitheStudySummary;

typedef struct LitheStudyResult LitheStudyResult;

/// Run studies, one after the other, and write tables (.csv), plots (.svg with the script behind them), the scenes
/// with their results, study.json and one page index.html. Free `*result` with lithe_study_result_destroy(), after a
/// failure too.
/// @return LITHE_OK. LITHE_FAILED: everything is written, some verdict does not hold or a study could not run.
/// LITHE_BAD_INPUT: no such study; the message lists them. LITHE_NO_SPACE, LITHE_NO_MEMORY, LITHE_INTERRUPTED.
LITHE_API LitheStatus lithe_study(LitheCtx *ctx, const LitheStudyDef *def,
                                  LitheStudyResult **result);

/// Run a scene with every combination of values and make tables of the main numbers, with observed orders and
/// Richardson's extrapolation along the values that refine. Otherwise as lithe_study().
/// @return LITHE_BAD_INPUT: a sweep is not PATH=VALUE,VALUE,..., or one of the scenes is bad.
/// LITHE_FAILED: a run did not converge.
LITHE_API LitheStatus lithe_sweep(LitheCtx *ctx, const LitheStudyDef *def,
                                  LitheStudyResult **result);

/// Borrowed until the result is destroyed; "" where there is none.
LITHE_API const char *lithe_study_result_folder(const LitheStudyResult *result);
LITHE_API const char *lithe_study_result_json(const LitheStudyResult *result);
LITHE_API LitheStudySummary lithe_study_result_summary(const LitheStudyResult *result);
LITHE_API void lithe_study_result_destroy(LitheCtx *ctx, LitheStudyResult **result);

#ifdef __cplusplus
}
#endif
