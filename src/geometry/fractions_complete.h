/// Giving parts of cells other fractions than the shape's alone: where sides are held.
#pragma once

#include "geometry/fractions.h"

/// New fractions of the parts of a slot's cell in place of those that it has. Thread-safe; asked twice, but not of cells
/// that are full.
typedef void (*LthPartChange)(const void *self, LitheCount slot, double *part);

/// Change parts; `volume` is that of what they have become. `before` gets the parts as they were: it borrows the grid of
/// `fractions` and, until these are changed again, the parts of blocks; its own arrays are freed by lth_fractions_forget().
LitheStatus lth_fractions_change(LitheCtx *ctx, LthFractions *fractions, LthPartChange change,
                                 const void *self, LthFractions *before);
void lth_fractions_forget(LitheCtx *ctx, LthFractions *before);

/// Bit q set: part q of a slot's cell is to be full. Thread-safe; not asked of cells that are.
typedef uint8_t (*LthPartChoice)(const void *self, LitheCount slot);

/// Make the chosen parts full. `volume` stays that of the shape.
LitheStatus lth_fractions_complete(LitheCtx *ctx, LthFractions *fractions, LthPartChoice choose,
                                   const void *self, LthFractions *before);
