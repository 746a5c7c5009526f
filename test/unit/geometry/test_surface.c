/// Cleaning surfaces: what is repaired, what is a defect, and that nothing leaks when memory is out.
#include "geometry/bvh.h"
#include "geometry/surface.h"
#include "soup_maker.h"

static SoupMaker maker; // large, so not on the stack

static SoupMaker *fresh(void) {
  memset(&maker, 0, sizeof maker);
  return &maker;
}

/// What every clean surface promises: every directed edge has exactly one opposite, no repeated points.
static void check_closed(const LthSurface *s) {
  LitheIndex n = 3 * s->n_tris;
  for (LitheIndex i = 0; i < n && n < 2000; i++) {
    LitheIndex a = s->tris[i], b = s->tris[i % 3 == 2 ? i - 2 : i + 1];
    int same = 0, opposite = 0;
    assert_in_range(a, 0, s->n_points - 1);
    for (LitheIndex j = 0; j < n; j++) {
      LitheIndex c = s->tris[j], d = s->tris[j % 3 == 2 ? j - 2 : j + 1];
      same += a == c && b == d;
      opposite += a == d && b == c;
    }
    assert_int_not_equal(a, b);
    assert_int_equal(same, 1);
    assert_int_equal(opposite, 1);
  }
}

static LthSurface *clean(LitheCtx *ctx, SoupMaker *m) {
  LthSurface *s = NULL;
  LthDefects defects;
  CHECK_OK(ctx, lth_surface_from_soup(ctx, soup_finish(m), "file", &defects, &s));
  assert_int_equal(defects.n, 0);
  lth_defects_free(ctx, &defects);
  check_closed(s);
  return s;
}

