/// All observers of a run together.
#pragma once

#include "scene/observe.h"
#include "scene/schedule.h"

typedef struct LthOutput {
  LthHistory *history;
  LthProbes *probes;
  LitheIndex n_bodies;
  LthFields **fields;         ///< (n_bodies)
  LthSurfaceOutput **surface; ///< (n_bodies)
  LitheIndex n_frames;
  double seconds; ///< spent here
} LthOutput;

/// Make the folder, remove the result.json of an earlier run, open all files.
/// Close with lth_output_close(), after a failure too.
LitheStatus lth_output_open(LitheCtx *ctx, const char *folder, const LthWorld *world,
                            const LthSchedule *schedule, LthOutput *out);

/// Write the present state.
LitheStatus lth_output_frame(LitheCtx *ctx, LthOutput *out, const LthWorld *world);

/// The first failure to close is returned; everything is closed.
LitheStatus lth_output_close(LitheCtx *ctx, LthOutput *out);
