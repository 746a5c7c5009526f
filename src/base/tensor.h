/// Vectors of three and row-major 3x3 matrices: pure inline functions, no allocation.
#pragma once

#include <math.h>
#include <string.h>

static inline double lth_v3_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double lth_v3_norm(const double a[3]) { return sqrt(lth_v3_dot(a, a)); }

static inline void lth_v3_copy(const double a[3], double r[3]) { memcpy(r, a, 3 * sizeof *r); }

static inline void lth_v3_sub(const double a[3], const double b[3], double r[3]) {
  for (int i = 0; i < 3; i++) r[i] = a[i] - b[i];
}

static inline void lth_v3_add(const double a[3], const double b[3], double r[3]) {
  for (int i = 0; i < 3; i++) r[i] = a[i] + b[i];
}

/// r += s a
static inline void lth_v3_axpy(double s, const double a[3], double r[3]) {
  for (int i = 0; i < 3; i++) r[i] += s * a[i];
}

static inline void lth_v3_scale(double s, double r[3]) {
  for (int i = 0; i < 3; i++) r[i] *= s;
}

/// r = a x b; r may not alias a or b.
static inline void lth_v3_cross(const double a[3], const double b[3], double r[3]) {
  r[0] = a[1] * b[2] - a[2] * b[1];
  r[1] = a[2] * b[0] - a[0] * b[2];
  r[2] = a[0] * b[1] - a[1] * b[0];
}

/// a b - c d to rounding of itself (Kahan).
static inline double lth_difference_of_products(double a, double b, double c, double d) {
  double w = c * d, rest = fma(-c, d, w);
  return fma(a, b, -w) + rest;
}

/// r = a x b to rounding of itself, also where both are nearly along one line: the plain product has rounding of the
/// product of their lengths there. r may not alias a or b.
static inline void lth_v3_cross_sharp(const double a[3], const double b[3], double r[3]) {
  lth_v3_cross(a, b, r);
  if (lth_v3_dot(r, r) > 1e-2 * lth_v3_dot(a, a) * lth_v3_dot(b, b)) return;
  r[0] = lth_difference_of_products(a[1], b[2], a[2], b[1]);
  r[1] = lth_difference_of_products(a[2], b[0], a[0], b[2]);
  r[2] = lth_difference_of_products(a[0], b[1], a[1], b[0]);
}

/// Divide by the length and return it; a zero vector stays as it is.
static inline double lth_v3_normalize(double r[3]) {
  double length = lth_v3_norm(r);
  if (length > 0) lth_v3_scale(1 / length, r);
  return length;
}

static inline double lth_v3_distance(const double a[3], const double b[3]) {
  double d[3];
  lth_v3_sub(a, b, d);
  return lth_v3_norm(d);
}

static inline void lth_m3_identity(double R[9]) {
  for (int i = 0; i < 9; i++) R[i] = i % 4 == 0;
}

/// r = A x; r may not alias x.
static inline void lth_m3_apply(const double A[9], const double x[3], double r[3]) {
  for (int i = 0; i < 3; i++) r[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

/// r = A^T x; r may not alias x.
static inline void lth_m3_apply_t(const double A[9], const double x[3], double r[3]) {
  for (int i = 0; i < 3; i++) r[i] = A[i] * x[0] + A[3 + i] * x[1] + A[6 + i] * x[2];
}

/// C = A B; C may not alias A or B.
static inline void lth_m3_mul(const double A[9], const double B[9], double C[9]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

static inline void lth_m3_transpose(const double A[9], double T[9]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) T[3 * i + j] = A[3 * j + i];
}

static inline double lth_m3_det(const double A[9]) {
  return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) +
         A[2] * (A[3] * A[7] - A[4] * A[6]);
}

/// C = det(A) A^-T; C may not alias A.
static inline void lth_m3_cofactor(const double A[9], double C[9]) {
  lth_v3_cross(A + 3, A + 6, C);
  lth_v3_cross(A + 6, A, C + 3);
  lth_v3_cross(A, A + 3, C + 6);
}

/// B = A^-1; B may not alias A. Rows (or columns) of any sizes cost no accuracy.
static inline void lth_m3_inverse(const double A[9], double B[9]) {
  double C[9], det = lth_m3_det(A);
  lth_m3_cofactor(A, C);
  for (int i = 0; i < 9; i++) B[i] = C[3 * (i % 3) + i / 3] / det;
}

/// R turns by `angle` [rad] about the unit vector `axis` (Rodrigues): cos I + (1 - cos) a a^T + sin [a]x.
static inline void lth_m3_rotation(const double axis[3], double angle, double R[9]) {
  double c = cos(angle), s = sin(angle);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) R[3 * i + j] = (1 - c) * axis[i] * axis[j] + (i == j ? c : 0);
  R[1] -= s * axis[2], R[2] += s * axis[1];
  R[3] += s * axis[2], R[5] -= s * axis[0];
  R[6] -= s * axis[1], R[7] += s * axis[0];
}
