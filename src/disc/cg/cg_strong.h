/// Strong constraints of conforming bodies: unknowns of nodes that move as prescribed.
#pragma once

#include "disc/cg/cg_disc.h"

/// How a node's components move.
typedef struct LthCgMotion {
  LitheIndex constraint; ///< that its forces count for
  bool is_position;      ///< value is the deformed place, not the displacement
  LthValue value[3];     ///< [m]
  double factor[3];      ///< on values that are displacements: a roller's outward direction; else 1
} LthCgMotion;

typedef struct LthCgStrong LthCgStrong;

/// Unknown i moves as motions[motion_of[i]], or is free where that is -1. All is copied but for what the
/// values themselves borrow; the discretisation is borrowed for life.       motion_of (n_dofs)
LitheStatus lth_cg_strong_create(LitheCtx *ctx, const LthDisc *disc, const LitheIndex *motion_of,
                                 LitheIndex n_motions, const LthCgMotion *motions,
                                 LthCgStrong **strong);
void lth_cg_strong_destroy(LitheCtx *ctx, LthCgStrong **strong);

/// 1 for every unknown that moves as prescribed, lent (n_dofs).
const uint8_t *lth_cg_strong_held(const LthCgStrong *strong);

/// Set the held unknowns of x (n_dofs) to their places at time t. `strong` is an LthCgStrong: fits
/// LthSystemBody.prescribe. Always LITHE_OK.
LitheStatus lth_cg_strong_prescribe(const void *strong, double t, double *x);

/// Forces of constraints on the held unknowns, from the imbalance (n_dofs) [N] without them: added to
/// `reaction` by constraint (x 3).
void lth_cg_strong_add_reactions(const LthCgStrong *strong, const double *imbalance,
                                 double *reaction);
