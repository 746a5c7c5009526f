/// Which faces of a coarse level are held, from those of the finer one.
#include "disc/staggered/staggered_hierarchy.h"
#include "disc/staggered/staggered_walls.h"

#include <math.h>

/// A fine face on a coarse one's plane is held; or it is dead and the next one, which no coarse plane meets, is held:
/// there the body ends half a coarse cell before.
static bool column_is_held(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  int here = lth_level_state(fine, a, lth_sparse_grid_slot(fine->grid, cell[0], cell[1], cell[2]));
  if (here != LTH_UNKNOWN_DEAD) return here == LTH_UNKNOWN_HELD;
  return lth_level_state(fine, a, lth_sparse_grid_along(fine->grid, cell, a, 1)) ==
             LTH_UNKNOWN_HELD ||
         lth_level_state(fine, a, lth_sparse_grid_along(fine->grid, cell, a, -1)) ==
             LTH_UNKNOWN_HELD;
}

/// How far the fine face of a cell is before a wall, in cells; behind it less than 0. Neighbours beside it in the coarse face tell.
static double before_wall(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  const bool held = column_is_held(fine, cell, a);
  double before = held ? -1 : 1.5;
  for (int b = 0; b < fine->grid->dim; b++) {
    if (b == a) continue;
    LitheIndex beside[3] = {cell[0], cell[1], cell[2]};
    beside[b] ^= 1;
    const int state =
        lth_level_state(fine, a, lth_sparse_grid_slot(fine->grid, beside[0], beside[1], beside[2]));
    if (held && state == LTH_UNKNOWN_FREE)
      before = fmax(before, lth_staggered_wall_way(fine, a, b, beside, cell) - 1);
    if (!held && state == LTH_UNKNOWN_HELD)
      before = fmin(before, lth_staggered_wall_way(fine, a, b, cell, beside));
  }
  return before;
}

/// Are the other components held beside the held fine face of a cell, too?
static bool is_clamped(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  for (int b = 0; b < fine->grid->dim; b++) {
    bool held = b == a;
    for (int q = 0; q < 4 && !held; q++) { // the faces across b at both cells of this face
      LitheIndex at[3] = {cell[0], cell[1], cell[2]};
      at[a] -= q & 1;
      at[b] += q >> 1;
      held = lth_level_state(fine, b, lth_sparse_grid_slot(fine->grid, at[0], at[1], at[2])) ==
             LTH_UNKNOWN_HELD;
    }
    if (!held) return false;
  }
  return true;
}

/// Does the held fine face of a cell hold what nothing behind it would hold on the coarse level, where it shares a coarse face with a free one?
static bool holds_alone(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  for (int b = 0; b < fine->grid->dim; b++) {
    if (b == a) continue;
    const int away = cell[b] & 1 ? 1 : -1; // from the other face of the pair
    int state[3];
    for (int k = 0; k < 3; k++) {
      LitheIndex at[3] = {cell[0], cell[1], cell[2]};
      at[b] += away * (k == 0 ? -1 : k);
      state[k] = lth_level_state(fine, a, lth_sparse_grid_slot(fine->grid, at[0], at[1], at[2]));
    }
    if (state[0] == LTH_UNKNOWN_FREE &&
        (state[1] != LTH_UNKNOWN_HELD || state[2] == LTH_UNKNOWN_FREE))
      return true;
  }
  return false;
}

/// Is what a held fine face holds sure to be held on the coarse level, too, where this face is given up? Holds of some components
/// may be as thin as one face: where the middle of a coarse face missed them, the coarse level would have a motion that nothing holds.
static bool is_thick(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  return is_clamped(fine, cell, a) && !holds_alone(fine, cell, a);
}

bool lth_staggered_coarse_is_held(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  LitheIndex low[3], high[3], c[3];
  bool any = false, thick = true;
  double before = 0;
  lth_fine_box(fine->grid->dim, cell, 0, low, high);
  high[a] = low[a];
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++) {
        if (!column_is_held(fine, c, a)) continue;
        any = true;
        thick &= is_thick(fine, c, a);
      }
  if (!any || !thick) return any;
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++) before += before_wall(fine, c, a);
  return before <= 0;
}
