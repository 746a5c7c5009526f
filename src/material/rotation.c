/// Polar rotation of a 3x3 matrix. Higham, "Computing the polar decomposition - with applications",
/// SIAM J. Sci. Stat. Comput. 7 (1986); Horn, "Closed-form solution of absolute orientation using unit
/// quaternions", J. Opt. Soc. Am. A 4 (1987).
#include "material/rotation.h"

#include "base/eigen.h"
#include "base/tensor.h"

#include <stdbool.h>

#define NEWTON_MAX 20
/// Below this det F / |F|^3 Newton's inverses lose digits, and below 0 it goes to a reflection.
#define NEWTON_MIN_DET 1e-6

static double frobenius(const double A[9]) {
  double sum = 0;
  for (int i = 0; i < 9; i++) sum += A[i] * A[i];
  return sqrt(sum);
}

/// X <- (g X + X^-T / g) / 2 until it stands still, g = sqrt(|X^-1| / |X|): quadratic, 5 to 8 rounds.
static void newton_polar(const double F[9], double R[9]) {
  memcpy(R, F, 9 * sizeof *R);
  bool scaled = true;
  for (int round = 0; round < NEWTON_MAX; round++) {
    double C[9], change = 0;
    lth_m3_cofactor(R, C);
    double det = lth_v3_dot(R, C);
    double size = frobenius(R), inverse_size = frobenius(C) / det;
    double g = scaled ? sqrt(inverse_size / size) : 1;
    for (int i = 0; i < 9; i++) {
      double next = 0.5 * (g * R[i] + C[i] / (g * det));
      change += (next - R[i]) * (next - R[i]);
      R[i] = next;
    }
    // near the end scaling only adds rounding; the error after a step of size s is about s^2 / 2
    if (change < 1e-4) scaled = false;
    if (change < 1e-18) return;
  }
}

/// The unit quaternion (w, x, y, z) that maximises R(q) : F.
static void horn_quaternion(const double F[9], double q[4]) {
  double N[16] = {
      F[0] + F[4] + F[8], F[7] - F[5],        F[2] - F[6],         F[3] - F[1],
      F[7] - F[5],        F[0] - F[4] - F[8], F[1] + F[3],         F[2] + F[6],
      F[2] - F[6],        F[1] + F[3],        -F[0] + F[4] - F[8], F[5] + F[7],
      F[3] - F[1],        F[2] + F[6],        F[5] + F[7],         -F[0] - F[4] + F[8],
  };
  double value[4], V[16];
  lth_symmetric_eigen(4, N, value, V);
  for (int i = 0; i < 4; i++) q[i] = V[4 * i + 3];
  double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; i++) q[i] /= length;
}

static void quaternion_matrix(const double q[4], double R[9]) {
  double w = q[0], x = q[1], y = q[2], z = q[3];
  R[0] = 1 - 2 * (y * y + z * z), R[1] = 2 * (x * y - w * z), R[2] = 2 * (x * z + w * y);
  R[3] = 2 * (x * y + w * z), R[4] = 1 - 2 * (x * x + z * z), R[5] = 2 * (y * z - w * x);
  R[6] = 2 * (x * z - w * y), R[7] = 2 * (y * z + w * x), R[8] = 1 - 2 * (x * x + y * y);
}

void lth_rotation_nearest(const double F[9], double R[9]) {
  // to unit size, so that no product over- or underflows
  double largest = 0, A[9];
  for (int i = 0; i < 9; i++) largest = fmax(largest, fabs(F[i]));
  if (!(largest > 0)) {
    lth_m3_identity(R);
    return;
  }
  for (int i = 0; i < 9; i++) A[i] = F[i] / largest;

  double size = frobenius(A);
  if (!isfinite(size)) {
    lth_m3_identity(R);
    return;
  }
  if (lth_m3_det(A) > NEWTON_MIN_DET * size * size * size) {
    newton_polar(A, R);
  } else {
    double q[4];
    horn_quaternion(A, q);
    quaternion_matrix(q, R);
  }
}
