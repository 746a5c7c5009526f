/// Observed orders of convergence, and what a refined sequence tends to.
#pragma once

#include <stdbool.h>

/// Order between two levels from errors e > 0 at lengths h. NaN where one of them is not positive.
double lth_order_between(double h0, double e0, double h1, double e1);

/// Order of e = C h^p by least squares in logarithms over all n levels with positive errors; *constant (may be
/// NULL) is C. NaN with fewer than two.
double lth_order_fit(int n, const double *h, const double *e, double *constant);

/// From three values q(h) = limit + C h^p, h falling: order and limit (Richardson). False where the values do not go
/// one way with shrinking steps, or no order in (0, 12] explains them.
bool lth_order_extrapolate(const double h[3], const double q[3], double *order, double *limit);
