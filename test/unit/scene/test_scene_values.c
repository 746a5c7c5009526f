/// What the reader makes of good scenes: every key's value, and the defaults.
#include "base/tensor.h"
#include "scene_text.h"

#define BODY(shape, more)                                                                          \
  "lithe: 1\nbodies:\n  - shape: " shape                                                           \
  "\n    material: {young_modulus: 1, poisson_ratio: 0}\n    method: {cells: 2}\n" more

static const double origin[3] = {0};

static double at(const LthValue *v, double x, double y, double z, double t) {
  const double p[3] = {x, y, z};
  return lth_value_at(v, p, t);
}

static void check_vector(const double v[3], double x, double y, double z, double tolerance) {
  CHECK_NEAR(v[0], x, tolerance);
  CHECK_NEAR(v[1], y, tolerance);
  CHECK_NEAR(v[2], z, tolerance);
}

static void gives_the_documented_defaults(void **state) {
  (void)state;
  Reading r = read_good(SMALL_SCENE);
  const LthScene *s = r.scene;
  const LthSceneBody *b = &s->bodies[0];
  assert_string_equal(s->title, "");
  assert_string_equal(s->name, "s");
  assert_string_equal(s->directory, ".");
  assert_string_equal(b->path, "bodies.0");
  assert_int_equal(b->materials[0].material.model, LTH_MATERIAL_COROTATED);
  CHECK_NEAR(b->materials[0].material.damping_mass, 0, 0);
  CHECK_NEAR(b->materials[0].material.yield_strength, 0, 0);
  assert_int_equal(b->mesh_kind, LTH_MESH_SLICE);
  assert_int_equal(b->degree, 1);
  assert_int_equal(b->flux, LTH_FLUX_IP);
  assert_int_equal(b->penalty, LTH_PENALTY_AUTO);
  CHECK_NEAR(b->sliver, 0.05, 0);
  assert_false(b->has_embed);
  CHECK_NEAR(b->initial_velocity[1].constant, 0, 0);
  check_vector(b->place_translation, 0, 0, 0, 0);
  for (int i = 0; i < 9; i++) CHECK_NEAR(b->place_rotation[i], i % 4 == 0, 0);
  check_vector(s->gravity, 0, 0, 0, 0);
  assert_int_equal(s->n_colliders, 0);
  CHECK_NEAR(s->contact_stiffness, 0, 0);
  assert_int_equal(s->contact_points, LTH_POINTS_AUTO);
  assert_int_equal(s->time_kind, LTH_TIME_STATIC);
  assert_int_equal(s->linear, LTH_LINEAR_AUTO);
  CHECK_NEAR(s->tolerance, 1e-8, 0);
  CHECK_NEAR(s->newton_tolerance, 1e-8, 0);
  assert_int_equal(s->newton_iterations, 100);
  assert_int_equal(s->threads, 0);
  assert_false(s->condition);
  assert_null(s->export_path);
  assert_true(s->fields_vtu);
  assert_true(s->surface_pc2);
  assert_false(s->surface_obj);
  assert_false(s->output_in_file_space);
  assert_int_equal(lithe_ctx_warning_count(r.ctx), 0);
  end_reading(&r);
}