static void finish(LitheCtx *ctx, LthSurface *s) {
  lth_surface_destroy(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Clean, expect a volume and a number of shells.
static void accept(SoupMaker *m, double volume, int n_shells) {
  LitheCtx *ctx = test_ctx();
  LthSurface *s = clean(ctx, m);
  CHECK_NEAR(lth_surface_volume(s), volume, 1e-13 * fabs(volume) * s->n_tris);
  assert_int_equal(s->n_shells, n_shells);
  finish(ctx, s);
}

/// Clean, expect exactly these counts of defects (open, non-manifold, crossing, unorientable, nesting);
/// a count of -1 stands for at least one.
static void refuse(SoupMaker *m, const int count[LTH_DEFECT_KINDS]) {
  LitheCtx *ctx = test_ctx();
  LthSurface *s = NULL;
  LthDefects defects;
  assert_int_equal(lth_surface_from_soup(ctx, soup_finish(m), "file", &defects, &s),
                   LITHE_BAD_INPUT);
  assert_null(s);
  LitheIndex total = 0;
  for (int k = 0; k < LTH_DEFECT_KINDS; k++) {
    if (count[k] < 0 ? defects.count[k] < 1 : defects.count[k] != count[k])
      fail_msg("%d of '%s', expected %d; %s", defects.count[k], lth_defect_text((LthDefectKind)k),
               count[k], lithe_ctx_message(ctx));
    total += defects.count[k];
  }
  assert_int_equal(defects.n, total);
  lth_defects_free(ctx, &defects);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static bool has_warning(LitheCtx *ctx, const char *text) {
  for (LitheIndex i = 0; i < lithe_ctx_warning_count(ctx); i++)
    if (strstr(lithe_ctx_warning(ctx, i), text)) return true;
  return false;
}

// ------------------------------------------------------------------ accepted

static void a_cube_of_quads_keeps_its_order(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  soup_cube(m, 0, 0, 0, 2);
  soup_point(m, 9, 9, 9); // belongs to no polygon
  LthSurface *s = clean(ctx, m);
  double min[3], max[3];
  lth_surface_bounds(s, min, max);
  for (int i = 0; i < 3; i++) {
    CHECK_NEAR(min[i], 0, 0);
    CHECK_NEAR(max[i], 2, 0);
  }
  assert_int_equal(s->n_points, 8);
  assert_int_equal(s->n_tris, 12);
  CHECK_NEAR(lth_surface_volume(s), 8, 1e-14);
  CHECK_NEAR(lth_surface_area(s), 24, 1e-14);
  for (LitheIndex t = 0; t < 12; t++) assert_int_equal(s->tri_poly[t], t / 2);
  for (LitheIndex p = 0; p < 8; p++) {
    assert_int_equal(s->soup_point[p], p);
    assert_memory_equal(s->points + 3 * p, m->points + 3 * p, 3 * sizeof(double));
  }
  assert_int_equal(s->n_soup_points, 9);
  assert_int_equal(s->soup_point[8], -1);
  assert_true(has_warning(ctx, "file: 1 points that no polygon uses left out"));
  finish(ctx, s);
}

/// Corner points of every triangle of their own, some moved by less than the tolerance.
static void make_welded_cube(SoupMaker *m, double offset, double jitter) {
  static SoupMaker cube;
  uint64_t seed = 5;
  memset(&cube, 0, sizeof cube);
  soup_cube(&cube, 0, 0, 0, 1);
  for (LitheIndex q = 0; q < 6; q++)
    for (int half = 0; half < 2; half++) {
      static const int corner[2][3] = {{0, 1, 2}, {0, 2, 3}};
      LitheIndex p[3];
      for (int k = 0; k < 3; k++) {
        const double *x = cube.points + 3 * cube.poly_point[4 * q + corner[half][k]];
        double y[3];
        for (int i = 0; i < 3; i++) y[i] = offset + x[i] + jitter * (test_random(&seed) - 0.5);
        p[k] = soup_point(m, y[0], y[1], y[2]);
      }
      soup_polygon(m, 3, p);
    }
}

static void points_that_are_almost_equal_are_welded(void **state) {
  (void)state;
  static const double offset[] = {0, -0.5, 1e3, 1e6};
  static const double jitter[] = {0, 5e-10};
  for (int i = 0; i < 8; i++) {
    SoupMaker *m = fresh();
    LitheCtx *ctx = test_ctx();
    make_welded_cube(m, offset[i / 2], jitter[i % 2]);
    LthSurface *s = clean(ctx, m);
    assert_int_equal(s->n_points, 8);
    CHECK_NEAR(lth_surface_volume(s), 1, 5e-9);
    assert_true(has_warning(ctx, "file: 36 points welded to 8"));
    finish(ctx, s);
  }
}

static void points_further_apart_are_not_welded(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  LthSurface *s = NULL;
  make_welded_cube(m, 0, 1e-8);
  assert_int_equal(lth_surface_from_soup(ctx, soup_finish(m), "file", NULL, &s), LITHE_BAD_INPUT);
  finish(ctx, s);
}

static void polygons_need_not_be_convex(void **state) {
  (void)state;
  // an L-shaped prism and a comb with teeth, as one polygon above and below
  static const double ell[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  static const double comb[][2] = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3},
                                   {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}, {0, 2}, {0, 1}};
  static const struct {
    const double (*xy)[2];
    int n;
    double area;
  } cases[] = {{ell, 6, 3}, {comb, 14, 11}};
  for (int i = 0; i < 2; i++)
    for (int turned = 0; turned < 2; turned++) {
      SoupMaker *m = fresh();
      int n = cases[i].n;
      LitheIndex top[16], bottom[16];
      for (int k = 0; k < n; k++) soup_point(m, cases[i].xy[k][0], cases[i].xy[k][1], 0);
      for (int k = 0; k < n; k++) soup_point(m, cases[i].xy[k][0], cases[i].xy[k][1], 2);
      // tilt it so that no plane is aligned; sums of halves keep coplanar points exactly so
      for (LitheIndex p = 0; turned && p < m->soup.n_points; p++)
        m->points[3 * p + 2] += 0.5 * m->points[3 * p] + 0.25 * m->points[3 * p + 1];
      for (int k = 0; k < n; k++) {
        bottom[k] = n - 1 - k;
        top[k] = n + k;
        soup_polygon(m, 4, (LitheIndex[]){k, (k + 1) % n, n + (k + 1) % n, n + k});
      }
      soup_polygon(m, n, top);
      soup_polygon(m, n, bottom);
      accept(m, 2 * cases[i].area, 1);
    }
}

static void mixed_orientation_is_made_to_agree(void **state) {
  (void)state;
  for (int mask = 0; mask < 64; mask++) {
    SoupMaker *m = fresh();
    soup_cube(m, 0, 0, 0, 1);
    for (int q = 0; q < 6; q++)
      if (mask >> q & 1) {
        LitheIndex *p = m->poly_point + 4 * q, keep = p[1];
        p[1] = p[3], p[3] = keep;
      }
    accept(m, 1, 1);
  }
}

static void an_inside_out_solid_is_turned(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  soup_cavity(m, 0, 0, 0, 1);
  LthSurface *s = clean(ctx, m);
  CHECK_NEAR(lth_surface_volume(s), 1, 1e-15);
  assert_true(has_warning(ctx, "1 of 1 shells faced inwards"));
  finish(ctx, s);
}

static void repeated_points_and_equal_opposite_faces_are_dropped(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  // two cubes with a wall between them, which both have
  LitheIndex a = soup_cube(m, 0, 0, 0, 1);
  soup_cube(m, 1, 0, 0, 1);
  soup_triangle(m, a, a, a + 1);
  soup_polygon(m, 5, (LitheIndex[]){a, a, a + 1, a + 1, a});
  LthSurface *s = clean(ctx, m);
  CHECK_NEAR(lth_surface_volume(s), 2, 1e-14);
  assert_int_equal(s->n_shells, 1);
  assert_int_equal(s->n_tris, 20);
  assert_true(has_warning(ctx, "2 triangles with repeated points dropped"));
  assert_true(has_warning(ctx, "2 pairs of equal triangles that face each other dropped"));
  finish(ctx, s);
}

/// A cube whose top is cut at the middle of one edge on one side only, joined by a triangle without area.
static void triangles_without_area_that_close_the_surface_are_replaced(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  LitheIndex p = soup_cube(m, 0, 0, 0, 1);
  m->soup.n_polys = 0; // only its points
  LitheIndex q = soup_point(m, 0.5, 0, 1), r = soup_point(m, 0.75, 0, 1);
  soup_polygon(m, 4, (LitheIndex[]){p, p + 2, p + 3, p + 1});
  soup_polygon(m, 4, (LitheIndex[]){p + 2, p + 6, p + 7, p + 3});
  soup_polygon(m, 4, (LitheIndex[]){p, p + 4, p + 6, p + 2});
  soup_polygon(m, 4, (LitheIndex[]){p + 1, p + 3, p + 7, p + 5});
  soup_polygon(m, 4, (LitheIndex[]){p, p + 1, p + 5, p + 4});
  soup_polygon(m, 6, (LitheIndex[]){p + 4, q, r, p + 5, p + 7, p + 6});
  soup_triangle(m, p + 4, p + 5, q);
  soup_triangle(m, q, p + 5, r);
  LthSurface *s = clean(ctx, m);
  CHECK_NEAR(lth_surface_volume(s), 1, 1e-14);
  CHECK_NEAR(lth_surface_area(s), 6, 1e-14);
  assert_int_equal(s->n_points, 10);
  assert_int_equal(s->n_tris, 16);
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double e[3], f[3];
    for (int i = 0; i < 3; i++) {
      e[i] = s->points[3 * s->tris[3 * t + 1] + i] - s->points[3 * s->tris[3 * t] + i];
      f[i] = s->points[3 * s->tris[3 * t + 2] + i] - s->points[3 * s->tris[3 * t] + i];
    }
    double c[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    CHECK_AT_LEAST(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), 0.1);
  }
  assert_true(has_warning(ctx, "2 triangles without area removed"));
  finish(ctx, s);
}

static void a_stray_triangle_without_area_is_dropped(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheIndex p = soup_cube(m, 0, 0, 0, 1);
  LitheIndex q = soup_point(m, 0.5, 0, 0);
  soup_triangle(m, p, p + 1, q);
  accept(m, 1, 1);
}

static void shells_and_cavities_are_told_apart(void **state) {
  (void)state;
  // a cavity, with a solid in it, and two solids outside; cavities first to show that order is free
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  soup_cavity(m, 1, 1, 1, 8);
  soup_cube(m, 2, 2, 2, 4);
  soup_cube(m, 0, 0, 0, 10);
  soup_cavity(m, 3, 3, 3, 1);
  soup_cube(m, 20, 0, 0, 1);
  soup_cube(m, -20, 0, 0, 2);
  LthSurface *s = clean(ctx, m);
  assert_int_equal(s->n_shells, 6);
  CHECK_NEAR(lth_surface_volume(s), 1000 - 512 + 64 - 1 + 1 + 8, 1e-9);
  assert_true(has_warning(ctx, "6 shells, of which 2 are cavities"));
  assert_false(has_warning(ctx, "faced inwards"));
  finish(ctx, s);
}

static void a_cavity_in_an_inside_out_file_stays_one(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cavity(m, 0, 0, 0, 3);
  soup_cube(m, 1, 1, 1, 1);
  accept(m, 26, 2);
}

static void a_shell_of_mixed_orientation_inside_another_is_a_cavity(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 3);
  LitheIndex first = m->poly_off[m->soup.n_polys];
  soup_cube(m, 1, 1, 1, 1);
  LitheIndex keep = m->poly_point[first + 1];
  m->poly_point[first + 1] = m->poly_point[first + 3];
  m->poly_point[first + 3] = keep;
  accept(m, 26, 2);
}

