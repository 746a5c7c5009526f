/// What a body in the mixed form keeps: pressures where nu = 0.5, and its solver.
#pragma once

#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_priv.h"

struct LthMixedState {
  double *pressure;  ///< in the internal force [Pa]; NULL: nu is below 0.5 everywhere    (n_slots)
  double *latest;    ///< as solved last: in force from the next linearisation on         (n_slots)
  LitheIndex *stiff; ///< slots of cells with nu = 0.5                                   (n_stiff)
  LitheIndex n_stiff;
  LitheIndex n_closed; ///< parts that are held on all sides: their mean pressure is zero
  LitheIndex *closed;  ///< part of a cell of these, or -1; NULL where n_closed is 0       (n_stiff)

  LthMixed *system;       ///< its multigrid is the body's
  LthMixedKrylov *krylov; ///< once prepared
  double *target;         ///< tr e where w = 0; NULL where nu is below 0.5    (n_slots)
  double *strain;         ///< the same of `stiff`                             (n_stiff)
  double *scratch;        ///< (n_dofs)
};

/// Which parts are held on all sides, once `stiff` is there (staggered_mixed_closed.c).
LitheStatus lth_mixed_closed_create(LitheCtx *ctx, const LthStaggered *s);
void lth_mixed_closed_free(LitheCtx *ctx, LthMixedState *m);
/// LthDiscVolume.admit.
LitheStatus lth_mixed_admit(LitheCtx *ctx, const LthDisc *disc, const double *u, double *c);
/// Pressures (n_slots) of such parts less their mean.
void lth_mixed_center(const LthStaggered *s, double *pressure);

/// Slots of the high faces of a cell.
void lth_mixed_high_faces(const LthStaggered *s, LitheCount slot, LitheCount high[3]);
/// tr e of a live cell from displacements u.
double lth_mixed_trace(const LthStaggered *s, LitheCount slot, const double *u);
