/// What the reader says about wrong scenes, to the letter: place, path, what is wrong, what is expected.
#include "scene_text.h"

static void reads_the_small_scene(void **state) {
  (void)state;
  Reading r = read_good(SMALL_SCENE);
  end_reading(&r);
}

static void finds_all_errors_in_one_run(void **state) {
  (void)state;
  const char *text =
      "lithe: 1\n"
      "titel: x\n"
      "bodies:\n"
      "  - shape: {box: {min: [0, 0, 0], max: [1, 2 kg, 3]}}\n"
      "    material: {young_modulus: 50 kPaa, poisson_ratio: 0.6}\n"
      "    method: {cells: 0, flux: ipp, degree: 5}\n"
      "    loads: 5\n"
      "    constraints:\n"
      "      - {where: {plane: {point: [0, 0, 0], normal: [0, 0, 0]}}, displacement: [0, "
      "\"sin(x\", 0]}\n"
      "time: dynamic\n";
  EXPECT_ERRORS(text, "s.yaml:2:1: titel: unknown key, got \"titel\"; did you mean title?",
                "s.yaml:4:44: bodies.0.shape.box.max.1: wrong dimension, got \"2 kg\", a mass; "
                "expected a length [m]",
                "s.yaml:5:15: bodies.0.material.density: missing, but time is dynamic; expected a "
                "number > 0 [kg/m^3]",
                "s.yaml:5:31: bodies.0.material.young_modulus: unknown unit \"kPaa\", got \"50 "
                "kPaa\"; did you mean "
                "kPa?",
                "s.yaml:5:55: bodies.0.material.poisson_ratio: out of range, got \"0.6\"; expected "
                "a number > -1 and "
                "<= 0.5",
                "s.yaml:6:21: bodies.0.method.cells: out of range, got \"0\"; expected an integer "
                ">= 1 and <= 100000",
                "s.yaml:6:30: bodies.0.method.flux: unknown word, got \"ipp\"; expected ip or bz, "
                "did you mean ip?",
                "s.yaml:6:43: bodies.0.method.degree: out of range, got \"5\"; expected an integer "
                ">= 1 and <= 4",
                "s.yaml:7:12: bodies.0.loads: wrong type, got \"5\"; expected a list, each a load "
                "such as {where: all, "
                "traction: [0, 0, 1 kPa]}",
                "s.yaml:9:52: bodies.0.constraints.0.where.plane.normal: a direction without "
                "length, got [0, 0, 0]; "
                "expected three numbers that are not all 0",
                "s.yaml:9:83: bodies.0.constraints.0.displacement.1: not a number: column 6: a "
                "closing bracket is "
                "missing, got \"sin(x\"; expected a number or an expression of x, y, z, t",
                "s.yaml:10:7: time: incomplete, got \"dynamic\" alone; expected a mapping such as "
                "{kind: dynamic, "
                "duration: 2, step: 1/120}");
}

static void needs_a_format_version_and_bodies(void **state) {
  (void)state;
  EXPECT_ERRORS("title: x\n", "s.yaml:1:1: lithe: missing; expected 1",
                "s.yaml:1:1: bodies: missing; expected a list of bodies");
  EXPECT_ERRORS("lithe: 2\nbodies: []\n", "s.yaml:1:8: lithe: unknown word, got \"2\"; expected 1",
                "s.yaml:2:9: bodies: wrong length, got an empty list; expected at least one entry");
  EXPECT_ERRORS(
      "", "s.yaml:1:1: the file is empty, got nothing; expected a scene that begins with lithe: 1");
  EXPECT_ERRORS(
      "- 1\n",
      "s.yaml:1:1: no scene, got a list of 1; expected a mapping that begins with lithe: 1");
}

static void refuses_what_is_not_built_yet(void **state) {
  (void)state;
#define UNBUILT "known but not available in this version, got "
  EXPECT_OVERRIDE_ERROR("bodies.0.method.mesh=voxels",
                        "--set bodies.0.method.mesh=voxels: bodies.0.method.mesh: it is of `kind: "
                        "cg`, got \"voxels\"; expected slice, hexahedra or tetrahedra");
  EXPECT_OVERRIDE_ERROR("cuts=[{at: 0}]",
                        "--set cuts=[{at: 0}]: cuts.0: incomplete, got none of the keys it needs; "
                        "expected exactly one of plane, blade, carve");
  EXPECT_OVERRIDE_ERROR("adapt={h: {criterion: rotation, threshold: 5 kPa}}",
                        "--set adapt={h: {criterion: rotation, threshold: 5 kPa}}: "
                        "adapt.h.threshold: wrong dimension, got \"5 kPa\", a pressure; expected "
                        "an angle [rad]");
  EXPECT_OVERRIDE_ERROR("solver.linear=petsc",
                        "--set solver.linear=petsc: solver.linear: " UNBUILT
                        "\"petsc\"; available: auto, cholesky, pcg or multigrid");
  EXPECT_OVERRIDE_ERROR("output.fields=[vti]",
                        "--set output.fields=[vti]: output.fields: vti holds fields on a grid, got "
                        "no body of `kind: staggered`; expected vtu");
}