static void shells_may_touch_at_a_point(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 1);
  soup_cube(m, 1, 1, 1, 1);
  accept(m, 2, 2);
  // from inside as well: a cavity with a corner in the corner of the solid's notch is one too
  m = fresh();
  soup_cube(m, 0, 0, 0, 4);
  LitheIndex p = soup_point(m, 0, 0, 0), q = soup_point(m, 2, 1, 1), r = soup_point(m, 1, 2, 1),
             t = soup_point(m, 1, 1, 2);
  soup_triangle(m, p, q, r);
  soup_triangle(m, p, r, t);
  soup_triangle(m, p, t, q);
  soup_triangle(m, q, t, r);
  accept(m, 64 - 4.0 / 6, 2);
}

static void many_shells_take_linear_time(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, -1, -1, -1, 100);
  for (int i = 0; i < 400; i++) soup_cavity(m, 3 * (i % 8), 3 * (i / 8 % 8), 3 * (i / 64), 1);
  accept(m, 1e6 - 400, 401);
}

static void nothing_depends_on_size_or_place(void **state) {
  (void)state;
  static const double scale[] = {1e-20, 1e-6, 1e6, 1e20};
  for (int i = 0; i < 4; i++) {
    SoupMaker *m = fresh();
    LitheCtx *ctx = test_ctx();
    soup_cube(m, 0, 0, 0, 10 * scale[i]);
    soup_cavity(m, 2 * scale[i], 2 * scale[i], 2 * scale[i], scale[i]);
    LthSurface *s = clean(ctx, m);
    double unit = scale[i] * scale[i] * scale[i];
    CHECK_NEAR(lth_surface_volume(s) / unit, 999, 1e-9);
    finish(ctx, s);
  }
}

