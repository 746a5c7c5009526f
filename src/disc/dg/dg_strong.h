/// Strong constraints: components of whole elements that move as prescribed.
#pragma once

#include "base/value.h"
#include "disc/dg/dg_space.h"

/// How components of an element move.
typedef struct LthStrongMotion {
  bool is_position;      ///< value is the deformed place, not the displacement
  LthValue value[3];     ///< [m]
  double factor;         ///< on the value: -1 for rollers whose normal points against its axis
  LitheIndex constraint; ///< row of `reaction` that its force is added to
} LthStrongMotion;

typedef struct LthDgStrong LthDgStrong;

/// Component a of element c moves as motions[motion_of[3 c + a]], or is free where that is -1. All is copied but
/// for what the values themselves borrow; the space is borrowed for life.   motion_of (3 n_cells)
LitheStatus lth_dg_strong_create(LitheCtx *ctx, const LthDgSpace *space,
                                 const LitheIndex *motion_of, LitheIndex n_motions,
                                 const LthStrongMotion *motions, LthDgStrong **strong);
void lth_dg_strong_destroy(LitheCtx *ctx, LthDgStrong **strong);

/// 1 for every unknown that moves as prescribed, lent (n_dofs).
const uint8_t *lth_dg_strong_held(const LthDgStrong *strong);

/// Set these unknowns of x (n_dofs) to the L2 projection of their places at time t; others are left as
/// they are. `strong` is an LthDgStrong: fits LthSystemBody.prescribe. Always LITHE_OK.
LitheStatus lth_dg_strong_prescribe(const void *strong, double t, double *x);

/// Forces that constraints put on the unknowns they hold, from the imbalance (n_dofs) [N] without them, inertia
/// included: added to `reaction` by constraint.
void lth_dg_strong_add_reactions(const LthDgStrong *strong, const double *imbalance,
                                 double *reaction);