static void takes_empty_keys_that_ask_for_nothing(void **state) {
  (void)state;
  Reading r = read_good(SMALL_SCENE
                        "    constraints:\n    loads: []\ncuts: []\nadapt: {}\ncolliders: null\n");
  assert_int_equal(r.scene->bodies[0].n_constraints, 0);
  end_reading(&r);
}

static void suggests_the_nearest_key(void **state) {
  (void)state;
  EXPECT_ERRORS(SMALL_SCENE "graviti: [0, 0, 0]\n",
                "s.yaml:7:1: graviti: unknown key, got \"graviti\"; did you mean gravity?");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.material.young=1 MPa",
      "--set bodies.0.material.young=1 MPa: bodies.0.material.young: unknown key, got "
      "\"young\"; did you mean young_modulus?");
  EXPECT_OVERRIDE_ERROR(
      "probes=[{name: a, point: [0, 0, 0], colour: red}]",
      "--set probes=[{name: a, point: [0, 0, 0], colour: red}]: probes.0.colour: unknown "
      "key, got \"colour\"; expected a probe such as {name: tip, point: [1, 0, 0]}");
}

static void checks_types_lengths_and_ranges(void **state) {
  (void)state;
  EXPECT_OVERRIDE_ERROR("gravity=[0, 1]",
                        "--set gravity=[0, 1]: gravity: wrong length, got a list of 2; "
                        "expected a list of 3 numbers [m/s^2]");
  EXPECT_OVERRIDE_ERROR("gravity=9.81",
                        "--set gravity=9.81: gravity: wrong type, got \"9.81\"; expected a "
                        "list of 3 numbers [m/s^2]");
  EXPECT_OVERRIDE_ERROR("gravity=[0, null, 0]",
                        "--set gravity=[0, null, 0]: gravity.1: wrong type, got "
                        "nothing; expected a number");
  EXPECT_OVERRIDE_ERROR("solver.threads=1.5",
                        "--set solver.threads=1.5: solver.threads: wrong type, got "
                        "\"1.5\"; expected an integer >= 0 and <= 4096");
  EXPECT_OVERRIDE_ERROR(
      "solver.condition=yes",
      "--set solver.condition=yes: solver.condition: wrong type, got \"yes\"; expected true "
      "or false");
  EXPECT_OVERRIDE_ERROR("bodies.0.method.sliver=1",
                        "--set bodies.0.method.sliver=1: bodies.0.method.sliver: "
                        "out of range, got \"1\"; expected a number >= 0 and < 1");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.material.density=-1",
      "--set bodies.0.material.density=-1: bodies.0.material.density: out of range, got "
      "\"-1\"; expected a number > 0 [kg/m^3]");
  EXPECT_OVERRIDE_ERROR("solver.tolerance=1/0",
                        "--set solver.tolerance=1/0: solver.tolerance: not a finite "
                        "number, got \"1/0\"; expected one");
  EXPECT_OVERRIDE_ERROR("bodies.0.name=\"\"",
                        "--set bodies.0.name=\"\": bodies.0.name: an empty text, got "
                        "\"\"; expected a text");
}

static void tells_where_numbers_may_vary(void **state) {
  (void)state;
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.material.density=1000*t",
      "--set bodies.0.material.density=1000*t: bodies.0.material.density: it varies with t, "
      "got \"1000*t\"; expected a number or an expression of x, y, z, value, label");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.shape={sphere: {center: [0, 0, 0], radius: x}}",
      "--set bodies.0.shape={sphere: {center: [0, 0, 0], radius: x}}: "
      "bodies.0.shape.sphere.radius: it varies with x, got \"x\"; expected a constant");
  EXPECT_OVERRIDE_ERROR(
      "colliders=[{plane: {point: [0, 0, 0], normal: [0, 1, 0], motion: [x, 0, 0]}}]",
      "--set colliders=[{plane: {point: [0, 0, 0], normal: [0, 1, 0], motion: [x, 0, 0]}}]: "
      "colliders.0.plane.motion.0: it varies with x, got \"x\"; expected a number or an "
      "expression of t");
}

