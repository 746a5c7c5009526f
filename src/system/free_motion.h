/// Which rigid motions nothing holds: what a static run without enough constraints is told.
#pragma once

#include "system/system.h"

#define LTH_FREE_MOTION_TEXT 512

typedef struct LthFreeMotions {
  LitheIndex n_components; ///< connected parts of all bodies
  LitheIndex n_free;       ///< parts with at least one free motion
  LitheIndex body;         ///< that the first of them is of, -1 where all are held
  double at[3];            ///< a place in it [m]
  int count;               ///< independent free motions of that part, 0 to 6
  char text
      [LTH_FREE_MOTION_TEXT]; ///< "translation along x, rotation about z", "" where all are held
} LthFreeMotions;

/// Find the rigid motions without energy that leave held unknowns where they are, for every connected part, with
/// the bodies at rest. Makes a matrix of its own, which ends the use of any other of this system; resets the
/// rotations to the identity.
LitheStatus lth_free_motions(LitheCtx *ctx, LthSystem *system, LthFreeMotions *result);