static void reads_numbers_with_units_and_arithmetic(void **state) {
  (void)state;
  static const struct {
    const char *text;
    double value;
  } lengths[] = {{"2*3 mm", 6e-3}, {"50cm", 0.5},      {"1/4", 0.25},    {"+1.5e0 m", 1.5},
                 {".5", 0.5},      {"(1+2) cm", 0.03}, {"1 in", 0.0254}, {"2^2", 4},
                 {"sqrt(4)", 2},   {"1e-3 km", 1}};
  for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
    char override[100];
    snprintf(override, sizeof override, "bodies.0.method={cell_size: %s}", lengths[i].text);
    Reading r = read_with(SMALL_SCENE, 1, (const char *const[]){override});
    CHECK_OK(r.ctx, r.status);
    CHECK_NEAR(r.scene->bodies[0].resolution.cell_size / lengths[i].value, 1, 4e-16);
    end_reading(&r);
  }
  Reading r =
      read_good("lithe: 1\nbodies:\n  - shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
                "    method: {cells: 2*2}\n"
                "    material: {young_modulus: 210 GPa, poisson_ratio: 0.3, density: 1.1 g/cm^3, "
                "damping: {mass: 2 Hz, stiffness: 3 ms}, yield_strength: 0.2 kN/mm^2}\n");
  const LthMaterial *m = &r.scene->bodies[0].materials[0].material;
  CHECK_NEAR(m->young.constant / 210e9, 1, 4e-16);
  CHECK_NEAR(m->density.constant / 1100, 1, 4e-16);
  CHECK_NEAR(m->damping_mass, 2, 0);
  CHECK_NEAR(m->damping_stiffness, 3e-3, 1e-18);
  CHECK_NEAR(m->yield_strength / 200e6, 1, 4e-16);
  assert_int_equal(r.scene->bodies[0].resolution.cells[0], 4);
  assert_int_equal(r.scene->bodies[0].resolution.cells[1], 0);
  end_reading(&r);
}

static void reads_the_method(void **state) {
  (void)state;
  const char *text =
      "lithe: 1\nbodies:\n  - shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
      "    material: {model: linear, young_modulus: 1e3*(1+x), poisson_ratio: 0.1*y}\n"
      "    method: {kind: dg, grid: {min: [0, 0, 0], max: [1, 1, 2 m], cells: [2, 3, 4]}, "
      "degree: 2, flux: bz, mesh: tetrahedra, penalty: {eta: 20, scale: none}, sliver: 0}\n";
  Reading r = read_good(text);
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_true(b->resolution.has_grid);
  CHECK_NEAR(b->resolution.grid.max[2], 2, 0);
  assert_int_equal(b->resolution.grid.cells[2], 4);
  assert_int_equal(b->degree, 2);
  assert_int_equal(b->flux, LTH_FLUX_BZ);
  assert_int_equal(b->mesh_kind, LTH_MESH_TETRAHEDRA);
  assert_int_equal(b->penalty, LTH_PENALTY_ETA_PLAIN);
  CHECK_NEAR(b->eta, 20, 0);
  CHECK_NEAR(b->sliver, 0, 0);
  const LthMaterial *m = &b->materials[0].material;
  assert_int_equal(m->model, LTH_MATERIAL_LINEAR);
  CHECK_NEAR(at(&m->young, 0.5, 0, 0, 0), 1500, 0);
  CHECK_NEAR(at(&m->poisson, 0, 2, 0, 0), 0.2, 0);
  end_reading(&r);
  r = read_with(SMALL_SCENE, 1, (const char *const[]){"bodies.0.method.penalty=7"});
  assert_int_equal(r.scene->bodies[0].penalty, LTH_PENALTY_ETA);
  CHECK_NEAR(r.scene->bodies[0].eta, 7, 0);
  end_reading(&r);
}

