/// Shapes: distances, bounds, and surfaces that are closed, oriented and on the true surface.
#include "closed_surface.h"
#include "ctx_fixture.h"

#include "base/tensor.h"
#include "geometry/shape.h"

static void free_surface(LitheCtx *ctx, LthSurface *s) {
  lth_free(ctx, s->points), lth_free(ctx, s->tris), lth_free(ctx, s->tri_shell);
  lth_free(ctx, s->tri_poly), lth_free(ctx, s->soup_point), lth_free(ctx, s);
}

static double volume(const LthSurface *s) {
  double sum = 0, n[3], a[3], b[3];
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    lth_v3_sub(tri_point(s, t, 1), tri_point(s, t, 0), a);
    lth_v3_sub(tri_point(s, t, 2), tri_point(s, t, 0), b);
    lth_v3_cross(a, b, n);
    lth_v3_sub(tri_point(s, t, 0), s->points, a);
    sum += lth_v3_dot(n, a) / 6;
  }
  return sum;
}

static const LthShape box = {.kind = LTH_SHAPE_BOX, .a = {-1, 0, 2}, .b = {1, 3, 4}};
static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {1, 2, 3}, .radius = 0.7};
static const LthShape can = {
    .kind = LTH_SHAPE_CYLINDER, .a = {0, 1, 0}, .b = {1, 2, 0.5}, .radius = 0.4};
static const LthShape pill = {
    .kind = LTH_SHAPE_CAPSULE, .a = {0, 1, 0}, .b = {1, 2, 0.5}, .radius = 0.4};
static const LthShape shell = {.kind = LTH_SHAPE_SHELL, .a = {0, 0, 1}, .radius = 1, .inner = 0.9};

static void box_has_eight_points_and_twelve_triangles(void **state) {
  Fixture *f = *state;
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &box, 0, &s));
  assert_int_equal(s->n_points, 8);
  assert_int_equal(s->n_tris, 12);
  check_closed(s);
  CHECK_NEAR(volume(s), 12, 1e-13);
  free_surface(f->ctx, s);
}

/// Points of the tessellation lie on the surface, it is closed, and its volume comes near the exact one
/// from below (convex shapes).
static void check_primitive(LitheCtx *ctx, const LthShape *shape, double resolution, double exact) {
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_shape_tessellate(ctx, shape, resolution, &s));
  check_closed(s);
  double min[3], max[3];
  lth_shape_bounds(shape, min, max);
  for (LitheIndex p = 0; p < s->n_points; p++) {
    CHECK_NEAR(lth_shape_value(shape, s->points + 3 * p), 0, 1e-14);
    for (int i = 0; i < 3; i++) {
      CHECK_AT_LEAST(s->points[3 * p + i], min[i] - 1e-14);
      CHECK_AT_MOST(s->points[3 * p + i], max[i] + 1e-14);
    }
  }
  double longest = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++)
    for (int k = 0; k < 3; k++)
      longest = fmax(longest, lth_v3_distance(tri_point(s, t, k), tri_point(s, t, (k + 1) % 3)));
  CHECK_AT_MOST(longest, 1.7 * resolution);
  CHECK_NEAR(volume(s), exact, 0.02 * exact);
  if (shape->kind != LTH_SHAPE_SHELL) CHECK_AT_MOST(volume(s), exact);
  assert_int_equal(s->n_shells, shape->kind == LTH_SHAPE_SHELL ? 2 : 1);
  free_surface(ctx, s);
}

static void primitives_are_closed_and_on_the_true_surface(void **state) {
  Fixture *f = *state;
  double length = 1.5, r = 0.4, bar = M_PI * r * r * length, end = 4 * M_PI / 3 * r * r * r;
  check_primitive(f->ctx, &ball, 0.1, 4 * M_PI / 3 * 0.343);
  check_primitive(f->ctx, &can, 0.08, bar);
  check_primitive(f->ctx, &pill, 0.08, bar + end);
  check_primitive(f->ctx, &shell, 0.06, 4 * M_PI / 3 * (1 - 0.729));
}

