/// All observers of a run together.
#pragma once

#include "scene/observe.h"
#include "scene/schedule.h"

#define LTH_CHECKPOINT_NAME "checkpoint" ///< file in the folder of a run

typedef struct LthOutput {
  LthHistory *history;
  LthProbes *probes;
  LitheIndex n_bodies;
  LthFields **fields;         ///< (n_bodies)
  LthSurfaceOutput **surface; ///< (n_bodies)
  LitheIndex n_frames;
  double seconds; ///< spent here
} LthOutput;

/// Make the folder, remove the result.json (and the checkpoint) of an earlier run, open all files; `resumes`:
/// those of an interrupted run, which lth_output_archive() then leads on from where they were.
/// Close with lth_output_close(), after a failure too.
LitheStatus lth_output_open(LitheCtx *ctx, const char *folder, const LthWorld *world,
                            const LthSchedule *schedule, bool resumes, LthOutput *out);

/// How far all files are. Reading cuts them there.
void lth_output_archive(LthOutput *out, LthArchive *archive);

/// Bodies have other elements than before.
LitheStatus lth_output_renew(LitheCtx *ctx, LthOutput *out, const LthWorld *world);

/// Write the present state.
LitheStatus lth_output_frame(LitheCtx *ctx, LthOutput *out, const LthWorld *world);

/// The first failure to close is returned; everything is closed.
LitheStatus lth_output_close(LitheCtx *ctx, LthOutput *out);
