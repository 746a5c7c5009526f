/// Surfaces of combined shapes: planes, edges and corners exact, the rest to second order, closed and without crossings.
#include "closed_surface.h"
#include "ctx_fixture.h"

#include "geometry/shape.h"
#include "geometry/solid.h"

static LthShape box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return (LthShape){.kind = LTH_SHAPE_BOX, .a = {x0, y0, z0}, .b = {x1, y1, z1}};
}

static LthShape ball(double x, double y, double z, double radius) {
  return (LthShape){.kind = LTH_SHAPE_SPHERE, .a = {x, y, z}, .radius = radius};
}

/// Along an axis, through the point x.
static LthShape bar(int axis, double from, double to, const double x[3], double radius) {
  LthShape s = {.kind = LTH_SHAPE_CYLINDER, .radius = radius};
  lth_v3_copy(x, s.a);
  lth_v3_copy(x, s.b);
  s.a[axis] = from, s.b[axis] = to;
  return s;
}

static LthShape join(LthShapeKind kind, LitheIndex n, LthShape *parts) {
  return (LthShape){.kind = kind, .n_children = n, .children = parts};
}

/// Closed, and sharp, which takes that nothing was told of chamfers.
static LthSurface *surface_of(LitheCtx *ctx, const LthShape *shape, double resolution) {
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_shape_tessellate(ctx, shape, resolution, &s));
  assert_int_equal(lithe_ctx_warning_count(ctx), 0);
  check_closed(s);
  return s;
}

static void check_exact(LitheCtx *ctx, const LthShape *shape, double resolution, double volume,
                        double area) {
  LthSurface *s = surface_of(ctx, shape, resolution);
  CHECK_NEAR(lth_surface_volume(s), volume, 1e-12 * volume);
  CHECK_NEAR(lth_surface_area(s), area, 1e-12 * area);
  assert_int_equal(count_crossings(ctx, s), 0);
  lth_surface_destroy(ctx, &s);
}

static bool has_point(const LthSurface *s, const double x[3]) {
  for (LitheIndex p = 0; p < s->n_points; p++)
    if (memcmp(s->points + 3 * p, x, 3 * sizeof *x) == 0) return true;
  return false;
}

/// Exactly along an axis.
static bool faces_an_axis(const LthSurface *s, LitheIndex t) {
  for (int a = 0; a < 3; a++)
    if (tri_point(s, t, 0)[a] == tri_point(s, t, 1)[a] &&
        tri_point(s, t, 0)[a] == tri_point(s, t, 2)[a])
      return true;
  return false;
}

static void an_l_of_two_boxes_is_exact_whether_they_overlap_or_touch(void **state) {
  Fixture *f = *state;
  const double flat = 0.3 + 0.21, thick = 0.5;
  LthShape overlap[] = {box(0, 0, 0, 1, 0.3, thick), box(0, 0, 0, 0.3, 1, thick)};
  LthShape touch[] = {box(0, 0, 0, 1, 0.3, thick), box(0, 0.3, 0, 0.3, 1, thick)};
  for (int i = 0; i < 2; i++) {
    LthShape l = join(LTH_SHAPE_UNION, 2, i ? touch : overlap);
    for (double resolution = 0.4; resolution > 0.03; resolution /= 2)
      check_exact(f->ctx, &l, resolution, flat * thick, 2 * flat + 4 * thick);
    LthSurface *s = surface_of(f->ctx, &l, 0.07);
    static const double corner[6][2] = {{0, 0}, {1, 0}, {1, 0.3}, {0.3, 0.3}, {0.3, 1}, {0, 1}};
    for (int c = 0; c < 12; c++)
      assert_true(has_point(s, (double[]){corner[c / 2][0], corner[c / 2][1], c % 2 * thick}));
    for (LitheIndex t = 0; t < s->n_tris; t++) assert_true(faces_an_axis(s, t));
    assert_int_equal(s->n_shells, 1);
    lth_surface_destroy(f->ctx, &s);
  }
}