static void distances_are_exact(void **state) {
  (void)state;
  CHECK_NEAR(lth_shape_value(&box, (double[]){2, 4, 5}), sqrt(3), 1e-15);
  CHECK_NEAR(lth_shape_value(&box, (double[]){0, 0.25, 3}), -0.25, 1e-15);
  CHECK_NEAR(lth_shape_value(&ball, (double[]){1, 2, 3}), -0.7, 1e-15);
  LthShape up = {.kind = LTH_SHAPE_CYLINDER, .a = {0, 0, 0}, .b = {0, 0, 2}, .radius = 1};
  CHECK_NEAR(lth_shape_value(&up, (double[]){4, 0, 6}), 5, 1e-15);
  CHECK_NEAR(lth_shape_value(&up, (double[]){0.5, 0, 1.9}), -0.1, 1e-15);
  up.kind = LTH_SHAPE_CAPSULE;
  CHECK_NEAR(lth_shape_value(&up, (double[]){0, 3, 6}), 4, 1e-15);
  CHECK_NEAR(lth_shape_value(&shell, (double[]){0, 0, 1}), 0.9, 1e-15);
  CHECK_NEAR(lth_shape_value(&shell, (double[]){0, 0.95, 1}), -0.05, 1e-15);
}

static double torus(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return hypot(hypot(x[0], x[1]) - 1, x[2]) - 0.3;
}

static const LthShape ring = {
    .kind = LTH_SHAPE_IMPLICIT, .value = {.eval = torus}, .box = {-1.3, -1.3, -0.3, 1.3, 1.3, 0.3}};

static void implicit_torus_is_a_closed_manifold_of_genus_one(void **state) {
  Fixture *f = *state;
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &ring, 0.09, &s));
  check_closed(s);
  assert_int_equal(s->n_points - s->n_tris / 2, 0); // V - E + F with E = 3 F / 2
  assert_int_equal(s->n_shells, 1);
  CHECK_NEAR(volume(s), 2 * M_PI * M_PI * 0.09, 0.03);
  for (LitheIndex p = 0; p < s->n_points; p++)
    CHECK_NEAR(lth_shape_value(&ring, s->points + 3 * p), 0,
               2e-4 * 0.09); // ends of edges are kept away from
  free_surface(f->ctx, s);
}

static void combinations_have_the_volume_of_the_set_operation(void **state) {
  Fixture *f = *state;
  LthShape parts[2] = {{.kind = LTH_SHAPE_BOX, .a = {0, 0, 0}, .b = {1, 1, 1}},
                       {.kind = LTH_SHAPE_SPHERE, .a = {1, 1, 1}, .radius = 0.5}};
  double eighth = M_PI / 6 * 0.125; // an eighth of the ball lies in the box
  const struct {
    LthShapeKind kind;
    double volume;
  } cases[] = {{LTH_SHAPE_UNION, 1 + 7 * eighth},
               {LTH_SHAPE_INTERSECTION, eighth},
               {LTH_SHAPE_DIFFERENCE, 1 - eighth}};
  for (int i = 0; i < 3; i++) {
    LthShape shape = {.kind = cases[i].kind, .children = parts, .n_children = 2};
    LthSurface *s = NULL;
    CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &shape, 0.05, &s));
    check_closed(s);
    CHECK_NEAR(volume(s), cases[i].volume, 0.01 * (cases[i].volume + 0.1));
    free_surface(f->ctx, s);
  }
}

static double noise(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return sin(7 * x[0]) * sin(8 * x[1]) + 0.5 * cos(9 * x[2] + x[0]) - 0.05;
}

