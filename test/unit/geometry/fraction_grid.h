/// A grid of 20^3 cells over [-1, 1]^3, its parts by place, and a shell in it.
#pragma once

#include "check.h"

#include "geometry/fractions.h"

static const double origin[3] = {-1, -1, -1}, h[3] = {0.1, 0.1, 0.1};
static const LitheIndex n[3] = {20, 20, 20};

static const LthShape shell = {
    .kind = LTH_SHAPE_SHELL, .a = {0.03, -0.02, 0.01}, .radius = 0.8, .inner = 0.55};

/// Part at (i, j, k) halves of cells from the origin; 0 where there is none.
static inline double part_at(const LthFractions *f, const int at[3]) {
  LitheIndex cell[3];
  for (int a = 0; a < 3; a++)
    cell[a] = at[a] / 2 + (LitheIndex)lround((origin[a] - f->grid->origin[a]) / h[a]);
  LitheCount slot = lth_sparse_grid_slot(f->grid, cell[0], cell[1], cell[2]);
  return slot < 0 ? 0
                  : lth_fractions_part(f, slot, (at[0] & 1) + 2 * (at[1] & 1) + 4 * (at[2] & 1));
}
