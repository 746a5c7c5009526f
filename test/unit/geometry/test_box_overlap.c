/// Overlaps of boxes with shapes: against closed forms, additive, and the same whichever way the axes lie.
#include "check.h"

#include "base/tensor.h"
#include "geometry/box_overlap.h"

static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.1, -0.2, 0.05}, .radius = 0.83};
static const LthShape shell = {
    .kind = LTH_SHAPE_SHELL, .a = {0.1, -0.2, 0.05}, .radius = 0.83, .inner = 0.6};
static const LthShape upright = {
    .kind = LTH_SHAPE_CYLINDER, .a = {0.1, 0, -0.5}, .b = {0.1, 0, 0.6}, .radius = 0.5};
static const LthShape can = {
    .kind = LTH_SHAPE_CYLINDER, .a = {-0.4, 0.3, -0.2}, .b = {0.4, -0.3, 0.6}, .radius = 0.35};
static const LthShape pill = {
    .kind = LTH_SHAPE_CAPSULE, .a = {-0.4, 0.3, -0.2}, .b = {0.4, -0.3, 0.6}, .radius = 0.35};
static const LthShape *const shapes[] = {&ball, &shell, &upright, &can, &pill};

static double closed_form(const LthShape *s) {
  double r = s->radius, length = lth_v3_distance(s->a, s->b), ball_part = 4 * M_PI / 3 * r * r * r;
  switch (s->kind) {
  case LTH_SHAPE_SPHERE:
    return ball_part;
  case LTH_SHAPE_SHELL:
    return ball_part - 4 * M_PI / 3 * pow(s->inner, 3);
  case LTH_SHAPE_CYLINDER:
    return M_PI * r * r * length;
  default:
    return M_PI * r * r * length + ball_part;
  }
}

static double overlap(const LthShape *s, const double low[3], const double high[3]) {
  double volume = NAN;
  assert_true(lth_box_overlap(s, low, high, &volume));
  return volume;
}

static void boxes_of_a_grid_sum_up_to_the_closed_form(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++) {
    int n = 9;
    double sum = 0, h = 2.6 / n;
    for (int c = 0; c < n * n * n; c++) {
      double low[3] = {-1.3 + h * (c % n), -1.3 + h * (c / n % n), -1.3 + h * (c / n / n)};
      double high[3] = {low[0] + h, low[1] + h, low[2] + h}, part = overlap(shapes[k], low, high);
      CHECK_AT_LEAST(part, -1e-9 * h * h * h);
      CHECK_AT_MOST(part, h * h * h * (1 + 1e-9));
      sum += part;
    }
    CHECK_NEAR(sum, closed_form(shapes[k]), 1e-8 * h * h * h);
  }
}

static void halves_of_a_box_sum_up_to_the_box(void **state) {
  (void)state;
  uint64_t seed = 7;
  for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++)
    for (int trial = 0; trial < 200; trial++) {
      double low[3], high[3], middle_low[3], middle_high[3], all = 1;
      int axis = trial % 3;
      for (int a = 0; a < 3; a++) {
        low[a] = 2.2 * test_random(&seed) - 1.1;
        high[a] = low[a] + 0.02 + 0.08 * test_random(&seed);
        all *= high[a] - low[a];
      }
      lth_v3_copy(low, middle_low);
      lth_v3_copy(high, middle_high);
      middle_low[axis] = middle_high[axis] = low[axis] + 0.37 * (high[axis] - low[axis]);
      CHECK_NEAR(overlap(shapes[k], low, middle_high) + overlap(shapes[k], middle_low, high),
                 overlap(shapes[k], low, high), 1e-9 * all);
    }
}

/// The same shape and box with x, y, z renamed.
static void turn(const double x[3], double to[3]) {
  for (int a = 0; a < 3; a++) to[a] = x[(a + 1) % 3];
}

static void axes_may_be_renamed(void **state) {
  (void)state;
  uint64_t seed = 11;
  for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++)
    for (int trial = 0; trial < 100; trial++) {
      double low[3], high[3], turned_low[3], turned_high[3], all = 1;
      LthShape turned = *shapes[k];
      turn(shapes[k]->a, turned.a);
      turn(shapes[k]->b, turned.b);
      for (int a = 0; a < 3; a++) {
        low[a] = 2 * test_random(&seed) - 1;
        high[a] = low[a] + 0.1 * test_random(&seed);
        all *= high[a] - low[a];
      }
      turn(low, turned_low);
      turn(high, turned_high);
      CHECK_NEAR(overlap(&turned, turned_low, turned_high), overlap(shapes[k], low, high),
                 1e-9 * all);
    }
}

static void an_eighth_of_a_ball_fills_its_corner(void **state) {
  (void)state;
  LthShape unit = {.kind = LTH_SHAPE_SPHERE, .radius = 1};
  CHECK_NEAR(overlap(&unit, (double[3]){0, 0, 0}, (double[3]){2, 2, 2}), M_PI / 6, 1e-11);
  CHECK_NEAR(overlap(&unit, (double[3]){0, 0, 0.5}, (double[3]){2, 2, 2}),
             M_PI / 3 * 0.25 * 2.5 / 4, 1e-11); // a quarter of a cap
}

static void planes_cut_boxes_like_corners_of_tetrahedra(void **state) {
  (void)state;
  double half[3] = {0.5, 1, 2}, n[3] = {0.6, 0.48, 0.64};
  // the corner below a plane that cuts all three edges: a b c / 6
  double depth = 0.3, reach = 0.6 * 0.5 + 0.48 * 1 + 0.64 * 2;
  double corner = depth / 0.6 * depth / 0.48 * depth / 0.64 / 6 / (1 * 2 * 4);
  CHECK_NEAR(lth_box_overlap_plane(half, n, reach - depth), corner, 1e-15);
  CHECK_NEAR(lth_box_overlap_plane(half, n, depth - reach), 1 - corner, 1e-14);
  CHECK_NEAR(lth_box_overlap_plane(half, n, 0), 0.5, 1e-14);
  CHECK_NEAR(lth_box_overlap_plane(half, (double[3]){0, 0, 1}, 0.5), 0.375, 1e-15);
  CHECK_NEAR(lth_box_overlap_plane(half, (double[3]){1e-7, 0, 1}, 0.5), 0.375, 1e-6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(boxes_of_a_grid_sum_up_to_the_closed_form),
      cmocka_unit_test(halves_of_a_box_sum_up_to_the_box),
      cmocka_unit_test(axes_may_be_renamed),
      cmocka_unit_test(an_eighth_of_a_ball_fills_its_corner),
      cmocka_unit_test(planes_cut_boxes_like_corners_of_tetrahedra),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