static void a_wild_function_still_gives_a_closed_manifold(void **state) {
  Fixture *f = *state;
  LthShape shape = {
      .kind = LTH_SHAPE_IMPLICIT, .value = {.eval = noise}, .box = {0, 0, 0, 1, 1, 1}};
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &shape, 0.11, &s));
  check_closed(s);
  CHECK_AT_LEAST(volume(s), 0.1);
  free_surface(f->ctx, s);
}

static void refuses_shapes_without_a_surface(void **state) {
  Fixture *f = *state;
  LthSurface *s = NULL;
  LthShape empty = ring, flat = box, dot = ball;
  empty.value = lth_value_constant(1);
  assert_int_equal(lth_shape_tessellate(f->ctx, &empty, 0.1, &s), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(f->ctx), "no surface found"));
  flat.b[1] = flat.a[1];
  assert_int_equal(lth_shape_tessellate(f->ctx, &flat, 0.1, &s), LITHE_BAD_INPUT);
  dot.radius = 0;
  assert_int_equal(lth_shape_tessellate(f->ctx, &dot, 0.1, &s), LITHE_BAD_INPUT);
  assert_int_equal(lth_shape_tessellate(f->ctx, &ball, 1e-9, &s), LITHE_BAD_INPUT);
  assert_int_equal(lth_shape_tessellate(f->ctx, &ball, 0, &s), LITHE_BAD_INPUT);
  assert_null(s);
}

static void mesh_distance_agrees_with_the_plain_search_and_the_formula(void **state) {
  Fixture *f = *state;
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &ring, 0.09, &s));
  LthShape plain = {.kind = LTH_SHAPE_MESH, .surface = s}, fast = plain;
  CHECK_OK(f->ctx, lth_shape_prepare(f->ctx, &fast));
  uint64_t seed = 7;
  for (int i = 0; i < 300; i++) {
    double x[3];
    for (int a = 0; a < 3; a++) x[a] = 3 * test_random(&seed) - 1.5;
    double d = lth_shape_value(&fast, x);
    CHECK_NEAR(d, lth_shape_value(&plain, x), 1e-14);
    CHECK_NEAR(d, torus(NULL, x, 0), 0.02);
  }
  lth_shape_free(f->ctx, &fast);
  free_surface(f->ctx, s);
}

static void sign_is_right_around_sharp_corners(void **state) {
  Fixture *f = *state;
  LthSurface *s = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &box, 0, &s));
  LthShape mesh = {.kind = LTH_SHAPE_MESH, .surface = s};
  CHECK_OK(f->ctx, lth_shape_prepare(f->ctx, &mesh));
  uint64_t seed = 3;
  for (int i = 0; i < 2000; i++) {
    double x[3], normal[3], step[3];
    for (int a = 0; a < 3; a++)
      x[a] = box.a[a] - 1 + (box.b[a] - box.a[a] + 2) * test_random(&seed);
    double d = lth_bvh_signed_distance(mesh.bvh, x, normal);
    CHECK_NEAR(d, lth_shape_value(&box, x), 1e-14);
    CHECK_NEAR(lth_v3_norm(normal), 1, 1e-14);
    lth_v3_copy(x, step);
    lth_v3_axpy(-0.5 * d, normal, step); // half way to the surface
    CHECK_NEAR(lth_shape_value(&box, step), 0.5 * d, 1e-13);
  }
  lth_shape_free(f->ctx, &mesh);
  free_surface(f->ctx, s);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(box_has_eight_points_and_twelve_triangles),
      TEST(primitives_are_closed_and_on_the_true_surface),
      TEST(distances_are_exact),
      TEST(implicit_torus_is_a_closed_manifold_of_genus_one),
      TEST(combinations_have_the_volume_of_the_set_operation),
      TEST(a_wild_function_still_gives_a_closed_manifold),
      TEST(refuses_shapes_without_a_surface),
      TEST(mesh_distance_agrees_with_the_plain_search_and_the_formula),
      TEST(sign_is_right_around_sharp_corners),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