/// A cube with one more point in its top, moved out over an edge by `out`: the surface is folded there.
static void make_folded_cube(SoupMaker *m, double out) {
  LitheIndex p = soup_cube(m, 0, 0, 0, 1);
  LitheIndex v = soup_point(m, 0.5, -out, 1);
  soup_triangle(m, p + 4, p + 5, v);
  soup_triangle(m, p + 5, p + 7, v);
  soup_triangle(m, p + 7, p + 4, v);
  soup_triangle(m, p + 4, p + 7, p + 6);
  // in place of the top's polygon
  for (LitheIndex i = 4; i < 8; i++) m->poly_point[i] = p;
}

static void a_slight_fold_is_mended_a_deep_one_is_not(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  make_folded_cube(m, 1e-4);
  LthSurface *s = clean(ctx, m);
  CHECK_NEAR(lth_surface_volume(s), 1, 1e-4);
  CHECK_NEAR(lth_surface_area(s), 6, 2e-4);
  assert_true(has_warning(ctx, "4 pairs of triangles that crossed slightly mended"));
  finish(ctx, s);
  m = fresh();
  make_folded_cube(m, 1e-2);
  refuse(m, (int[]){0, 0, 4, 0, 0});
}

// ------------------------------------------------------------------ refused

static void an_open_surface_has_its_edges_counted(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 1);
  m->soup.n_polys--;
  refuse(m, (int[]){4, 0, 0, 0, 0});
}

