/// Gauss rules on the segment, the triangle and the tetrahedron, for integrands that are not polynomials.
#pragma once

#include "base/ctx.h"

#define LTH_GAUSS_MAX 16 ///< points a direction: polynomials up to degree 31

/// Points x in (0, 1) and weights w (n each) of int_0^1 f(x) (1 - x)^a dx, exact up to degree 2n - 1;
/// 1 <= n <= LTH_GAUSS_MAX, a = 0 (Gauss-Legendre), 1 or 2.
void lth_gauss_jacobi(int n, int a, double *x, double *w);

/// A rule on a simplex from collapsed coordinates: n^2 points on a triangle, n^3 in a tetrahedron.
/// All weights are positive, all points inside; `bary` sums to 1 and so do the weights.
typedef struct LthSimplexRule {
  int n, dim; ///< points a direction; 2: triangle, 3: tetrahedron
  double x[3][LTH_GAUSS_MAX], w[3][LTH_GAUSS_MAX];
} LthSimplexRule;

/// Exact for polynomials of `degree`. LITHE_BAD_INPUT: degree outside 0 ... 2 LTH_GAUSS_MAX - 1.
LitheStatus lth_simplex_rule(LitheCtx *ctx, int dim, int degree, LthSimplexRule *rule);

static inline int lth_simplex_rule_points(const LthSimplexRule *rule) {
  return rule->dim == 2 ? rule->n * rule->n : rule->n * rule->n * rule->n;
}

/// Barycentric coordinates (dim + 1) of point k; returns its weight.
double lth_simplex_rule_point(const LthSimplexRule *rule, int k, double *bary);
