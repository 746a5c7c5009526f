/// Nearest boundary points: on the boundary, along the normal, nearest among many.
#include "check.h"

#include "base/tensor.h"
#include "geometry/shape_foot.h"

#define SCALE 0.1

static double ellipsoid(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return x[0] * x[0] / 4 + x[1] * x[1] + x[2] * x[2] - 1;
}

/// Points around the box [-1.4, 1.4]^3, the same in every run.
static void place(int i, double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = 1.4 * sin(1.7 * i + 2.1 * a + 0.3 * a * i);
}

/// On the boundary; x lies on the normal through it; the sign is that of the shape's value.
static void check_foot(const LthShape *shape, const double x[3], double tolerance) {
  LthFoot foot;
  double back[3];
  assert_true(lth_shape_foot(shape, x, SCALE, &foot));
  assert_true(fabs(lth_shape_value(shape, foot.point)) < tolerance);
  assert_true(fabs(lth_v3_norm(foot.normal) - 1) < 1e-12);
  lth_v3_copy(foot.point, back);
  lth_v3_axpy(foot.distance, foot.normal, back);
  assert_true(lth_v3_distance(back, x) < 1e3 * tolerance);
  assert_true(lth_shape_value(shape, x) * foot.distance >= 0);
}

static void test_feet_of_primitives_lie_on_the_normal_through_x(void **state) {
  (void)state;
  const LthShape shapes[] = {
      {.kind = LTH_SHAPE_BOX, .a = {-1, -.5, -.7}, .b = {.9, .8, .6}},
      {.kind = LTH_SHAPE_SPHERE, .a = {.1, .2, .3}, .radius = 0.9},
      {.kind = LTH_SHAPE_SHELL, .a = {.1, 0, 0}, .radius = 1.1, .inner = .6},
      {.kind = LTH_SHAPE_CAPSULE, .a = {-.5, 0, 0}, .b = {.5, .2, 0}, .radius = .4}};
  for (int s = 0; s < 4; s++)
    for (int i = 0; i < 50; i++) {
      double x[3];
      place(i, x);
      check_foot(shapes + s, x, 1e-9);
    }
}

static void test_the_foot_on_a_combination_lies_on_the_boundary_of_all(void **state) {
  (void)state;
  LthShape parts[] = {{.kind = LTH_SHAPE_BOX, .a = {-1, -1, -1}, .b = {1, 1, 1}},
                      {.kind = LTH_SHAPE_SPHERE, .a = {1, 0, 0}, .radius = .6}};
  LthShape cut = {.kind = LTH_SHAPE_DIFFERENCE, .children = parts, .n_children = 2};
  double near_hole[3] = {.3, .1, 0}, near_side[3] = {-.9, .2, .1}, at_mouth[3] = {1.1, .1, 0};
  LthFoot foot;
  assert_true(lth_shape_foot(&cut, near_hole, SCALE, &foot));
  assert_true(fabs(lth_v3_distance(foot.point, parts[1].a) - .6) < 1e-12);
  assert_true(foot.distance < 0);
  assert_true(foot.normal[0] > 0.9); // into the hole
  assert_true(lth_shape_foot(&cut, near_side, SCALE, &foot));
  assert_true(fabs(foot.point[0] + 1) < 1e-12 && foot.normal[0] < -0.99);
  // the box has no side in the mouth of the hole
  assert_true(lth_shape_foot(&cut, at_mouth, SCALE, &foot));
  assert_true(fabs(lth_shape_value(&cut, foot.point)) < 1e-6);
}

static void test_root_finding_ends_on_the_boundary_of_an_implicit_shape(void **state) {
  (void)state;
  LthShape shape = {
      .kind = LTH_SHAPE_IMPLICIT, .value = {.eval = ellipsoid}, .box = {-9, -9, -9, 9, 9, 9}};
  for (int i = 0; i < 20; i++) {
    LthFoot foot;
    double x[3], length;
    place(i, x);
    // within a cell of the boundary
    length = sqrt(x[0] * x[0] / 4 + x[1] * x[1] + x[2] * x[2]);
    lth_v3_scale((1 + 0.04 * (i % 3 - 1)) / length, x);
    assert_true(lth_shape_foot(&shape, x, SCALE, &foot));
    assert_true(fabs(ellipsoid(NULL, foot.point, 0)) < 1e-6);
    double normal[3] = {foot.point[0] / 4, foot.point[1], foot.point[2]};
    lth_v3_normalize(normal);
    assert_true(lth_v3_dot(normal, foot.normal) > 1 - 1e-6);
    assert_true(fabs(foot.distance) < 0.12);
  }
}

static void test_a_shape_that_is_far_away_has_no_foot(void **state) {
  (void)state;
  LthShape shape = {.kind = LTH_SHAPE_CYLINDER, .a = {0, 0, 0}, .b = {1, 0, 0}, .radius = .1};
  double x[3] = {200, 0, 0};
  LthFoot foot;
  assert_false(lth_shape_foot(&shape, x, SCALE, &foot));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_feet_of_primitives_lie_on_the_normal_through_x),
      cmocka_unit_test(test_the_foot_on_a_combination_lies_on_the_boundary_of_all),
      cmocka_unit_test(test_root_finding_ends_on_the_boundary_of_an_implicit_shape),
      cmocka_unit_test(test_a_shape_that_is_far_away_has_no_foot)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
