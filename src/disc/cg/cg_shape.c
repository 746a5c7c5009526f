/// Shape functions and their gradients: formulas for the values, differentiated by carrying gradients along.
/// Bathe, Finite Element Procedures, chapter 5; pyramids: Bedrosian 1992.
#include "disc/cg/cg_shape.h"

#include <math.h>
#include <string.h>

/// A number and its gradient.
typedef struct Jet {
  double v, d[3];
} Jet;

static Jet jet_of(double value, int axis) {
  Jet j = {.v = value};
  j.d[axis] = 1;
  return j;
}

/// a + b f
static Jet jet_line(double a, double b, Jet f) {
  Jet j = {.v = a + b * f.v};
  for (int i = 0; i < 3; i++) j.d[i] = b * f.d[i];
  return j;
}

static Jet jet_add(Jet f, Jet g) {
  Jet j = {.v = f.v + g.v};
  for (int i = 0; i < 3; i++) j.d[i] = f.d[i] + g.d[i];
  return j;
}

static Jet jet_mul(Jet f, Jet g) {
  Jet j = {.v = f.v * g.v};
  for (int i = 0; i < 3; i++) j.d[i] = f.d[i] * g.v + f.v * g.d[i];
  return j;
}

static Jet jet_div(Jet f, Jet g) {
  Jet j = {.v = f.v / g.v};
  for (int i = 0; i < 3; i++) j.d[i] = (f.d[i] - j.v * g.d[i]) / g.v;
  return j;
}

/// Lagrange's polynomial of a node at `at` (-1, 0 or 1) among those of degree 1 or 2 on [-1, 1].
static Jet line_function(int degree, double at, Jet x) {
  if (degree == 1) return jet_line(0.5, 0.5 * at, x);
  Jet square = jet_mul(x, x);
  if (at == 0) return jet_line(1, -1, square);
  return jet_add(jet_line(0, 0.5 * at, x), jet_line(0, 0.5, square));
}

static Jet tensor_function(int degree, const double at[3], const Jet x[3]) {
  Jet f = line_function(degree, at[0], x[0]);
  for (int a = 1; a < 3; a++) f = jet_mul(f, line_function(degree, at[a], x[a]));
  return f;
}

static Jet serendipity_function(const double at[3], const Jet x[3]) {
  bool is_corner = at[0] != 0 && at[1] != 0 && at[2] != 0;
  Jet f = {.v = 1}, sum = {.v = -2};
  for (int a = 0; a < 3; a++) {
    f = jet_mul(f, line_function(at[a] == 0 ? 2 : 1, at[a], x[a]));
    sum = jet_add(sum, jet_line(0, at[a], x[a]));
  }
  return is_corner ? jet_mul(f, sum) : f;
}

/// Function of degree 1 or 2 of a simplex, n barycentric coordinates L of the place and l of the node.
static Jet simplex_function(int degree, int n, const double *l, const Jet *L) {
  Jet f = {.v = 1};
  for (int i = 0; i < n; i++) {
    if (l[i] == 1) return degree == 1 ? L[i] : jet_mul(L[i], jet_line(-1, 2, L[i]));
    if (l[i] == 0.5) f = jet_mul(f, jet_line(0, 2, L[i]));
  }
  return f;
}

static Jet tetrahedron_function(int degree, const double at[3], const Jet x[3]) {
  double l[4] = {1 - at[0] - at[1] - at[2], at[0], at[1], at[2]};
  Jet L[4] = {{.v = 1}, x[0], x[1], x[2]};
  for (int a = 0; a < 3; a++) L[0] = jet_add(L[0], jet_line(0, -1, x[a]));
  return simplex_function(degree, 4, l, L);
}

