/// Smooth fractions at flat sides that are planes of symmetry: those of the solid and its mirror image, behind the side.
#pragma once

#include "geometry/fractions.h"

/// A flat side of a shape across an axis.
typedef struct LthMirror {
  int axis;
  double sign;  ///< 1: the outward normal is along the axis; -1: against it
  double place; ///< along the axis [m]
  bool (*contains)(const void *self,
                   const double x[3]); ///< is x, in the plane, of the side? Thread-safe
  const void *self;
} LthMirror;

/// Smooth fractions of a shape (a definition of that method) become, within the profile's width of the mirrors, those of the shape
/// continued by its mirror image (docs/theory/fractions.md, section 5): a part beyond a mirror is empty, and one behind it does not
/// see it. `volume` follows.
LitheStatus lth_fractions_mirror(LitheCtx *ctx, LthFractions *fractions, const LthShape *shape,
                                 const LthFractionDef *def, const LthMirror *mirrors,
                                 LitheIndex n_mirrors);
