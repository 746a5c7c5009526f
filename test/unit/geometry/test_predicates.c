/// Orientation predicates: right where doubles are not, symmetric, exact on constructed zeros.
#include "check.h"
#include "geometry/predicates.h"

/// On a lattice of neighbouring doubles the sign is that of exact integer arithmetic.
static void signs_on_neighbouring_doubles_are_exact(void **state) {
  (void)state;
  const double u = 0x1p-53;
  double b[2] = {12, 12}, c[2] = {24, 24};
  for (int i = 0; i < 64; i++)
    for (int j = 0; j < 64; j++) {
      // a = (1/2 + i u, 1/2 + j u): left of the diagonal where j > i
      double a[2] = {0.5 + i * u * 2, 0.5 + j * u * 2};
      assert_int_equal(lth_orient2d(a, b, c), (i > j) ? -1 : (i < j) ? 1 : 0);
    }
}

static void lifted_to_space_the_same(void **state) {
  (void)state;
  const double u = 0x1p-52;
  double b[3] = {12, 12, 0}, c[3] = {24, 24, 0}, d[3] = {5, 7, 1};
  for (int i = 0; i < 32; i++)
    for (int j = 0; j < 32; j++) {
      double a[3] = {0.5 + i * u, 0.5 + j * u, 0};
      assert_int_equal(lth_orient3d(a, b, c, d), (i > j) ? -1 : (i < j) ? 1 : 0);
    }
}

/// Differences below 2^20 keep the determinant below 6 x 2^60.
static int integer_orient3d(int64_t p[4][3]) {
  int64_t m[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) m[i][j] = p[i + 1][j] - p[0][j];
  int64_t det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return (det > 0) - (det < 0);
}

static void agrees_with_integers(void **state) {
  (void)state;
  uint64_t seed = 1;
  int zeros = 0;
  for (int n = 0; n < 20000; n++) {
    int64_t p[4][3];
    double x[4][3];
    // small lattices give many coplanar sets, large offsets make the filter fail
    int64_t range = n % 2 ? 3 : 1 << 20, offset = n % 3 ? 0 : (int64_t)1 << 30;
    for (int i = 0; i < 4; i++)
      for (int j = 0; j < 3; j++) {
        p[i][j] = (int64_t)(test_random(&seed) * (double)range) + offset;
        x[i][j] = (double)p[i][j] * 0x1p-40;
      }
    int want = integer_orient3d(p);
    zeros += want == 0;
    assert_int_equal(lth_orient3d(x[0], x[1], x[2], x[3]), want);
    assert_int_equal(lth_orient3d(x[1], x[0], x[2], x[3]), -want);
    assert_int_equal(lth_orient3d(x[1], x[2], x[0], x[3]), want);
    assert_int_equal(lth_orient3d(x[3], x[1], x[2], x[0]), -want);
  }
  assert_true(zeros > 1000);
}

/// d = a + s (b - a) + t (c - a) rounded: next to the plane, where doubles get signs wrong.
static void does_not_depend_on_the_order_of_points(void **state) {
  (void)state;
  uint64_t seed = 2;
  for (int n = 0; n < 5000; n++) {
    double x[4][3];
    double s = test_random(&seed), t = test_random(&seed);
    for (int j = 0; j < 3; j++) {
      for (int i = 0; i < 3; i++) x[i][j] = test_random(&seed) + 1000 * (n % 2);
      x[3][j] = x[0][j] + s * (x[1][j] - x[0][j]) + t * (x[2][j] - x[0][j]);
    }
    int want = lth_orient3d(x[0], x[1], x[2], x[3]);
    assert_int_equal(lth_orient3d(x[1], x[2], x[0], x[3]), want);
    assert_int_equal(lth_orient3d(x[2], x[0], x[1], x[3]), want);
    assert_int_equal(lth_orient3d(x[0], x[2], x[1], x[3]), -want);
    assert_int_equal(lth_orient3d(x[0], x[1], x[3], x[2]), -want);
    assert_int_equal(lth_orient3d(x[3], x[2], x[1], x[0]), want);
  }
}

static void points_of_a_line_are_collinear(void **state) {
  (void)state;
  double a[3] = {0.1, 0.2, 0.3}, b[3] = {0.2, 0.4, 0.6}, c[3] = {0.4, 0.8, 1.2};
  assert_true(lth_collinear(a, b, c));
  c[2] = nextafter(c[2], 2);
  assert_false(lth_collinear(a, b, c));
  assert_true(lth_collinear(a, a, c));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(signs_on_neighbouring_doubles_are_exact),
      cmocka_unit_test(lifted_to_space_the_same),
      cmocka_unit_test(agrees_with_integers),
      cmocka_unit_test(does_not_depend_on_the_order_of_points),
      cmocka_unit_test(points_of_a_line_are_collinear),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