static void a_doubled_face_is_not_manifold(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheIndex p = soup_cube(m, 0, 0, 0, 1);
  soup_polygon(m, 4, (LitheIndex[]){p + 1, p + 3, p + 7, p + 5});
  refuse(m, (int[]){0, 5, 0, 0, 0}); // four sides and the diagonal
  // whichever way the second copy faces
  m = fresh();
  p = soup_cube(m, 0, 0, 0, 1);
  soup_triangle(m, p, p + 3, p + 2);
  soup_triangle(m, p, p + 2, p + 3);
  soup_triangle(m, p, p + 2, p + 3);
  LitheCtx *ctx = test_ctx();
  LthSurface *s = NULL;
  assert_int_equal(lth_surface_from_soup(ctx, soup_finish(m), "file", NULL, &s), LITHE_BAD_INPUT);
  finish(ctx, s);
}

static void cubes_with_a_common_edge_are_not_manifold(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 1);
  soup_cube(m, 1, 1, 0, 1);
  refuse(m, (int[]){0, 1, 0, 0, 0});
}

static void a_moebius_strip_is_open_and_has_no_outside(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  enum { N = 24 };
  for (int i = 0; i < N; i++)
    for (int side = 0; side < 2; side++) {
      double angle = 2 * M_PI * i / N, width = side ? 0.3 : -0.3;
      double radius = 1 + width * cos(angle / 2);
      soup_point(m, radius * cos(angle), radius * sin(angle), width * sin(angle / 2));
    }
  for (int i = 0; i < N; i++) {
    bool last = i == N - 1;
    LitheIndex a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
    soup_triangle(m, a, b, d);
    soup_triangle(m, a, d, c);
  }
  refuse(m, (int[]){2 * N, 0, 0, 1, 0});
}

static void a_closed_surface_without_outside_is_told(void **state) {
  (void)state;
  // the projective plane with six points: closed, every edge has two triangles, no orientation
  static const LitheIndex tris[10][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                                         {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  SoupMaker *m = fresh();
  uint64_t seed = 3;
  for (int i = 0; i < 6; i++)
    soup_point(m, test_random(&seed), test_random(&seed), test_random(&seed));
  for (int t = 0; t < 10; t++) soup_polygon(m, 3, tris[t]);
  refuse(m, (int[]){0, 0, -1, 1, 0}); // in space it cannot but cross itself
}

static void crossing_cubes_are_found(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 1);
  soup_cube(m, 0.6, 0.55, 0.7, 1);
  refuse(m, (int[]){0, 0, -1, 0, 0});
}

static void overlaps_in_a_plane_are_found(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 1);
  soup_cube(m, 1, 0.25, 0.25, 0.5); // stands on a face of the first
  refuse(m, (int[]){0, 0, -1, 0, 0});
}

/// A tetrahedron with its tip at `tip` and its base at larger z.
static void make_spike(SoupMaker *m, const double tip[3]) {
  LitheIndex t = soup_point(m, tip[0], tip[1], tip[2]);
  LitheIndex a = soup_point(m, tip[0] + 0.2, tip[1], tip[2] + 1),
             b = soup_point(m, tip[0] - 0.1, tip[1] + 0.2, tip[2] + 1),
             c = soup_point(m, tip[0] - 0.1, tip[1] - 0.2, tip[2] + 1);
  soup_triangle(m, t, b, a);
  soup_triangle(m, t, c, b);
  soup_triangle(m, t, a, c);
  soup_triangle(m, a, b, c);
}

static void a_tip_that_touches_a_face_or_an_edge_is_found(void **state) {
  (void)state;
  static const struct {
    double tip[3];
    bool touches;
  } cases[] = {{{0.3, 0.6, 1}, true},           // inside a triangle
               {{0.5, 0.5, 1}, true},           // on a diagonal
               {{0.5, 0, 1}, true},             // on an edge
               {{0.3, 0.6, 1 - 0x1p-40}, true}, // just through
               {{0.3, 0.6, 1 + 0x1p-40}, false}};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    SoupMaker *m = fresh();
    soup_cube(m, 0, 0, 0, 1);
    make_spike(m, cases[i].tip);
    if (cases[i].touches)
      refuse(m, (int[]){0, 0, -1, 0, 0});
    else
      accept(m, 1 + 0.06 / 3, 2);
  }
}

