/// What the reader makes of the staggered method and of scenes in two dimensions.
#include "base/tensor.h"
#include "scene_text.h"

#include "embed/contact.h"
#include "scene/body.h"

static Reading read_override(const char *override) {
  Reading r =
      read_with(SMALL_SCENE, 2, (const char *const[]){"bodies.0.method.kind=staggered", override});
  CHECK_OK(r.ctx, r.status);
  return r;
}

static void reads_the_keys_of_the_staggered_method(void **state) {
  (void)state;
  Reading r = read_override("title=defaults");
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_int_equal(r.scene->dimension, 3);
  assert_int_equal(b->method_kind, LTH_METHOD_STAGGERED);
  assert_int_equal(b->fractions.method, LTH_FRACTIONS_EXACT);
  assert_false(b->has_fractions);
  assert_int_equal(b->formulation, LTH_FORMULATION_AUTO);
  assert_int_equal(b->resolution.cells[0], 4);
  end_reading(&r);
  r = read_override("bodies.0.method.fractions={samples: 8}");
  assert_int_equal(r.scene->bodies[0].fractions.method, LTH_FRACTIONS_SAMPLES);
  assert_int_equal(r.scene->bodies[0].fractions.samples, 8);
  assert_true(r.scene->bodies[0].has_fractions);
  end_reading(&r);
  r = read_override("bodies.0.method.fractions=smooth");
  assert_int_equal(r.scene->bodies[0].fractions.method, LTH_FRACTIONS_SMOOTH);
  end_reading(&r);
  r = read_override("bodies.0.method.fractions={smooth: 2}");
  assert_int_equal(r.scene->bodies[0].fractions.method, LTH_FRACTIONS_SMOOTH);
  CHECK_NEAR(r.scene->bodies[0].fractions.half_width, 2, 0);
  end_reading(&r);
  r = read_override("bodies.0.method.formulation=mixed");
  assert_int_equal(r.scene->bodies[0].formulation, LTH_FORMULATION_MIXED);
  end_reading(&r);
}

#define EXPECT_STAGGERED_ERROR(override, line)                                                     \
  expect_lines(SMALL_SCENE, 2, (const char *const[]){"bodies.0.method.kind=staggered", override},  \
               (const char *const[]){line, NULL})

static void refuses_what_a_staggered_grid_cannot_take(void **state) {
  (void)state;
  EXPECT_STAGGERED_ERROR("bodies.0.method.fractions={samples: 5}",
                         "--set bodies.0.method.fractions={samples: 5}: "
                         "bodies.0.method.fractions.samples: control volumes share halves of "
                         "cells, got 5 samples; expected an even number");
  EXPECT_STAGGERED_ERROR("bodies.0.method.mesh=hexahedra",
                         "--set bodies.0.method.mesh=hexahedra: bodies.0.method.mesh: a staggered "
                         "grid has no mesh, got \"hexahedra\"; expected cells, cell_size or grid "
                         "alone");
}

static void takes_incompressible_bodies_where_mixed_may_be_taken(void **state) {
  (void)state;
  const char *half = "bodies.0.material.poisson_ratio=0.5";
  Reading r = read_override(
      "bodies.0.material={model: linear, young_modulus: 1 MPa, poisson_ratio: 0.5, density: 1000}");
  end_reading(&r);
  EXPECT_STAGGERED_ERROR(half, "--set bodies.0.material.poisson_ratio=0.5: "
                               "bodies.0.material.poisson_ratio: only the mixed formulation keeps "
                               "volumes, and it is of linear bodies, got 0.5 with model corotated; "
                               "expected a number < 0.5, or `model: linear`");
#define NOT_MIXED(with)                                                                            \
  "--set bodies.0.material.poisson_ratio=0.5: bodies.0.material.poisson_ratio: only the mixed "    \
  "formulation keeps volumes, got 0.5 with " with                                                  \
  "; expected a number < 0.5, or `kind: staggered` with `formulation: mixed`"
  EXPECT_OVERRIDE_ERROR("bodies.0.material.poisson_ratio=0.5", NOT_MIXED("kind dg"));
  expect_lines(SMALL_SCENE, 3,
               (const char *const[]){"bodies.0.method.kind=staggered",
                                     "bodies.0.method.formulation=displacement", half},
               (const char *const[]){NOT_MIXED("formulation displacement"), NULL});
}

