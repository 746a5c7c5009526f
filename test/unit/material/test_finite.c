/// Finite solids: derivatives by differences, invariance, Lame's constants at every rotation, definite tangents.
#include "check.h"

#include "base/eigen.h"
#include "base/tensor.h"
#include "material/finite.h"
#include "material/rotation.h"

#include <string.h>

#define STEP 1e-4

static const LthMaterialModel models[] = {LTH_MATERIAL_COROTATED, LTH_MATERIAL_NEO_HOOKEAN};

/// I + size times random numbers.
static void random_gradient(uint64_t *seed, int dim, double size, double *F) {
  for (int i = 0; i < dim * dim; i++)
    F[i] = (i % (dim + 1) == 0) + size * (2 * test_random(seed) - 1);
}

static void random_turn(uint64_t *seed, int dim, double *R) {
  double A[9];
  for (int i = 0; i < 9; i++) A[i] = 2 * test_random(seed) - 1;
  if (dim == 3) {
    lth_rotation_nearest(A, R);
    return;
  }
  R[0] = R[3] = cos(7 * A[0]), R[2] = sin(7 * A[0]), R[1] = -R[2];
}

static void multiply(int dim, const double *A, const double *B, double *C) {
  for (int i = 0; i < dim; i++)
    for (int j = 0; j < dim; j++) {
      C[i * dim + j] = 0;
      for (int k = 0; k < dim; k++) C[i * dim + j] += A[i * dim + k] * B[k * dim + j];
    }
}

/// True where both sums of neighbouring stretches are well away from zero, so that R is smooth.
static bool is_smooth(const LthFinite *m, const double *F) {
  double v, P[9], R[9];
  LthFinite turning = {.model = LTH_MATERIAL_COROTATED, .dim = m->dim, .mu = 1};
  lth_finite_stress(&turning, F, &v, P, R);
  double S[9] = {0}, s[3];
  for (int i = 0; i < m->dim; i++)
    for (int j = 0; j < m->dim; j++)
      for (int k = 0; k < m->dim; k++)
        S[i * m->dim + j] +=
            0.5 * (R[k * m->dim + i] * F[k * m->dim + j] + R[k * m->dim + j] * F[k * m->dim + i]);
  lth_symmetric_eigen(m->dim, S, s, NULL);
  return s[0] + s[1] > 0.1;
}

/// Every model, dimension and set of loose shears, at gradients from small to inverted.
static void for_all(void (*check)(const LthFinite *m, const double *F, uint64_t *seed)) {
  uint64_t seed = 5;
  static const unsigned loose[2][4] = {{0, 4, 0, 4}, {0, 4, 3, 7}};
  for (int k = 0; k < 2 * 2 * 4 * 40; k++) {
    double F[9];
    LthFinite m = {models[k % 2], 2 + k / 2 % 2, 0.7, loose[k / 2 % 2][k / 4 % 4]};
    random_gradient(&seed, m.dim, 0.03 * (1 + k / 16), F);
    if (is_smooth(&m, F)) check(&m, F, &seed);
  }
}

static void check_stress(const LthFinite *m, const double *F, uint64_t *seed) {
  double P[9], G[9], v, A[9];
  (void)seed;
  lth_finite_stress(m, F, &v, P, G);
  for (int i = 0; i < m->dim * m->dim; i++) {
    double psi[4], vol[4];
    static const double at[4] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
      memcpy(A, F, sizeof A);
      A[i] += at[k] * STEP;
      psi[k] = lth_finite_energy(m, A, &vol[k]);
    }
    // fourth order: the error is the fifth derivative times STEP^4 and rounding over STEP
    CHECK_NEAR((psi[0] - 8 * psi[1] + 8 * psi[2] - psi[3]) / (12 * STEP), P[i], 1e-9);
    CHECK_NEAR((vol[0] - 8 * vol[1] + 8 * vol[2] - vol[3]) / (12 * STEP), G[i], 1e-9);
  }
}

static void stress_is_the_slope_of_the_energy(void **state) {
  (void)state;
  for_all(check_stress);
}

static void check_tangent(const LthFinite *m, const double *F, uint64_t *seed) {
  const int n = m->dim * m->dim;
  double H[81], p = 3 * (test_random(seed) - 0.5), v;
  lth_finite_tangent(m, F, p, false, H);
  for (int i = 0; i < n; i++) {
    double A[9], P[4][9], G[4][9];
    static const double at[4] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
      memcpy(A, F, sizeof A);
      A[i] += at[k] * STEP;
      lth_finite_stress(m, A, &v, P[k], G[k]);
      for (int j = 0; j < n; j++) P[k][j] += p * G[k][j];
    }
    for (int j = 0; j < n; j++)
      CHECK_NEAR((P[0][j] - 8 * P[1][j] + 8 * P[2][j] - P[3][j]) / (12 * STEP), H[j * n + i], 1e-7);
  }
}

static void tangent_is_the_slope_of_the_stress(void **state) {
  (void)state;
  for_all(check_tangent);
}

static void check_definite(const LthFinite *m, const double *F, uint64_t *seed) {
  const int n = m->dim * m->dim;
  double H[81], D[81], A[81], value[9], V[81], p = 8 * (test_random(seed) - 0.5);
  lth_finite_tangent(m, F, p, false, H);
  lth_finite_tangent(m, F, p, true, D);
  memcpy(A, H, sizeof A);
  lth_symmetric_eigen(n, A, value, V);
  double size = fmax(fabs(value[0]), fabs(value[n - 1]));
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double want = 0;
      for (int k = 0; k < n; k++) want += fmax(value[k], 0) * V[i * n + k] * V[j * n + k];
      CHECK_NEAR(D[i * n + j], want, 1e-12 * size);
    }
}