static void reads_constraints_and_loads(void **state) {
  (void)state;
  Reading r = read_good(
      SMALL_SCENE "    constraints:\n"
                  "      - {where: {box: {min: [-1, -1, -1], max: [1, 0.01, 1]}}, displacement: "
                  "[0, 0, 0], enforce: strong}\n"
                  "      - {where: {plane: {point: [0, 1, 0], normal: [0, 2, 0]}}, displacement: "
                  "[null, \"0.1*t\", null]}\n"
                  "      - {where: all, position: [x, 2*y, z + t], interior: true}\n"
                  "      - {where: {normal: [1, 0, 0]}, displacement: {normal: 1 mm}}\n"
                  "    loads:\n"
                  "      - {where: {normal: [1, 0, 0], within: 10 deg}, traction: [1 kPa, 0, x]}\n"
                  "      - {where: all, pressure: 2 kPa, follower: true}\n"
                  "      - {where: {not: {sphere: {center: [0, 0, 0], radius: 0.6}}}, stress: [[1, "
                  "2, 3], [4, 5, 6], "
                  "[7, 8, t]]}\n"
                  "      - {where: {face: {at: [0, 0, 0.1]}}, total_force: [0, 0, -500 N]}\n"
                  "      - {body_force: [\"x\", 0, 1 kN/m^3]}\n"
                  "      - {where: {and: [all, {or: [all, {implicit: x - 1}]}]}, pressure: 1}\n");
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_int_equal(b->n_constraints, 4);
  const LthSceneConstraint *c = b->constraints;
  assert_string_equal(c[0].path, "bodies.0.constraints.0");
  assert_int_equal(c[0].where.kind, LTH_WHERE_SHAPE);
  assert_true(c[0].strong && c[0].fixed[0] && c[0].fixed[1] && c[0].fixed[2]);
  check_vector(c[1].where.normal, 0, 1, 0, 0);
  assert_true(!c[1].fixed[0] && c[1].fixed[1] && !c[1].fixed[2] && !c[1].strong);
  CHECK_NEAR(at(&c[1].value[1], 0, 0, 0, 3), 0.3, 1e-16);
  assert_true(c[2].is_position && c[2].interior && c[2].where.kind == LTH_WHERE_ALL);
  CHECK_NEAR(at(&c[2].value[2], 0, 0, 4, 3), 7, 0);
  assert_true(c[3].normal_only);
  CHECK_NEAR(c[3].value[0].constant, 1e-3, 0);
  CHECK_NEAR(c[3].where.angle, 30 * 3.14159265358979323846 / 180, 1e-16);

  const LthSceneLoad *l = b->loads;
  assert_int_equal(b->n_loads, 6);
  CHECK_NEAR(l[0].value[0].constant, 1000, 0);
  CHECK_NEAR(at(&l[0].value[2], 5, 0, 0, 0), 5, 0);
  CHECK_NEAR(l[0].where.angle, 10 * 3.14159265358979323846 / 180, 1e-16);
  assert_true(l[1].kind == LTH_LOAD_PRESSURE && l[1].follower);
  assert_int_equal(l[2].kind, LTH_LOAD_STRESS);
  CHECK_NEAR(l[2].stress[5].constant, 6, 0);
  CHECK_NEAR(at(&l[2].stress[8], 0, 0, 0, 9), 9, 0);
  assert_int_equal(l[2].where.kind, LTH_WHERE_NOT);
  assert_int_equal(l[2].where.children[0].kind, LTH_WHERE_SHAPE);
  assert_int_equal(l[3].kind, LTH_LOAD_TOTAL_FORCE);
  assert_int_equal(l[3].where.kind, LTH_WHERE_FACE);
  CHECK_NEAR(l[3].where.angle, 20 * 3.14159265358979323846 / 180, 1e-16);
  assert_int_equal(l[4].kind, LTH_LOAD_BODY_FORCE);
  CHECK_NEAR(l[4].value[2].constant, 1000, 0);
  const LthWhere *inner = &l[5].where.children[1].children[1];
  CHECK_NEAR(lth_shape_value(&inner->shape, (const double[]){3, 0, 0}), 2, 0);
  end_reading(&r);
}

