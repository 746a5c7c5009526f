/// Exact fractions in the plane against closed forms and against many inside tests.
#include "check.h"
#include "geometry/fractions.h"
#include "geometry/fractions_plane.h"

#include <string.h>

/// A number in [0, 1) that differs from call to call in the same way in every run.
static double noise(void) {
  static uint32_t state = 777;
  state = state * 1664525u + 1013904223u;
  return state / 4294967296.0;
}

static LthShape disk(double x, double y, double radius) {
  return (LthShape){.kind = LTH_SHAPE_DISK, .a = {x, y, 0}, .radius = radius};
}

static LthShape box(double x0, double y0, double x1, double y1) {
  return (LthShape){.kind = LTH_SHAPE_BOX, .a = {x0, y0, -INFINITY}, .b = {x1, y1, INFINITY}};
}

static LthShape combination(LthShapeKind kind, LthShape *children, int n) {
  return (LthShape){.kind = kind, .children = children, .n_children = n};
}

/// Sum over all parts of a grid on which nothing lies evenly.
static double grid_area(const LthShape *shape, int n) {
  LitheCtx *ctx = test_ctx();
  LthFractions *f = NULL;
  double min[3], max[3], h[3] = {0, 0, 1}, origin[3] = {0, 0, -0.5};
  lth_shape_bounds(shape, min, max);
  for (int a = 0; a < 2; a++) {
    h[a] = 1.0371 * (max[a] - min[a]) / n;
    origin[a] = min[a] - 0.0123 * h[a] * n;
  }
  LthFractionDef def = {.method = LTH_FRACTIONS_EXACT};
  CHECK_OK(ctx, lth_fractions_create(ctx, shape, 2, origin, h, (LitheIndex[3]){n, n, 1}, &def, &f));
  double area = f->volume;
  lth_fractions_destroy(ctx, &f);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
  return area;
}

/// Area of the lens that two circles of radii r and s at distance d share.
static double lens(double r, double s, double d) {
  double a = acos((d * d + r * r - s * s) / (2 * d * r)),
         b = acos((d * d + s * s - r * r) / (2 * d * s));
  return r * r * (a - sin(2 * a) / 2) + s * s * (b - sin(2 * b) / 2);
}

static void disks_and_rings_have_their_areas(void **state) {
  (void)state;
  LthShape round = disk(0.3, -0.1, 1.7);
  LthShape ring = {.kind = LTH_SHAPE_ANNULUS, .a = {0.3, 0.2, 0}, .radius = 1.5, .inner = 0.4};
  for (int n = 1; n < 200; n = 2 * n + 1) {
    CHECK_NEAR(grid_area(&round, n), M_PI * 1.7 * 1.7, 1e-13 * M_PI * 1.7 * 1.7);
    CHECK_NEAR(grid_area(&ring, n), M_PI * (2.25 - 0.16), 1e-13 * M_PI * 2.09);
  }
}

static void combinations_of_straight_shapes_are_exact(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthLoops *l = NULL;
  const double corners[] = {0, 0, 2, 1, 1, 2};
  CHECK_OK(ctx, lth_loops_create(ctx, 1, (const LitheIndex[]){0, 3}, corners, &l));
  LthShape triangle = {.kind = LTH_SHAPE_POLYGON, .loops = l};
  // the triangle without its part over y = x is half of it; boxes that share a side are one
  LthShape parts[] = {triangle, box(0, 0, 1, 1), box(1, 0, 2, 1)};
  LthShape all = combination(LTH_SHAPE_UNION, parts, 3);
  LthShape shared = combination(LTH_SHAPE_INTERSECTION, parts, 2);
  LthShape rest = combination(LTH_SHAPE_DIFFERENCE, parts, 3);
  // the triangle's area is 1.5; of it 0.5 is in the left box, 0.25 in the right one
  for (int n = 1; n < 100; n = 2 * n + 1) {
    CHECK_NEAR(grid_area(&all, n), 2 + 1.5 - 0.75, 1e-13 * 3);
    CHECK_NEAR(grid_area(&shared, n), 0.5, 1e-13);
    CHECK_NEAR(grid_area(&rest, n), 0.75, 1e-13);
  }
  lth_loops_destroy(ctx, &l);
  lithe_ctx_destroy(&ctx);
}

static void circles_that_meet_are_resolved(void **state) {
  (void)state;
  LthShape parts[] = {disk(0, 0, 1), disk(0.9, 0, 0.7)};
  double both = lens(1, 0.7, 0.9);
  LthShape all = combination(LTH_SHAPE_UNION, parts, 2);
  LthShape shared = combination(LTH_SHAPE_INTERSECTION, parts, 2);
  LthShape rest = combination(LTH_SHAPE_DIFFERENCE, parts, 2);
  for (int n = 1; n < 100; n = 3 * n + 1) {
    CHECK_NEAR(grid_area(&shared, n), both, 1e-12);
    CHECK_NEAR(grid_area(&all, n), M_PI * 1.49 - both, 1e-12 * 4);
    CHECK_NEAR(grid_area(&rest, n), M_PI - both, 1e-12 * 3);
  }
}

static void disks_cut_by_boxes_have_closed_forms(void **state) {
  (void)state;
  LthShape parts[] = {disk(0, 0, 1), box(0, -2, 2, 0.5)};
  LthShape shared = combination(LTH_SHAPE_INTERSECTION, parts, 2);
  double cap = acos(0.5) - 0.5 * sqrt(0.75); // beyond y = 0.5
  for (int n = 1; n < 200; n = 2 * n + 1)
    CHECK_NEAR(grid_area(&shared, n), (M_PI - cap) / 2, 1e-13 * 2);
}

