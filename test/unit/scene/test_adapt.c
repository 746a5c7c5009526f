/// What the criteria of refinement measure, and what is marked for it.
#include "base/tensor.h"
#include "mesh/topology.h"
#include "scene/adapt.h"
#include "scene/world.h"
#include "scene_text.h"

#define SCENE                                                                                      \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: bar\n"                                                                                \
  "    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}\n"                                           \
  "    material: {model: corotated, young_modulus: 1000, poisson_ratio: 0, density: 2}\n"          \
  "    method: {kind: dg, mesh: hexahedra, cells: [4, 1, 1], degree: %s}\n"                        \
  "    initial: {displacement: [%s]}\n"                                                            \
  "gravity: [0, 0, -3]\n"                                                                          \
  "adapt: {h: {criterion: %s, threshold: 1, coarsen: 0.5, max_level: 2}}\n"                        \
  "time: {kind: dynamic, duration: 1, step: 0.1}\n"

typedef struct Run {
  Reading reading;
  LitheCtx *ctx;
  LthWorld *world;
  LthBody *body;
} Run;

static Run begin(const char *degree, const char *displacement, const char *criterion) {
  char text[1500];
  double times[2];
  snprintf(text, sizeof text, SCENE, degree, displacement, criterion);
  Run run = {.reading = read_good(text)};
  run.ctx = run.reading.ctx;
  CHECK_OK(run.ctx, lth_world_create(run.ctx, run.reading.scene, times, &run.world));
  run.body = run.world->bodies[0];
  lth_simulation_measure(run.ctx, run.world->sim); // rotations are those of the state
  return run;
}

static void end(Run *run) {
  lth_world_destroy(run->ctx, &run->world);
  end_reading(&run->reading);
}

static double *measure(Run *run, LthCriterion criterion) {
  double *value = lth_alloc(run->ctx, run->body->mesh->n_cells, sizeof *value);
  CHECK_OK(run->ctx, lth_adapt_measure(run->ctx, run->body, run->world->adapt->bodies, criterion,
                                       NULL, value));
  return value;
}

/// Pressed by 5 % along x, pulled by 2 % along y, and turned by 0.5 about z.
static void stress_is_the_largest_and_its_plane_that_at_rest(void **state) {
  (void)state;
  Run run =
      begin("1", "\"0.95*cos(0.5)*x-1.02*sin(0.5)*y-x\", \"0.95*sin(0.5)*x+1.02*cos(0.5)*y-y\", 0",
            "principal-stress");
  double *value = measure(&run, LTH_BY_STRESS);
  for (LitheIndex c = 0; c < 4; c++) {
    double normal[3];
    CHECK_NEAR(value[c], 50, 1e-9); // E times the strain: there is no lateral contraction
    lth_adapt_normal(run.body, c, normal);
    CHECK_NEAR(fabs(normal[0]), 1, 1e-12);
  }
  lth_free(run.ctx, value);
  end(&run);
}

/// The right half is turned by 0.3 about z.
static void turn_is_the_angle_to_a_neighbour(void **state) {
  (void)state;
  Run run = begin("1",
                  "\"x > 2 ? cos(0.3)*x-sin(0.3)*y-x : 0\", \"x > 2 ? sin(0.3)*x+cos(0.3)*y-y : "
                  "0\", 0",
                  "rotation");
  double *value = measure(&run, LTH_BY_TURN);
  for (LitheIndex c = 0; c < 4; c++) CHECK_NEAR(value[c], c == 1 || c == 2 ? 0.3 : 0, 1e-12);
  lth_free(run.ctx, value);
  end(&run);
}

/// All elements with the same value e: the error is e times the energy norm of solution and error together.
static void error_is_an_element_s_over_its_share(void **state) {
  (void)state;
  Run run = begin("1", "\"0.01*x\", \"0.02*x*y\", 0", "error-estimate");
  double *value = measure(&run, LTH_BY_ERROR), sum = 0, errors = 0, parts[4 * LTH_ESTIMATE_PARTS];
  LthDgEstimateDef def = {.op = run.body->op,
                          .x = lth_body_position(run.body),
                          .gravity = {0, 0, -3},
                          .density = run.body->density};
  CHECK_OK(run.ctx, lth_dg_estimate(run.ctx, &def, parts));
  for (LitheIndex c = 0; c < 4; c++) {
    errors += lth_dg_estimate_sum(parts, c);
    sum += value[c] * value[c];
  }
  double energy = 2 * lth_dg_energy(run.body->op, 0, lth_body_position(run.body));
  CHECK_NEAR(sum / 4, errors / (energy + errors), 1e-12);
  lth_free(run.ctx, value);
  end(&run);
}

/// Divide the first element by eight.
static void divide(Run *run) {
  LthBodyChange *c = run->body->change;
  LthSplit split;
  CHECK_OK(run->ctx, lth_refinement_divide(run->ctx, c->refinement, c->topology, c->cell_record[0],
                                           0, LTH_DIVIDE_EIGHT, (double[3]){1, 0, 0}, &split));
  CHECK_OK(run->ctx, lth_body_change_inherit(run->ctx, run->body));
  for (LitheIndex i = split.first; i < c->topology->log.n_births; i++)
    c->level[c->topology->log.births[i].cell] = 1;
  CHECK_OK(run->ctx, lth_world_renew(run->ctx, run->world));
  assert_int_equal(run->body->mesh->n_cells, 11);
}