static void reads_colliders_and_their_motion(void **state) {
  (void)state;
  Reading r = read_good(
      SMALL_SCENE
      "colliders:\n"
      "  - plane: {point: [0, 0, 0], normal: [0, 0, 3]}\n"
      "  - sphere: {center: [1, 2, 3], radius: 10 cm, motion: [t, 0, 1 mm]}\n"
      "  - box: {min: [0, 0, 0], max: [1, 1, 1], motion: {rotate: {axis: [0, 2, 0], angle: \"90*t "
      "deg\"}}}\n"
      "  - capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 1, motion: {translate: [0, t^2, 0]}}\n"
      "contact: {stiffness: 1 MPa/m, friction: 0.3, damping: 1 ms}\n");
  const LthCollider *c = r.scene->colliders;
  assert_int_equal(r.scene->n_colliders, 4);
  check_vector(c[0].normal, 0, 0, 1, 0);
  assert_int_equal(c[1].kind, LTH_COLLIDER_SPHERE);
  CHECK_NEAR(c[1].shape.radius, 0.1, 1e-17);
  CHECK_NEAR(at(&c[1].translation[0], 0, 0, 0, 2), 2, 0);
  CHECK_NEAR(at(&c[2].angle, 0, 0, 0, 1), 3.14159265358979323846 / 2, 1e-15);
  check_vector(c[2].axis, 0, 1, 0, 0);
  CHECK_NEAR(at(&c[3].translation[1], 0, 0, 0, 3), 9, 0);
  CHECK_NEAR(r.scene->contact_stiffness, 1e6, 0);
  CHECK_NEAR(r.scene->contact_friction, 0.3, 0);
  CHECK_NEAR(r.scene->contact_damping, 1e-3, 0);
  end_reading(&r);
}

static void reads_the_three_forms_of_time(void **state) {
  (void)state;
  static const char *const forms[] = {
      "time={kind: dynamic, step: 1/120, duration: 2}",
      "time={dynamic: {step: 1/120, duration: 2 s}}",
      "time={kind: dynamic, integrator: implicit-euler, step: 1/120, duration: 2}"};
  for (int i = 0; i < 3; i++) {
    Reading r = read_with(SMALL_SCENE, 1, &forms[i]);
    CHECK_OK(r.ctx, r.status);
    assert_int_equal(r.scene->time_kind, LTH_TIME_DYNAMIC);
    CHECK_NEAR(r.scene->step, 1.0 / 120, 0);
    CHECK_NEAR(r.scene->duration, 2, 0);
    CHECK_NEAR(r.scene->output_every, 1.0 / 30, 0);
    end_reading(&r);
  }
  Reading r = read_with(SMALL_SCENE, 1, (const char *const[]){"time={quasistatic: {steps: 5}}"});
  assert_int_equal(r.scene->time_kind, LTH_TIME_QUASISTATIC);
  assert_int_equal(r.scene->steps, 5);
  CHECK_NEAR(r.scene->duration, 1, 0);
  CHECK_NEAR(r.scene->output_every, 0, 0);
  end_reading(&r);
}

static void reads_solver_probes_exact_and_output(void **state) {
  (void)state;
  Reading r =
      read_good(SMALL_SCENE
                "    embed: {interpolation: stitched, samples: faces}\n"
                "solver: {linear: pcg, tolerance: 1e-10, threads: 2, newton: {tolerance: 1e-6, "
                "iterations: 7}, condition: true, export: K.mtx}\n"
                "probes: [{name: a, point: [1, 2, 3 mm]}, {name: 2, point: [0, 0, 0]}]\n"
                "exact: {position: [x, y, \"z + t\"], stress: [[1, 0, 0], [0, x, 0], [0, 0, 0]]}\n"
                "output: {every: last, fields: none, surface: [obj, stl], space: file}\n");
  const LthScene *s = r.scene;
  assert_int_equal(s->linear, LTH_LINEAR_PCG);
  CHECK_NEAR(s->tolerance, 1e-10, 0);
  assert_int_equal(s->threads, 2);
  CHECK_NEAR(s->newton_tolerance, 1e-6, 0);
  assert_int_equal(s->newton_iterations, 7);
  assert_true(s->condition);
  assert_string_equal(s->export_path, "K.mtx");
  assert_int_equal(s->n_probes, 2);
  assert_string_equal(s->probes[1].name, "2");
  CHECK_NEAR(s->probes[0].point[2], 3e-3, 0);
  assert_true(s->has_exact_displacement && s->exact_is_position && s->has_exact_stress);
  CHECK_NEAR(at(&s->exact[2], 0, 0, 1, 2), 3, 0);
  CHECK_NEAR(at(&s->exact_stress[4], 5, 0, 0, 0), 5, 0);
  CHECK_NEAR(s->output_every, -1, 0);
  assert_true(!s->fields_vtu && !s->surface_pc2 && s->surface_obj && s->surface_stl &&
              !s->surface_ply);
  assert_true(s->output_in_file_space);
  const LthSceneBody *b = &s->bodies[0];
  assert_true(b->has_embed && b->interpolation == LTH_EMBED_STITCHED &&
              b->samples == LTH_SAMPLE_FACES);
  assert_int_equal(s->contact_points, LTH_POINTS_AUTO);
  end_reading(&r);
}

