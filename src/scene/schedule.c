/// When a run solves and when it writes: output times are hit exactly.
#include "scene/schedule.h"

#include <math.h>

#define ROUNDING 1e-9 // of an interval: times that differ by less are the same

/// Whole intervals of `part` in `whole`, the last one perhaps shorter; at least one.
static LitheCount count_parts(double whole, double part) {
  double n = ceil(whole / part - ROUNDING);
  return n > 1 ? (LitheCount)n : 1;
}

static LthSchedule dynamic_schedule(const LthScene *scene) {
  LthSchedule s = {.kind = LTH_TIME_DYNAMIC,
                   .writes_start = true,
                   .duration = scene->duration,
                   .step = scene->step};
  if (scene->output_every < 0)
    s.period = s.duration;
  else
    s.period = scene->output_every > s.step ? scene->output_every : s.step;
  s.n_outputs = (LitheIndex)count_parts(s.duration, s.period);
  return s;
}

static LthSchedule quasistatic_schedule(const LthScene *scene) {
  LitheIndex n = scene->steps > 0 ? scene->steps : 1;
  LthSchedule s = {.kind = LTH_TIME_QUASISTATIC,
                   .writes_start = true,
                   .duration = scene->duration,
                   .step = scene->duration / n};
  double stride = scene->output_every > 0 ? floor(scene->output_every / s.step + 0.5) : 1;
  if (scene->output_every < 0) stride = n;
  s.period = s.step * fmin(fmax(stride, 1), n);
  s.n_outputs = (LitheIndex)count_parts(s.duration, s.period);
  return s;
}

LthSchedule lth_schedule_make(const LthScene *scene) {
  if (scene->time_kind == LTH_TIME_DYNAMIC) return dynamic_schedule(scene);
  if (scene->time_kind == LTH_TIME_QUASISTATIC && scene->duration > 0)
    return quasistatic_schedule(scene);
  return (LthSchedule){.kind = scene->time_kind, .n_outputs = 1, .duration = scene->duration};
}

double lth_schedule_time(const LthSchedule *s, LitheIndex k) {
  if (k >= s->n_outputs) return s->duration;
  return k * s->period;
}

LitheCount lth_schedule_steps(const LthSchedule *s, LitheIndex k) {
  if (!(s->step > 0)) return 1;
  return count_parts(lth_schedule_time(s, k) - lth_schedule_time(s, k - 1), s->step);
}

LitheCount lth_schedule_total(const LthSchedule *s) {
  // all intervals but the last are alike
  return (s->n_outputs - 1) * lth_schedule_steps(s, 1) + lth_schedule_steps(s, s->n_outputs);
}