static Jet wedge_function(const LthCgKind *kind, const double at[3], const Jet x[3]) {
  double l[3] = {1 - at[0] - at[1], at[0], at[1]};
  Jet L[3] = {jet_add(jet_line(1, -1, x[0]), jet_line(0, -1, x[1])), x[0], x[1]};
  if (kind->kind == LTH_WEDGE18 || kind->kind == LTH_WEDGE6)
    return jet_mul(simplex_function(kind->shape->degree, 3, l, L),
                   line_function(kind->shape->degree, at[2], x[2]));
  Jet linear = simplex_function(1, 3, l, L), bubble = jet_line(1, -1, jet_mul(x[2], x[2]));
  if (at[2] == 0) return jet_mul(linear, bubble);
  Jet f = jet_mul(simplex_function(2, 3, l, L), line_function(1, at[2], x[2]));
  bool is_corner = l[0] == 1 || l[1] == 1 || l[2] == 1;
  return is_corner ? jet_add(f, jet_line(0, -0.5, jet_mul(linear, bubble))) : f;
}

/// What the functions of a pyramid are made of: d = 1 - t, the planes through its sides 1 - t +- r, 1 - t +- s,
/// all four over d ((d^2 - r^2)(d^2 - s^2) / d^2 is the bubble of the base).
typedef struct Pyramid {
  Jet r, s, t, d;
} Pyramid;

static Jet pyramid_corner(const Pyramid *p, double r, double s) {
  Jet f = jet_mul(jet_line(1, r, p->r), jet_line(1, s, p->s));
  Jet mixed = jet_div(jet_mul(jet_mul(p->r, p->s), p->t), p->d);
  return jet_line(0, 0.25, jet_add(f, jet_add(jet_line(0, -1, p->t), jet_line(0, r * s, mixed))));
}

static Jet pyramid_bubble(const Pyramid *p) {
  Jet square = jet_mul(p->d, p->d);
  Jet a = jet_add(square, jet_line(0, -1, jet_mul(p->r, p->r)));
  Jet b = jet_add(square, jet_line(0, -1, jet_mul(p->s, p->s)));
  return jet_div(jet_mul(a, b), square);
}

/// Serendipity function of a node of the pyramid of 13.
static Jet pyramid_function(const Pyramid *p, const double at[3]) {
  if (at[2] == 1) return jet_mul(p->t, jet_line(-1, 2, p->t));
  if (at[2] == 0.5) { // at half the height of the edge to corner 2 at
    Jet a = jet_add(p->d, jet_line(0, 2 * at[0], p->r));
    Jet b = jet_add(p->d, jet_line(0, 2 * at[1], p->s));
    return jet_div(jet_mul(p->t, jet_mul(a, b)), p->d);
  }
  if (at[0] != 0 && at[1] != 0) {
    Jet sum = jet_add(jet_line(-1, at[0], p->r), jet_line(0, at[1], p->s));
    return jet_mul(sum, pyramid_corner(p, at[0], at[1]));
  }
  Jet along = at[0] == 0 ? p->r : p->s, across = at[0] == 0 ? p->s : p->r;
  Jet f = jet_add(jet_mul(p->d, p->d), jet_line(0, -1, jet_mul(along, along)));
  f = jet_mul(f, jet_add(p->d, jet_line(0, at[0] + at[1], across)));
  return jet_line(0, 0.5, jet_div(f, p->d));
}

static Jet any_pyramid_function(LthElementKind kind, const double at[3], const Jet x[3]) {
  Pyramid p = {x[0], x[1], x[2], jet_line(1, -1, x[2])};
  if (p.d.v < 1e-12) p.d.v = 1e-12; // at the apex the quotients have limits
  if (kind == LTH_PYRAMID5) return at[2] == 1 ? p.t : pyramid_corner(&p, at[0], at[1]);
  if (kind == LTH_PYRAMID13) return pyramid_function(&p, at);
  Jet bubble = pyramid_bubble(&p);
  if (at[0] == 0 && at[1] == 0 && at[2] == 0) return bubble;
  Jet f = pyramid_function(&p, at);
  if (at[2] != 0) return f;
  // value of the function of 13 at the centre of the base: -1/4 of corners, 1/2 of edges
  return jet_add(f, jet_line(0, at[0] != 0 && at[1] != 0 ? 0.25 : -0.5, bubble));
}

