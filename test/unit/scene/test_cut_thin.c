/// Cuts that lie side by side at any distance, down to rounding: what is between them moves, is merged or is taken
/// away, and the matrix stays positive definite.
#include "mesh/topology.h"
#include "scene/cut.h"
#include "scene_text.h"

#include <math.h>

#define STEP 0.01

/// How the second of two cuts lies to the first.
typedef enum Kind { SLICE, HANGING, HALF, WEDGE, NEEDLE, N_KINDS } Kind;

static size_t add_plane(char *at, size_t room, const char *within, double x, double nx, double z) {
  return (size_t)snprintf(
      at, room,
      "  - {at: 0.005, space: rest, plane: {point: [%.17g, 0.5, %.17g], normal: "
      "[%.17g, 0.2, %g]}%s}\n",
      x, z, nx, nx == 1 ? 0.1 : 1, within);
}

static void write_scene(char *text, size_t room, Kind kind, double d, const char *young,
                        const char *flux) {
  const char *part = ", within: {box: {min: [-1, -1, -1], max: [0.6, 2, 2]}}";
  bool first_ends = kind == HANGING || kind == HALF;
  size_t n = (size_t)snprintf(
      text, room,
      "lithe: 1\nbodies:\n  - name: cube\n    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
      "    material: {young_modulus: %s, poisson_ratio: 0.3, density: 1000}\n"
      "    method: {kind: dg, cells: 2, degree: 2, flux: %s, sliver: 0}\n"
      "    initial: {velocity: [\"y\", \"1+x*3\", \"x-y\"]}\ngravity: [0, -9.81, 0]\n"
      "contact: {bodies: false}\ntime: {kind: dynamic, duration: 0.03, step: %g}\n"
      "solver: {linear: cholesky}\ncuts:\n",
      young, flux, STEP);
  n += add_plane(text + n, room - n, first_ends ? part : "", 0.5, 0.3, 0.45);
  if (kind == WEDGE)
    n += add_plane(text + n, room - n, "", 0.5, 0.3 + d, 0.45);
  else
    n += add_plane(text + n, room - n, kind == HANGING ? part : "", 0.5, 0.3, 0.45 + d);
  if (kind == NEEDLE)
    for (int i = 0; i < 2; i++) n += add_plane(text + n, room - n, "", 0.47 + i * d, 1, 0.45);
  assert_true(n < room);
}

/// Cut, and two steps. The share of the volume that is gone after it.
static double run(Kind kind, double d, const char *young, const char *flux) {
  static char text[3000];
  double times[2], gone = 0;
  bool changed;
  LthWorld *world = NULL;
  write_scene(text, sizeof text, kind, d, young, flux);
  Reading r = read_with(text, 0, NULL);
  if (r.status == LITHE_OK) r.status = lth_world_create(r.ctx, r.scene, times, &world);
  if (r.status == LITHE_OK) r.status = lth_world_cut_due(r.ctx, world, STEP, &changed);
  if (r.status == LITHE_OK)
    r.status = lth_topology_check(r.ctx, world->bodies[0]->change->topology, 0, NULL);
  for (int i = 0; i < 2 && r.status == LITHE_OK; i++)
    r.status = lth_simulation_step(r.ctx, world->sim, STEP);
  if (r.status != LITHE_OK)
    fail_msg("kind %d, distance %g: %s\n%s", kind, d, lithe_ctx_message(r.ctx), text);
  assert_true(lth_simulation_report(world->sim)->converged);
  LitheIndex n_removed = 0;
  for (LitheIndex i = 0; i < world->n_notes; i++) n_removed += world->notes[i].n_removed;
  gone = 1 - world->bodies[0]->mass / 1000;
  if (n_removed == 0) CHECK_NEAR(gone, 0, 1e-12);
  lth_world_destroy(r.ctx, &world);
  end_reading(&r);
  return gone;
}

static void run_all(const char *young, double most) {
  static const double distance[] = {1e-3, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11, 1e-12, 1e-14};
  for (int kind = 0; kind < N_KINDS; kind++)
    for (size_t i = 0; i < sizeof distance / sizeof distance[0]; i++)
      CHECK_AT_MOST(run(kind, distance[i], young, i % 2 ? "ip" : "bz"), most);
}

static void of_soft_bodies_no_more_than_rounding_is_taken_away(void **state) {
  (void)state;
  run_all("1e4", 1e-8);
}

/// A wave runs 160 times through the body in a step.
static void of_stiff_bodies_no_more_than_a_step_can_carry(void **state) {
  (void)state;
  run_all("2e11", 2e-5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(of_soft_bodies_no_more_than_rounding_is_taken_away),
      cmocka_unit_test(of_stiff_bodies_no_more_than_a_step_can_carry),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
