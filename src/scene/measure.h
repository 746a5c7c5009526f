/// Figures of the bodies' present state for the result: displacement, stress, volume, errors.
#pragma once

#include "scene/world.h"

typedef struct LthDisplacementFigures {
  double max;  ///< largest length at corners of elements [m]
  double mean; ///< mean length over the volume [m]
} LthDisplacementFigures;

LitheStatus lth_measure_displacement(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                                     LthDisplacementFigures *figures);

/// Samples: the centroid of each element whose functions are linear (stress is one there but for its rotation),
/// the centroid and all corners of others.
typedef struct LthStressFigures {
  double von_mises_max; ///< [Pa]
  double p99;           ///< 99 % of the volume lies at or below it [Pa]
  double at[3];         ///< rest place of the largest [m]
  double safety;        ///< least yield strength over von Mises stress; NaN where none is given
} LthStressFigures;

LitheStatus lth_measure_stress(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                               LthStressFigures *figures);

/// von Mises stress of xx yy zz yz zx xy.
double lth_von_mises(const double stress[6]);

/// Deformed volume [m^3]: det F at each element's mean gradient.
double lth_measure_volume(LitheIndex n, LthBody *const *bodies);

/// Norms of displacement minus the scene's exact one at the present time, over the volume; h1 is the norm
/// of the gradient of the error (the exact gradient by central differences).
typedef struct LthErrorFigures {
  double l1, l2, linf, h1;
  double stress_l2, stress_linf; ///< with an exact stress
} LthErrorFigures;

LitheStatus lth_measure_error(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                              LthErrorFigures *figures);
