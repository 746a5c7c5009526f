/// Which rigid motions nothing holds: what a static run without enough constraints is told.
#pragma once

#include "disc/dg/dg_operator.h"

#define LTH_FREE_MOTION_TEXT 512

typedef struct LthFreeMotions {
  LitheIndex n_components; ///< connected parts of the body
  LitheIndex n_free;       ///< parts with at least one free motion
  LitheIndex first;        ///< a cell of the first of them, -1 where all are held
  int count;               ///< independent free motions of that part, 0 to 6
  char text
      [LTH_FREE_MOTION_TEXT]; ///< "translation along x, rotation about z", "" where all are held
} LthFreeMotions;

/// Find the rigid motions without energy, for every connected part, with the body at rest. Parts with a
/// cell in `strong` (n_cells, or NULL) are held. Resets the operator's rotations to the identity.
LitheStatus lth_free_motions(LitheCtx *ctx, LthDgOperator *op, const LthDgSpace *space,
                             const uint8_t *strong, LthFreeMotions *result);
