/// Wrapped surfaces: whatever the triangles were, what comes out bounds a solid, and it is the right one.
#include "solids.h"

#include "failing_memory.h"
#include "geometry/shape.h"

/// The triangles of a surface as a soup, the k-th kept where keep(k) and turned where turn(k).
typedef bool (*Choice)(const LthSurface *s, LitheIndex tri);

static LthSoup soup_of(LitheCtx *ctx, const LthSurface *s, Choice keep, Choice turn) {
  LthSoup soup = {.n_points = s->n_points, .points = s->points};
  soup.poly_off = lth_alloc(ctx, (LitheCount)s->n_tris + 1, sizeof *soup.poly_off);
  soup.poly_point = lth_alloc(ctx, 3 * (LitheCount)s->n_tris, sizeof *soup.poly_point);
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    if (keep && !keep(s, t)) continue;
    bool is_turned = turn && turn(s, t);
    LitheIndex *p = soup.poly_point + 3 * soup.n_polys;
    p[0] = s->tris[3 * t];
    p[1] = s->tris[3 * t + (is_turned ? 2 : 1)];
    p[2] = s->tris[3 * t + (is_turned ? 1 : 2)];
    soup.n_polys++;
    soup.poly_off[soup.n_polys] = 3 * soup.n_polys;
  }
  return soup;
}

static void soup_free(LitheCtx *ctx, LthSoup *soup) {
  lth_free(ctx, soup->poly_off), lth_free(ctx, soup->poly_point);
}

static bool any(const LthSurface *s, LitheIndex tri) { return s && tri >= 0; }

static bool third(const LthSurface *s, LitheIndex tri) {
  uint64_t seed = 7919u * (uint64_t)(tri + 1) + (uint64_t)s->n_tris;
  test_random(&seed);
  return test_random(&seed) < 0.3;
}

static LthWrap *wrap_of(LitheCtx *ctx, const LthSurface *s, Choice keep, Choice turn) {
  LthWrap *w = NULL;
  LthSoup soup = soup_of(ctx, s, keep, turn);
  CHECK_OK(ctx, lth_wrap_create(ctx, &soup, "soup", &w));
  soup_free(ctx, &soup);
  return w;
}

static LthSurface *wrapped(LitheCtx *ctx, const LthWrap *w, double resolution) {
  LthShape shape = {.kind = LTH_SHAPE_WRAP, .wrap = w, .resolution = resolution};
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_shape_tessellate(ctx, &shape, 1, &s));
  return s;
}

/// Strict cleaning finds nothing to complain about, and the same volume.
static void check_solid(LitheCtx *ctx, const LthSurface *s) {
  LthSurface *clean = NULL;
  LthDefects defects = {0};
  LthSoup soup = soup_of(ctx, s, NULL, NULL);
  CHECK_OK(ctx, lth_surface_from_soup(ctx, &soup, "wrapped", &defects, &clean));
  assert_int_equal(defects.n, 0);
  assert_int_equal(clean->n_tris, s->n_tris);
  assert_int_equal(clean->n_shells, s->n_shells);
  CHECK_NEAR(solid_volume(clean), solid_volume(s), 1e-12 * fabs(solid_volume(s)));
  lth_defects_free(ctx, &defects);
  lth_surface_destroy(ctx, &clean);
  soup_free(ctx, &soup);
}

/// Volume of the wrapped soup, which has to be a solid.
static double wrapped_volume(LitheCtx *ctx, const LthSurface *s, Choice keep, Choice turn,
                             double resolution) {
  LthWrap *w = wrap_of(ctx, s, keep, turn);
  LthSurface *out = wrapped(ctx, w, resolution);
  check_solid(ctx, out);
  double volume = solid_volume(out);
  lth_surface_destroy(ctx, &out);
  lth_wrap_destroy(ctx, &w);
  return volume;
}

/// A unit cube, turned so that nothing is along an axis.
static LthSurface *turned_box(LitheCtx *ctx) {
  double R[9];
  solid_rotation(1, 2, 3, 0.7, R);
  LthSurface *s = solid_box(ctx, (double[]){-0.5, -0.5, -0.5}, (double[]){0.5, 0.5, 0.5});
  return solid_move(s, R, 1, NULL);
}

