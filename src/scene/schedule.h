/// When a run solves and when it writes: output times are hit exactly.
#pragma once

#include "scene/scene.h"

/// Output time k = 1 ... n_outputs ends an interval of equal steps that are never longer than asked for;
/// so that output times fall on steps, a step may come out shorter. With `every` at or below the step
/// every step is an output time. A static run has one output time and one solve; a quasistatic one
/// solves `steps` times and writes at the solves nearest to multiples of `every`.
typedef struct LthSchedule {
  LthTimeKind kind;
  LitheIndex n_outputs; ///< without the state at the start
  bool writes_start;    ///< the state at the start is output time 0
  double duration;      ///< [s]
  double period;        ///< between output times; the last interval may be shorter [s]
  double step;          ///< longest step asked for; quasistatic: the load step [s]
} LthSchedule;

LthSchedule lth_schedule_make(const LthScene *scene);

/// Time of output k.
double lth_schedule_time(const LthSchedule *schedule, LitheIndex k);

/// Steps between outputs k - 1 and k.
LitheCount lth_schedule_steps(const LthSchedule *schedule, LitheIndex k);

/// Steps of the whole run.
LitheCount lth_schedule_total(const LthSchedule *schedule);
