/// What a body in the mixed form keeps: pressures where nu = 0.5, and its solver.
#pragma once

#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_priv.h"

struct LthMixedState {
  double *pressure; ///< in the internal force [Pa]; NULL: nu is below 0.5 everywhere    (n_slots)
  double *latest;   ///< as solved last: in force from the next linearisation on         (n_slots)
  double *trace;    ///< tr e at the last one                                            (n_slots)
  bool is_solved;   ///< solves of the mixed form move them
};

/// tr e of a live cell at positions x.
double lth_mixed_trace(const LthStaggered *s, LitheCount slot, const double *x);
