/// Rows of the staggered operator, one unknown at a time, as lists of entries: for matrices.
#pragma once

#include "disc/staggered/staggered_level.h"

/// One entry of a row: unknown of component b at a slot.
typedef struct LthStaggeredEntry {
  LitheCount slot;
  int b;
  double value;
} LthStaggeredEntry;

#define LTH_STAGGERED_ROW 15 ///< entries of a row at most

/// Row of cm M + ck K at a free unknown, its diagonal first; entries at dead unknowns are left out, those at held ones
/// are there. Returns how many.
int lth_staggered_row(const LthStaggeredLevel *level, double cm, double ck, int a, LitheCount slot,
                      LthStaggeredEntry entry[LTH_STAGGERED_ROW]);