/// All but the two triangles of one side: corners 4 to 7 of the box before it was turned.
static bool no_lid(const LthSurface *s, LitheIndex tri) {
  double n[3], a[3], b[3], R[9];
  solid_rotation(1, 2, 3, 0.7, R);
  const double *p = s->points;
  const LitheIndex *t = s->tris + 3 * tri;
  lth_v3_sub(p + 3 * t[1], p + 3 * t[0], a);
  lth_v3_sub(p + 3 * t[2], p + 3 * t[0], b);
  lth_v3_cross(a, b, n);
  double lid[3] = {R[2], R[5], R[8]};
  return lth_v3_dot(n, lid) < 0.5;
}

static void corners_lie_on_the_file_s_triangles(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_torus(ctx, 1, 0.4, 40, 20);
  LthWrap *w = wrap_of(ctx, s, NULL, NULL);
  double resolution = 0.1;
  LthSurface *out = wrapped(ctx, w, resolution);
  check_solid(ctx, out);
  double farthest = 0;
  for (LitheIndex p = 0; p < out->n_points; p++)
    farthest = fmax(farthest, fabs(lth_bvh_signed_distance(w->bvh, out->points + 3 * p, NULL)));
  // but for those kept 1e-4 of a lattice edge (at most sqrt(3) h) away from its ends
  CHECK_AT_MOST(farthest, 1.01e-4 * sqrt(3) * resolution);
  lth_surface_destroy(ctx, &out);
  lth_wrap_destroy(ctx, &w);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

static void volumes_converge_with_order_two(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *ball = solid_sphere(ctx, 10), *box = turned_box(ctx);
  double exact = solid_volume(ball);
  double of_ball[2], of_box[2], open[2], h[2] = {0.18, 0.06};
  for (int k = 0; k < 2; k++) {
    of_ball[k] = fabs(wrapped_volume(ctx, ball, NULL, NULL, h[k]) - exact);
    of_box[k] = fabs(wrapped_volume(ctx, box, NULL, NULL, h[k]) - 1);
    open[k] = fabs(wrapped_volume(ctx, box, no_lid, NULL, h[k]) - 1);
  }
  // a factor of 9 with order 2; facets and chamfered edges both lose volume with h^2
  CHECK_AT_MOST(of_ball[1], of_ball[0] / 6);
  CHECK_AT_MOST(of_box[1], of_box[0] / 6);
  CHECK_AT_MOST(open[1], open[0] / 6);
  // edges of length 12 lose at most h^2 / 2 of their cross-section
  CHECK_AT_MOST(of_box[0], 6 * h[0] * h[0]);
  CHECK_AT_MOST(open[0], 6 * h[0] * h[0]);
  solid_free(ctx, &ball), solid_free(ctx, &box);
  lithe_ctx_destroy(&ctx);
}

static bool same_bits(LitheCtx *ctx, const LthWrap *v, const LthWrap *w, double resolution) {
  LthSurface *a = wrapped(ctx, v, resolution), *b = wrapped(ctx, w, resolution);
  bool same = a->n_points == b->n_points && a->n_tris == b->n_tris &&
              memcmp(a->points, b->points, 3 * sizeof *a->points * (size_t)a->n_points) == 0 &&
              memcmp(a->tris, b->tris, 3 * sizeof *a->tris * (size_t)a->n_tris) == 0;
  lth_surface_destroy(ctx, &a), lth_surface_destroy(ctx, &b);
  return same;
}

static void turned_triangles_and_inverted_surfaces_change_nothing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *box = turned_box(ctx), *ball = solid_sphere(ctx, 6);
  LthWrap *good = wrap_of(ctx, ball, NULL, NULL), *mixed = wrap_of(ctx, ball, NULL, third),
          *inverted = wrap_of(ctx, ball, NULL, any), *open = wrap_of(ctx, box, no_lid, NULL),
          *open_inverted = wrap_of(ctx, box, no_lid, any);
  assert_true(same_bits(ctx, good, mixed, 0.15));
  assert_true(same_bits(ctx, good, inverted, 0.15));
  assert_true(same_bits(ctx, open, open_inverted, 0.15));
  assert_int_equal(good->n_turned_shells + mixed->n_turned_shells, 0);
  assert_int_equal(inverted->n_turned_shells, 1);
  assert_int_equal(open->n_open_edges, 4);
  assert_int_equal(open->n_holes, 1);
  CHECK_AT_LEAST(open->largest_hole, 1);
  LthWrap *all[] = {good, mixed, inverted, open, open_inverted};
  for (int i = 0; i < 5; i++) lth_wrap_destroy(ctx, &all[i]);
  solid_free(ctx, &box), solid_free(ctx, &ball);
  lithe_ctx_destroy(&ctx);
}

