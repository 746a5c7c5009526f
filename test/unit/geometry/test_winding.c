/// The generalised winding number: whole numbers of closed surfaces, exact values of open ones, and the
/// tree against the sum over all triangles.
#include "solids.h"

#include "geometry/bvh.h"
#include "geometry/winding.h"

static LthWinding *winding_of(LitheCtx *ctx, const LthSurface *s) {
  LthWinding *w = NULL;
  CHECK_OK(ctx, lth_winding_create(ctx, s->n_tris, s->points, s->tris, &w));
  return w;
}

static void random_point(uint64_t *seed, double size, double x[3]) {
  for (int i = 0; i < 3; i++) x[i] = size * (2 * test_random(seed) - 1);
}

/// Rounding of a sum of n solid angles.
static double rounding(const LthSurface *s) { return 1e-15 * s->n_tris; }

static void sphere_and_torus_count_once_inside_and_not_outside(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *sphere = solid_sphere(ctx, 12), *torus = solid_torus(ctx, 1, 0.4, 48, 24);
  LthWinding *of_sphere = winding_of(ctx, sphere), *of_torus = winding_of(ctx, torus);
  uint64_t seed = 11;
  int inside = 0;
  for (int k = 0; k < 400; k++) {
    double x[3];
    random_point(&seed, 1.6, x);
    double r = lth_v3_norm(x), tube = hypot(hypot(x[0], x[1]) - 1, x[2]);
    // the facets lie within a few per cent of the true surfaces
    if (fabs(r - 1) > 0.05) CHECK_NEAR(lth_winding_direct(of_sphere, x), r < 1, rounding(sphere));
    if (fabs(tube - 0.4) > 0.05)
      CHECK_NEAR(lth_winding_direct(of_torus, x), tube < 0.4, rounding(torus));
    inside += tube < 0.35;
  }
  assert_true(inside > 20);
  lth_winding_destroy(ctx, &of_sphere), lth_winding_destroy(ctx, &of_torus);
  solid_free(ctx, &sphere), solid_free(ctx, &torus);
  lithe_ctx_destroy(&ctx);
}

/// The unit cube about the origin without its side at z = 1/2.
static LthSurface *open_box(LitheCtx *ctx) {
  LthSurface *s = solid_box(ctx, (double[]){-0.5, -0.5, -0.5}, (double[]){0.5, 0.5, 0.5});
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    int at_lid = 0;
    for (int k = 0; k < 3; k++) at_lid += s->points[3 * s->tris[3 * t + k] + 2] == 0.5;
    if (at_lid == 3) continue;
    for (int k = 0; k < 3; k++) s->tris[3 * n + k] = s->tris[3 * t + k];
    n++;
  }
  assert_true(n < s->n_tris);
  s->n_tris = n;
  return s;
}