static void wants_exactly_one_of_several_keys(void **state) {
  (void)state;
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.method.cell_size=1 cm",
      "--set bodies.0.method.cell_size=1 cm: bodies.0.method.cell_size: cells and cell_size "
      "exclude each other, got both; expected exactly one of cells, cell_size, grid");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.method={degree: 1}",
      "--set bodies.0.method={degree: 1}: bodies.0.method: incomplete, got none of the keys "
      "it needs; expected exactly one of cells, cell_size, grid");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.loads=[{where: all}]",
      "--set bodies.0.loads=[{where: all}]: bodies.0.loads.0: incomplete, got none of the "
      "keys it needs; expected exactly one of traction, total_force, pressure, stress, "
      "body_force, point_force");
  EXPECT_OVERRIDE_ERROR(
      "exact={displacement: [0, 0, 0], position: [x, y, z]}",
      "--set exact={displacement: [0, 0, 0], position: [x, y, z]}: exact.position: "
      "displacement and position exclude each other, got both; expected one");
}

static void checks_shapes(void **state) {
  (void)state;
#define SHAPE(text) "bodies.0.shape={" text "}"
#define SAYS(text) "--set bodies.0.shape={" text "}: bodies.0.shape."
  EXPECT_OVERRIDE_ERROR(
      SHAPE("box: {min: [0, 0, 0], max: [1, 0, 1]}"),
      SAYS("box: {min: [0, 0, 0], max: [1, 0, 1]}") "box.max: an empty box, got 0..0 along "
                                                    "y; expected max > min");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("shell: {center: [0, 0, 0], inner: 2, outer: 1}"),
      SAYS("shell: {center: [0, 0, 0], inner: 2, outer: 1}") "shell.inner: not inside the "
                                                             "outer radius, got 2 and 1; expected "
                                                             "inner < outer");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("capsule: {from: [1, 1, 1], to: [1, 1, 1], radius: 1}"),
      SAYS("capsule: {from: [1, 1, 1], to: [1, 1, 1], radius: 1}") "capsule.to: an axis "
                                                                   "without length, got from and "
                                                                   "to at one place; expected two "
                                                                   "places");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("implicit: x^2+y^2+z^2-1"),
      SAYS("implicit: x^2+y^2+z^2-1") "implicit: no box to look for the shape in, got an "
                                      "expression alone; expected {value, min, max}, or "
                                      "method.grid");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("sphere: {center: [1e200, 0, 0], radius: 1}"),
      "--set bodies.0.shape={sphere: {center: [1e200, 0, 0], radius: 1}}: bodies.0.shape: no size "
      "that can "
      "be computed with, got 2 m at up to 1e+200 m from the origin; expected a body from "
      "1e-12 m on within 1e+12 m");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("union: [{sphere: {center: [0, 0, 0], radius: 1}, resolution: 1}]"),
      SAYS("union: [{sphere: {center: [0, 0, 0], radius: 1}, resolution: 1}]") "union.0.resolution:"
                                                                               " it belongs to the "
                                                                               "whole shape, got "
                                                                               "it in a part; "
                                                                               "expected it "
                                                                               "beside the "
                                                                               "outermost union, "
                                                                               "intersection or "
                                                                               "difference");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("mesh: {file: nothing.obj, unit: kg}"),
      SAYS("mesh: {file: nothing.obj, unit: kg}") "mesh.file: cannot be read: No such file "
                                                  "or directory, got \"nothing.obj\"; expected a "
                                                  "file (looked for ./nothing.obj)");
  EXPECT_OVERRIDE_ERROR(
      SHAPE("mesh: {file: .}"),
      SAYS("mesh: {file: .}") "mesh.file: cannot be read: it is a folder, got \".\"; "
                              "expected a file (looked for ./.)");
  expect_lines(
      SMALL_SCENE, 1, (const char *const[]){SHAPE("mesh: {file: a.obj, repair: wrap}")},
      (const char *const[]){
          SAYS("mesh: {file: a.obj, repair: wrap}") "mesh.file: cannot be read: No such file or "
                                                    "directory, got \"a.obj\"; expected a file "
                                                    "(looked for ./a.obj)",
          NULL});
  expect_lines(
      SMALL_SCENE, 1,
      (const char *const[]){SHAPE("image: {file: a.nii, labels: [1], islands: remove-free}")},
      (const char *const[]){
          SAYS("image: {file: a.nii, labels: [1], islands: remove-free}") "image.file: cannot be "
                                                                          "read: No such file or "
                                                                          "directory, got "
                                                                          "\"a.nii\"; expected a "
                                                                          "file "
                                                                          "(looked for ./a.nii)",
          NULL});
}

