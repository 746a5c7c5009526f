/// Patches of plane boundaries: they end at corners, go round curves, and tell the two sides of a corner apart.
#include "check.h"

#include "mesh/where_place.h"

#define DEGREE 0.017453292519943295

static bool holds(const LthWhereSolid *ready, double x, double y, double nx, double ny) {
  LthPlace place = {.x = {x, y}, .is_boundary = true, .point = {x, y}, .normal = {nx, ny}};
  return lth_where_solid_contains(ready, &place);
}

static LthWhere face(double x, double y, double angle) {
  return (LthWhere){.kind = LTH_WHERE_FACE, .point = {x, y, 0}, .angle = angle * DEGREE};
}

static void prepare(LitheCtx *ctx, const LthWhere *where, const LthShape *shape, double step,
                    LthWhereSolid *ready) {
  CHECK_OK(ctx, lth_where_solid_prepare(ctx, where, 2, shape, NULL, step, false, ready));
}

static void side_of_a_box_ends_at_its_corners(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  LthShape box = {.kind = LTH_SHAPE_BOX, .a = {0, 0, -INFINITY}, .b = {2, 1, INFINITY}};
  LthWhere where = face(2, 0.3, 80);
  LthWhereSolid ready;
  prepare(ctx, &where, &box, 0.05, &ready);
  for (int i = 0; i <= 1000; i++) {
    assert_true(holds(&ready, 2, i / 1000.0, 1, 0));
    assert_false(holds(&ready, 2 * i / 1000.0, 1, 0, 1));
    assert_false(holds(&ready, 2 * i / 1000.0, 0, 0, -1));
    assert_false(holds(&ready, 0, i / 1000.0, -1, 0));
  }
  lth_where_solid_free(ctx, &ready);
  where.angle = 91 * DEGREE;
  prepare(ctx, &where, &box, 0.05, &ready);
  assert_true(holds(&ready, 0, 0.5, -1, 0));
  lth_where_solid_free(ctx, &ready);
  lithe_ctx_destroy(&ctx);
}

static void one_side_of_an_annulus_is_all_of_its_circle(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  LthShape ring = {.kind = LTH_SHAPE_ANNULUS, .a = {0.1, 0.2, 0}, .radius = 1, .inner = 0.9};
  LthWhere where = face(0.1, 1.1, 10);
  LthWhereSolid ready;
  prepare(ctx, &where, &ring, 0.04, &ready);
  for (int i = 0; i < 720; i++) {
    double c = cos(i * DEGREE / 2), s = sin(i * DEGREE / 2);
    assert_true(holds(&ready, 0.1 + 0.9 * c, 0.2 + 0.9 * s, -c, -s));
    assert_false(holds(&ready, 0.1 + c, 0.2 + s, c, s));
  }
  lth_where_solid_free(ctx, &ready);
  lithe_ctx_destroy(&ctx);
}

static void sides_of_a_turned_polygon_with_a_hole(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  static const double corner[16] = {0, -1, 1, 0, 0, 1, -1, 0, 0, -0.5, 0.5, 0, 0, 0.5, -0.5, 0};
  static const LitheIndex first[3] = {0, 4, 8};
  const double r = sqrt(0.5);
  LthLoops *loops = NULL;
  CHECK_OK(ctx, lth_loops_create(ctx, 2, first, corner, &loops));
  LthShape shape = {.kind = LTH_SHAPE_POLYGON, .loops = loops};
  LthWhere child = face(0.5, 0.5, 30), where = {.kind = LTH_WHERE_NOT, .children = &child};
  LthWhereSolid ready;
  where.n_children = 1;
  prepare(ctx, &where, &shape, 0.03, &ready);
  for (int i = 1; i < 200; i++) {
    double t = i / 200.0;
    assert_false(holds(&ready, 1 - t, t, r, r));
    assert_true(holds(&ready, -t, 1 - t, -r, r));
    assert_true(holds(&ready, 1 - t, -t, r, -r));
    assert_true(holds(&ready, (1 - t) / 2, t / 2, -r, -r));
  }
  lth_where_solid_free(ctx, &ready);
  lth_loops_destroy(ctx, &loops);
  lithe_ctx_destroy(&ctx);
}

static void steps_far_too_fine_are_refused(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  LthShape disk = {.kind = LTH_SHAPE_DISK, .radius = 1};
  LthWhere where = face(1, 0, 30);
  LthWhereSolid ready;
  assert_true(lth_where_solid_prepare(ctx, &where, 2, &disk, NULL, 1e-9, false, &ready) ==
              LITHE_BAD_INPUT);
  lth_where_solid_free(ctx, &ready);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(side_of_a_box_ends_at_its_corners),
      cmocka_unit_test(one_side_of_an_annulus_is_all_of_its_circle),
      cmocka_unit_test(sides_of_a_turned_polygon_with_a_hole),
      cmocka_unit_test(steps_far_too_fine_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