static void
a_box_without_lid_counts_five_sixths_at_its_centre_and_half_in_its_opening(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = open_box(ctx);
  LthWinding *w = winding_of(ctx, s);
  CHECK_NEAR(lth_winding_direct(w, (double[]){0, 0, 0}), 5.0 / 6, 1e-14);
  uint64_t seed = 5;
  for (int k = 0; k < 100; k++) {
    double x[3] = {0.98 * (test_random(&seed) - 0.5), 0.98 * (test_random(&seed) - 0.5), 0.5};
    CHECK_NEAR(lth_winding_direct(w, x), 0.5, 1e-14);
    x[2] = 0.5 - 1e-6;
    assert_true(lth_winding_direct(w, x) > 0.5);
    x[2] = 0.5 + 1e-6;
    assert_true(lth_winding_direct(w, x) < 0.5);
  }
  lth_winding_destroy(ctx, &w);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

static void doubled_overlapping_and_turned_surfaces_add_up(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_join(ctx, solid_sphere(ctx, 6), solid_sphere(ctx, 6));
  s = solid_join(ctx, s, solid_move(solid_sphere(ctx, 5), NULL, 1, (double[]){1, 0, 0}));
  s = solid_join(ctx, s, solid_flip(solid_move(solid_sphere(ctx, 5), NULL, 0.2, NULL)));
  LthWinding *w = winding_of(ctx, s);
  CHECK_NEAR(lth_winding_direct(w, (double[]){-0.5, 0, 0}), 2, rounding(s));
  CHECK_NEAR(lth_winding_direct(w, (double[]){0.5, 0, 0}), 3, rounding(s));
  CHECK_NEAR(lth_winding_direct(w, (double[]){1.5, 0, 0}), 1, rounding(s));
  CHECK_NEAR(lth_winding_direct(w, (double[]){-0.05, 0, 0}), 1, rounding(s));
  CHECK_NEAR(lth_winding_direct(w, (double[]){5, 5, 5}), 0, rounding(s));
  lth_winding_destroy(ctx, &w);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

/// Triangles anywhere, of all sizes: nothing that is closed.
static LthSurface *random_soup(LitheCtx *ctx, LitheIndex n, uint64_t seed) {
  LthSurface *s = solid_new(ctx, 3 * n, n);
  for (LitheIndex t = 0; t < n; t++) {
    double at[3], size = pow(10, -2 * test_random(&seed));
    random_point(&seed, 1, at);
    for (LitheIndex k = 0; k < 3; k++) {
      double d[3];
      random_point(&seed, size, d);
      lth_v3_add(at, d, s->points + 9 * t + 3 * k);
      s->tris[3 * t + k] = 3 * t + k;
    }
  }
  return s;
}

static void the_tree_keeps_its_bound(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *shapes[] = {random_soup(ctx, 500, 3), solid_torus(ctx, 1, 0.4, 40, 20),
                          open_box(ctx)};
  static const double openings[] = {1.2, 2, 4, 16};
  uint64_t seed = 21;
  for (int m = 0; m < 3; m++) {
    LthWinding *w = winding_of(ctx, shapes[m]);
    for (int k = 0; k < 200; k++) {
      double x[3], bound, worst = INFINITY;
      random_point(&seed, 1 + 2 * test_random(&seed), x);
      double direct = lth_winding_direct(w, x);
      for (int o = 0; o < 4; o++) {
        double got = lth_winding_number(w, x, openings[o], &bound);
        CHECK_AT_MOST(fabs(got - direct), bound + rounding(shapes[m]));
        assert_true(bound <= worst);
        worst = bound;
        assert_true(got == lth_winding_number(w, x, openings[o], NULL));
      }
    }
    lth_winding_destroy(ctx, &w);
    solid_free(ctx, &shapes[m]);
  }
  lithe_ctx_destroy(&ctx);
}

/// One group at twice the distance: area / distance^2 (radius / distance)^3, a factor of 2^5.
static void the_error_of_a_group_falls_with_the_fifth_power_of_its_distance(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = random_soup(ctx, 60, 9);
  LthWinding *w = winding_of(ctx, s);
  double worst[3] = {0, 0, 0};
  uint64_t seed = 2;
  for (int k = 0; k < 100; k++) {
    double x[3];
    random_point(&seed, 1, x);
    lth_v3_normalize(x);
    lth_v3_scale(20, x);
    for (int level = 0; level < 3; level++, lth_v3_scale(2, x)) {
      double error = lth_winding_number(w, x, 1.5, NULL) - lth_winding_direct(w, x);
      worst[level] = fmax(worst[level], fabs(error));
    }
  }
  for (int level = 0; level < 2; level++) {
    double ratio = worst[level] / worst[level + 1];
    CHECK_AT_LEAST(ratio, 28);
    CHECK_AT_MOST(ratio, 36);
  }
  lth_winding_destroy(ctx, &w);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

static void inside_is_what_the_sum_says(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *shapes[] = {random_soup(ctx, 300, 4), solid_torus(ctx, 1, 0.4, 40, 20),
                          open_box(ctx)};
  uint64_t seed = 8;
  int n_inside = 0;
  for (int m = 0; m < 3; m++) {
    LthWinding *w = winding_of(ctx, shapes[m]);
    for (int k = 0; k < 500; k++) {
      double x[3];
      random_point(&seed, 1.2, x);
      double direct = lth_winding_direct(w, x);
      if (fabs(direct - 0.5) < 1e-3) continue;
      assert_int_equal(lth_winding_inside(w, x), direct > 0.5);
      n_inside += direct > 0.5;
    }
    lth_winding_destroy(ctx, &w);
    solid_free(ctx, &shapes[m]);
  }
  assert_true(n_inside > 100);
  lithe_ctx_destroy(&ctx);
}

static void boxes_have_their_numbers_ready(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *torus = solid_torus(ctx, 1, 0.4, 96, 48), *open = open_box(ctx);
  torus->n_tris -= torus->n_tris / 7; // with a hole
  const LthSurface *both[2] = {torus, open};
  uint64_t seed = 17;
  for (int k = 0; k < 60; k++) {
    LthWinding *w = winding_of(ctx, both[k % 2]);
    LthWindingNear *larger = malloc(sizeof *larger), *near = malloc(sizeof *near);
    double center[3], inner[3], half[3], quarter[3], x[3];
    random_point(&seed, 1.2, center);
    for (int a = 0; a < 3; a++) {
      half[a] = 0.02 + 0.1 * test_random(&seed);
      quarter[a] = half[a] / 4;
      inner[a] = center[a] + 0.7 * half[a] * (2 * test_random(&seed) - 1);
    }
    assert_true(lth_winding_near(w, NULL, center, half, larger));
    assert_true(lth_winding_near(w, larger, inner, quarter, near));
    assert_true(near->n <= larger->n);
    for (int p = 0; p < 20; p++) {
      for (int a = 0; a < 3; a++) x[a] = inner[a] + quarter[a] * (2 * test_random(&seed) - 1);
      double direct = lth_winding_direct(w, x);
      CHECK_NEAR(lth_winding_near_number(larger, x), direct, LTH_WINDING_NEAR_ERROR);
      CHECK_NEAR(lth_winding_near_number(near, x), direct, LTH_WINDING_NEAR_ERROR);
    }
    free(larger), free(near);
    lth_winding_destroy(ctx, &w);
  }
  solid_free(ctx, &torus), solid_free(ctx, &open);
  lithe_ctx_destroy(&ctx);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = random_soup(ctx, 2000, 6);
  double first[50];
  for (int threads = 1; threads <= 3; threads++) {
    lth_set_threads(ctx, threads);
    LthWinding *w = winding_of(ctx, s);
    uint64_t seed = 1;
    for (int k = 0; k < 50; k++) {
      double x[3];
      random_point(&seed, 1.5, x);
      double got = lth_winding_number(w, x, 2, NULL);
      if (threads == 1) first[k] = got;
      assert_true(got == first[k]);
    }
    lth_winding_destroy(ctx, &w);
  }
  solid_free(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void no_triangles_wind_around_nothing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthWinding *w = NULL;
  CHECK_OK(ctx, lth_winding_create(ctx, 0, NULL, NULL, &w));
  double bound, x[3] = {0, 0, 0};
  assert_true(lth_winding_number(w, x, 2, &bound) == 0 && bound == 0);
  assert_false(lth_winding_inside(w, x));
  lth_winding_destroy(ctx, &w);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sphere_and_torus_count_once_inside_and_not_outside),
      cmocka_unit_test(a_box_without_lid_counts_five_sixths_at_its_centre_and_half_in_its_opening),
      cmocka_unit_test(doubled_overlapping_and_turned_surfaces_add_up),
      cmocka_unit_test(the_tree_keeps_its_bound),
      cmocka_unit_test(the_error_of_a_group_falls_with_the_fifth_power_of_its_distance),
      cmocka_unit_test(inside_is_what_the_sum_says),
      cmocka_unit_test(boxes_have_their_numbers_ready),
      cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
      cmocka_unit_test(no_triangles_wind_around_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
