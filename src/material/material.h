/// Elastic materials: what a scene says of them, and Lame's constants.
#pragma once

#include "base/value.h"

#include <stdbool.h>

typedef enum LthMaterialModel {
  LTH_MATERIAL_LINEAR,    ///< small strain
  LTH_MATERIAL_COROTATED, ///< small strain in a rotated frame per element
  LTH_MATERIAL_NEO_HOOKEAN
} LthMaterialModel;

typedef struct LthMaterial {
  LthMaterialModel model;
  LthValue young;           ///< [Pa]
  LthValue poisson;         ///< [-], below 0.5
  LthValue density;         ///< [kg/m^3]
  double damping_mass;      ///< Rayleigh a [1/s]
  double damping_stiffness; ///< Rayleigh b [s]
  double yield_strength;    ///< [Pa], 0: not given
} LthMaterial;

/// lambda = E nu / ((1 + nu)(1 - 2 nu)), mu = E / (2 (1 + nu))  [Pa]
static inline void lth_lame(double young, double poisson, double *lambda, double *mu) {
  *mu = young / (2 * (1 + poisson));
  *lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
}

/// Young's modulus [Pa], Poisson's ratio and density [kg/m^3] wherever a body is. Thread-safe.
typedef struct LthMaterialField {
  void (*eval)(const void *self, const double x[3], double *young, double *poisson,
               double *density);
  const void *self;
  bool is_uniform; ///< the same everywhere
} LthMaterialField;
