/// Files that a scene names: surfaces that are scaled, fitted and placed, tables of motion, the scenes
/// that come with Lithe; and what is said of files that are missing or bad.
#include "base/tensor.h"
#include "scene_text.h"

#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/lithe-scene-XXXXXX";

static void write_file(const char *name, const char *text) {
  char path[200];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  assert_int_equal(fclose(file), 0);
}

/// A box of 2 x 4 x 6 from (1, 1, 1), as quadrilaterals.
#define BOX_OBJ                                                                                    \
  "v 1 1 1\nv 3 1 1\nv 3 5 1\nv 1 5 1\nv 1 1 7\nv 3 1 7\nv 3 5 7\nv 1 5 7\n"                       \
  "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\n"

static int make_files(void **state) {
  (void)state;
  if (!mkdtemp(folder)) return 1;
  write_file("box.obj", BOX_OBJ "f 4 1 5 8\n");
  write_file("open.obj", BOX_OBJ);
  write_file("bad.obj", "v 1 2\n");
  write_file("skin.obj", BOX_OBJ);
  write_file("hand.csv", "t, x, y, z\n0, 0, 0, 0\n\n# a pause\n1, 2, 0, -1\n3, 2, 4, -1\n");
  write_file("back.csv", "0 0 0 0\n1 0 0 0\n1 1 1 1\n");
  write_file("short.csv", "0,0,0\n");
  return 0;
}

static Reading read_here(const char *text) {
  char path[300];
  write_file("scene.yaml", text);
  snprintf(path, sizeof path, "%s/scene.yaml", folder);
  Reading r = {.ctx = test_ctx()};
  r.status = lth_scene_read(r.ctx, path, NULL, 0, NULL, &r.errors, &r.scene);
  return r;
}

#define MESH(mesh, more)                                                                           \
  "lithe: 1\nbodies:\n  - shape: {mesh: " mesh                                                     \
  "}\n    material: {young_modulus: 1, poisson_ratio: 0}\n    method: {cells: 2}\n" more

static void check_box(const LthSceneBody *b, const double min[3], const double max[3],
                      double tolerance) {
  double low[3], high[3];
  lth_shape_bounds(&b->shape, low, high);
  for (int i = 0; i < 3; i++) {
    CHECK_NEAR(low[i], min[i], tolerance);
    CHECK_NEAR(high[i], max[i], tolerance);
  }
  double volume = (max[0] - min[0]) * (max[1] - min[1]) * (max[2] - min[2]);
  CHECK_NEAR(lth_surface_volume(b->surface) / volume, 1, 1e-13);
}

/// A file's point through file_to_scene is where the body's own point is.
static void check_transform(const LthSceneBody *b) {
  const double corner[3] = {3, 5, 7}, *A = b->file_to_scene, *x = b->soup->points + 3 * 6;
  for (int i = 0; i < 3; i++)
    CHECK_NEAR(A[4 * i] * corner[0] + A[4 * i + 1] * corner[1] + A[4 * i + 2] * corner[2] +
                   A[4 * i + 3],
               x[i], 1e-15);
}

static void scales_fits_and_places_surfaces(void **state) {
  (void)state;
  Reading r = read_here(MESH("{file: box.obj, unit: mm, scale: 10}", ""));
  CHECK_OK(r.ctx, r.status);
  check_box(&r.scene->bodies[0], (const double[]){0.01, 0.01, 0.01},
            (const double[]){0.03, 0.05, 0.07}, 1e-16);
  check_transform(&r.scene->bodies[0]);
  end_reading(&r);

  // the longest side, z, becomes 0.3; centred in x and z, resting on y = 0
  r = read_here(MESH("{file: box.obj, fit: 0.3}", ""));
  check_box(&r.scene->bodies[0], (const double[]){-0.05, 0, -0.15},
            (const double[]){0.05, 0.2, 0.15}, 1e-16);
  check_transform(&r.scene->bodies[0]);
  end_reading(&r);

  r = read_here(
      MESH("{file: box.obj, fit: 0.3, up: z}",
           "    place: {rotate: {axis: [1, 0, 0], angle: 90 deg}, translate: [0, 0, 1]}\n"));
  check_box(&r.scene->bodies[0], (const double[]){-0.05, -0.3, 0.9}, (const double[]){0.05, 0, 1.1},
            1e-15);
  check_transform(&r.scene->bodies[0]);
  assert_int_equal(r.scene->bodies[0].soup->n_polys, 6);
  end_reading(&r);
}

