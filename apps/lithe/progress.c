/// One line on the terminal that says how far a run is and how long it will take.
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define PATIENCE 1.0 // seconds before the first line appears
#define PERIOD 0.1   // seconds between two lines

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void progress_start(Progress *progress, bool quiet) {
  *progress = (Progress){.is_shown = !quiet && isatty(STDERR_FILENO)};
  progress->last = now() + PATIENCE - PERIOD;
}

void progress_tell(void *user, const char *phase, double fraction) {
  Progress *p = user;
  if (!p->is_shown) return;
  double t = now();
  if (strncmp(phase, p->phase, sizeof p->phase - 1) != 0) {
    snprintf(p->phase, sizeof p->phase, "%s", phase);
    p->start = t;
  }
  if (t < p->last + PERIOD) return;
  p->last = t;
  p->has_line = true;

  // the time left is known once a little of the phase is done
  double spent = t - p->start;
  fprintf(stderr, "\r\033[K%s", p->phase);
  if (fraction >= 0) fprintf(stderr, " %3.0f %%", 100 * fraction);
  if (fraction > 0.01 && spent > 0.5)
    fprintf(stderr, ", %.0f s left", spent * (1 - fraction) / fraction);
  fflush(stderr);
}

void progress_end(Progress *progress) {
  if (progress->has_line) fprintf(stderr, "\r\033[K");
  progress->has_line = false;
}
