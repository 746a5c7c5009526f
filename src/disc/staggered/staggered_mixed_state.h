/// What a body in the mixed form keeps: pressures where nu = 0.5, and its solver.
#pragma once

#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_priv.h"

struct LthMixedState {
  double *pressure;  ///< in the internal force [Pa]; NULL: nu is below 0.5 everywhere    (n_slots)
  double *latest;    ///< as solved last: in force from the next linearisation on         (n_slots)
  LitheIndex *stiff; ///< slots of cells with nu = 0.5                                   (n_stiff)
  LitheIndex n_stiff;

  const LthDiscSolver *base; ///< of the displacement form: products with K
  LthMixedGrid *grid;        ///< once prepared, for M inertia + K
  double inertia, ck;        ///< cm / ck [1/s^2]; ck of the solve at hand
  LthMixedKrylov *krylov;
  double *target;    ///< tr e where w = 0; NULL where nu is below 0.5    (n_slots)
  double *from, *to; ///< scratch                                         (n_dofs)
};

/// tr e of a live cell from displacements u.
double lth_mixed_trace(const LthStaggered *s, LitheCount slot, const double *u);
