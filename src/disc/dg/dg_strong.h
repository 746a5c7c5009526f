/// Strong constraints: whole elements that move as prescribed.
#pragma once

#include "base/value.h"
#include "disc/dg/dg_space.h"

/// How an element moves.
typedef struct LthStrongMotion {
  bool is_position;  ///< value is the deformed place, not the displacement
  LthValue value[3]; ///< [m]
} LthStrongMotion;

typedef struct LthDgStrong LthDgStrong;

/// Element c moves as motions[motion_of[c]], or is free where that is -1. All is copied but for what the
/// values themselves borrow; the space is borrowed for life.                 motion_of (n_cells)
LitheStatus lth_dg_strong_create(LitheCtx *ctx, const LthDgSpace *space,
                                 const LitheIndex *motion_of, LitheIndex n_motions,
                                 const LthStrongMotion *motions, LthDgStrong **strong);
void lth_dg_strong_destroy(LitheCtx *ctx, LthDgStrong **strong);

/// 1 for every unknown that moves as prescribed, lent (n_dofs).
const uint8_t *lth_dg_strong_held(const LthDgStrong *strong);

/// Set x (n_dofs) in these elements to the L2 projection of their places at time t; others are left as
/// they are. `strong` is an LthDgStrong: fits LthSystemBody.prescribe. Always LITHE_OK.
LitheStatus lth_dg_strong_prescribe(const void *strong, double t, double *x);

/// Forces that constraints put on their elements at rest or in even motion, from the imbalance (n_dofs) [N]
/// without them: added to `reaction` by motion (n_motions x 3).
void lth_dg_strong_add_reactions(const LthDgStrong *strong, const double *imbalance,
                                 double *reaction);