static void a_doubled_shell_is_one(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *one = solid_sphere(ctx, 6);
  LthSurface *two = solid_join(ctx, solid_sphere(ctx, 6), solid_sphere(ctx, 6));
  LthWrap *v = wrap_of(ctx, one, NULL, NULL), *w = wrap_of(ctx, two, NULL, NULL);
  assert_int_equal(w->n_repeated, one->n_tris);
  assert_int_equal(w->n_open_edges + w->n_crowded_edges, 0);
  assert_true(same_bits(ctx, v, w, 0.2));
  lth_wrap_destroy(ctx, &v), lth_wrap_destroy(ctx, &w);
  solid_free(ctx, &one), solid_free(ctx, &two);
  lithe_ctx_destroy(&ctx);
}

static void overlapping_solids_are_united_and_cavities_stay(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double h = 0.08;
  LthSurface *boxes =
      solid_join(ctx, solid_box(ctx, (double[]){0, 0, 0}, (double[]){1, 1, 1}),
                 solid_box(ctx, (double[]){0.5, 0.5, 0.5}, (double[]){1.5, 1.5, 1.5}));
  // 24 edges and 6 concave ones where the boxes meet
  CHECK_NEAR(wrapped_volume(ctx, boxes, NULL, NULL, h), 2 - 0.125, 12 * h * h);

  LthSurface *hollow = solid_join(ctx, solid_sphere(ctx, 10),
                                  solid_flip(solid_move(solid_sphere(ctx, 8), NULL, 0.5, NULL)));
  LthWrap *w = wrap_of(ctx, hollow, NULL, NULL);
  LthSurface *out = wrapped(ctx, w, h);
  check_solid(ctx, out);
  assert_int_equal(out->n_shells, 2);
  CHECK_NEAR(solid_volume(out), solid_volume(hollow), 0.01 * solid_volume(hollow));
  lth_surface_destroy(ctx, &out);
  lth_wrap_destroy(ctx, &w);
  solid_free(ctx, &boxes), solid_free(ctx, &hollow);
  lithe_ctx_destroy(&ctx);
}

/// Long thin triangles through a cube: no inside to speak of.
static LthSurface *needles(LitheCtx *ctx, LitheIndex n) {
  LthSurface *s = solid_new(ctx, 3 * n, n);
  uint64_t seed = 17;
  for (LitheIndex i = 0; i < 9 * n; i++) s->points[i] = test_random(&seed);
  for (LitheIndex t = 0; t < n; t++)
    for (LitheIndex k = 0; k < 3; k++) {
      s->tris[3 * t + k] = 3 * t + k;
      s->points[9 * t + 6 + k] = s->points[9 * t + k] + 0.3 * test_random(&seed);
    }
  return s;
}

static void needles_give_a_solid_or_a_clear_error(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = needles(ctx, 150), *out = NULL;
  LthWrap *w = wrap_of(ctx, s, NULL, NULL);
  check_solid(ctx, out = wrapped(ctx, w, 0.05));
  lth_surface_destroy(ctx, &out);
  lth_wrap_destroy(ctx, &w);
  solid_free(ctx, &s);

  s = needles(ctx, 3);
  w = wrap_of(ctx, s, NULL, NULL);
  LthShape shape = {.kind = LTH_SHAPE_WRAP, .wrap = w};
  assert_int_equal(lth_shape_tessellate(ctx, &shape, 0.2, &out), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "resolution"));
  lth_wrap_destroy(ctx, &w);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

