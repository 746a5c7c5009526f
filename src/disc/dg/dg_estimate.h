/// What is missing of equilibrium, element by element: a residual estimate of the error in energy
/// (docs/theory/adaptivity.md, section 1; Houston, Schoetzau and Wihler 2006 for elasticity with discontinuous functions).
#pragma once

#include "disc/dg/dg_operator.h"

/// The parts of the estimate of an element.
enum {
  LTH_ESTIMATE_VOLUME,   ///< forces that stress does not balance inside
  LTH_ESTIMATE_FACES,    ///< jumps of traction to neighbours
  LTH_ESTIMATE_BOUNDARY, ///< traction less loads where nothing is held
  LTH_ESTIMATE_JUMPS, ///< jumps of the displacement, and its distance from what constraints prescribe
  LTH_ESTIMATE_PARTS
};

typedef struct LthDgEstimateDef {
  const LthDgOperator *op; ///< with the rotations of x
  const double *x;         ///< position (n_dofs) [m]
  double t;
  const LthLoad *loads; ///< of all kinds; point forces are left out
  LitheIndex n_loads;
  double gravity[3];
  const double *density;      ///< per cell, for gravity and inertia; NULL: neither
  const double *acceleration; ///< NULL: in equilibrium (n_dofs) [m/s^2]
} LthDgEstimateDef;

/// Squared parts of the error in energy, `parts` (n_cells x LTH_ESTIMATE_PARTS) [J]. Elements that move as prescribed
/// have none.
LitheStatus lth_dg_estimate(LitheCtx *ctx, const LthDgEstimateDef *def, double *parts);

/// Sum of an element's parts [J].
static inline double lth_dg_estimate_sum(const double *parts, LitheIndex cell) {
  double sum = 0;
  for (int i = 0; i < LTH_ESTIMATE_PARTS; i++) sum += parts[LTH_ESTIMATE_PARTS * (size_t)cell + i];
  return sum;
}

/// How fast an element's polynomial falls off with its degree: size of its gradient's share of the highest degree over that
/// of the degree below, 0 for degree 1. Smooth solutions have small ones.
double lth_dg_roughness(const LthDgOperator *op, LitheIndex cell, const double *x);