static void triangles_that_share_a_point_may_cross_as_well(void **state) {
  (void)state;
  // the spike's tip is a corner of the cube, its body inside: it leaves through the far side
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 0.5);
  LitheIndex t = soup_point(m, 0, 0, 0), a = soup_point(m, 1, 0.8, 0.9),
             b = soup_point(m, 0.9, 1, 0.8), c = soup_point(m, 0.8, 0.9, 1);
  soup_triangle(m, t, b, a);
  soup_triangle(m, t, c, b);
  soup_triangle(m, t, a, c);
  soup_triangle(m, a, b, c);
  refuse(m, (int[]){0, 0, -1, 0, 0});
}

static void a_surface_folded_flat_is_found(void **state) {
  (void)state;
  // a flat four-cornered "tetrahedron": every edge is shared, but all lies in one plane
  SoupMaker *m = fresh();
  LitheIndex a = soup_point(m, 0, 0, 0), b = soup_point(m, 1, 0, 0), c = soup_point(m, 1, 1, 0),
             d = soup_point(m, 0, 1, 0);
  soup_triangle(m, a, b, c);
  soup_triangle(m, a, d, b);
  soup_triangle(m, a, c, d);
  soup_triangle(m, b, d, c);
  refuse(m, (int[]){0, 0, -1, 0, 0});
}

static void a_solid_inside_a_solid_is_a_question(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  soup_cube(m, 0, 0, 0, 3);
  soup_cube(m, 1, 1, 1, 1);
  refuse(m, (int[]){0, 0, 0, 0, 1});
}

static void a_surface_without_volume_is_refused(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheIndex a = soup_point(m, 0, 0, 0), b = soup_point(m, 1, 0, 0), c = soup_point(m, 1, 1, 0);
  soup_triangle(m, a, b, c);
  soup_triangle(m, c, b, a);
  refuse(m, (int[]){0, 0, 0, 0, 0});
  m = fresh();
  a = soup_point(m, 1, 2, 3);
  soup_triangle(m, a, a, a);
  refuse(m, (int[]){0, 0, 0, 0, 0});
}

static void the_message_counts_places_and_advises(void **state) {
  (void)state;
  SoupMaker *m = fresh();
  LitheCtx *ctx = test_ctx();
  LthSurface *s = NULL;
  soup_cube(m, 0, 0, 0, 1);
  m->soup.n_polys--;
  assert_int_equal(lth_surface_from_soup(ctx, soup_finish(m), "box.obj", NULL, &s),
                   LITHE_BAD_INPUT);
  const char *text = lithe_ctx_message(ctx);
  assert_non_null(strstr(text,
                         "box.obj: the surface is not the boundary of a solid: 4 open edges (the "
                         "first from (1, 1, 0) to (1, 0, 0))"));
  assert_non_null(strstr(text, "Fill Holes"));
  finish(ctx, s);
}

// ------------------------------------------------------------------ random solids

typedef struct Box {
  double low[3], high[3];
} Box;

static Box random_box(uint64_t *seed, double size, bool on_lattice) {
  Box box;
  for (int i = 0; i < 3; i++) {
    double a = test_random(seed), b = 0.05 + test_random(seed) * size;
    if (on_lattice) a = floor(4 * a) / 4, b = 0.25 + floor(4 * b) / 4;
    box.low[i] = a;
    box.high[i] = a + b;
  }
  return box;
}

static bool is_apart(const Box *a, const Box *b) {
  for (int i = 0; i < 3; i++)
    if (a->high[i] < b->low[i] || b->high[i] < a->low[i]) return true;
  return false;
}

static bool is_within(const Box *a, const Box *b) {
  for (int i = 0; i < 3; i++)
    if (!(b->low[i] < a->low[i] && a->high[i] < b->high[i])) return false;
  return true;
}

/// Turn the whole soup by a rotation that rounds every coordinate.
static void rotate(SoupMaker *m, double angle) {
  double c = cos(angle), s = sin(angle);
  for (LitheIndex p = 0; p < m->soup.n_points; p++)
    for (int axis = 0; axis < 3; axis++) {
      double *x = m->points + 3 * p, *u = &x[axis], *v = &x[(axis + 1) % 3], keep = *u;
      *u = c * *u - s * *v;
      *v = s * keep + c * *v;
    }
}