/// Volume of a combination of boxes: that of the blocks between all their sides which it holds.
static double volume_of_boxes(const LthShape *s) {
  double side[3][16], sum = 0;
  LitheIndex n = 2 * s->n_children;
  for (int a = 0; a < 3; a++) {
    for (LitheIndex i = 0; i < n; i++) {
      double x = i % 2 ? s->children[i / 2].b[a] : s->children[i / 2].a[a];
      LitheIndex at = i;
      for (; at > 0 && side[a][at - 1] > x; at--) side[a][at] = side[a][at - 1];
      side[a][at] = x;
    }
  }
  for (LitheIndex i = 0; i + 1 < n; i++)
    for (LitheIndex j = 0; j + 1 < n; j++)
      for (LitheIndex k = 0; k + 1 < n; k++) {
        double size[3] = {side[0][i + 1] - side[0][i], side[1][j + 1] - side[1][j],
                          side[2][k + 1] - side[2][k]};
        double x[3] = {side[0][i] + size[0] / 2, side[1][j] + size[1] / 2,
                       side[2][k] + size[2] / 2};
        double block = size[0] * size[1] * size[2];
        if (block > 0 && lth_shape_value(s, x) < 0) sum += block;
      }
  return sum;
}

/// Coordinates are eighths, hundredths, or any.
static double random_coordinate(uint64_t *seed, int kind) {
  double x = test_random(seed);
  return kind == 0 ? floor(8 * x) / 8 : kind == 1 ? floor(100 * x) / 100 : x;
}

static void random_boxes_have_the_volume_of_the_set_operation(void **state) {
  Fixture *f = *state;
  for (uint64_t number = 1; number <= 40; number++) {
    uint64_t seed = 7919 * number;
    LthShape part[5];
    LitheIndex n = 2 + (LitheIndex)(4 * test_random(&seed));
    for (LitheIndex i = 0; i < n; i++) {
      part[i] = box(0, 0, 0, 0, 0, 0);
      for (int a = 0; a < 3; a++) {
        double p = random_coordinate(&seed, (int)(number % 3)),
               q = random_coordinate(&seed, (int)(number % 3));
        part[i].a[a] = fmin(p, q);
        part[i].b[a] = p == q ? p + 0.25 : fmax(p, q);
      }
    }
    LthShapeKind kinds[] = {LTH_SHAPE_UNION, LTH_SHAPE_DIFFERENCE};
    LthShape shape = join(kinds[number % 2], n, part);
    double volume = volume_of_boxes(&shape);
    if (!(volume > 1e-9)) continue;
    LthSurface *s = surface_of(f->ctx, &shape, 0.11);
    if (!(fabs(lth_surface_volume(s) - volume) <= 1e-12 * volume))
      print_message("number %d\n", (int)number);
    CHECK_NEAR(lth_surface_volume(s), volume, 1e-12 * volume);
    lth_surface_destroy(f->ctx, &s);
  }
}

static void an_l_far_from_the_origin_is_as_exact(void **state) {
  Fixture *f = *state;
  const double o = 1e5;
  LthShape part[] = {box(o, o, o, o + 1, o + 0.3, o + 0.5),
                     box(o, o + 0.3, o, o + 0.3, o + 1, o + 0.5)};
  LthShape l = join(LTH_SHAPE_UNION, 2, part);
  double volume = volume_of_boxes(&l); // of the places as they are stored
  LthSurface *s = surface_of(f->ctx, &l, 0.06);
  CHECK_NEAR(lth_surface_volume(s), volume, 1e-12 * volume);
  lth_surface_destroy(f->ctx, &s);
}

static void walls_much_thinner_than_the_resolution_are_exact(void **state) {
  Fixture *f = *state;
  LthShape part[] = {box(0, 0, 0, 1, 1, 1), box(0.003, 0.004, 0.005, 0.99, 0.98, 2)};
  LthShape tub = join(LTH_SHAPE_DIFFERENCE, 2, part);
  double width = 0.987, depth = 0.976, height = 0.995;
  check_exact(f->ctx, &tub, 0.1, 1 - width * depth * height, 6 + 2 * (width + depth) * height);
  check_exact(f->ctx, &tub, 0.45, 1 - width * depth * height, 6 + 2 * (width + depth) * height);
}