static void embeds_another_file_as_the_body_is_placed(void **state) {
  (void)state;
  Reading r = read_here(MESH("{file: box.obj, fit: 0.3}", "    embed: {surface: skin.obj}\n"));
  CHECK_OK(r.ctx, r.status);
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_int_equal(b->embed_soup->n_polys, 5);
  for (int i = 0; i < 24; i++) CHECK_NEAR(b->embed_soup->points[i], b->soup->points[i], 0);
  end_reading(&r);
  r = read_here(
      MESH("{file: box.obj, fit: 0.3}", "    embed: {surface: {file: skin.obj, scale: 2}}\n"));
  CHECK_NEAR(r.scene->bodies[0].embed_soup->points[0], 2, 0);
  end_reading(&r);
}

static void moves_colliders_by_tables(void **state) {
  (void)state;
  Reading r =
      read_here(SMALL_SCENE "colliders:\n"
                            "  - sphere: {center: [0, 0, 0], radius: 1, motion: {keys: hand.csv}}\n"
                            "  - mesh: {file: box.obj, scale: 2, place: {translate: [1, 0, 0]}}\n");
  CHECK_OK(r.ctx, r.status);
  const LthValue *v = r.scene->colliders[0].translation;
  static const double times[] = {-1, 0, 0.5, 1, 2, 3, 9}, want_x[] = {0, 0, 1, 2, 2, 2, 2},
                      want_y[] = {0, 0, 0, 0, 2, 4, 4};
  const double x[3] = {5, 5, 5};
  for (int i = 0; i < 7; i++) {
    CHECK_NEAR(lth_value_at(&v[0], x, times[i]), want_x[i], 0);
    CHECK_NEAR(lth_value_at(&v[1], x, times[i]), want_y[i], 0);
  }
  CHECK_NEAR(lth_value_at(&v[2], x, 0.25), -0.25, 0);
  assert_int_equal(r.scene->colliders[1].kind, LTH_COLLIDER_MESH);
  CHECK_NEAR(lth_surface_volume(r.scene->collider_surfaces[1]), 48 * 8, 1e-10);
  end_reading(&r);
}

/// The first error of a scene, without the folder in front.
static void check_first_error(const char *text, const char *want) {
  Reading r = read_here(text);
  assert_int_equal(r.status, LITHE_BAD_INPUT);
  assert_int_equal(r.errors.n, 1);
  const char *line = strstr(r.errors.lines[0], "scene.yaml");
  if (!line || strncmp(line, want, strlen(want)) != 0)
    fail_msg("%s\nexpected ...%s", r.errors.lines[0], want);
  end_reading(&r);
}

static void blames_bad_files_at_their_name(void **state) {
  (void)state;
  check_first_error(MESH("{file: missing.obj}", ""),
                    "scene.yaml:3:26: bodies.0.shape.mesh.file: cannot be read: "
                    "No such file or directory, got \"missing.obj\"; expected a "
                    "file (looked for /tmp/lithe-scene-");
  check_first_error(MESH("{file: bad.obj}", ""), "scene.yaml:3:26: bodies.0.shape.mesh.file: ");
  check_first_error(MESH("{file: open.obj}", ""),
                    "scene.yaml:3:26: bodies.0.shape.mesh.file: open.obj: the "
                    "surface is not the boundary of a solid: 4 ");
  check_first_error(MESH("{file: box.obj, unit: kg}", ""),
                    "scene.yaml:3:41: bodies.0.shape.mesh.unit: no unit of length, got \"kg\"; "
                    "expected m, mm, cm, "
                    "um, in or ft");
  check_first_error(MESH("{file: box.obj, up: z}", ""),
                    "scene.yaml:3:35: bodies.0.shape.mesh.up: it goes with fit, "
                    "got no fit; expected fit beside it, or place.rotate");
#define KEYS(file)                                                                                 \
  SMALL_SCENE "colliders:\n  - sphere: {center: [0, 0, 0], radius: 1, motion: {keys: " file "}}\n"
  check_first_error(KEYS("back.csv"),
                    "scene.yaml:8:59: colliders.0.sphere.motion.keys: back.csv:3: time 1 does not "
                    "come after 1; expected rising times");
  check_first_error(KEYS("short.csv"),
                    "scene.yaml:8:59: colliders.0.sphere.motion.keys: short.csv:1: ");
}

