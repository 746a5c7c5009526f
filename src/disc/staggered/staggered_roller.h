/// Rollers on boundary that is not along an axis: Nitsche's terms at points of the surface, beside the rows of the grid
/// (docs/theory/staggered.md, "Rollers that are not along an axis").
///
///   E_roller(u) = sum over points A [ k/2 (m(u) - g)^2 - s(u) (m(u) - g) ]
///
/// m is the displacement along the outward normal n at the point, s = n . sigma n the stress that goes with it, that of a cell nearby
/// which is filled well: the energy bounds it.
#pragma once

#include "disc/staggered/staggered_priv.h"

/// A point of the surface that a roller holds.
typedef struct LthRollerPoint {
  LitheIndex roller;
  double x[3], normal[3]; ///< at rest [m], unit and outward
  double area;            ///< A [m^2]
  double stiffness;       ///< k [Pa/m]
  LitheCount first;       ///< of its terms
  int n;                  ///< how many
} LthRollerPoint;

struct LthStaggeredRollers {
  LthRollerPoint *point;
  LitheCount n_points, cap_points;
  LitheIndex *func; ///< of a term, ascending for each point                  (n_terms)
  double *move;     ///< m by its three unknowns                              (n_terms x 3)
  double *push;     ///< s by its three unknowns [Pa/m]                       (n_terms x 3)
  LitheCount n_terms, cap_func, cap_move, cap_push;
  LitheCount *near_off; ///< of a function: those it meets in some point  (n_funcs + 1)
  LitheIndex *near;     ///< ascending
};

/// The points of rollers, without stiffness and terms (staggered_roller_place.c).
LitheStatus lth_rollers_place(LitheCtx *ctx, const LthStaggered *s, LthStaggeredRollers *r);
