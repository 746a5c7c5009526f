/// A number that may vary in space and time: a constant, or a callback such as a scene's expression.
#pragma once

#include <stddef.h>

/// Zero-initialised it is the constant 0. `self` is borrowed and must outlive the value.
typedef struct LthValue {
  double constant;                                               ///< where eval is NULL
  double (*eval)(const void *self, const double x[3], double t); ///< thread-safe; x [m], t [s]
  const void *self;
} LthValue;

static inline LthValue lth_value_constant(double c) { return (LthValue){.constant = c}; }

static inline double lth_value_at(const LthValue *v, const double x[3], double t) {
  return v->eval ? v->eval(v->self, x, t) : v->constant;
}
