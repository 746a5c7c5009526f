/// BLAS and LAPACK on one thread: several do not promise the same bits, and wait for each other on a busy machine.
#pragma once

#include <omp.h>

/// Returns what lth_blas_threads() takes afterwards.
static inline int lth_blas_one_thread(void) {
  int before = omp_get_max_threads();
  omp_set_num_threads(1);
  return before;
}

static inline void lth_blas_threads(int before) { omp_set_num_threads(before); }
