/// Cyclic Jacobi for small symmetric matrices. Golub and Van Loan, Matrix Computations, section 8.5.
#include "base/eigen.h"

#include <float.h>
#include <math.h>

enum { MAX_SWEEPS = 40 };

/// Rotate rows and columns p and q so that A[p][q] becomes 0.
static void rotate(int n, double *A, double *V, int p, int q) {
  double theta = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
  double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
  double c = 1 / sqrt(t * t + 1), s = t * c;
  A[p * n + p] -= t * A[p * n + q];
  A[q * n + q] += t * A[p * n + q];
  A[p * n + q] = A[q * n + p] = 0;
  for (int i = 0; i < n; i++) {
    if (i == p || i == q) continue;
    double ip = A[i * n + p], iq = A[i * n + q];
    A[i * n + p] = A[p * n + i] = c * ip - s * iq;
    A[i * n + q] = A[q * n + i] = s * ip + c * iq;
  }
  for (int i = 0; V && i < n; i++) {
    double ip = V[i * n + p], iq = V[i * n + q];
    V[i * n + p] = c * ip - s * iq;
    V[i * n + q] = s * ip + c * iq;
  }
}

static void sort_ascending(int n, double *values, double *V) {
  for (int i = 1; i < n; i++)
    for (int j = i; j > 0 && values[j] < values[j - 1]; j--) {
      double swap = values[j];
      values[j] = values[j - 1], values[j - 1] = swap;
      for (int k = 0; V && k < n; k++) {
        swap = V[k * n + j];
        V[k * n + j] = V[k * n + j - 1], V[k * n + j - 1] = swap;
      }
    }
}

void lth_symmetric_eigen(int n, double *A, double *values, double *vectors) {
  for (int i = 0; vectors && i < n * n; i++) vectors[i] = i % (n + 1) == 0;
  for (int sweep = 0, rotated = 1; rotated && sweep < MAX_SWEEPS; sweep++) {
    rotated = 0;
    for (int p = 0; p < n; p++)
      for (int q = p + 1; q < n; q++) {
        double limit = DBL_EPSILON * sqrt(fabs(A[p * n + p])) * sqrt(fabs(A[q * n + q]));
        if (!(fabs(A[p * n + q]) > 0.25 * limit + DBL_MIN)) continue;
        rotate(n, A, vectors, p, q);
        rotated = 1;
      }
  }
  for (int i = 0; i < n; i++) values[i] = A[i * n + i];
  sort_ascending(n, values, vectors);
}