static void writes_the_places_of_defects(void **state) {
  (void)state;
  char path[300], defects[300];
  write_file("scene.yaml", MESH("{file: open.obj, fit: 0.1}", ""));
  snprintf(path, sizeof path, "%s/scene.yaml", folder);
  snprintf(defects, sizeof defects, "%s/defects.ply", folder);
  Reading r = {.ctx = test_ctx()};
  r.status = lth_scene_read(r.ctx, path, NULL, 0, defects, &r.errors, &r.scene);
  assert_int_equal(r.status, LITHE_BAD_INPUT);
  assert_int_equal(r.errors.n, 1);
  assert_non_null(strstr(r.errors.lines[0], "; they are drawn in "));
  assert_non_null(strstr(r.errors.lines[0], defects));
  assert_int_equal(access(defects, R_OK), 0);
  assert_int_equal(unlink(defects), 0);
  end_reading(&r);
}

static void refuses_devices_and_missing_scenes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSceneErrors errors = {0};
  LthScene *scene = NULL;
  assert_int_equal(lth_scene_read(ctx, "/dev/zero", NULL, 0, NULL, &errors, &scene),
                   LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx), "/dev/zero: it is a device; expected a scene file");
  assert_int_equal(lth_scene_read(ctx, "/nothing.yaml", NULL, 0, NULL, &errors, &scene),
                   LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx),
                      "/nothing.yaml: cannot be read: No such file or directory");
  lithe_ctx_destroy(&ctx);
}

static void opens_no_file_for_text_of_unknown_origin(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSceneErrors errors = {0};
  LthScene *scene = NULL;
  const char *text = MESH("{file: /dev/zero}", "");
  CHECK_OK(ctx, lth_scene_read_text(ctx, NULL, text, strlen(text), NULL, 0, &errors, &scene));
  assert_null(scene->bodies[0].soup);
  lth_scene_destroy(ctx, &scene);
  lithe_ctx_destroy(&ctx);
}

static void reads_the_scenes_that_come_with_it(void **state) {
  (void)state;
  static const char *const names[] = {"hello", "spinning-bar", "cantilever",
                                      "pull",  "pressed",      "bunny-drop"};
  const char *source = getenv("LITHE_TEST_SOURCE");
  if (!source) fail_msg("LITHE_TEST_SOURCE is not set: run the tests through CTest");
  bool has_bunny = access("/usr/share/glmark2/models/bunny.obj", R_OK) == 0;
  for (int i = 0; i < (has_bunny ? 6 : 5); i++) {
    char path[1000];
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", source, names[i]);
    Reading r = {.ctx = test_ctx()};
    r.status = lth_scene_read(r.ctx, path, NULL, 0, NULL, &r.errors, &r.scene);
    CHECK_OK(r.ctx, r.status);
    assert_string_equal(r.scene->name, names[i]);
    end_reading(&r);
  }
}

static int remove_files(void **state) {
  (void)state;
  static const char *const names[] = {"box.obj",  "open.obj", "bad.obj",   "skin.obj",
                                      "hand.csv", "back.csv", "short.csv", "scene.yaml"};
  char path[300];
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    snprintf(path, sizeof path, "%s/%s", folder, names[i]);
    unlink(path);
  }
  return rmdir(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scales_fits_and_places_surfaces),
      cmocka_unit_test(embeds_another_file_as_the_body_is_placed),
      cmocka_unit_test(moves_colliders_by_tables),
      cmocka_unit_test(blames_bad_files_at_their_name),
      cmocka_unit_test(writes_the_places_of_defects),
      cmocka_unit_test(refuses_devices_and_missing_scenes),
      cmocka_unit_test(opens_no_file_for_text_of_unknown_origin),
      cmocka_unit_test(reads_the_scenes_that_come_with_it),
  };
  return cmocka_run_group_tests(tests, make_files, remove_files);
}
