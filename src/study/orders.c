/// Observed orders of convergence, and what a refined sequence tends to.
#include "study/orders.h"

#include <math.h>

double lth_order_between(double h0, double e0, double h1, double e1) {
  if (!(h0 > 0 && h1 > 0 && e0 > 0 && e1 > 0) || h0 == h1) return NAN;
  return log(e0 / e1) / log(h0 / h1);
}

double lth_order_fit(int n, const double *h, const double *e, double *constant) {
  double m = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (int i = 0; i < n; i++) {
    if (!(h[i] > 0 && e[i] > 0)) continue;
    double u = log(h[i]), v = log(e[i]);
    m++, x += u, y += v, xx += u * u, xy += u * v;
  }
  double spread = m * xx - x * x;
  if (m < 2 || !(spread > 1e-12 * m * xx)) return NAN;
  double p = (m * xy - x * y) / spread;
  if (constant) *constant = exp((y - p * x) / m);
  return p;
}

/// (h0^p - h1^p) / (h1^p - h2^p), which grows with p.
static double step_ratio(const double h[3], double p) {
  double a = pow(h[0] / h[1], p), b = pow(h[2] / h[1], p);
  return (a - 1) / (1 - b);
}

bool lth_order_extrapolate(const double h[3], const double q[3], double *order, double *limit) {
  double ratio = (q[0] - q[1]) / (q[1] - q[2]), low = 1e-3, high = 12;
  if (!(h[0] > h[1] && h[1] > h[2] && h[2] > 0)) return false;
  if (!(ratio > 1) || !isfinite(ratio)) return false;
  if (step_ratio(h, low) > ratio || step_ratio(h, high) < ratio) return false;
  for (int i = 0; i < 60; i++) {
    double middle = (low + high) / 2;
    if (step_ratio(h, middle) < ratio)
      low = middle;
    else
      high = middle;
  }
  *order = low;
  *limit = q[2] + (q[2] - q[1]) / (pow(h[1] / h[2], low) - 1);
  return true;
}
