/// A staggered 2D body at several times: outlines of its cells where they are then, drawn side by side.
#pragma once

#include "study/study_run.h"

#define LTH_FRAMES_MAX 8

/// The body at one time. Everything in the run's arena.
typedef struct LthFrame {
  double time;   ///< [s]
  int n, cap;    ///< cells
  int *corners;  ///< of each cell's polygon (n)
  double *place; ///< their places now (n x 2 LTH_FRAME_CORNERS)
  double *value; ///< von Mises stress at the cell's centre [Pa] (n)
  double area;   ///< of all polygons now [m^2]
  int n_held, cap_held;
  double *held; ///< places of held unknowns on the boundary (n_held x 2)
} LthFrame;

#define LTH_FRAME_CORNERS 8

typedef struct LthFrames {
  LthStudyRun *run;
  int n;
  LthFrame frame[LTH_FRAMES_MAX];
} LthFrames;

/// An LthRunLook: `user` is an LthFrames with its run. Keeps the state of every output time.
LitheStatus lth_frames_look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame);

/// All frames side by side as a picture of the report, (a), (b), ...: colour is von Mises stress, dots are held.
LitheStatus lth_frames_draw(const LthFrames *frames, const char *name, const char *caption);