static void holes_within_one_cell_are_exact(void **state) {
  Fixture *f = *state;
  LthShape part[] = {box(0, 0, 0, 1, 1, 1), box(0.41, 0.42, 0.43, 0.44, 0.46, 0.45),
                     box(0.7, 0.71, -1, 0.72, 0.74, 2)};
  LthShape block = join(LTH_SHAPE_DIFFERENCE, 3, part);
  check_exact(f->ctx, &block, 0.3, 1 - 0.03 * 0.04 * 0.02 - 0.02 * 0.03,
              6 + 2 * (0.03 * 0.04 + 0.04 * 0.02 + 0.02 * 0.03) - 2 * 0.02 * 0.03 + 2 * 0.05);
}

static void normal_of(const LthSurface *s, LitheIndex t, double normal[3]) {
  double e[3], f[3];
  lth_v3_sub(tri_point(s, t, 1), tri_point(s, t, 0), e);
  lth_v3_sub(tri_point(s, t, 2), tri_point(s, t, 0), f);
  lth_v3_cross(e, f, normal);
  lth_v3_normalize(normal);
}

typedef struct Side {
  Half ends; ///< in rising order
  LitheIndex tri;
} Side;

/// No two neighbours face each other: parts here meet at right angles and wider.
static void check_unfolded(const LthSurface *s) {
  LitheIndex n = 3 * s->n_tris;
  Side *side = calloc((size_t)n, sizeof *side);
  for (LitheIndex h = 0; h < n; h++) {
    LitheIndex a = s->tris[h], b = s->tris[h / 3 * 3 + (h % 3 + 1) % 3];
    side[h] = (Side){{a < b ? a : b, a < b ? b : a}, h / 3};
  }
  qsort(side, (size_t)n, sizeof *side, compare_halves);
  for (LitheIndex h = 0; h < n; h += 2) {
    double p[3], q[3];
    normal_of(s, side[h].tri, p);
    normal_of(s, side[h + 1].tri, q);
    CHECK_AT_LEAST(lth_v3_dot(p, q), -0.85);
  }
  free(side);
}

/// Errors fall by nearly four from one resolution to the next; from the start they are below `bound`.
static void check_second_order(LitheCtx *ctx, const LthShape *shape, double volume, double area,
                               double bound) {
  double last[2] = {0};
  for (int level = 0; level < 3; level++) {
    LthSurface *s = surface_of(ctx, shape, 0.1 / (1 << level));
    double error[2] = {fabs(lth_surface_volume(s) / volume - 1),
                       area > 0 ? fabs(lth_surface_area(s) / area - 1) : 0};
    assert_int_equal(count_crossings(ctx, s), 0);
    check_unfolded(s);
    CHECK_AT_MOST(error[0], bound / (1 << 2 * level));
    CHECK_AT_MOST(error[1], bound / (1 << 2 * level));
    if (level > 0) CHECK_AT_LEAST(log2(last[0] / error[0]), 1.7);
    last[0] = error[0], last[1] = error[1];
    lth_surface_destroy(ctx, &s);
  }
}