static void places_shapes_by_rotation_then_translation(void **state) {
  (void)state;
  // a quarter turn about z takes x to y; then everything moves by 10 along x
#define PLACE "    place: {rotate: {axis: [0, 0, 2], angle: 90 deg}, translate: [10, 0, 0]}\n"
  double min[3], max[3];
  Reading r = read_good(BODY("{box: {min: [0, 0, 0], max: [3, 2, 1]}}", PLACE));
  lth_shape_bounds(&r.scene->bodies[0].shape, min, max);
  assert_int_equal(r.scene->bodies[0].shape.kind, LTH_SHAPE_MESH);
  check_vector(min, 8, 0, 0, 1e-14);
  check_vector(max, 10, 3, 1, 1e-14);
  CHECK_NEAR(lth_surface_volume(r.scene->bodies[0].shape.surface), 6, 1e-13);
  check_vector(r.scene->bodies[0].place_translation, 10, 0, 0, 0);
  CHECK_NEAR(r.scene->bodies[0].place_rotation[3], 1, 1e-15);
  end_reading(&r);

  r = read_good(BODY("{capsule: {from: [1, 0, 0], to: [2, 0, 0], radius: 0.5}}", PLACE));
  check_vector(r.scene->bodies[0].shape.a, 10, 1, 0, 1e-15);
  check_vector(r.scene->bodies[0].shape.b, 10, 2, 0, 1e-15);
  end_reading(&r);

  r = read_good(BODY(
      "{implicit: {value: \"(x-1)^2 + y^2 + z^2 - 1\", min: [0, -1, -1], max: [2, 1, 1]}}", PLACE));
  lth_shape_bounds(&r.scene->bodies[0].shape, min, max);
  check_vector(min, 9, 0, -1, 1e-14);
  check_vector(max, 11, 2, 1, 1e-14);
  CHECK_NEAR(lth_shape_value(&r.scene->bodies[0].shape, (const double[]){10, 1, 0}), -1, 1e-14);
  end_reading(&r);

  // without a rotation coordinates stay to the bit
  r = read_good(BODY("{box: {min: [0, 0, 0], max: [0.1, 0.7, 0.3]}}",
                     "    place: {translate: [0, 0, 0.1]}\n"));
  assert_int_equal(r.scene->bodies[0].shape.kind, LTH_SHAPE_BOX);
  check_vector(r.scene->bodies[0].shape.b, 0.1, 0.7, 0.1 + 0.3, 0);
  end_reading(&r);
}

static void finds_boxes_for_implicit_parts(void **state) {
  (void)state;
  double min[3], max[3];
  Reading r = read_good(
      BODY("{intersection: [{sphere: {center: [0, 0, 0], radius: 1}}, {implicit: x}]}", ""));
  const LthShape *s = &r.scene->bodies[0].shape;
  lth_shape_bounds(&s->children[1], min, max);
  check_vector(min, -1, -1, -1, 0);
  check_vector(max, 1, 1, 1, 0);
  end_reading(&r);

  r = read_good("lithe: 1\nbodies:\n  - shape: {implicit: \"x^2 + y^2 + z^2 - 1\"}\n"
                "    material: {young_modulus: 1, poisson_ratio: 0}\n"
                "    method: {grid: {min: [-2, -2, -2], max: [2, 2, 2], cells: [4, 4, 4]}}\n");
  lth_shape_bounds(&r.scene->bodies[0].shape, min, max);
  check_vector(max, 2, 2, 2, 0);
  CHECK_NEAR(lth_shape_value(&r.scene->bodies[0].shape, origin), -1, 0);
  end_reading(&r);
}