/// Lines 1 to 8; tests add further keys behind.
#define PLANE_SCENE(shape)                                                                         \
  "lithe: 1\n"                                                                                     \
  "dimension: 2\n"                                                                                 \
  "bodies:\n"                                                                                      \
  "  - name: plate\n"                                                                              \
  "    shape: " shape "\n"                                                                         \
  "    material: {young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}\n"                      \
  "    method: {kind: staggered, cells: [8, 4]}\n"
#define DISK "{disk: {center: [1, 2], radius: 0.5}}"

static double value_at(const LthShape *shape, double x, double y) {
  return lth_shape_value(shape, (const double[]){x, y, 0});
}

static void check_plane_vector(const double v[3], double x, double y) {
  CHECK_NEAR(v[0], x, 1e-15);
  CHECK_NEAR(v[1], y, 1e-15);
  CHECK_NEAR(v[2], 0, 0);
}

static void vectors_of_two_entries_lie_in_the_plane(void **state) {
  (void)state;
  Reading r = read_good(PLANE_SCENE(
      DISK) "    place: {translate: [1, 2]}\n"
            "    constraints: [{where: {plane: {point: [1, 2], normal: [0, 2]}}, displacement: "
            "[null, \"0.1*t*x\"]}]\n"
            "    loads: [{where: {normal: [1, 0]}, stress: [[1, 2], [3, \"y\"]]}, {where: all, "
            "traction: [5, 6]}]\n"
            "    initial: {velocity: [1, \"x\"]}\n"
            "gravity: [0, -9.81]\n"
            "colliders: [{disk: {center: [0, -1], radius: 1, motion: [\"t\", 0]}}, {box: {min: [0, "
            "0], max: [1, 1]}}]\n"
            "probes: [{name: a, point: [3, 4]}]\n"
            "exact: {displacement: [\"x\", 7], stress: [[1, 2], [2, 3]]}\n");
  const LthScene *s = r.scene;
  const LthSceneBody *b = &s->bodies[0];
  assert_int_equal(s->dimension, 2);
  check_plane_vector(s->gravity, 0, -9.81);
  check_plane_vector(s->probes[0].point, 3, 4);
  check_plane_vector(b->place_translation, 1, 2);
  check_plane_vector(b->constraints[0].where.normal, 0, 1);
  assert_false(b->constraints[0].fixed[0]);
  assert_true(b->constraints[0].fixed[1]);
  assert_false(b->constraints[0].fixed[2]);
  const double x[3] = {2, 3, 0};
  CHECK_NEAR(lth_value_at(&b->constraints[0].value[1], x, 5), 1, 1e-15);
  CHECK_NEAR(b->loads[0].stress[3].constant, 3, 0);
  CHECK_NEAR(lth_value_at(&b->loads[0].stress[4], x, 0), 3, 0);
  for (int i = 0; i < 3; i++) CHECK_NEAR(b->loads[0].stress[6 + i].constant, 0, 0);
  CHECK_NEAR(b->loads[1].value[1].constant, 6, 0);
  CHECK_NEAR(lth_value_at(&b->initial_velocity[1], x, 0), 2, 0);
  CHECK_NEAR(s->exact[1].constant, 7, 0);
  CHECK_NEAR(s->exact_stress[4].constant, 3, 0);
  assert_int_equal(b->resolution.cells[1], 4);
  assert_int_equal(b->resolution.cells[2], 1);
  assert_int_equal(s->colliders[0].kind, LTH_COLLIDER_SPHERE);
  check_plane_vector(s->colliders[0].shape.a, 0, -1);
  assert_int_equal(s->colliders[1].kind, LTH_COLLIDER_BOX);
  end_reading(&r);
}

static void grids_of_planes_are_one_cell_of_one_metre_thick(void **state) {
  (void)state;
  Reading r = read_with(PLANE_SCENE(DISK), 2,
                        (const char *const[]){"bodies.0.method={kind: staggered, grid: {min: [-1, "
                                              "0], max: [3, 4], cells: [5, 6]}}",
                                              "gravity=[0, 0]"});
  CHECK_OK(r.ctx, r.status);
  const LthGrid *grid = &r.scene->bodies[0].resolution.grid;
  CHECK_NEAR(grid->min[2], -0.5, 0);
  CHECK_NEAR(grid->max[2], 0.5, 0);
  CHECK_NEAR(grid->max[1], 4, 0);
  assert_int_equal(grid->cells[1], 6);
  assert_int_equal(grid->cells[2], 1);
  end_reading(&r);
}

