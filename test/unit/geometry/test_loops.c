/// Polygons with holes: distance, area in boxes, and what is refused.
#include "check.h"
#include "geometry/shape.h"

#include <string.h>

/// A number in [0, 1) that differs from call to call in the same way in every run.
static double noise(void) {
  static uint32_t state = 12345;
  state = state * 1664525u + 1013904223u;
  return state / 4294967296.0;
}

#define STAR 37

/// A star with a hole of the same kind: not convex, no side along the axes.
static LthLoops *make_star(LitheCtx *ctx) {
  double points[4 * STAR];
  const LitheIndex first[3] = {0, STAR, 2 * STAR};
  for (int i = 0; i < 2 * STAR; i++) {
    double angle = 2 * M_PI * i / STAR, r = i < STAR ? 1 : 0.3;
    r *= i % 2 ? 0.7 : 1;
    points[2 * i] = 0.1 + r * cos(angle);
    points[2 * i + 1] = -0.2 + r * sin(angle);
  }
  LthLoops *loops = NULL;
  CHECK_OK(ctx, lth_loops_create(ctx, 2, first, points, &loops));
  return loops;
}

static double segment_distance(const double *p, const double *q, const double *x) {
  double dx = q[0] - p[0], dy = q[1] - p[1];
  double s = ((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / (dx * dx + dy * dy);
  s = fmin(fmax(s, 0), 1);
  return hypot(x[0] - p[0] - s * dx, x[1] - p[1] - s * dy);
}

/// Every edge looked at; the sign by the edges right of x.
static double plain_distance(const LthLoops *l, const double *x) {
  double best = INFINITY;
  bool inside = false;
  for (LitheIndex i = 0; i < l->n_points; i++) {
    const double *p = l->points + 2 * i, *q = l->points + 2 * l->next[i];
    best = fmin(best, segment_distance(p, q, x));
    if ((p[1] > x[1]) == (q[1] > x[1])) continue;
    if (p[0] + (x[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) > x[0]) inside = !inside;
  }
  return inside ? -best : best;
}

static void distances_are_those_to_the_nearest_edge(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthLoops *l = make_star(ctx);
  for (int k = 0; k < 2000; k++) {
    double x[2] = {3 * noise() - 1.5, 3 * noise() - 1.5}, q[2], n[2];
    double d = lth_loops_distance(l, x, q, n);
    CHECK_NEAR(d, plain_distance(l, x), 1e-15 * 3);
    // the way back: from the nearest point along the normal
    for (int a = 0; a < 2; a++) CHECK_NEAR(q[a] + d * n[a], x[a], 1e-15 * 4);
    CHECK_NEAR(hypot(n[0], n[1]), 1, 1e-12);
  }
  for (LitheIndex i = 0; i < l->n_points; i++)
    CHECK_NEAR(lth_loops_distance(l, l->points + 2 * i, NULL, NULL), 0, 0);
  lth_loops_destroy(ctx, &l);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Cut a polygon (n corners of at most 4 STAR) by the half plane sign (x_axis - at) <= 0.
static int cut(int n, double *points, int axis, double sign, double at) {
  double kept[8 * STAR];
  int m = 0;
  for (int i = 0; i < n; i++) {
    const double *p = points + 2 * i, *q = points + 2 * ((i + 1) % n);
    double dp = sign * (p[axis] - at), dq = sign * (q[axis] - at);
    if (dp <= 0) kept[2 * m] = p[0], kept[2 * m + 1] = p[1], m++;
    if ((dp <= 0) == (dq <= 0)) continue;
    double s = dp / (dp - dq);
    kept[2 * m] = p[0] + s * (q[0] - p[0]), kept[2 * m + 1] = p[1] + s * (q[1] - p[1]), m++;
  }
  memcpy(points, kept, sizeof *kept * 2 * (size_t)m);
  return m;
}

/// The loops cut side by side of the box.
static double plain_area(const LthLoops *l, const double min[2], const double max[2]) {
  double area = 0;
  for (LitheIndex k = 0; k < l->n_loops; k++) {
    double points[8 * STAR];
    int n = l->first[k + 1] - l->first[k];
    memcpy(points, l->points + 2 * l->first[k], sizeof *points * 2 * (size_t)n);
    for (int a = 0; a < 2; a++) {
      n = cut(n, points, a, 1, max[a]);
      n = cut(n, points, a, -1, min[a]);
    }
    for (int i = 0; i < n; i++) {
      const double *p = points + 2 * i, *q = points + 2 * ((i + 1) % n);
      area += ((p[0] - min[0]) * (q[1] - min[1]) - (p[1] - min[1]) * (q[0] - min[0])) / 2;
    }
  }
  return area;
}

static void areas_in_boxes_are_those_of_cut_polygons(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthLoops *l = make_star(ctx);
  for (int k = 0; k < 4000; k++) {
    double size = k % 2 ? 0.02 : 1, min[2], max[2];
    for (int a = 0; a < 2; a++) {
      min[a] = 3 * noise() - 1.6;
      max[a] = min[a] + size * (0.1 + noise());
    }
    CHECK_NEAR(lth_loops_area(l, min, max), plain_area(l, min, max), 1e-15 * 8);
  }
  const double all_min[2] = {-2, -2}, all_max[2] = {2, 2};
  CHECK_NEAR(lth_loops_area(l, all_min, all_max), l->area, 1e-14);
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

static void areas_over_a_grid_add_up_to_the_polygon(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthLoops *l = make_star(ctx);
  double sum = 0;
  const int n = 173;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double min[2] = {-1.2 + 2.5 * i / n, -1.4 + 2.5 * j / n};
      double max[2] = {-1.2 + 2.5 * (i + 1) / n, -1.4 + 2.5 * (j + 1) / n};
      sum += lth_loops_area(l, min, max);
    }
  CHECK_NEAR(sum, l->area, 1e-13 * l->area);
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

static void sides_along_the_grid_give_full_and_empty_boxes_exactly(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const double points[] = {0, 0, 8, 0, 8, 8, 4, 8, 4, 4, 0, 4, 5, 1, 5, 2, 7, 2, 7, 1};
  const LitheIndex first[] = {0, 6, 10};
  LthLoops *l = NULL;
  CHECK_OK(ctx, lth_loops_create(ctx, 2, first, points, &l));
  CHECK_NEAR(l->area, 46, 0);
  for (int i = -2; i < 20; i++)
    for (int j = -2; j < 20; j++) {
      double min[2] = {i / 2.0, j / 2.0}, max[2] = {min[0] + 0.5, min[1] + 0.5};
      bool is_full = i >= 0 && j >= 0 && i < 16 && j < 16 && !(i < 8 && j >= 8) &&
                     !(i >= 10 && i < 14 && j >= 2 && j < 4);
      CHECK_NEAR(lth_loops_area(l, min, max), is_full ? 0.25 : 0, 0);
    }
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

static void corners_and_reference_places_on_edges_do_no_harm(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthLoops *l = NULL;
  // an edge through the box's corner, upwards and downwards, and along its diagonals
  const double cases[][6] = {{0, 0, 2, 4, -3, 4},  {0, 0, 2, -4, 3, 4},  {-1, -1, 3, 3, -1, 3},
                             {1, 0, 0, 1, -5, -5}, {0, 0, 1, 0, 0.5, 1}, {0, 0, 0, 1, -1, 0.5}};
  const LitheIndex first[] = {0, 3};
  const double min[2] = {0, 0}, max[2] = {1, 1};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    CHECK_OK(ctx, lth_loops_create(ctx, 1, first, cases[k], &l));
    CHECK_NEAR(lth_loops_area(l, min, max), plain_area(l, min, max), 1e-15);
    lth_loops_destroy(ctx, &l);
  }
  // an edge through the place in the box that is looked at first
  const double place[2] = {0.4142135, 0.5772156};
  const double through[] = {place[0], place[1] - 2, place[0], place[1] + 2, -3, 0};
  CHECK_OK(ctx, lth_loops_create(ctx, 1, first, through, &l));
  CHECK_NEAR(lth_loops_area(l, min, max), place[0], 1e-15);
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

static void expect_refusal(LitheIndex n_loops, const LitheIndex *first, const double *points,
                           const char *words) {
  LitheCtx *ctx = test_ctx();
  LthLoops *l = NULL;
  assert_int_equal(lth_loops_create(ctx, n_loops, first, points, &l), LITHE_BAD_INPUT);
  assert_null(l);
  if (!strstr(lithe_ctx_message(ctx), words)) fail_msg("%s", lithe_ctx_message(ctx));
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void refuses_loops_that_bound_no_area(void **state) {
  (void)state;
  const LitheIndex one[] = {0, 4}, two[] = {0, 4, 8}, three[] = {0, 4, 8, 12};
  expect_refusal(1, one, (const double[]){0, 0, 1, 0, 1, 0, 0, 0}, "2 different corners");
  expect_refusal(1, one, (const double[]){0, 0, 1, 0, 2, 0, 3, 0}, "no area");
  expect_refusal(1, one, (const double[]){0, 0, 1, 1, 1, 0, 0, 2}, "touches or crosses");
  expect_refusal(1, one, (const double[]){0, 0, 2, 0, 2, 2, 2, 1}, "touches or crosses");
  expect_refusal(2, two, (const double[]){0, 0, 4, 0, 4, 4, 0, 4, 1, 1, 5, 1, 5, 2, 1, 2},
                 "touches or crosses");
  expect_refusal(2, two, (const double[]){0, 0, 4, 0, 4, 4, 0, 4, 6, 1, 8, 1, 8, 2, 6, 2},
                 "loop 2 of the polygon is not inside the first");
  expect_refusal(3, three, (const double[]){0, 0, 9, 0, 9, 9, 0, 9, 1, 1, 5, 1,
                                            5, 5, 1, 5, 2, 2, 3, 2, 3, 3, 2, 3},
                 "loop 3 of the polygon is inside loop 2");
}

static void takes_loops_either_way_round_and_closed_twice(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const LitheIndex first[] = {0, 5, 9};
  const double points[] = {0, 0, 0, 4, 4, 4, 4, 0, 0, 0, 1, 1, 2, 1, 2, 2, 1, 2};
  LthLoops *l = NULL;
  CHECK_OK(ctx, lth_loops_create(ctx, 2, first, points, &l));
  assert_int_equal(l->n_points, 8);
  CHECK_NEAR(l->area, 15, 0);
  LthShape shape = {.kind = LTH_SHAPE_POLYGON, .loops = l};
  CHECK_NEAR(lth_shape_value(&shape, (const double[]){3, 3, 0}), -1, 0);
  CHECK_NEAR(lth_shape_value(&shape, (const double[]){1.5, 1.5, 0}), 0.5, 0);
  double min[3], max[3];
  lth_shape_bounds(&shape, min, max);
  CHECK_NEAR(max[1], 4, 0);
  CHECK_NEAR(max[2], 0, 0);
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(distances_are_those_to_the_nearest_edge),
      cmocka_unit_test(areas_in_boxes_are_those_of_cut_polygons),
      cmocka_unit_test(areas_over_a_grid_add_up_to_the_polygon),
      cmocka_unit_test(sides_along_the_grid_give_full_and_empty_boxes_exactly),
      cmocka_unit_test(corners_and_reference_places_on_edges_do_no_harm),
      cmocka_unit_test(refuses_loops_that_bound_no_area),
      cmocka_unit_test(takes_loops_either_way_round_and_closed_twice),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