static void two_boxes_are_accepted_just_where_they_are_apart_or_nested(void **state) {
  (void)state;
  uint64_t seed = 17;
  int n_apart = 0, n_nested = 0, n_crossing = 0;
  for (int n = 0; n < 600; n++) {
    Box a = random_box(&seed, n % 3 ? 1 : 0.3, false),
        b = random_box(&seed, n % 3 ? 0.3 : 1, false);
    bool apart = is_apart(&a, &b), nested = is_within(&b, &a) || is_within(&a, &b);
    SoupMaker *m = fresh();
    LitheCtx *ctx = test_ctx();
    LthSurface *s = NULL;
    LthDefects defects;
    soup_box(m, a.low, a.high, false);
    soup_box(m, b.low, b.high, nested); // the other way round: one of them is a cavity
    rotate(m, n % 2 ? 0.7 + n : 0);
    LitheStatus status = lth_surface_from_soup(ctx, soup_finish(m), "file", &defects, &s);
    if ((status == LITHE_OK) != (apart || nested))
      fail_msg("case %d: %s", n, lithe_ctx_message(ctx));
    if (status == LITHE_OK)
      check_closed(s);
    else
      assert_true(defects.count[LTH_DEFECT_CROSSING] > 0);
    n_apart += apart, n_nested += nested, n_crossing += !apart && !nested;
    lth_defects_free(ctx, &defects);
    finish(ctx, s);
  }
  assert_true(n_apart > 50 && n_nested >= 10 && n_crossing > 50);
}

/// Winding number of the surface about x by solid angles.
static double winding(const LthSurface *s, const double x[3]) {
  double sum = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    const LitheIndex *p = s->tris + 3 * t;
    sum += lth_solid_angle(s->points + 3 * p[0], s->points + 3 * p[1], s->points + 3 * p[2], x);
  }
  return sum / (4 * M_PI);
}

static void what_is_accepted_winds_once_or_not_at_all(void **state) {
  (void)state;
  uint64_t seed = 23;
  int n_accepted = 0;
  for (int n = 0; n < 500; n++) {
    SoupMaker *m = fresh();
    LitheCtx *ctx = test_ctx();
    LthSurface *s = NULL;
    // boxes on a coarse lattice share faces, edges and corners all the time
    int n_boxes = 2 + n % 3;
    for (int i = 0; i < n_boxes; i++) {
      Box box = random_box(&seed, 1, true);
      soup_box(m, box.low, box.high, test_random(&seed) < 0.3);
    }
    rotate(m, n % 2 ? n : 0);
    if (lth_surface_from_soup(ctx, soup_finish(m), "file", NULL, &s) == LITHE_OK) {
      n_accepted++;
      check_closed(s);
      for (int i = 0; i < 20; i++) {
        double x[3];
        for (int k = 0; k < 3; k++) x[k] = 2 * test_random(&seed);
        double w = winding(s, x), off = fmin(fabs(w), fabs(w - 1));
        if (off > 1e-6) fail_msg("case %d winds %g times", n, w);
      }
    }
    finish(ctx, s);
  }
  assert_true(n_accepted > 10);
}

// ------------------------------------------------------------------ memory and threads

static void threads_do_not_change_what_is_found(void **state) {
  (void)state;
  LthDefects found[3];
  static const int threads[] = {1, 2, 7};
  LitheCtx *ctx = test_ctx();
  SoupMaker *m = fresh();
  uint64_t seed = 31;
  for (int i = 0; i < 100; i++) { // enough triangles for threads to share
    Box box = random_box(&seed, 0.4, false);
    soup_box(m, box.low, box.high, false);
  }
  for (int i = 0; i < 3; i++) {
    LthSurface *s = NULL;
    lth_set_threads(ctx, threads[i]);
    assert_int_equal(lth_surface_from_soup(ctx, soup_finish(m), "file", &found[i], &s),
                     LITHE_BAD_INPUT);
    assert_int_equal(found[i].n, found[0].n);
    assert_memory_equal(found[i].kind, found[0].kind, sizeof(LthDefectKind) * (size_t)found[0].n);
    assert_memory_equal(found[i].segment, found[0].segment,
                        6 * sizeof(double) * (size_t)found[0].n);
  }
  assert_true(found[0].n > 100);
  for (int i = 0; i < 3; i++) lth_defects_free(ctx, &found[i]);
  finish(ctx, NULL);
}

typedef struct Quota {
  int left;
} Quota;

