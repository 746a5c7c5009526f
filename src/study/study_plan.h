/// How far a command of many studies is, and how long the rest will take.
#pragma once

#include "base/ctx.h"

/// Seconds that a study takes on two quiet cores, about: only their ratios matter. A study that is not in the list of
/// study_plan.c counts like a short one.
double lth_study_seconds(const char *name, bool quick);

/// Zero-initialise, add every study that is meant, then tell the beginning of each.
typedef struct LthStudyPlan {
  int n, n_begun;
  double all;             ///< estimated seconds of all
  double before, current; ///< of those that are done, of the one that runs
  double start, began;    ///< lth_now() when all of it and the one that runs began
} LthStudyPlan;

void lth_study_plan_add(LthStudyPlan *plan, double seconds);
void lth_study_plan_begin(LthStudyPlan *plan, double seconds, double now);

/// Seconds left: the estimate of what is not done, times how much slower than estimated the rest was.
double lth_study_plan_left(const LthStudyPlan *plan, double now);

/// Put "study 3 of 12, 4 min left, NAME: " before what the context tells of its progress.
void lth_study_plan_tell(const LthStudyPlan *plan, LitheCtx *ctx, const char *name);
