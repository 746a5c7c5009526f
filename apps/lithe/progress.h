/// One line on the terminal that says how far a run is and how long it will take.
#pragma once

#include <stdbool.h>

typedef struct Progress {
  bool is_shown; ///< standard error is a terminal and --quiet was not given
  bool has_line;
  double start, last; ///< of the phase, and of the last line [s]
  char phase[160];
} Progress;

void progress_start(Progress *progress, bool quiet);

/// Fits LitheProgressFn; `user` is the Progress.
void progress_tell(void *user, const char *phase, double fraction);

/// Wipe the line.
void progress_end(Progress *progress);
