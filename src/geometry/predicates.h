/// Signs of small determinants, always right: a filtered double evaluation, then exact arithmetic.
/// The idea of floating-point expansions is Priest's and Shewchuk's (Adaptive Precision Floating-Point
/// Arithmetic and Fast Robust Geometric Predicates, 1997). Right as long as no product overflows or
/// underflows: coordinates up to 1e60, differences that are zero or above 1e-60.
#pragma once

#include <stdbool.h>

/// Sign of the area of triangle abc: 1 counter-clockwise, -1 clockwise, 0 collinear.
int lth_orient2d(const double a[2], const double b[2], const double c[2]);

/// Sign of (b - a) x (c - a) . (d - a): 1 where d lies on the side that abc's normal points to, 0 coplanar.
int lth_orient3d(const double a[3], const double b[3], const double c[3], const double d[3]);

/// True where the three points lie on a line (or coincide), exactly.
bool lth_collinear(const double a[3], const double b[3], const double c[3]);