static void reads_the_shapes_of_the_plane(void **state) {
  (void)state;
  Reading r = read_good(PLANE_SCENE(DISK));
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 1, 2), -0.5, 1e-15);
  end_reading(&r);
  r = read_good(PLANE_SCENE("{annulus: {center: [1, 0], inner: 1, outer: 3}}"));
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 1, 0), 1, 0);
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 1, 1.5), -0.5, 1e-15);
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 5, 0), 1, 0);
  end_reading(&r);
  r = read_good(PLANE_SCENE("{box: {min: [0, 0], max: [4, 2]}}"));
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 2, 0.75), -0.75, 0);
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 7, 6), 5, 0);
  double min[3], max[3];
  lth_shape_bounds(&r.scene->bodies[0].shape, min, max);
  check_plane_vector(max, 4, 2);
  end_reading(&r);
  r = read_good(PLANE_SCENE("{polygon: [[0, 0], [4, 0], [2 m, 1000 mm], [0, 4]]}"));
  CHECK_NEAR(r.scene->bodies[0].shape.loops->area, 6, 0);
  end_reading(&r);
  r = read_good(
      PLANE_SCENE("{polygon: [[[0, 0], [4, 0], [4, 4], [0, 4]], [[1, 1], [2, 1], [1, 2]]]}"));
  CHECK_NEAR(r.scene->bodies[0].shape.loops->area, 15.5, 0);
  end_reading(&r);
  r = read_good(PLANE_SCENE("{difference: [{implicit: {value: \"x^2+y^2-4\", min: [-2, -2], max: "
                            "[2, 2]}}, {union: [" DISK
                            ", {disk: {center: [0, 0], radius: 1}}]}]}"));
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 1.5, 0), -0.5, 1e-15);
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 0.5, 0), 0.5, 0);
  CHECK_NEAR(value_at(&r.scene->bodies[0].shape, 3, 0), 5, 0);
  end_reading(&r);
}

static void turns_shapes_by_an_angle_alone(void **state) {
  (void)state;
  const char *const forms[] = {"place: {rotate: 90 deg, translate: [1, 0]}",
                               "place: {rotate: {angle: 90 deg}, translate: [1, 0]}"};
  for (int k = 0; k < 2; k++) {
    char text[600];
    snprintf(text, sizeof text, "%s    %s\n",
             PLANE_SCENE("{union: [{box: {min: [0, 0], max: [4, 2]}}, {disk: {center: [5, 0], "
                         "radius: 0.5}}]}"),
             forms[k]);
    Reading r = read_good(text);
    const LthShape *shape = &r.scene->bodies[0].shape;
    // the box now reaches from x = -1 to 1 and y = 0 to 4, the disk is at (1, 5)
    CHECK_NEAR(value_at(shape, 0, 2), -1, 1e-15);
    CHECK_NEAR(value_at(shape, -1.25, 2), 0.25, 1e-15);
    CHECK_NEAR(value_at(shape, 1, 5), -0.5, 1e-15);
    end_reading(&r);
  }
}

#define EXPECT_PLANE_ERROR(override, line)                                                         \
  expect_lines(PLANE_SCENE(DISK), 1, (const char *const[]){override},                              \
               (const char *const[]){"--set " override ": " line, NULL})