static void curved_parts_converge_with_second_order(void **state) {
  Fixture *f = *state;
  const double origin[3] = {0, 0, 0}, middle[3] = {0.5, 0.5, 0}, r = 0.3;
  LthShape bored[] = {box(0, 0, 0, 1, 1, 0.5), bar(2, -1, 2, middle, r)};
  LthShape block = join(LTH_SHAPE_DIFFERENCE, 2, bored);
  check_second_order(f->ctx, &block, 0.5 - M_PI * r * r * 0.5, 4 - 2 * M_PI * r * r + M_PI * r,
                     4e-3);
  bored[1] = bar(2, 0, 0.5, middle, r); // ends that lie in the block's sides
  check_second_order(f->ctx, &block, 0.5 - M_PI * r * r * 0.5, 4 - 2 * M_PI * r * r + M_PI * r,
                     4e-3);

  LthShape dented[] = {box(0, 0, 0, 1, 1, 1), ball(1, 1, 1, 0.5)};
  LthShape cube = join(LTH_SHAPE_DIFFERENCE, 2, dented);
  check_second_order(f->ctx, &cube, 1 - M_PI / 48, 6 - 3 * M_PI / 16 + M_PI / 8, 1e-3);
  cube.kind = LTH_SHAPE_UNION;
  check_second_order(f->ctx, &cube, 1 + 7 * M_PI / 48, 6 - 3 * M_PI / 16 + 7 * M_PI / 8, 6e-3);

  LthShape crossing[] = {bar(0, -1, 1, origin, r), bar(1, -1, 1, origin, r),
                         bar(2, -1, 1, origin, r)};
  double three = 8 * (2 - sqrt(2)) * r * r * r, two = 16 * r * r * r / 3;
  LthShape cross = join(LTH_SHAPE_UNION, 3, crossing);
  check_second_order(f->ctx, &cross, 6 * M_PI * r * r - 3 * two + three, 0, 1.2e-2);
  cross.kind = LTH_SHAPE_INTERSECTION;
  check_second_order(f->ctx, &cross, three, 24 * (2 - sqrt(2)) * r * r, 2e-2);
  cross.n_children = 2;
  check_second_order(f->ctx, &cross, two, 16 * r * r, 2e-2);
}

static void half_a_shell_has_both_balls(void **state) {
  Fixture *f = *state;
  const double R = 0.5, r = 0.3;
  LthShape part[] = {{.kind = LTH_SHAPE_SHELL, .radius = R, .inner = r}, box(-1, -1, 0, 1, 1, 1)};
  LthShape bowl = join(LTH_SHAPE_INTERSECTION, 2, part);
  check_second_order(f->ctx, &bowl, 2 * M_PI / 3 * (R * R * R - r * r * r),
                     2 * M_PI * (R * R + r * r) + M_PI * (R * R - r * r), 6e-3);
}

/// One bar in two parts, along no axis: their common end is one plane, from whichever side it is told.
static void ends_of_slanting_parts_meet_whichever_way_they_face(void **state) {
  Fixture *f = *state;
  LthShape part[] = {
      {.kind = LTH_SHAPE_CYLINDER, .b = {0.2, 0.4, 0.4}, .radius = 0.3},
      {.kind = LTH_SHAPE_CYLINDER, .a = {0.4, 0.8, 0.8}, .b = {0.2, 0.4, 0.4}, .radius = 0.3}};
  LthShape rod = join(LTH_SHAPE_UNION, 2, part);
  check_second_order(f->ctx, &rod, M_PI * 0.09 * 1.2, 2 * M_PI * 0.3 * (0.3 + 1.2), 1e-2);
}

/// Two round sides that are nearer than chords are deep: where true points would bring triangles to cross, they stay.
static void a_crescent_thinner_than_its_chords_are_deep_has_no_crossings(void **state) {
  Fixture *f = *state;
  for (double t = 0.02; t > 0.004; t *= 0.5) {
    LthShape part[] = {bar(2, 0, 1, (double[]){0, 0, 0}, 0.3),
                       bar(2, 0, 1, (double[]){t, 0, 0}, 0.3)};
    LthShape crescent = join(LTH_SHAPE_DIFFERENCE, 2, part);
    LthSurface *s = surface_of(f->ctx, &crescent, 0.1);
    assert_int_equal(count_crossings(f->ctx, s), 0);
    lth_surface_destroy(f->ctx, &s);
  }
}

static void edges_of_curved_parts_lie_on_both(void **state) {
  Fixture *f = *state;
  LthShape part[] = {box(0, 0, 0, 1, 1, 0.5), bar(2, -1, 2, (double[]){0.5, 0.5, 0}, 0.3)};
  LthShape block = join(LTH_SHAPE_DIFFERENCE, 2, part);
  LthSurface *s = surface_of(f->ctx, &block, 0.06);
  LitheIndex n_rim = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    // no chamfer: each triangle lies in a plane of the box, or has its corners on the cylinder
    bool is_round = true;
    for (int k = 0; k < 3; k++) {
      const double *x = tri_point(s, t, k);
      double off = hypot(x[0] - 0.5, x[1] - 0.5) - 0.3;
      is_round = is_round && fabs(off) < 0.06 * 0.06 / 0.3;
      n_rim += (x[2] == 0 || x[2] == 0.5) && fabs(off) < 1e-13;
    }
    assert_true(is_round || faces_an_axis(s, t));
  }
  CHECK_AT_LEAST(n_rim, 2 * 2 * M_PI * 0.3 / 0.06);
  lth_surface_destroy(f->ctx, &s);
}

