/// Making parts of cells full where the solid goes on beyond its surface: on sides that are held.
#pragma once

#include "geometry/fractions.h"

/// Bit q set: part q of a slot's cell is to be full. Thread-safe; not asked of cells that are.
typedef uint8_t (*LthPartChoice)(const void *self, LitheCount slot);

/// Make the chosen parts full. `volume` stays that of the shape.
LitheStatus lth_fractions_complete(LitheCtx *ctx, LthFractions *fractions, LthPartChoice choose,
                                   const void *self);
