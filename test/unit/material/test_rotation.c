/// Rotations against LAPACK's singular values, for regular, inverted, flat and vanishing gradients.
#include "check.h"

#include "base/tensor.h"
#include "material/rotation.h"

#include <lapacke.h>
#undef I
#include <string.h>

static double normal(uint64_t *seed) { // Box-Muller
  double u = test_random(seed) + 0x1p-54, v = test_random(seed);
  return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}

static void random_matrix(uint64_t *seed, double A[9]) {
  for (int i = 0; i < 9; i++) A[i] = normal(seed);
}

/// Singular values and the nearest rotation U diag(1, 1, +-1) V^T.
static void svd_rotation(const double F[9], double s[3], double R[9]) {
  double A[9], U[9], Vt[9], work[3], UV[9];
  memcpy(A, F, sizeof A);
  assert_int_equal(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'A', 'A', 3, 3, A, 3, s, U, 3, Vt, 3, work), 0);
  lth_m3_mul(U, Vt, UV);
  if (lth_m3_det(UV) < 0)
    for (int i = 0; i < 3; i++) U[3 * i + 2] = -U[3 * i + 2];
  lth_m3_mul(U, Vt, R);
}

static double distance(const double A[9], const double B[9]) {
  double sum = 0;
  for (int i = 0; i < 9; i++) sum += (A[i] - B[i]) * (A[i] - B[i]);
  return sqrt(sum);
}

static void check_is_rotation(const double R[9]) {
  double T[9], P[9], I[9];
  lth_m3_transpose(R, T);
  lth_m3_mul(R, T, P);
  lth_m3_identity(I);
  CHECK_AT_MOST(distance(P, I), 1e-14);
  CHECK_NEAR(lth_m3_det(R), 1, 1e-14);
}

/// |F - R| is what R minimises; well defined also where R itself is not.
static void check_is_nearest(const double F[9]) {
  double s[3], want[9], R[9];
  svd_rotation(F, s, want);
  lth_rotation_nearest(F, R);
  check_is_rotation(R);
  double size = fmax(s[0], 1e-300);
  double gap = s[1] + s[2] * (lth_m3_det(F) < 0 ? -1 : 1); // conditioning of R
  CHECK_AT_MOST(distance(F, R), distance(F, want) + 1e-14 * (1 + size));
  if (gap > 1e-3 * size) CHECK_AT_MOST(distance(R, want), 2e-14 * size / gap);
}

static void random_gradients_give_the_nearest_rotation(void **state) {
  (void)state;
  uint64_t seed = 7;
  for (int k = 0; k < 4000; k++) {
    double F[9];
    random_matrix(&seed, F); // half of them inverted
    check_is_nearest(F);
  }
}

static void rotations_are_fixed_points(void **state) {
  (void)state;
  uint64_t seed = 11;
  for (int k = 0; k < 1000; k++) {
    double A[9], Q[9], R[9];
    random_matrix(&seed, A);
    lth_rotation_nearest(A, Q);
    lth_rotation_nearest(Q, R);
    CHECK_AT_MOST(distance(Q, R), 2e-15);
  }
}

static void stretched_gradients_of_any_size_are_accurate(void **state) {
  (void)state;
  uint64_t seed = 13;
  for (int k = 0; k < 2000; k++) {
    double A[9], B[9], U[9], V[9], T[9], F[9];
    random_matrix(&seed, A), random_matrix(&seed, B);
    lth_rotation_nearest(A, U), lth_rotation_nearest(B, V);
    double s[3] = {1, pow(10, -3 * test_random(&seed)), pow(10, -6 * test_random(&seed))};
    if (k % 2) s[2] = -s[2]; // inverted
    double size = pow(10, 200 * (test_random(&seed) - 0.5));
    for (int i = 0; i < 9; i++) T[i] = size * U[i] * s[i % 3];
    lth_m3_mul(T, V, F);
    double want[9], R[9];
    lth_m3_mul(U, V, want);
    lth_rotation_nearest(F, R);
    check_is_rotation(R);
    double gap = s[1] + s[2];
    if (gap > 1e-4) CHECK_AT_MOST(distance(R, want), 2e-14 / gap);
  }
}

static void inverted_gradients_give_a_proper_rotation(void **state) {
  (void)state;
  check_is_nearest((double[9]){-1, 0, 0, 0, 1, 0, 0, 0, 1});
  check_is_nearest((double[9]){-1, 0, 0, 0, -2, 0, 0, 0, -3});
  check_is_nearest((double[9]){0, 1, 0, 1, 0, 0, 0, 0, 1});
}

static void flat_and_line_gradients_are_answered(void **state) {
  (void)state;
  check_is_nearest((double[9]){1, 2, 0, -1, 3, 0, 0, 0, 0});
  check_is_nearest((double[9]){0, 0, 0, 0, 0, 2, 0, 0, 0});
  check_is_nearest((double[9]){1, 2, 3, 2, 4, 6, -1, -2, -3});
  check_is_nearest((double[9]){1e-200, 0, 0, 0, 1e-200, 0, 0, 0, 1e-206});
}

static void zero_and_infinite_gradients_give_the_identity(void **state) {
  (void)state;
  double I[9], R[9];
  lth_m3_identity(I);
  lth_rotation_nearest((double[9]){0}, R);
  CHECK_NEAR(distance(R, I), 0, 0);
  lth_rotation_nearest((double[9]){NAN, 1, 1}, R);
  CHECK_NEAR(distance(R, I), 0, 0);
  lth_rotation_nearest((double[9]){1, INFINITY, 1}, R);
  CHECK_NEAR(distance(R, I), 0, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_gradients_give_the_nearest_rotation),
      cmocka_unit_test(rotations_are_fixed_points),
      cmocka_unit_test(stretched_gradients_of_any_size_are_accurate),
      cmocka_unit_test(inverted_gradients_give_a_proper_rotation),
      cmocka_unit_test(flat_and_line_gradients_are_answered),
      cmocka_unit_test(zero_and_infinite_gradients_give_the_identity),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
