/// Unknowns near the boundary, as loads see them (docs/theory/staggered.md, "Tractions").
#pragma once

#include "disc/staggered/staggered_priv.h"

/// An unknown near the boundary.
typedef struct LthFringe {
  int a;           ///< component
  double slope[3]; ///< -grad_h V as its row sees it: along the outward normal [1/m]
  double point[3], normal[3];
} LthFringe;

/// Everything within one cell of the cell at slot[0] is full.
bool lth_fringe_is_inside(const LthStaggered *s, const LitheCount *slot, const int stride[3]);

/// Differences of the fractions of the samples that the row of component rim->a reads; false where there are none. Samples without stiffness
/// count as empty: loads act only where something resists them. Those on a roller's side, whose other half is empty, count as if the
/// solid went on beyond it: the side is a boundary of its own (`side[b]`: the slope along b there).
bool lth_fringe_slope(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                      LthFringe *rim, double side[3]);

/// The boundary nearest to a place, by the shape or else by the fractions.
void lth_fringe_nearest(const LthStaggered *s, const double at[3], LthFringe *rim);

/// The boundary that fractions fall towards beside the unknown at `at`: the nearest one, but beside corners, where that may be another side.
void lth_fringe_boundary(const LthStaggered *s, const double at[3], LthFringe *rim);

/// Is the dead shear sample at slot[0], which unknowns of components a and b meet in, on a side across axis b that a roller
/// holds? Both unknowns of component b are on that side.
bool lth_fringe_is_on_roller(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                             int a, int b);

/// A roller's side beside the unknown, across axis b.
LthFringe lth_fringe_of_roller(const LthStaggered *s, LitheIndex func, int a, int b, double slope);
