/// Gauss-Jacobi points by Newton's method with deflation, and conical product rules from them
/// (Stroud, Approximate Calculation of Multiple Integrals, 1971, section 2.4).
#include "geometry/quadrature.h"

#include <math.h>

/// Jacobi polynomial P_n^(a,0)(t) and its derivative.
static double jacobi(int n, double a, double t, double *derivative) {
  double p0 = 1, p1 = 0.5 * (a + (a + 2) * t);
  if (n == 0) {
    *derivative = 0;
    return 1;
  }
  for (int k = 1; k < n; k++) {
    double s = 2 * k + a;
    double c1 = 2 * (k + 1) * (k + a + 1) * s, c2 = (s + 1) * a * a, c3 = s * (s + 1) * (s + 2);
    double c4 = 2 * (k + a) * k * (s + 2), p2 = ((c2 + c3 * t) * p1 - c4 * p0) / c1;
    p0 = p1, p1 = p2;
  }
  // (2n + a)(1 - t^2) P' = n (a - (2n + a) t) P_n + 2 n (n + a) P_{n-1}
  double s = 2 * n + a;
  *derivative = (n * (a - s * t) * p1 + 2 * n * (n + a) * p0) / (s * (1 - t * t));
  return p1;
}

void lth_gauss_jacobi(int n, int a, double *x, double *w) {
  LITHE_ASSERT(n >= 1 && n <= LTH_GAUSS_MAX && a >= 0);
  double root[LTH_GAUSS_MAX];
  for (int k = 0; k < n; k++) {
    // start between the Chebyshev point and the root before it; deflate the roots that are known
    double t = -cos((2 * k + 1) * acos(-1) / (2 * n)), slope, step;
    if (k > 0) t = 0.5 * (t + root[k - 1]);
    for (int it = 0; it < 60; it++) {
      double p = jacobi(n, a, t, &slope), known = 0;
      for (int j = 0; j < k; j++) known += 1 / (t - root[j]);
      step = p / (slope - p * known);
      t -= step;
      if (fabs(step) < 1e-15) break;
    }
    root[k] = t;
    jacobi(n, a, t, &slope);
    x[k] = 0.5 * (1 + t);
    // on (-1, 1): 2^(a+1) / ((1 - t^2) P'^2); the map to (0, 1) divides by 2^(a+1)
    w[k] = 1 / ((1 - t * t) * slope * slope);
  }
}

LitheStatus lth_simplex_rule(LitheCtx *ctx, int dim, int degree, LthSimplexRule *rule) {
  if (degree < 0 || degree > 2 * LTH_GAUSS_MAX - 1)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "quadrature of degree %d; expected 0 to %d", degree,
               2 * LTH_GAUSS_MAX - 1);
  rule->dim = dim;
  rule->n = degree / 2 + 1;
  for (int i = 0; i < dim; i++) lth_gauss_jacobi(rule->n, dim - 1 - i, rule->x[i], rule->w[i]);
  return LITHE_OK;
}

double lth_simplex_rule_point(const LthSimplexRule *rule, int k, double *bary) {
  double rest = 1, weight = rule->dim == 2 ? 2 : 6;
  for (int i = 0; i < rule->dim; i++) {
    int j = k % rule->n;
    k /= rule->n;
    bary[i + 1] = rest * rule->x[i][j];
    rest *= 1 - rule->x[i][j];
    weight *= rule->w[i][j];
  }
  bary[0] = rest;
  return weight;
}