static double slope(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return x[0] + 2 * x[1] + 3 * x[2] - 0.6;
}

static void the_box_of_an_implicit_shape_cuts_sharply(void **state) {
  Fixture *f = *state;
  LthShape corner = {
      .kind = LTH_SHAPE_IMPLICIT, .value = {.eval = slope}, .box = {0, 0, 0, 1, 1, 1}};
  LthSurface *s = surface_of(f->ctx, &corner, 0.05);
  CHECK_NEAR(lth_surface_volume(s), 0.6 * 0.3 * 0.2 / 6, 1e-13);
  lth_surface_destroy(f->ctx, &s);
}

static void boxes_that_touch_in_an_edge_or_a_corner_stay_apart(void **state) {
  Fixture *f = *state;
  LthShape edge[] = {box(0, 0, 0, 1, 1, 1), box(1, 1, 0, 2, 2, 1)};
  LthShape corner[] = {box(0, 0, 0, 1, 1, 1), box(1, 1, 1, 2, 2, 2)};
  for (int i = 0; i < 2; i++) {
    LthShape two = join(LTH_SHAPE_UNION, 2, i ? corner : edge);
    LthSurface *s = surface_of(f->ctx, &two, 0.21);
    assert_int_equal(s->n_shells, 2);
    CHECK_NEAR(lth_surface_volume(s), 2, 1e-12);
    CHECK_NEAR(lth_surface_area(s), 12, 1e-11);
    lth_surface_destroy(f->ctx, &s);
  }
}

/// Sides that coincide without being known for one function: a capsule around a cylinder.
static void parts_that_share_a_curved_side_are_joined(void **state) {
  Fixture *f = *state;
  LthShape part[] = {{.kind = LTH_SHAPE_CAPSULE, .b = {0, 0, 1}, .radius = 0.3},
                     bar(2, 0, 1, (double[]){0, 0, 0}, 0.3)};
  LthShape pill = join(LTH_SHAPE_UNION, 2, part);
  check_second_order(f->ctx, &pill, M_PI * 0.09 + 4 * M_PI / 3 * 0.027, 0, 2e-2);
}

static void more_than_fits_into_a_cell_is_told_and_chamfered(void **state) {
  Fixture *f = *state;
  LthShape part[40];
  part[0] = box(0, 0, 0, 1, 1, 1);
  for (int i = 1; i < 40; i++) {
    double x = 0.4 + 0.002 * i;
    part[i] = box(x, -1, 0.5, x + 0.001, 2, 2);
  }
  LthShape comb = join(LTH_SHAPE_DIFFERENCE, 40, part);
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &comb, 0.3, &s));
  assert_int_equal(lithe_ctx_warning_count(f->ctx), 1);
  assert_non_null(strstr(lithe_ctx_warning(f->ctx, 0), "chamfered at its resolution of 0.3 m"));
  check_closed(s);
  lth_surface_destroy(f->ctx, &s);
}