static void a_sheet_that_is_there_twice_encloses_nothing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_join(ctx, solid_sphere(ctx, 3), solid_flip(solid_sphere(ctx, 3)));
  LthSoup soup = soup_of(ctx, s, NULL, NULL);
  LthWrap *w = NULL;
  assert_int_equal(lth_wrap_create(ctx, &soup, "sheet.obj", &w), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "sheet.obj: no triangle"));
  assert_null(w);
  soup_free(ctx, &soup);
  solid_free(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void the_map_answers_as_the_winding_number_does(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *shapes[] = {turned_box(ctx), solid_torus(ctx, 1, 0.4, 30, 15)};
  for (int m = 0; m < 2; m++) {
    LthWrap *w = wrap_of(ctx, shapes[m], m == 0 ? no_lid : NULL, NULL);
    LthWrapMap *map = NULL;
    CHECK_OK(ctx, lth_wrap_map_create(ctx, w, 0.04, &map));
    LitheCount n_known = 0, n = (LitheCount)map->n[0] * map->n[1] * map->n[2];
    for (LitheCount i = 0; i < n; i++) n_known += map->state[i] != LTH_WRAP_UNKNOWN;
    CHECK_AT_LEAST((double)n_known, 0.25 * (double)n);
    uint64_t seed = 33;
    for (int k = 0; k < 2000; k++) {
      double x[3];
      for (int i = 0; i < 3; i++)
        x[i] = w->box[i] + (1.1 * test_random(&seed) - 0.05) * (w->box[3 + i] - w->box[i]);
      assert_int_equal(lth_wrap_map_inside(map, x), lth_wrap_inside(w, x));
      assert_int_equal(lth_wrap_value(w, x) < 0, lth_wrap_inside(w, x));
    }
    lth_wrap_map_destroy(ctx, &map);
    lth_wrap_destroy(ctx, &w);
    solid_free(ctx, &shapes[m]);
  }
  lithe_ctx_destroy(&ctx);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = needles(ctx, 100), *first = NULL;
  for (int threads = 1; threads <= 3; threads++) {
    lth_set_threads(ctx, threads);
    LthWrap *w = wrap_of(ctx, s, NULL, NULL);
    LthSurface *out = wrapped(ctx, w, 0.05);
    if (!first) {
      first = out;
    } else {
      assert_int_equal(out->n_points, first->n_points);
      assert_memory_equal(out->points, first->points, 24 * (size_t)out->n_points);
      lth_surface_destroy(ctx, &out);
    }
    lth_wrap_destroy(ctx, &w);
  }
  lth_surface_destroy(ctx, &first);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

static int allocations_left;

static void running_out_of_memory_is_told_and_nothing_is_lost(void **state) {
  (void)state;
  LitheCtx *good = test_ctx();
  LthSurface *ball = solid_sphere(good, 2);
  LthSoup soup = soup_of(good, ball, NULL, NULL);
  for (int n = 0, done = 0; !done; n++) {
    LitheCtxDef def = lithe_ctx_def_default();
    def.allocate = test_failing_allocate;
    def.memory_user = &allocations_left;
    allocations_left = n;
    LitheCtx *ctx = lithe_ctx_create(&def);
    LthWrap *w = NULL;
    LthSurface *s = NULL;
    LitheStatus status = lth_wrap_create(ctx, &soup, "soup", &w);
    if (status == LITHE_OK) {
      LthShape shape = {.kind = LTH_SHAPE_WRAP, .wrap = w};
      status = lth_shape_tessellate(ctx, &shape, 0.4, &s);
    }
    done = status == LITHE_OK;
    assert_true(done || (status == LITHE_NO_MEMORY && !s));
    lth_surface_destroy(ctx, &s);
    lth_wrap_destroy(ctx, &w);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
  soup_free(good, &soup);
  solid_free(good, &ball);
  lithe_ctx_destroy(&good);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(corners_lie_on_the_file_s_triangles),
      cmocka_unit_test(volumes_converge_with_order_two),
      cmocka_unit_test(turned_triangles_and_inverted_surfaces_change_nothing),
      cmocka_unit_test(a_doubled_shell_is_one),
      cmocka_unit_test(overlapping_solids_are_united_and_cavities_stay),
      cmocka_unit_test(needles_give_a_solid_or_a_clear_error),
      cmocka_unit_test(a_sheet_that_is_there_twice_encloses_nothing),
      cmocka_unit_test(the_map_answers_as_the_winding_number_does),
      cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
      cmocka_unit_test(running_out_of_memory_is_told_and_nothing_is_lost),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
