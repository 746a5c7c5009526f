/// Checkpoints of a run: its state before a step, from which another process goes on with the same bits.
#pragma once

#include "base/archive.h"
#include "scene/output.h"

/// Where a run stands: steps done on the way to an output time.
typedef struct LthPlace {
  LitheIndex output;
  LitheCount step;
} LthPlace;

/// Of a run that writes checkpoints. Zero-initialise.
typedef struct LthCheckpoint {
  const LthScene *scene; ///< NULL: the run writes none
  char *path, *scene_path;
  uint64_t digest;
  double written;   ///< when the last one was [s]; 0: never
  LthArchive state; ///< before the step that comes
} LthCheckpoint;

/// Get ready to write `folder`/checkpoint where the scene asks for it. `digest`: of all that went into the run.
LitheStatus lth_checkpoint_open(LitheCtx *ctx, const LthScene *scene, const char *folder,
                                uint64_t digest, LthCheckpoint *checkpoint);
void lth_checkpoint_close(LitheCtx *ctx, LthCheckpoint *checkpoint);

/// Before a step: keep the state in memory, and write it where the last file is as old as the scene says.
LitheStatus lth_checkpoint_take(LitheCtx *ctx, LthCheckpoint *checkpoint, LthPlace place,
                                LthWorld *world, LthOutput *out);

/// Write the state kept last, if there is one: a run that is interrupted within a step.
LitheStatus lth_checkpoint_write_last(LitheCtx *ctx, LthCheckpoint *checkpoint);

/// A checkpoint read back.
typedef struct LthResume {
  char *path, *data;
  LthArchive state;
  char *version, *scene_file, *scene_path;
  char **overrides; ///< (n_overrides)
  LitheCount n_overrides;
  uint64_t digest;
  LthPlace place;
} LthResume;

/// Read `folder`/checkpoint and its head: whose it is.
LitheStatus lth_resume_open(LitheCtx *ctx, const char *folder, LthResume *resume);
void lth_resume_close(LitheCtx *ctx, LthResume *resume);

/// LITHE_BAD_INPUT where what went into the run is not what the checkpoint was written for.
LitheStatus lth_resume_check(LitheCtx *ctx, const LthResume *resume, uint64_t digest);

/// Put the state into what was built from the scene, first the bodies, then the outputs, reopened.
LitheStatus lth_resume_world(LitheCtx *ctx, LthResume *resume, LthWorld *world);
LitheStatus lth_resume_output(LitheCtx *ctx, LthResume *resume, LthOutput *out);