static void circles_that_fit_into_each_other_leave_no_gap(void **state) {
  (void)state;
  LthShape parts[] = {disk(0, 0, 0.5),
                      {.kind = LTH_SHAPE_ANNULUS, .a = {0, 0, 0}, .radius = 1, .inner = 0.5}};
  LthShape all = combination(LTH_SHAPE_UNION, parts, 2);
  LthShape same[] = {disk(0, 0, 0.5), disk(0, 0, 0.5)};
  LthShape nothing[] = {disk(0, 0, 1), combination(LTH_SHAPE_DIFFERENCE, same, 2)};
  LthShape rest = combination(LTH_SHAPE_DIFFERENCE, nothing, 2);
  CHECK_NEAR(grid_area(&all, 20), M_PI, 1e-12);
  CHECK_NEAR(grid_area(&rest, 20), M_PI, 1e-12);
}

static double ellipse(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return x[0] * x[0] / 4 + x[1] * x[1] - 1;
}

static void implicit_shapes_converge_with_the_square_of_the_cell(void **state) {
  (void)state;
  LthShape shape = {.kind = LTH_SHAPE_IMPLICIT,
                    .value = {.eval = ellipse},
                    .box = {-2.1, -1.1, -INFINITY, 2.1, 1.1, INFINITY}};
  // a side is a chord over 1/16 of a part, h/32: it lacks at most its curvature (up to 2) times its length
  // squared over 12 along the perimeter of less than 10
  for (int n = 10; n < 100; n *= 2) {
    double h = 4.4 / n;
    CHECK_NEAR(grid_area(&shape, n), 2 * M_PI, 10 * 2 * (h / 32) * (h / 32) / 12 * 2);
  }
}

static void unions_agree_with_many_inside_tests(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthShape parts[7], inner[3];
  for (int trial = 0; trial < 6; trial++) {
    for (int i = 0; i < 7; i++) {
      double x = noise(), y = noise();
      parts[i] = i % 2 ? disk(x, y, 0.1 + 0.3 * noise())
                       : box(x, y, x + 0.1 + noise() / 2, y + 0.1 + noise() / 2);
    }
    for (int i = 0; i < 3; i++) inner[i] = disk(noise(), noise(), 0.1 + 0.4 * noise());
    parts[5] = combination(LTH_SHAPE_INTERSECTION, inner, 3);
    parts[6] = combination(LTH_SHAPE_DIFFERENCE, inner, 2);
    LthShape all = combination(trial % 2 ? LTH_SHAPE_DIFFERENCE : LTH_SHAPE_UNION, parts, 7);
    LthProbe *probe = NULL;
    CHECK_OK(ctx, lth_probe_create(ctx, &all, 0.1, &probe));
    const double min[2] = {0.1, 0.2}, max[2] = {0.9, 0.95};
    const int n = 1000;
    LitheCount count = 0;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) {
        double x[3] = {min[0] + (max[0] - min[0]) * (i + 0.5) / n,
                       min[1] + (max[1] - min[1]) * (j + 0.5) / n, 0};
        count += lth_probe_inside(probe, x);
      }
    double sampled = (double)count / n / n * (max[0] - min[0]) * (max[1] - min[1]);
    // sides of some 10 shapes, each shorter than 3, pass through rows of samples
    CHECK_NEAR(lth_plane_area(probe, min, max), sampled, 10 * 3 * 0.8 / n / 10);
    lth_probe_destroy(ctx, &probe);
  }
  lithe_ctx_destroy(&ctx);
}

static void pixels_of_a_turned_image_have_their_areas(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthVolume *v = NULL;
  LthImage *image = NULL;
  const LitheIndex n[3] = {13, 9, 1};
  double c = 0.1 * cos(0.4), s = 0.1 * sin(0.4);
  const double to_world[12] = {c, -s, 0, 0.2, s, c, 0, 0.1, 0, 0, 1, 0};
  CHECK_OK(ctx, lth_volume_create(ctx, n, to_world, &v));
  int n_set = 0;
  for (LitheIndex i = 1; i < 12; i++)
    for (LitheIndex j = 1; j < 8; j++)
      if (noise() < 0.5) v->values[lth_volume_index(v, i, j, 0)] = 2, n_set++;
  CHECK_OK(ctx, lth_image_create(ctx, v, 1, (const double[]){2}, 1, 0, &image));
  LthShape shape = {.kind = LTH_SHAPE_IMAGE, .image = image};
  for (int k = 1; k < 100; k = 3 * k + 1) CHECK_NEAR(grid_area(&shape, k), 0.01 * n_set, 1e-13);
  lth_image_destroy(ctx, &image);
  lth_volume_destroy(ctx, &v);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(disks_and_rings_have_their_areas),
      cmocka_unit_test(combinations_of_straight_shapes_are_exact),
      cmocka_unit_test(circles_that_meet_are_resolved),
      cmocka_unit_test(disks_cut_by_boxes_have_closed_forms),
      cmocka_unit_test(circles_that_fit_into_each_other_leave_no_gap),
      cmocka_unit_test(implicit_shapes_converge_with_the_square_of_the_cell),
      cmocka_unit_test(unions_agree_with_many_inside_tests),
      cmocka_unit_test(pixels_of_a_turned_image_have_their_areas),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