static void definite_tangent_is_the_nearest_semidefinite_one(void **state) {
  (void)state;
  for_all(check_definite);
}

static void check_invariance(const LthFinite *m, const double *F, uint64_t *seed) {
  double R[9], RF[9], P[9], G[9], RP[9], P2[9], v, v2;
  random_turn(seed, m->dim, R);
  multiply(m->dim, R, F, RF);
  CHECK_NEAR(lth_finite_energy(m, RF, &v2), lth_finite_energy(m, F, &v), 1e-12);
  CHECK_NEAR(v2, v, 1e-12);
  lth_finite_stress(m, F, &v, P, G);
  lth_finite_stress(m, RF, &v2, P2, G);
  multiply(m->dim, R, P, RP);
  for (int i = 0; i < m->dim * m->dim; i++) CHECK_NEAR(P2[i], RP[i], 1e-12);
}

static void turning_changes_no_energy_and_turns_the_stress(void **state) {
  (void)state;
  for_all(check_invariance);
}

/// 2 mu e : e, shears that are loose left out, is d2 psi at a rotation; dv is the trace.
static void every_rotation_has_lames_constants(void **state) {
  (void)state;
  uint64_t seed = 9;
  for (int k = 0; k < 200; k++) {
    LthFinite m = {models[k % 2], 2 + k / 2 % 2, 1.3, 0};
    const int d = m.dim, n = d * d;
    m.loose = d == 3 ? (unsigned)(k / 4 % 8) : k / 4 % 2 ? 4 : 0;
    double R[9], B[9], A[9], RA[9], P[9], G[9], H[81], v, trace = 0, want = 0, got = 0, slope = 0;
    random_turn(&seed, d, R);
    for (int i = 0; i < n; i++) A[i] = test_random(&seed) - 0.5;
    multiply(d, R, A, RA);
    lth_finite_stress(&m, R, &v, P, G);
    lth_finite_tangent(&m, R, 0, true, H);
    for (int i = 0; i < d; i++)
      for (int j = 0; j < d; j++) {
        double e = 0.5 * (A[i * d + j] + A[j * d + i]);
        bool is_loose = i != j && m.loose >> (3 - i - j) & 1;
        if (!is_loose) want += 2 * m.mu * e * e;
        trace += i == j ? e : 0;
      }
    for (int i = 0; i < n; i++) {
      CHECK_NEAR(P[i], 0, 1e-14);
      slope += G[i] * RA[i];
      B[i] = 0;
      for (int j = 0; j < n; j++) B[i] += H[i * n + j] * RA[j];
      got += RA[i] * B[i];
    }
    CHECK_NEAR(v, 0, 1e-14);
    CHECK_NEAR(slope, trace, 1e-14);
    CHECK_NEAR(got, want, 1e-13);
  }
}

static void small_strains_keep_their_digits(void **state) {
  (void)state;
  uint64_t seed = 3;
  for (int k = 0; k < 40; k++) {
    LthFinite m = {models[k % 2], 2 + k / 2 % 2, 1, 0};
    const int d = m.dim, n = d * d;
    double R[9], A[9], F[9], v, want = 0, E[9];
    random_turn(&seed, d, R);
    for (int i = 0; i < n; i++) A[i] = 1e-7 * (test_random(&seed) - 0.5);
    for (int i = 0; i < n; i++) F[i] = (i % (d + 1) == 0) + A[i];
    for (int i = 0; i < d; i++)
      for (int j = 0; j < d; j++) {
        E[i * d + j] = 0.5 * (A[i * d + j] + A[j * d + i]);
        want += E[i * d + j] * E[i * d + j];
      }
    // third order in the strain, and twice its rounding
    CHECK_NEAR(lth_finite_energy(&m, F, &v), want, 1e-6 * want);
  }
}

static void inversion_is_pushed_back(void **state) {
  (void)state;
  for (int k = 0; k < 4; k++) {
    LthFinite m = {models[k % 2], 2 + k / 2, 1, 0};
    const int d = m.dim;
    for (double s = 0.9; s > -2; s -= 0.1) { // one stretch from 1 through 0 to the other side
      double F[9] = {0}, P[9], G[9], v;
      for (int i = 0; i < d; i++) F[i * d + i] = i ? 1 : s;
      lth_finite_stress(&m, F, &v, P, G);
      double lambda = 2; // P of all of W
      if (s > -0.9) CHECK_AT_MOST(P[0] + lambda * v * G[0], 0);
      for (int i = 0; i < d * d; i++) assert_true(isfinite(P[i] + G[i]));
    }
  }
}

static void collapse_to_a_point_is_answered(void **state) {
  (void)state;
  for (int k = 0; k < 16; k++) {
    LthFinite m = {models[k % 2], 2 + k / 2 % 2, 1, k / 4 % 2 ? 4 : 0};
    double F[9] = {k < 8}, H[81], P[9], G[9], v;
    const int n = m.dim * m.dim;
    lth_finite_stress(&m, F, &v, P, G);
    lth_finite_tangent(&m, F, -1, true, H);
    for (int i = 0; i < n; i++) assert_true(isfinite(P[i]) && isfinite(H[i * n + i]));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stress_is_the_slope_of_the_energy),
      cmocka_unit_test(tangent_is_the_slope_of_the_stress),
      cmocka_unit_test(definite_tangent_is_the_nearest_semidefinite_one),
      cmocka_unit_test(turning_changes_no_energy_and_turns_the_stress),
      cmocka_unit_test(every_rotation_has_lames_constants),
      cmocka_unit_test(small_strains_keep_their_digits),
      cmocka_unit_test(inversion_is_pushed_back),
      cmocka_unit_test(collapse_to_a_point_is_answered),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
