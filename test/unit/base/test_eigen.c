/// Small eigenproblems with known answers.
#include "check.h"

#include "base/eigen.h"

#include <string.h>

static void finds_the_spectrum_of_the_second_difference(void **state) {
  (void)state;
  enum { N = 20 };
  double A[N * N] = {0}, values[N];
  for (int i = 0; i < N; i++) {
    A[i * N + i] = 2;
    if (i > 0) A[i * N + i - 1] = A[(i - 1) * N + i] = -1;
  }
  lth_symmetric_eigen(N, A, values, NULL);
  for (int k = 0; k < N; k++)
    CHECK_NEAR(values[k], 2 - 2 * cos((k + 1) * acos(-1) / (N + 1)), 1e-14);
}

static void vectors_diagonalise_random_matrices(void **state) {
  (void)state;
  uint64_t seed = 1;
  for (int n = 1; n <= 12; n++) {
    double A[144], copy[144], values[12], V[144];
    for (int i = 0; i < n; i++)
      for (int j = 0; j <= i; j++) A[i * n + j] = A[j * n + i] = test_random(&seed) - 0.5;
    memcpy(copy, A, sizeof A);
    lth_symmetric_eigen(n, A, values, V);
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) {
        double AV = 0, VV = 0;
        for (int k = 0; k < n; k++)
          AV += copy[i * n + k] * V[k * n + j], VV += V[k * n + i] * V[k * n + j];
        CHECK_NEAR(AV, V[i * n + j] * values[j], 1e-14 * n);
        CHECK_NEAR(VV, i == j, 1e-14 * n);
        if (j > 0) CHECK_AT_MOST(values[j - 1], values[j]);
      }
  }
}

static void survives_zeros_and_equal_values(void **state) {
  (void)state;
  double zero[9] = {0}, ones[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1}, values[3];
  lth_symmetric_eigen(3, zero, values, NULL);
  for (int i = 0; i < 3; i++) CHECK_NEAR(values[i], 0, 0);
  lth_symmetric_eigen(3, ones, values, NULL);
  CHECK_NEAR(values[0], 0, 4e-16);
  CHECK_NEAR(values[1], 0, 4e-16);
  CHECK_NEAR(values[2], 3, 4e-15);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(finds_the_spectrum_of_the_second_difference),
      cmocka_unit_test(vectors_diagonalise_random_matrices),
      cmocka_unit_test(survives_zeros_and_equal_values),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