static LitheIndex count_merged(Run *run, double value) {
  double *values = lth_alloc(run->ctx, 11, sizeof *values);
  LthMark *mark = lth_alloc(run->ctx, 11, sizeof *mark);
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < 11; c++) values[c] = value;
  CHECK_OK(run->ctx, lth_adapt_mark(run->ctx, run->body, run->world->adapt->bodies,
                                    &(LthAdaptValues){.h = values}, true, mark));
  for (LitheIndex c = 0; c < 11; c++) n += mark[c] == LTH_MERGE;
  lth_free(run->ctx, values);
  lth_free(run->ctx, mark);
  return n;
}

/// Below the coarsening threshold, 0.5, after what the whole element is foreseen to have: as much stress, twice the turn, the
/// errors of all together times 2^degree.
static void families_merge_by_what_the_whole_is_foreseen_to_have(void **state) {
  (void)state;
  static const struct {
    const char *criterion, *degree;
    double limit;
  } rules[] = {{"principal-stress", "1", 0.5},
               {"rotation", "1", 0.25},
               {"error-estimate", "1", 0.5 / (2 * 2.8284271247461903)},
               {"error-estimate", "2", 0.5 / (4 * 2.8284271247461903)}};
  for (int i = 0; i < 4; i++) {
    Run run = begin(rules[i].degree, "0, 0, 0", rules[i].criterion);
    divide(&run);
    assert_int_equal(count_merged(&run, 0.999 * rules[i].limit), 8);
    assert_int_equal(count_merged(&run, 1.001 * rules[i].limit), 0);
    end(&run);
  }
}

/// A body in free fall: what is beyond the acceleration that is kept is released, and held back in full.
static void what_new_functions_release_is_held_back(void **state) {
  (void)state;
  Run run = begin("1", "0, 0, 0", "principal-stress");
  LthSystem *system = run.world->system;
  double *rate = lth_alloc(run.ctx, system->n, sizeof *rate), released;
  double *mass = lth_alloc(run.ctx, system->n, sizeof *mass);
  uint8_t *rows = lth_alloc(run.ctx, system->n_rows, 1);
  memset(rows, 1, (size_t)system->n_rows);
  lth_system_mass_diagonal(system, mass);
  CHECK_OK(run.ctx, lth_simulation_step(run.ctx, run.world->sim, 0.1)); // has made a matrix
  CHECK_OK(run.ctx, lth_simulation_find_rate(run.ctx, run.world->sim, rate));
  for (LitheIndex c = 0; c < 4; c++)
    CHECK_NEAR(rate[3 * run.body->space->func_off[c] + 2], -3, 1e-10); // the constant's
  for (int share = 1; share >= 0; share--) {
    for (LitheCount i = 0; i < system->n; i++) rate[i] *= share;
    CHECK_OK(run.ctx, lth_simulation_keep_rate(run.ctx, run.world->sim, rate));
    CHECK_OK(run.ctx, lth_simulation_hold_back(run.ctx, run.world->sim, rows, 0.5, &released));
    CHECK_NEAR(released, share ? 0 : 3, 1e-10); // rounding of E x over rho h^2
  }
  for (LitheIndex c = 0; c < 4; c++) {
    LitheIndex i = 3 * run.body->space->func_off[c] + 2;
    CHECK_NEAR(system->fade[i], 3 * mass[i], 1e-10);
  }
  lth_free(run.ctx, rate);
  lth_free(run.ctx, mass);
  lth_free(run.ctx, rows);
  end(&run);
}

/// Nothing is stressed enough to be divided, and nothing was: mesh, system and pattern, and with it the symbolic analysis, stay.
static void a_look_that_changes_nothing_renews_nothing(void **state) {
  (void)state;
  Run run = begin("1", "0, 0, 0", "principal-stress");
  const LthSimulation *sim = run.world->sim;
  const LthMesh *mesh = run.body->mesh;
  const uint64_t pattern = lth_simulation_matrix(sim)->pattern_revision;
  bool changed = true;
  for (int i = 0; i < 3; i++) {
    CHECK_OK(run.ctx, lth_adapt_before_step(run.ctx, run.world));
    CHECK_OK(run.ctx, lth_simulation_step(run.ctx, run.world->sim, 0.001));
    CHECK_OK(run.ctx, lth_adapt_look(run.ctx, run.world, 0.001, 0, &changed));
    assert_false(changed);
  }
  assert_true(run.world->adapt->n_looks > 0);
  assert_int_equal(run.world->n_renewals, 0);
  assert_ptr_equal(run.world->sim, sim);
  assert_ptr_equal(run.body->mesh, mesh);
  assert_true(lth_simulation_matrix(sim)->pattern_revision == pattern);
  end(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stress_is_the_largest_and_its_plane_that_at_rest),
      cmocka_unit_test(turn_is_the_angle_to_a_neighbour),
      cmocka_unit_test(error_is_an_element_s_over_its_share),
      cmocka_unit_test(families_merge_by_what_the_whole_is_foreseen_to_have),
      cmocka_unit_test(what_new_functions_release_is_held_back),
      cmocka_unit_test(a_look_that_changes_nothing_renews_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
