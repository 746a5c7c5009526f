/// Bodies in space as they are in the end: faces of elements, grids of places or embedded surfaces, with hidden sides hidden.
#pragma once

#include "study/study_run.h"

/// What is seen of a body. Zero-initialise, set run and what is wanted. Everything is in the run's arena.
typedef struct LthView {
  LthStudyRun *run;
  const char *label; ///< words above it
  bool of_surface;   ///< the embedded surface instead of the elements' faces
  double times;      ///< displacements are drawn so many times as large; 0: as they are
  int n, cap;
  double *corner; ///< of triangles, where they are now [m]                    (n x 9)
  uint8_t *edges; ///< 1, 2, 4: the side behind corner 0, 1, 2 is a side of a face (n)
} LthView;

/// An LthRunLook: `user` is an LthView. Keeps the body as it is at the last output.
LitheStatus lth_view_look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame);

/// Add the quadrilaterals between a grid of m x n places, as they are now (m x n x 3), every `step`-th line drawn.
LitheStatus lth_view_add_grid(LthView *view, int m, int n, const double *places, int step);

/// All views side by side to one scale as a picture of the report, seen from `eye` with `up` upwards.
LitheStatus lth_views_draw(LthStudyRun *run, int n, const LthView *views, const double eye[3],
                           const double up[3], const char *name, const char *caption);
