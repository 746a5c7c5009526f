/// Quadrature rules on reference elements and their faces.
#include "disc/cg/cg_shape.h"
#include "geometry/quadrature.h"

#include <math.h>
#include <string.h>

static void add_point(LthCgRule *rule, double r, double s, double t, double weight) {
  double *xi = rule->xi[rule->n];
  LITHE_ASSERT(rule->n < LTH_CG_MAX_POINTS);
  xi[0] = r, xi[1] = s, xi[2] = t;
  rule->weight[rule->n++] = weight;
}

/// Gauss points on [-1, 1].
static void line_rule(int n, double *x, double *w) {
  lth_gauss_jacobi(n, 0, x, w);
  for (int i = 0; i < n; i++) x[i] = 2 * x[i] - 1, w[i] *= 2;
}

static void hexahedron_rule(int n, LthCgRule *rule) {
  double x[LTH_GAUSS_MAX], w[LTH_GAUSS_MAX];
  line_rule(n, x, w);
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) add_point(rule, x[i], x[j], x[k], w[i] * w[j] * w[k]);
}

/// Points of a triangle: 1, 3 (degree 2), or a product of n a direction.
static int triangle_rule(int n, double (*xi)[2], double *w) {
  if (n == 1) {
    xi[0][0] = xi[0][1] = 1.0 / 3, w[0] = 0.5;
    return 1;
  }
  if (n == 0) { // the rule of three inner points
    for (int i = 0; i < 3; i++) {
      xi[i][0] = i == 1 ? 2.0 / 3 : 1.0 / 6;
      xi[i][1] = i == 2 ? 2.0 / 3 : 1.0 / 6;
      w[i] = 1.0 / 6;
    }
    return 3;
  }
  double x[2][LTH_GAUSS_MAX], v[2][LTH_GAUSS_MAX];
  lth_gauss_jacobi(n, 1, x[0], v[0]);
  lth_gauss_jacobi(n, 0, x[1], v[1]);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      xi[n * i + j][0] = x[0][i];
      xi[n * i + j][1] = (1 - x[0][i]) * x[1][j];
      w[n * i + j] = v[0][i] * v[1][j];
    }
  return n * n;
}

static void wedge_rule(int n_triangle, int n_line, LthCgRule *rule) {
  double xi[LTH_CG_MAX_POINTS][2], v[LTH_CG_MAX_POINTS], x[LTH_GAUSS_MAX], w[LTH_GAUSS_MAX];
  int n = triangle_rule(n_triangle, xi, v);
  line_rule(n_line, x, w);
  for (int k = 0; k < n_line; k++)
    for (int i = 0; i < n; i++) add_point(rule, xi[i][0], xi[i][1], x[k], v[i] * w[k]);
}

/// Products in the collapsed coordinates r / (1 - t), s / (1 - t), t.
static void pyramid_rule(int n, LthCgRule *rule) {
  double x[LTH_GAUSS_MAX], w[LTH_GAUSS_MAX], t[LTH_GAUSS_MAX], v[LTH_GAUSS_MAX];
  line_rule(n, x, w);
  lth_gauss_jacobi(n, 2, t, v);
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        add_point(rule, (1 - t[k]) * x[i], (1 - t[k]) * x[j], t[k], w[i] * w[j] * v[k]);
}

/// n points a direction in collapsed coordinates.
static void tetrahedron_rule(int n, LthCgRule *rule) {
  double x[3][LTH_GAUSS_MAX], w[3][LTH_GAUSS_MAX];
  for (int a = 0; a < 3; a++) lth_gauss_jacobi(n, 2 - a, x[a], w[a]);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      for (int k = 0; k < n; k++) {
        double r = x[0][i], s = (1 - r) * x[1][j], t = (1 - r - s) * x[2][k];
        add_point(rule, r, s, t, w[0][i] * w[1][j] * w[2][k]);
      }
}

/// Four points, exact to degree 2.
static void four_points(LthCgRule *rule) {
  double near = (5 - sqrt(5)) / 20, far = 1 - 3 * near;
  add_point(rule, near, near, near, 1.0 / 24);
  add_point(rule, far, near, near, 1.0 / 24);
  add_point(rule, near, far, near, 1.0 / 24);
  add_point(rule, near, near, far, 1.0 / 24);
}

void lth_cg_stiffness_rule(LthElementKind kind, bool reduced, LthCgRule *rule) {
  rule->n = 0;
  switch (kind) {
  case LTH_TET4:
    add_point(rule, 0.25, 0.25, 0.25, 1.0 / 6);
    break;
  case LTH_TET10:
    four_points(rule);
    break;
  case LTH_HEX8:
    hexahedron_rule(2, rule);
    break;
  case LTH_HEX20:
    hexahedron_rule(reduced ? 2 : 3, rule);
    break;
  case LTH_WEDGE6:
    wedge_rule(reduced ? 1 : 0, 2, rule);
    break;
  case LTH_WEDGE15:
    wedge_rule(0, 3, rule);
    break;
  default:
    lth_cg_mass_rule(kind, rule);
  }
}

void lth_cg_mass_rule(LthElementKind kind, LthCgRule *rule) {
  rule->n = 0;
  int n = lth_element_shape(kind)->degree + 1;
  switch (lth_element_shape(kind)->n_corners) {
  case 4:
    tetrahedron_rule(n, rule);
    break;
  case 5:
    pyramid_rule(n, rule);
    break;
  case 6:
    wedge_rule(n, n, rule);
    break;
  default:
    hexahedron_rule(n, rule);
  }
}

/// Place and edge vectors of a triangle or a quadrilateral with corners p at (a, b) in [0, 1]^2.
static void face_place(int n, const double (*p)[3], double a, double b, LthCgFaceRule *rule) {
  for (int i = 0; i < 3; i++) {
    double u = p[1][i] - p[0][i], v = p[n - 1][i] - p[0][i];
    double twist = n == 4 ? p[2][i] - p[1][i] - p[3][i] + p[0][i] : 0;
    rule->xi[rule->n][i] = p[0][i] + a * u + b * v + a * b * twist;
    rule->a[rule->n][i] = u + b * twist;
    rule->b[rule->n][i] = v + a * twist;
  }
}

void lth_cg_plane_rule(int n_corners, int order, LthCgPlaneRule *rule) {
  rule->n = 0;
  if (n_corners == 3) {
    rule->n = triangle_rule(order, rule->at, rule->weight);
    return;
  }
  double x[LTH_GAUSS_MAX], w[LTH_GAUSS_MAX];
  lth_gauss_jacobi(order, 0, x, w);
  for (int i = 0; i < order; i++)
    for (int j = 0; j < order; j++, rule->n++) {
      rule->at[rule->n][0] = x[i], rule->at[rule->n][1] = x[j];
      rule->weight[rule->n] = w[i] * w[j];
    }
}

void lth_cg_face_rule(const LthCgKind *kind, int n_corners, const int8_t *corner,
                      const LthCgPlaneRule *plane, LthCgFaceRule *rule) {
  double p[4][3];
  for (int i = 0; i < n_corners; i++) memcpy(p[i], kind->node[corner[i]], sizeof p[i]);
  for (rule->n = 0; rule->n < plane->n; rule->n++) {
    const double *at = plane->at[rule->n];
    face_place(n_corners, (const double(*)[3])p, at[0], at[1], rule);
    rule->weight[rule->n] = plane->weight[rule->n];
  }
}
