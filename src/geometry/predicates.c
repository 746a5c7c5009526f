/// Orientation predicates with an error bound and an exact fallback.
///
/// An expansion is a sum of doubles that do not overlap, ordered by magnitude: its sign is that of its
/// last term. Sums and products of expansions are exact. Needs round-to-nearest without contraction or
/// reassociation, which is how this library is compiled.
#include "geometry/predicates.h"

#include <math.h>

#define UNIT_ROUNDOFF 0x1p-53
#define EXPANSION_MAX 192 // terms of a 3x3 determinant of differences: 3 x 2 x 16 x 2

typedef struct Expansion {
  int n;
  double term[EXPANSION_MAX];
} Expansion;

/// x += b. Zero terms are left out, which keeps everyday coordinates cheap.
static void expansion_add(Expansion *x, double b) {
  double carry = b;
  int n = 0;
  for (int i = 0; i < x->n; i++) {
    double t = x->term[i], sum = carry + t;
    double t_part = sum - carry, carry_part = sum - t_part;
    double error = (carry - carry_part) + (t - t_part);
    if (error != 0) x->term[n++] = error;
    carry = sum;
  }
  if (carry != 0) x->term[n++] = carry;
  x->n = n;
}

/// x += a * b
static void expansion_add_two_product(Expansion *x, double a, double b) {
  double product = a * b;
  expansion_add(x, fma(a, b, -product));
  expansion_add(x, product);
}

/// x += sign * a * b
static void expansion_add_product(Expansion *x, double sign, const Expansion *a,
                                  const Expansion *b) {
  for (int i = 0; i < a->n; i++)
    for (int j = 0; j < b->n; j++) expansion_add_two_product(x, sign * a->term[i], b->term[j]);
}

static void expansion_difference(Expansion *x, double a, double b) {
  x->n = 0;
  expansion_add(x, a);
  expansion_add(x, -b);
}

static int expansion_sign(const Expansion *x) {
  if (x->n == 0) return 0;
  return x->term[x->n - 1] > 0 ? 1 : -1;
}

static int sign_of(double x) { return (x > 0) - (x < 0); }

static int orient2d_exact(const double a[2], const double b[2], const double c[2]) {
  Expansion acx, acy, bcx, bcy, det;
  det.n = 0;
  expansion_difference(&acx, a[0], c[0]);
  expansion_difference(&acy, a[1], c[1]);
  expansion_difference(&bcx, b[0], c[0]);
  expansion_difference(&bcy, b[1], c[1]);
  expansion_add_product(&det, 1, &acx, &bcy);
  expansion_add_product(&det, -1, &acy, &bcx);
  return expansion_sign(&det);
}

int lth_orient2d(const double a[2], const double b[2], const double c[2]) {
  double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
  double det = left - right, size = fabs(left) + fabs(right);
  // a product carries 3 roundings and the subtraction one more: |error| <= 4 u size to first order
  if (fabs(det) > 5 * UNIT_ROUNDOFF * size) return sign_of(det);
  if (size == 0) return 0;
  return orient2d_exact(a, b, c);
}

static int orient3d_exact(const double a[3], const double b[3], const double c[3],
                          const double d[3]) {
  const double *row[3] = {b, c, d};
  Expansion m[3][3], minor, det;
  det.n = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) expansion_difference(&m[i][j], row[i][j], a[j]);
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    minor.n = 0;
    expansion_add_product(&minor, 1, &m[i][0], &m[j][1]);
    expansion_add_product(&minor, -1, &m[i][1], &m[j][0]);
    expansion_add_product(&det, 1, &minor, &m[k][2]);
  }
  return expansion_sign(&det);
}

/// The part of b - a that its rounded value d misses, exactly.
static double difference_tail(double b, double a, double d) {
  double a_part = b - d, b_part = d + a_part;
  return (b - b_part) + (a_part - a);
}

/// Determinant of the rounded differences `m` exactly, plus what their tails add to first order.
/// `size` is the sum of the six products' magnitudes. False where that does not settle the sign.
static bool orient3d_corrected(const double m[3][3], double tail[3][3], double size, int *sign) {
  Expansion det, minor;
  bool is_exact = true;
  double correction = 0;
  det.n = 0;
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    minor.n = 0;
    expansion_add_two_product(&minor, m[i][0], m[j][1]);
    expansion_add_two_product(&minor, -m[i][1], m[j][0]);
    for (int t = 0; t < minor.n; t++) expansion_add_two_product(&det, minor.term[t], m[k][2]);
    // cofactors of row k times its tails
    for (int c = 0; c < 3; c++) {
      int u = (c + 1) % 3, v = (c + 2) % 3;
      if (tail[k][c] == 0) continue;
      is_exact = false;
      correction += tail[k][c] * (m[i][u] * m[j][v] - m[i][v] * m[j][u]);
    }
  }
  *sign = expansion_sign(&det);
  if (is_exact) return true;
  double main_part = 0;
  for (int i = 0; i < det.n; i++) main_part += det.term[i];
  // second-order tails: 3 u^2 size; roundings in the correction: 9 terms of u size, 7 u each; in the sum: u
  double sum = main_part + correction;
  double bound = 100 * UNIT_ROUNDOFF * UNIT_ROUNDOFF * size + 4 * UNIT_ROUNDOFF * fabs(sum);
  *sign = sign_of(sum);
  return fabs(sum) > bound;
}

int lth_orient3d(const double a[3], const double b[3], const double c[3], const double d[3]) {
  double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
  double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
  double dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
  double cxdy = cx * dy, cydx = cy * dx, dxby = dx * by, dybx = dy * bx, bxcy = bx * cy,
         bycx = by * cx;
  double det = bz * (cxdy - cydx) + cz * (dxby - dybx) + dz * (bxcy - bycx);
  double size = fabs(bz) * (fabs(cxdy) + fabs(cydx)) + fabs(cz) * (fabs(dxby) + fabs(dybx)) +
                fabs(dz) * (fabs(bxcy) + fabs(bycx));
  // three differences, two products, a subtraction, two sums: |error| <= 8 u size to first order
  if (fabs(det) > 10 * UNIT_ROUNDOFF * size) return sign_of(det);
  if (size == 0) return 0;

  const double m[3][3] = {{bx, by, bz}, {cx, cy, cz}, {dx, dy, dz}}, *row[3] = {b, c, d};
  double tail[3][3];
  int sign = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) tail[i][j] = difference_tail(row[i][j], a[j], m[i][j]);
  if (orient3d_corrected(m, tail, size, &sign)) return sign;
  return orient3d_exact(a, b, c, d);
}

bool lth_collinear(const double a[3], const double b[3], const double c[3]) {
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3;
    double p[2] = {a[i], a[j]}, q[2] = {b[i], b[j]}, r[2] = {c[i], c[j]};
    if (lth_orient2d(p, q, r) != 0) return false;
  }
  return true;
}
