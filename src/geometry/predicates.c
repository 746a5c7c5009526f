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

/// x += sign * a * b
static void expansion_add_product(Expansion *x, double sign, const Expansion *a,
                                  const Expansion *b) {
  for (int i = 0; i < a->n; i++)
    for (int j = 0; j < b->n; j++) {
      double product = a->term[i] * b->term[j];
      double error = fma(a->term[i], b->term[j], -product);
      expansion_add(x, sign * error);
      expansion_add(x, sign * product);
    }
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
  Expansion acx, acy, bcx, bcy, det = {0};
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
  Expansion m[3][3], det = {0};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) expansion_difference(&m[i][j], row[i][j], a[j]);
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    Expansion minor = {0};
    expansion_add_product(&minor, 1, &m[i][0], &m[j][1]);
    expansion_add_product(&minor, -1, &m[i][1], &m[j][0]);
    expansion_add_product(&det, 1, &minor, &m[k][2]);
  }
  return expansion_sign(&det);
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
