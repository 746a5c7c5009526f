/// How far a command of many studies is, and how long the rest will take.
#include "study/study_plan.h"

#include <stdio.h>
#include <string.h>

#define SHORT_STUDY 1.0 // seconds of one that is not listed
#define TRUST 5.0 // estimated seconds after which what was measured weighs as much as the estimate

/// Rounded up from runs on two cores; studies of less than some seconds are left out.
static const struct {
  const char *name;
  double full, quick;
} listed[] = {
    {"kaufmann/fig7-ears", 13, 3},
    {"kaufmann/table1", 7, 1},
    {"kaufmann/fig8", 25, 4},
    {"kaufmann/fig9", 16, 3},
    {"kaufmann/fig7-slices", 4, 2},
    {"kaufmann/fig10-carve", 55, 1},
    {"adapt/corner", 40, 3},
    {"dolny/table5.1", 35, 1},
    {"dolny/table5.2", 80, 1},
    {"dolny/fig5.1", 2, 1},
    {"dolny/free", 15, 2},
    {"dolny/fig5.4", 11, 1},
    {"validation/cantilever", 10, 1},
    {"validation/cook", 6, 1},
    {"validation/cylinder", 25, 4},
    {"validation/sphere", 35, 7},
    {"validation/kirsch", 85, 15},
    {"validation/le1", 9, 2},
    {"validation/le10", 15, 2},
    {"validation/hertz", 110, 10},
    {"validation/bar", 20, 9},
};

double lth_study_seconds(const char *name, bool quick) {
  for (size_t i = 0; i < sizeof listed / sizeof listed[0]; i++)
    if (strcmp(name, listed[i].name) == 0) return quick ? listed[i].quick : listed[i].full;
  return SHORT_STUDY;
}

void lth_study_plan_add(LthStudyPlan *plan, double seconds) {
  plan->n++;
  plan->all += seconds;
}

void lth_study_plan_begin(LthStudyPlan *plan, double seconds, double now) {
  if (plan->n_begun++ == 0) plan->start = now;
  plan->before += plan->current;
  plan->current = seconds;
  plan->began = now;
}

double lth_study_plan_left(const LthStudyPlan *plan, double now) {
  double slower = (plan->began - plan->start + TRUST) / (plan->before + TRUST);
  double rest = slower * (plan->all - plan->before - plan->current);
  double current = slower * plan->current - (now - plan->began);
  return (rest > 0 ? rest : 0) + (current > 0 ? current : 0);
}

void lth_study_plan_tell(const LthStudyPlan *plan, LitheCtx *ctx, const char *name) {
  char text[LTH_PROGRESS_HEAD_MAX], left[40];
  double seconds = lth_study_plan_left(plan, lth_now());
  if (seconds >= 90)
    snprintf(left, sizeof left, "%.0f min", seconds / 60);
  else
    snprintf(left, sizeof left, "%.0f s", seconds);
  snprintf(text, sizeof text, "study %d of %d, about %s left, %s: ", plan->n_begun, plan->n, left,
           name);
  lth_progress_head(ctx, text);
}