static LthSurface *with_threads(const LthShape *shape, int threads, LitheCtx **ctx) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = threads;
  *ctx = lithe_ctx_create(&def);
  return surface_of(*ctx, shape, 0.07);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  (void)state;
  LthShape part[] = {box(0, 0, 0, 1, 1, 0.5), bar(2, -1, 2, (double[]){0.5, 0.5, 0}, 0.3),
                     ball(1, 1, 0.5, 0.25)};
  LthShape shape = join(LTH_SHAPE_DIFFERENCE, 3, part);
  LitheCtx *one, *other;
  LthSurface *s = with_threads(&shape, 1, &one);
  for (int threads = 2; threads <= 7; threads += 5) {
    LthSurface *t = with_threads(&shape, threads, &other);
    assert_int_equal(s->n_points, t->n_points);
    assert_int_equal(s->n_tris, t->n_tris);
    assert_memory_equal(s->points, t->points, 3 * (size_t)s->n_points * sizeof *s->points);
    assert_memory_equal(s->tris, t->tris, 3 * (size_t)s->n_tris * sizeof *s->tris);
    lth_surface_destroy(other, &t);
    lithe_ctx_destroy(&other);
  }
  lth_surface_destroy(one, &s);
  lithe_ctx_destroy(&one);
}

static void sides_in_one_plane_are_one_field(void **state) {
  Fixture *f = *state;
  LthShape part[] = {box(0, 0, 0, 1, 1, 1), box(1, 0, 0, 2, 1, 1),
                     bar(2, 0, 1, (double[]){0.5, 0.5, 0}, 0.3),
                     bar(2, 1, 2, (double[]){0.5, 0.5, 0}, 0.3)};
  LthShape shape = join(LTH_SHAPE_UNION, 4, part);
  LthSolid *solid = NULL;
  CHECK_OK(f->ctx, lth_solid_create(f->ctx, &shape, &solid));
  assert_int_equal(solid->n_fields, 3 + 2 + 2 + 2); // x at 3 places, y at 2, z at 3, one round side
  lth_solid_destroy(f->ctx, &solid);
}

static void sides_follow_the_formula_and_open_ones_stay_open(void **state) {
  Fixture *f = *state;
  LthShape part[] = {ball(0, 0, 0, 1), ball(3, 0, 0, 1), ball(1.5, 0, 0, 1)};
  LthShape two = join(LTH_SHAPE_UNION, 2, part), all[] = {two, part[2]};
  LthShape shape = join(LTH_SHAPE_DIFFERENCE, 2, all);
  LthSolid *solid = NULL;
  CHECK_OK(f->ctx, lth_solid_create(f->ctx, &shape, &solid));
  assert_int_equal(solid->n_fields, 3);
  LitheIndex open[3];
  for (int code = 0; code < 27; code++) {
    LthFieldSide side[3] = {(LthFieldSide)(code % 3 - 1), (LthFieldSide)(code / 3 % 3 - 1),
                            (LthFieldSide)(code / 9 - 1)};
    int either = side[0] < side[1] ? side[0] : side[1];
    int want = either > -side[2] ? either : -side[2];
    assert_int_equal(lth_solid_side(solid, side), want);
    LitheIndex n = lth_solid_undecided(solid, side, 3, open);
    if (want != 0) assert_int_equal(n, 0);
    if (want == 0) assert_in_range(n, 1, (side[0] == 0) + (side[1] == 0) + (side[2] == 0));
  }
  lth_solid_destroy(f->ctx, &solid);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(an_l_of_two_boxes_is_exact_whether_they_overlap_or_touch),
      TEST(random_boxes_have_the_volume_of_the_set_operation),
      TEST(an_l_far_from_the_origin_is_as_exact),
      TEST(walls_much_thinner_than_the_resolution_are_exact),
      TEST(holes_within_one_cell_are_exact),
      TEST(curved_parts_converge_with_second_order),
      TEST(half_a_shell_has_both_balls),
      TEST(ends_of_slanting_parts_meet_whichever_way_they_face),
      TEST(a_crescent_thinner_than_its_chords_are_deep_has_no_crossings),
      TEST(edges_of_curved_parts_lie_on_both),
      TEST(the_box_of_an_implicit_shape_cuts_sharply),
      TEST(boxes_that_touch_in_an_edge_or_a_corner_stay_apart),
      TEST(parts_that_share_a_curved_side_are_joined),
      TEST(more_than_fits_into_a_cell_is_told_and_chamfered),
      TEST(any_number_of_threads_gives_the_same_bits),
      TEST(sides_in_one_plane_are_one_field),
      TEST(sides_follow_the_formula_and_open_ones_stay_open),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