static void checks_what_belongs_together(void **state) {
  (void)state;
  EXPECT_ERRORS(
      SMALL_SCENE "gravity: [0, 0, -9.81]\nprobes: [{name: a, point: [0, 0, 0]}, {name: a, point: "
                  "[1, 0, 0]}]\n",
      "s.yaml:8:46: probes.1.name: the name is taken, got \"a\" twice; expected names that differ");
  EXPECT_OVERRIDE_ERROR("contact.points=surface",
                        "--set contact.points=surface: contact.points: no surface is embedded, got "
                        "\"surface\"; expected nodes, or embed in the body");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.place={rotate: {axis: [0, 0, 0], angle: 20 deg}}",
      "--set bodies.0.place={rotate: {axis: [0, 0, 0], angle: 20 deg}}: "
      "bodies.0.place.rotate.axis: a direction without length, got [0, 0, 0]; expected "
      "three numbers that are not all 0");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.loads=[{where: all, traction: [0, 0, 1], follower: true}]",
      "--set bodies.0.loads=[{where: all, traction: [0, 0, 1], follower: true}]: "
      "bodies.0.loads.0.follower: only a pressure follows the surface, got true; expected "
      "pressure beside it");
  EXPECT_OVERRIDE_ERROR(
      "bodies.0.constraints=[{where: all, displacement: [null, null, null]}]",
      "--set bodies.0.constraints=[{where: all, displacement: [null, null, null]}]: "
      "bodies.0.constraints.0.displacement: it holds nothing, got only null; expected at "
      "least one number or expression");
  EXPECT_OVERRIDE_ERROR(
      "time={kind: static, step: 0.1}",
      "--set time={kind: static, step: 0.1}: time.step: it has no meaning in a static run, "
      "got \"0.1\"; leave it out");
  EXPECT_OVERRIDE_ERROR(
      "time={dynamic: {duration: 1}}",
      "--set time={dynamic: {duration: 1}}: time.dynamic.step: missing; expected a number > "
      "0 [s]");
  EXPECT_OVERRIDE_ERROR(
      "time={kind: dynamic, duration: 1e6, step: 1 us}",
      "--set time={kind: dynamic, duration: 1e6, step: 1 us}: time.step: too many steps, got "
      "1e+12 in 1e+06 s; expected at most 1e+09: a longer step or a shorter duration");
  EXPECT_OVERRIDE_ERROR(
      "output.fields=[vtu, none]",
      "--set output.fields=[vtu, none]: output.fields: none stands beside formats, got a "
      "list of 2; expected one or the other");
}

static void checks_overrides(void **state) {
  (void)state;
  EXPECT_OVERRIDE_ERROR("bodies.0", "--set bodies.0: not PATH=VALUE; expected for example "
                                    "bodies.0.method.degree=2");
  EXPECT_OVERRIDE_ERROR(
      "bodies.7.name=x",
      "--set bodies.7.name=x: bodies is a list of 1, got \"7\"; expected a number from 0 to 1");
  EXPECT_OVERRIDE_ERROR("bodies.0.name.x=2",
                        "--set bodies.0.name.x=2: bodies.0.name is \"bar\" and has no "
                        "keys, got \"x\"; expected the path of a mapping or a list");
  EXPECT_OVERRIDE_ERROR("title=", "--set title=: the value is empty; expected for example "
                                  "bodies.0.method.degree=2");
  EXPECT_OVERRIDE_ERROR("title=[1",
                        "--set title=[1: not YAML: flow sequence without a closing bracket; "
                        "expected YAML 1.2 or JSON");
}

static void says_how_many_more_errors_there_are(void **state) {
  (void)state;
  char text[20000] = SMALL_SCENE "probes:\n";
  for (int i = 0; i < 130; i++) strcat(text, "  - {name: a, point: [0, 0, 0], x: 1}\n");
  Reading r = read_with(text, 0, NULL);
  assert_int_equal(r.errors.n, 101);
  assert_string_equal(r.errors.lines[0],
                      "s.yaml:8:33: probes.0.x: unknown key, got \"x\"; expected a probe "
                      "such as {name: tip, point: [1, 0, 0]}");
  assert_non_null(strstr(r.errors.lines[100], "more errors"));
  end_reading(&r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_the_small_scene),
      cmocka_unit_test(finds_all_errors_in_one_run),
      cmocka_unit_test(needs_a_format_version_and_bodies),
      cmocka_unit_test(refuses_what_is_not_built_yet),
      cmocka_unit_test(takes_empty_keys_that_ask_for_nothing),
      cmocka_unit_test(suggests_the_nearest_key),
      cmocka_unit_test(checks_types_lengths_and_ranges),
      cmocka_unit_test(tells_where_numbers_may_vary),
      cmocka_unit_test(wants_exactly_one_of_several_keys),
      cmocka_unit_test(checks_shapes),
      cmocka_unit_test(checks_what_belongs_together),
      cmocka_unit_test(checks_overrides),
      cmocka_unit_test(says_how_many_more_errors_there_are),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