static void *quota_allocate(void *user, size_t alignment, size_t bytes) {
  Quota *quota = user;
  return quota->left-- > 0 ? aligned_alloc(alignment, bytes) : NULL;
}

static void quota_release(void *user, void *block) {
  (void)user;
  free(block);
}

static void running_out_of_memory_leaks_nothing(void **state) {
  (void)state;
  for (int kind = 0; kind < 3; kind++) {
    SoupMaker *m = fresh();
    LitheIndex p = soup_cube(m, 0, 0, 0, 3);
    LitheIndex q = soup_point(m, 1.5, 0, 0);
    soup_triangle(m, p, p + 1, q);
    if (kind == 0) soup_cavity(m, 1, 1, 1, 1);
    if (kind == 1) soup_cube(m, 1, 1, 1, 4);
    if (kind == 2) m = fresh(), make_folded_cube(m, 1e-4);
    LitheStatus status = LITHE_NO_MEMORY;
    int n = 0;
    for (; status == LITHE_NO_MEMORY; n++) {
      Quota quota = {n};
      LitheCtxDef def = lithe_ctx_def_default();
      def.allocate = quota_allocate;
      def.release = quota_release;
      def.memory_user = &quota;
      LitheCtx *ctx = lithe_ctx_create(&def);
      LthSurface *s = NULL;
      LthDefects defects;
      status = lth_surface_from_soup(ctx, soup_finish(m), "file", &defects, &s);
      assert_true((s != NULL) == (status == LITHE_OK));
      lth_surface_destroy(ctx, &s);
      lth_defects_free(ctx, &defects);
      assert_int_equal(lth_alloc_bytes(ctx), 0);
      lithe_ctx_destroy(&ctx);
    }
    assert_int_equal(status, kind == 1 ? LITHE_BAD_INPUT : LITHE_OK);
    assert_true(n > 20);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_of_quads_keeps_its_order),
      cmocka_unit_test(points_that_are_almost_equal_are_welded),
      cmocka_unit_test(points_further_apart_are_not_welded),
      cmocka_unit_test(polygons_need_not_be_convex),
      cmocka_unit_test(mixed_orientation_is_made_to_agree),
      cmocka_unit_test(an_inside_out_solid_is_turned),
      cmocka_unit_test(repeated_points_and_equal_opposite_faces_are_dropped),
      cmocka_unit_test(triangles_without_area_that_close_the_surface_are_replaced),
      cmocka_unit_test(a_stray_triangle_without_area_is_dropped),
      cmocka_unit_test(shells_and_cavities_are_told_apart),
      cmocka_unit_test(a_cavity_in_an_inside_out_file_stays_one),
      cmocka_unit_test(a_shell_of_mixed_orientation_inside_another_is_a_cavity),
      cmocka_unit_test(shells_may_touch_at_a_point),
      cmocka_unit_test(many_shells_take_linear_time),
      cmocka_unit_test(nothing_depends_on_size_or_place),
      cmocka_unit_test(a_slight_fold_is_mended_a_deep_one_is_not),
      cmocka_unit_test(an_open_surface_has_its_edges_counted),
      cmocka_unit_test(a_doubled_face_is_not_manifold),
      cmocka_unit_test(cubes_with_a_common_edge_are_not_manifold),
      cmocka_unit_test(a_moebius_strip_is_open_and_has_no_outside),
      cmocka_unit_test(a_closed_surface_without_outside_is_told),
      cmocka_unit_test(crossing_cubes_are_found),
      cmocka_unit_test(overlaps_in_a_plane_are_found),
      cmocka_unit_test(a_tip_that_touches_a_face_or_an_edge_is_found),
      cmocka_unit_test(triangles_that_share_a_point_may_cross_as_well),
      cmocka_unit_test(a_surface_folded_flat_is_found),
      cmocka_unit_test(a_solid_inside_a_solid_is_a_question),
      cmocka_unit_test(a_surface_without_volume_is_refused),
      cmocka_unit_test(the_message_counts_places_and_advises),
      cmocka_unit_test(two_boxes_are_accepted_just_where_they_are_apart_or_nested),
      cmocka_unit_test(what_is_accepted_winds_once_or_not_at_all),
      cmocka_unit_test(threads_do_not_change_what_is_found),
      cmocka_unit_test(running_out_of_memory_leaks_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