static Jet shape_function(const LthCgKind *kind, const double at[3], const Jet x[3]) {
  switch (kind->kind) {
  case LTH_TET4:
  case LTH_TET10:
    return tetrahedron_function(kind->shape->degree, at, x);
  case LTH_HEX20:
    return serendipity_function(at, x);
  case LTH_WEDGE6:
  case LTH_WEDGE15:
  case LTH_WEDGE18:
    return wedge_function(kind, at, x);
  case LTH_PYRAMID5:
  case LTH_PYRAMID13:
  case LTH_PYRAMID14:
    return any_pyramid_function(kind->kind, at, x);
  default:
    return tensor_function(kind->shape->degree, at, x);
  }
}

void lth_cg_shape(const LthCgKind *kind, const double xi[3], double *phi, double *dphi) {
  Jet x[3] = {jet_of(xi[0], 0), jet_of(xi[1], 1), jet_of(xi[2], 2)};
  for (int i = 0; i < kind->n; i++) {
    Jet f = shape_function(kind, kind->node[i], x);
    phi[i] = f.v;
    for (int a = 0; a < 3; a++) dphi[3 * i + a] = f.d[a];
  }
}

static const double corners[4][8][3] = {
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    {{-1, -1, -1},
     {1, -1, -1},
     {1, 1, -1},
     {-1, 1, -1},
     {-1, -1, 1},
     {1, -1, 1},
     {1, 1, 1},
     {-1, 1, 1}},
    {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
    {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}};

/// Mean place of n nodes.
static void mean_place(const LthCgKind *kind, int n, const int8_t *node, double mean[3]) {
  for (int a = 0; a < 3; a++) {
    mean[a] = 0;
    for (int i = 0; i < n; i++) mean[a] += kind->node[node[i]][a] / n;
  }
}

void lth_cg_kind_init(LthElementKind kind, LthCgKind *out) {
  const LthElementShape *shape = lth_element_shape(kind);
  *out = (LthCgKind){.kind = kind, .shape = shape, .n = shape->n_nodes};
  int family = shape->n_corners == 4   ? 0
               : shape->n_corners == 8 ? 1
               : shape->n_corners == 6 ? 2
                                       : 3;
  memcpy(out->node, corners[family], sizeof corners[family]);
  for (int i = 8; i < LTH_ELEMENT_MAX_NODES; i++) memset(out->node[i], 0, sizeof out->node[i]);
  static const int8_t all[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  mean_place(out, shape->n_corners, all, out->center);
  if (family == 3) out->center[2] = 0.25;
  for (int f = 0; f < shape->n_faces; f++) {
    const int8_t *node = shape->face[f].node;
    int n = shape->face[f].n_corners;
    for (int i = 0; i < n && shape->face[f].n_nodes >= 2 * n; i++) {
      int8_t ends[2] = {node[i], node[(i + 1) % n]};
      mean_place(out, 2, ends, out->node[node[n + i]]);
    }
    if (shape->face[f].n_nodes == 2 * n + 1) mean_place(out, n, node, out->node[node[2 * n]]);
  }
}

#define APEX 1e-6

static bool clamp_to(double low, double high, double *x) {
  if (*x >= low && *x <= high) return false;
  *x = *x > high ? high : low; // and numbers that are none
  return true;
}

/// r, s >= 0, sum of n coordinates at most 1.
static bool clamp_simplex(int n, double *xi) {
  bool outside = false;
  double sum = 0;
  for (int i = 0; i < n; i++) {
    outside |= clamp_to(0, 1, &xi[i]);
    sum += xi[i];
  }
  for (int i = 0; i < n && sum > 1; i++) xi[i] /= sum;
  return outside || sum > 1;
}

bool lth_cg_clamp(const LthCgKind *kind, double xi[3]) {
  bool outside = false;
  int corner_count = kind->shape->n_corners;
  if (corner_count == 4) return clamp_simplex(3, xi);
  if (corner_count == 6) {
    outside = clamp_simplex(2, xi);
    return clamp_to(-1, 1, &xi[2]) || outside;
  }
  // at the apex itself the gradients of a pyramid have no value: a little below they do
  if (corner_count == 5) outside = clamp_to(0, 1 - APEX, &xi[2]);
  double reach = corner_count == 5 ? 1 - xi[2] : 1;
  for (int a = 0; a < (corner_count == 5 ? 2 : 3); a++) outside |= clamp_to(-reach, reach, &xi[a]);
  return outside;
}
