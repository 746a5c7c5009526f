/// Contact points of staggered bodies: every side of a shape has its own, with its area.
#include "base/tensor.h"
#include "scene/world.h"
#include "scene_text.h"

#include <math.h>
#include <stdio.h>

#define SCENE                                                                                      \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: body\n"                                                                               \
  "    shape: %s\n"                                                                                \
  "    material: {young_modulus: 1e4, poisson_ratio: 0.3, density: 1000}\n"                        \
  "    method: {kind: staggered, cells: %d}\n"                                                     \
  "colliders:\n"                                                                                   \
  "  - plane: {point: [0, -9, 0], normal: [0, 1, 0]}\n"                                            \
  "contact: {points: nodes}\n"                                                                     \
  "time: {kind: dynamic, duration: 1, step: 0.01}\n"

typedef struct Run {
  Reading reading;
  LthWorld *world;
  const LthEmbedding *nodes;
} Run;

static Run begin(const char *shape, int cells) {
  char text[1000];
  double times[2];
  assert_in_range(snprintf(text, sizeof text, SCENE, shape, cells), 1, sizeof text - 1);
  Run run = {.reading = read_good(text)};
  CHECK_OK(run.reading.ctx,
           lth_world_create(run.reading.ctx, run.reading.scene, times, &run.world));
  run.nodes = run.world->bodies[0]->nodes;
  assert_non_null(run.nodes);
  return run;
}

static void end(Run *run) {
  lth_world_destroy(run->reading.ctx, &run->world);
  end_reading(&run->reading);
}

static double area_where(const Run *run, int axis, double value) {
  double area = 0;
  for (LitheIndex p = 0; p < run->nodes->n_points; p++)
    if (fabs(run->nodes->rest[3 * p + axis] - value) < 1e-9) area += run->nodes->area[p];
  return area;
}

// the cells along an edge are as near to one side as to the other: both have a point there
static void test_each_side_of_a_box_has_all_of_its_area(void **state) {
  (void)state;
  const double high[3] = {1, 0.5, 0.75};
  for (int cells = 8; cells <= 20; cells += 4) {
    Run run = begin("{box: {min: [0, 0, 0], max: [1, 0.5, 0.75]}}", cells);
    for (int axis = 0; axis < 3; axis++)
      for (int side = 0; side < 2; side++)
        CHECK_NEAR(area_where(&run, axis, side * high[axis]),
                   high[(axis + 1) % 3] * high[(axis + 2) % 3], 1e-6);
    end(&run);
  }
}

static double area(const Run *run) {
  double sum = 0;
  for (LitheIndex p = 0; p < run->nodes->n_points; p++) sum += run->nodes->area[p];
  return sum;
}

static void test_curved_and_turned_sides_have_about_their_area(void **state) {
  (void)state;
  Run ball = begin("{sphere: {center: [0, 0, 0], radius: 0.5}}", 24);
  CHECK_NEAR(area(&ball), M_PI, 0.02 * M_PI);
  for (LitheIndex p = 0; p < ball.nodes->n_points; p++)
    CHECK_NEAR(lth_v3_norm(ball.nodes->rest + 3 * p), 0.5, 1e-9);
  end(&ball);
  Run can = begin("{cylinder: {from: [0, 0, 0], to: [0.6, 0.8, 0], radius: 0.3}}", 24);
  CHECK_NEAR(area(&can), 2 * M_PI * 0.3 * 1.3, 0.05 * 2 * M_PI * 0.3 * 1.3);
  end(&can);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_each_side_of_a_box_has_all_of_its_area),
      cmocka_unit_test(test_curved_and_turned_sides_have_about_their_area),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
