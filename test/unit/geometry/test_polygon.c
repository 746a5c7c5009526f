/// Triangulating polygons: areas add up, no triangle folds over or is empty, holes by bridges work.
#include "check.h"
#include "geometry/polygon.h"
#include "geometry/surface.h"

#include <string.h>

#define MAX 600

/// Twice the signed area of triangle (i, j, k) seen along z.
static double area2(const double *points, LitheIndex i, LitheIndex j, LitheIndex k) {
  const double *a = points + 3 * i, *b = points + 3 * j, *c = points + 3 * k;
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Triangulate points 0 ... n - 1 (counter-clockwise seen along z) in this order or as given; no triangle has less than `least` of the area.
static void check_areas(const double *points, LitheIndex n, const LitheIndex *corner,
                        double least) {
  LitheCtx *ctx = test_ctx();
  LthPolygonWork work = {0};
  static LitheIndex tris[3 * MAX], own[MAX];
  double whole = 0, sum = 0;
  for (LitheIndex i = 0; i < n; i++) own[i] = corner ? corner[i] : i;
  for (LitheIndex i = 1; i + 1 < n; i++) whole += area2(points, own[0], own[i], own[i + 1]);
  CHECK_OK(ctx, lth_polygon_triangulate(ctx, &work, points, n, own, tris));
  for (LitheIndex t = 0; t < n - 2; t++) {
    double area = area2(points, tris[3 * t], tris[3 * t + 1], tris[3 * t + 2]);
    CHECK_AT_LEAST(area, least * whole);
    sum += area;
  }
  // positive areas that sum to the whole cannot overlap
  CHECK_NEAR(sum, whole, 1e-14 * n * whole);
  lth_polygon_work_free(ctx, &work);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void check_polygon(const double *points, LitheIndex n, const LitheIndex *corner) {
  check_areas(points, n, corner, 1e-14);
}

static void star_shaped_polygons_are_cut_without_overlap(void **state) {
  (void)state;
  static double points[3 * MAX];
  uint64_t seed = 11;
  for (int n = 4; n < 500; n = n * 5 / 4 + 1)
    for (int repeat = 0; repeat < 5; repeat++) {
      for (int i = 0; i < n; i++) {
        double radius = 0.05 + test_random(&seed), angle = 2 * M_PI * i / n;
        points[3 * i] = radius * cos(angle) + 100;
        points[3 * i + 1] = radius * sin(angle);
        points[3 * i + 2] = 0.3 * points[3 * i] - 2 * points[3 * i + 1];
      }
      check_polygon(points, n, NULL);
    }
}

static void a_spiral_is_cut(void **state) {
  (void)state;
  static double points[3 * MAX];
  enum { N = 200 };
  for (int i = 0; i < N; i++) {
    double angle = 0.2 * i;
    for (int side = 0; side < 2; side++) {
      double radius = 1 + 0.1 * angle + 0.25 * side;
      double *x = points + 3 * (side ? i : 2 * N - 1 - i);
      x[0] = radius * cos(angle), x[1] = radius * sin(angle), x[2] = 0;
    }
  }
  check_polygon(points, 2 * N, NULL);
}

static void corners_on_straight_sides_give_no_empty_triangles(void **state) {
  (void)state;
  static double points[3 * MAX];
  for (int per_side = 1; per_side < 20; per_side++) {
    int n = 0;
    static const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int side = 0; side < 4; side++)
      for (int i = 0; i < per_side; i++, n++) {
        const double *a = corner[side], *b = corner[(side + 1) % 4];
        double s = (double)(i * 64 / per_side) / 64;
        points[3 * n] = a[0] + s * (b[0] - a[0]);
        points[3 * n + 1] = a[1] + s * (b[1] - a[1]);
        points[3 * n + 2] = 0;
      }
    check_polygon(points, n, NULL);
  }
}

static void a_hole_joined_by_a_bridge_is_left_out(void **state) {
  (void)state;
  // outer square counter-clockwise, inner one clockwise, joined along one line used twice
  double points[] = {0, 0, 0, 3, 0, 0, 3, 3, 0, 0, 3, 0, 1, 1, 0, 1, 2, 0, 2, 2, 0, 2, 1, 0};
  LitheIndex corner[] = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
  check_polygon(points, 10, corner);
}

static void a_crossed_polygon_still_gives_its_number_of_triangles(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthPolygonWork work = {0};
  double points[] = {0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0, -1, 0.5, 0, 7, 7, 7};
  LitheIndex corner[] = {0, 1, 2, 3, 4}, tris[9];
  memset(tris, -1, sizeof tris);
  CHECK_OK(ctx, lth_polygon_triangulate(ctx, &work, points, 5, corner, tris));
  for (int i = 0; i < 9; i++) assert_in_range(tris[i], 0, 4);
  lth_polygon_work_free(ctx, &work);
  lithe_ctx_destroy(&ctx);
}

/// Two parts that touch in a corner, in the middle of an edge: rounding has the ring cross itself there, or not.
static void a_pinched_polygon_does_not_fold_over(void **state) {
  (void)state;
  static const double corner[9][2] = {{-0.84, -0.33},  {-0.42, -0.8},   {0.01, -0.87},
                                      {0.07, -0.35},   {-0.13, 0.05},   {-0.215, 0.144},
                                      {-0.177, 0.147}, {-0.183, 0.159}, {-0.823, -0.141}};
  double points[27] = {0};
  for (int turn = 0; turn < 500; turn++) {
    double c = cos(0.01 * turn), s = sin(0.01 * turn);
    for (int i = 0; i < 9; i++) {
      points[3 * i] = c * corner[i][0] - s * corner[i][1];
      points[3 * i + 1] = s * corner[i][0] + c * corner[i][1];
    }
    check_areas(points, 9, NULL, -1e-14);
  }
}

static void a_soup_is_triangulated_as_it_is(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  LitheIndex off[] = {0, 4, 7, 9}, corner[] = {0, 1, 2, 3, 1, 1, 2, 0, 1};
  LthSoup soup = {
      .n_points = 4, .n_polys = 3, .points = points, .poly_off = off, .poly_point = corner};
  LitheIndex n = 0, *tris = NULL, *tri_poly = NULL;
  CHECK_OK(ctx, lth_soup_triangulate(ctx, &soup, &n, &tris, &tri_poly));
  assert_int_equal(n, 3); // the last has two corners only
  assert_int_equal(tri_poly[0], 0);
  assert_int_equal(tri_poly[1], 0);
  assert_int_equal(tri_poly[2], 1);
  assert_memory_equal(tris + 6, corner + 4, 3 * sizeof *corner);
  lth_free(ctx, tris);
  lth_free(ctx, tri_poly);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(star_shaped_polygons_are_cut_without_overlap),
      cmocka_unit_test(a_spiral_is_cut),
      cmocka_unit_test(corners_on_straight_sides_give_no_empty_triangles),
      cmocka_unit_test(a_hole_joined_by_a_bridge_is_left_out),
      cmocka_unit_test(a_crossed_polygon_still_gives_its_number_of_triangles),
      cmocka_unit_test(a_pinched_polygon_does_not_fold_over),
      cmocka_unit_test(a_soup_is_triangulated_as_it_is),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