static void takes_materials_by_place(void **state) {
  (void)state;
  Reading r =
      read_good("lithe: 1\nbodies:\n  - shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
                "    material:\n"
                "      - {where: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}, young_modulus: 1, "
                "poisson_ratio: 0}\n"
                "      - {young_modulus: 2, poisson_ratio: 0}\n"
                "    method: {cells: 2}\n");
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_int_equal(b->n_materials, 2);
  assert_true(b->materials[0].has_where && !b->materials[1].has_where);
  CHECK_NEAR(b->materials[1].material.young.constant, 2, 0);
  end_reading(&r);
}

static void warns_of_sizes_and_angles_that_look_wrong(void **state) {
  (void)state;
  Reading r = read_good(BODY("{box: {min: [0, 0, 0], max: [200, 1, 1]}}",
                             "    place: {rotate: {axis: [1, 0, 0], angle: 20}}\n"));
  assert_int_equal(lithe_ctx_warning_count(r.ctx), 2);
  assert_string_equal(
      lithe_ctx_warning(r.ctx, 0),
      "bodies.0.place.rotate.angle: an angle without unit is in radians: 20 is 3.183 turns; "
      "write \"20 deg\" if degrees are meant");
  assert_string_equal(lithe_ctx_warning(r.ctx, 1),
                      "bodies.0: body body is 200 m long: if its file is in "
                      "millimetres, write `unit: mm` in mesh");
  end_reading(&r);
  r = read_good(BODY("{sphere: {center: [0, 0, 0], radius: 100 um}}", ""));
  assert_string_equal(lithe_ctx_warning(r.ctx, 0),
                      "bodies.0: body body is only 0.2 mm long: is the unit of its shape right?");
  end_reading(&r);
}

static void overrides_any_value(void **state) {
  (void)state;
  Reading r =
      read_with(SMALL_SCENE, 4,
                (const char *const[]){"bodies.0.method.degree=2", "solver.newton.iterations=3",
                                      "bodies.0.shape.box.max.1=2 m",
                                      "probes=[{name: p, point: [0, 0, 0]}]"});
  CHECK_OK(r.ctx, r.status);
  assert_int_equal(r.scene->bodies[0].degree, 2);
  assert_int_equal(r.scene->newton_iterations, 3);
  CHECK_NEAR(r.scene->bodies[0].shape.b[1], 2, 0);
  assert_int_equal(r.scene->n_probes, 1);
  end_reading(&r);
}

static void reads_json_scenes(void **state) {
  (void)state;
  Reading r = read_good(
      "{\"lithe\": 1, \"bodies\": [{\"shape\": {\"sphere\": {\"center\": [0, 0, 0], "
      "\"radius\": \"5 cm\"}}, \"material\": {\"young_modulus\": 1e5, \"poisson_ratio\": 0.4}, "
      "\"method\": {\"cells\": 4}}]}");
  CHECK_NEAR(r.scene->bodies[0].shape.radius, 0.05, 1e-17);
  end_reading(&r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gives_the_documented_defaults),
      cmocka_unit_test(reads_numbers_with_units_and_arithmetic),
      cmocka_unit_test(reads_the_method),
      cmocka_unit_test(reads_constraints_and_loads),
      cmocka_unit_test(reads_colliders_and_their_motion),
      cmocka_unit_test(reads_the_three_forms_of_time),
      cmocka_unit_test(reads_solver_probes_exact_and_output),
      cmocka_unit_test(places_shapes_by_rotation_then_translation),
      cmocka_unit_test(finds_boxes_for_implicit_parts),
      cmocka_unit_test(takes_materials_by_place),
      cmocka_unit_test(warns_of_sizes_and_angles_that_look_wrong),
      cmocka_unit_test(overrides_any_value),
      cmocka_unit_test(reads_json_scenes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