static void refuses_what_belongs_to_space(void **state) {
  (void)state;
  EXPECT_PLANE_ERROR("gravity=[0, 0, -9.81]", "gravity: wrong length, got a list of 3; expected a "
                                              "list of 2 numbers [m/s^2]");
  EXPECT_PLANE_ERROR("bodies.0.shape={sphere: {center: [0, 0], radius: 1}}",
                     "bodies.0.shape.sphere: it is of scenes in three dimensions, got sphere in "
                     "`dimension: 2`; expected one of box, implicit, union, intersection, "
                     "difference, disk, annulus, polygon, image");
  EXPECT_PLANE_ERROR("bodies.0.embed={}",
                     "bodies.0.embed: it is of scenes in three dimensions, got embed in "
                     "`dimension: 2`; leave it out");
  EXPECT_PLANE_ERROR("bodies.0.material.young_modulus=1+z^2",
                     "bodies.0.material.young_modulus: it varies with z, got \"1+z^2\"; expected a "
                     "number or an expression of x, y, value, label");
  EXPECT_PLANE_ERROR("bodies.0.method.kind=dg",
                     "bodies.0.method.kind: it works in three dimensions alone, got \"dg\"; "
                     "expected staggered");
  EXPECT_PLANE_ERROR("bodies.0.place={rotate: {axis: [0, 1], angle: 1}}",
                     "bodies.0.place.rotate.axis: it is of scenes in three dimensions, got axis in "
                     "`dimension: 2`; leave it out");
  EXPECT_PLANE_ERROR("bodies.0.loads=[{where: all, stress: [[1, 0], [0, 1, 2]]}]",
                     "bodies.0.loads.0.stress.1: wrong length, got a list of 3; expected a list of "
                     "2 numbers");
  EXPECT_OVERRIDE_ERROR("bodies.0.shape={disk: {center: [0, 0, 0], radius: 1}}",
                        "--set bodies.0.shape={disk: {center: [0, 0, 0], radius: 1}}: "
                        "bodies.0.shape.disk: it is of scenes in two dimensions, got disk in three "
                        "(write `dimension: 2` for a plane); expected one of box, sphere, "
                        "cylinder, capsule, shell, mesh, implicit, union, intersection, "
                        "difference, image");
  EXPECT_OVERRIDE_ERROR("bodies.0.place={rotate: 45 deg}",
                        "--set bodies.0.place={rotate: 45 deg}: bodies.0.place.rotate: a rotation "
                        "in space has an axis, got \"45 deg\"; expected {axis, angle}");
}

static void names_what_is_wrong_with_a_polygon(void **state) {
  (void)state;
  EXPECT_PLANE_ERROR("bodies.0.shape={polygon: [[0, 0], [1, 0]]}",
                     "bodies.0.shape.polygon: loop 1 of the polygon has 2 different corners; "
                     "expected at least three");
  EXPECT_PLANE_ERROR("bodies.0.shape={polygon: [[0, 0], [1, 0], [1, 1, 1]]}",
                     "bodies.0.shape.polygon.2: no corner, got a list of 3; expected [x, y]");
  EXPECT_PLANE_ERROR("bodies.0.shape={polygon: [[0, 0], [1, 1], [1, 0], [0, 2]]}",
                     "bodies.0.shape.polygon: the polygon touches or crosses itself at about "
                     "(0.666667, 0.666667): an edge of loop 1 from (0, 0) on meets one of loop 1 "
                     "from (1, 0) on; expected loops "
                     "without common points");
  EXPECT_PLANE_ERROR("bodies.0.shape={annulus: {center: [0, 0], inner: 2, outer: 1}}",
                     "bodies.0.shape.annulus.inner: not inside the outer radius, got 2 and 1; "
                     "expected inner < outer");
}

// A square of a metre's depth rests on a strip, a cube of the same side on a spot: the same pressure, whatever the side.
static void a_spot_in_the_plane_carries_the_pressure_that_one_in_space_does(void **state) {
  (void)state;
  for (double side = 0.01; side < 100; side *= 10) {
    LthScene plane = {.dimension = 2, .gravity = {0, -9.81, 0}},
             space = {.dimension = 3, .gravity = {0, -9.81, 0}};
    LthBody square = {.scene = &plane, .size = side, .mass = 1000 * side * side},
            cube = {.scene = &space, .size = side, .mass = 1000 * side * side * side};
    CHECK_NEAR(lth_body_weight(&cube), 9810 * side * side * side, 1e-12);
    CHECK_NEAR(lth_body_weight(&square) / lth_body_weight(&cube), LTH_CONTACT_SPOT, 1e-12);
    // the spot in space is as wide as it is deep
    CHECK_NEAR(LTH_CONTACT_SPOT * LTH_CONTACT_SPOT, 0.004, 1e-12);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_the_keys_of_the_staggered_method),
      cmocka_unit_test(refuses_what_a_staggered_grid_cannot_take),
      cmocka_unit_test(takes_incompressible_bodies_where_mixed_may_be_taken),
      cmocka_unit_test(vectors_of_two_entries_lie_in_the_plane),
      cmocka_unit_test(grids_of_planes_are_one_cell_of_one_metre_thick),
      cmocka_unit_test(reads_the_shapes_of_the_plane),
      cmocka_unit_test(turns_shapes_by_an_angle_alone),
      cmocka_unit_test(refuses_what_belongs_to_space),
      cmocka_unit_test(names_what_is_wrong_with_a_polygon),
      cmocka_unit_test(a_spot_in_the_plane_carries_the_pressure_that_one_in_space_does),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
