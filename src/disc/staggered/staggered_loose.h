/// Parts of a level that hang loose: features thinner than two cells have motions without energy, which rule A leaves.
#pragma once

#include "disc/staggered/staggered_level.h"

/// What was left out.
typedef struct LthLoose {
  LitheCount n_cells; ///< cells
  double place[3];    ///< centre of one of them [m]
} LthLoose;

/// After rule A: empty the cells that can move without energy against what they hang on, so that free motions of what is
/// left are those of whole connected pieces, and apply rule A again. Unknowns that are held count as ground.
LitheStatus lth_staggered_drop_loose(LitheCtx *ctx, LthStaggeredLevel *level, LthLoose *loose);
