/// One scene by several methods at refining resolutions: what `lithe verify` runs and compares.
#pragma once

#include "lithe/study.h"
#include "scene/scene.h"
#include "study/study_run.h"

#define LTH_VERIFY_LEVELS_MAX 8

/// A method and the resolutions that it is run at.
typedef struct LthVerifyMethod {
  LthMethodKind kind;
  const char *name;                    ///< "dg", "staggered", "cg"; in 2D the kinds of fractions
  const char *settings;                ///< of `method` but its resolution; NULL: what suits a body
  double cells[LTH_VERIFY_LEVELS_MAX]; ///< along the longest side of the first body
  const char *file[LTH_VERIFY_LEVELS_MAX]; ///< meshes of the first body instead, or NULL
  const LthStudyResult *result;            ///< (n_levels)
  int n_levels;
} LthVerifyMethod;

/// Whether a body can be computed by a kind of method at all; if not *why says what is missing.
bool lth_verify_allows(const LthScene *scene, LthMethodKind kind, const char **why);

/// "bodies.1.method={kind: dg, cells: 12, degree: 2}": body b by a method at one of its levels.
const char *lth_verify_override(LthStudyRun *run, const LthScene *scene, LitheIndex b,
                                const LthVerifyMethod *method, int level);

/// Cells along the longest side of a body as the scene has it.
double lth_verify_cells(const LthSceneBody *body);

/// Tables of every method, the comparison, and its verdicts.
void lth_verify_report(LthStudyRun *run, int n_methods, LthVerifyMethod *methods, double tolerance);
