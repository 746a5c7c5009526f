/// result.json: the figures of a whole run.
#pragma once

#include "io/json.h"
#include "lithe/run.h"
#include "scene/measure.h"
#include "scene/output.h"

/// Seconds by phase; what the stepper itself took is in its report.
typedef struct LthTimes {
  double read, mesh, integrate, output, total;
} LthTimes;

typedef struct LthResultInput {
  const LthWorld *world;
  const LthProbes *probes;
  const LthOutput *out;
  LitheStatus status; ///< LITHE_OK, LITHE_NOT_CONVERGED or LITHE_INTERRUPTED
  LthTimes times;
  double condition; ///< NaN: not asked for
} LthResultInput;

/// Section `topology`, where something has changed (result_change.c).
void lth_result_put_changes(LthJson *json, const LthWorld *world);

/// Section `adapt`, where the scene has it.
void lth_result_put_adapt(LthJson *json, const LthWorld *world);

/// Text of the result, freed by lth_free(), and the figures that a summary shows.
LitheStatus lth_result_text(LitheCtx *ctx, const LthResultInput *input, LitheRunSummary *summary,
                            char **text);
