/// Elements change in the middle of a run: nothing moves, and all that is built upon elements follows.
#include "base/tensor.h"
#include "mesh/topology.h"
#include "scene/change.h"
#include "scene/cut.h"
#include "scene_text.h"

#define SCENE                                                                                      \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: bar\n"                                                                                \
  "    shape: {sphere: {center: [0, 0.2, 0], radius: 0.1}}\n"                                      \
  "    material: {young_modulus: \"2e4*(1+x)\", poisson_ratio: 0.4, density: \"1000*(1+3*x)\"}\n"  \
  "    method: {kind: dg, cells: 4, sliver: 0.001, degree: \"1.5+4*x\"}\n"                         \
  "    initial: {velocity: [\"y\", \"-1+x*3\", \"x-y\"]}\n"                                        \
  "  - name: other\n"                                                                              \
  "    shape: {box: {min: [-0.1, 0.301, -0.1], max: [0.1, 0.35, 0.1]}}\n"                          \
  "    material: {young_modulus: 1e4, poisson_ratio: 0.3, density: 1000}\n"                        \
  "    method: {kind: dg, mesh: hexahedra, cells: [3, 1, 3], degree: 1}\n"                         \
  "gravity: [0, -9.81, 0]\n"                                                                       \
  "colliders:\n"                                                                                   \
  "  - plane: {point: [0, 0.095, 0], normal: [0.1, 1, 0]}\n"                                       \
  "contact: {friction: 0.3}\n"                                                                     \
  "cuts:\n"                                                                                        \
  "  - {at: 0.05, body: bar, plane: {point: [0.01, 0.19, 0], normal: [1, 0.3, 0.2]}}\n"            \
  "  - {at: 0.05, body: bar, plane: {point: [0, 0.2, 0.01], normal: [0, 0.1, 1]}, space: rest}\n"  \
  "time: {kind: dynamic, duration: 1, step: 0.01}\n"

typedef struct Run {
  Reading reading;
  LitheCtx *ctx;
  LthWorld *world;
} Run;

static Run begin_with(const char *text, int n_overrides, const char *const *overrides) {
  Run run = {.reading = read_with(text, n_overrides, overrides)};
  double times[2];
  run.ctx = run.reading.ctx;
  CHECK_OK(run.ctx, run.reading.status);
  CHECK_OK(run.ctx, lth_world_create(run.ctx, run.reading.scene, times, &run.world));
  return run;
}

static void end(Run *run) {
  lth_world_destroy(run->ctx, &run->world);
  end_reading(&run->reading);
}

static void steps(Run *run, int n) {
  for (int i = 0; i < n; i++)
    CHECK_OK(run->ctx, lth_simulation_step(run->ctx, run->world->sim, 0.01));
}

/// Position and velocity of points well inside elements, by places that splits do not move.
enum { POINTS = 200 };
typedef struct Look {
  double at[POINTS][3], x[POINTS][3], v[POINTS][3];
} Look;

static void look(const Run *run, Look *look) {
  const LthBody *body = run->world->bodies[0];
  for (int i = 0; i < POINTS; i++) {
    LitheIndex cell;
    bool inside;
    CHECK_OK(run->ctx, lth_disc_find_cell(run->ctx, body->disc, look->at[i], &cell, &inside));
    lth_disc_sample(body->disc, cell, lth_body_position(body), look->at[i], look->x[i]);
    lth_disc_sample(body->disc, cell, lth_body_velocity(body), look->at[i], look->v[i]);
  }
}

static void choose_places(const Run *run, Look *look) {
  const LthMesh *mesh = run->world->bodies[0]->mesh;
  for (int i = 0; i < POINTS; i++) { // between centroids and corners of cells
    LitheIndex c = (LitheIndex)(i * 7 % mesh->n_cells);
    LitheIndex f = mesh->cell_face[mesh->cell_face_off[c] + i % 4];
    const double *g = mesh->cell_centroid + 3 * (LitheCount)c,
                 *h = mesh->face_centroid + 3 * (LitheCount)f;
    for (int a = 0; a < 3; a++) look->at[i][a] = g[a] + 0.7 * (h[a] - g[a]);
  }
}

/// A matrix of a factorisation is positive definite: Cholesky fails else.
static void check_definite(const Run *run) {
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  const LthBlockMatrix *A = lth_simulation_matrix(run->world->sim);
  if (!engine) return;
  CHECK_OK(run->ctx, engine->analyse(run->ctx, A, &factor));
  CHECK_OK(run->ctx, engine->factorize(run->ctx, factor, A));
  engine->destroy(run->ctx, &factor);
}

static void nothing_moves_when_a_body_is_cut(void **state) {
  (void)state;
  const char *overrides[] = {"bodies.0.method.sliver=0"}; // what is merged moves
  Run run = begin_with(SCENE, 1, overrides);
  static Look before, after;
  bool changed;
  steps(&run, 5);
  lth_simulation_measure(run.ctx, run.world->sim);
  LthStepReport r0 = *lth_simulation_report(run.world->sim);
  LitheIndex n0 = run.world->bodies[0]->mesh->n_cells;
  choose_places(&run, &before);
  after = before;
  look(&run, &before);
  CHECK_OK(run.ctx, lth_world_cut_due(run.ctx, run.world, 0.055, &changed));
  assert_true(changed);
  look(&run, &after);
  lth_simulation_measure(run.ctx, run.world->sim);
  LthStepReport r1 = *lth_simulation_report(run.world->sim);
  assert_true(run.world->bodies[0]->mesh->n_cells > n0 + 20);
  for (int i = 0; i < POINTS; i++)
    for (int a = 0; a < 3; a++) {
      CHECK_NEAR(after.x[i][a], before.x[i][a], 1e-14);
      CHECK_NEAR(after.v[i][a], before.v[i][a], 1e-13);
    }
  for (int a = 0; a < 3; a++) {
    CHECK_NEAR(r1.momentum[a], r0.momentum[a], 1e-13 * 10);
    CHECK_NEAR(r1.angular_momentum[a], r0.angular_momentum[a], 1e-13 * 2);
  }
  CHECK_NEAR(r1.kinetic_energy / r0.kinetic_energy, 1, 1e-13);
  CHECK_NEAR(r1.work, r0.work, 0);
  assert_true(r1.linear_total == r0.linear_total);
  CHECK_NEAR(lth_simulation_time(run.world->sim), 0.05, 1e-15);
  const LthChangeNote *note = run.world->notes;
  assert_int_equal(run.world->n_notes, 2);
  assert_true(note[1].pieces >= 4);
  assert_int_equal(run.world->n_renewals, 1); // two cuts at one time, followed once
  CHECK_NEAR(note[1].kinetic[0], note[1].kinetic[1], 1e-13 * note[1].kinetic[0]);
  CHECK_NEAR(note[1].strain[1], note[1].strain[0], 0.3 * note[1].strain[0]);
  CHECK_NEAR(note[1].volume, lth_body_volume(run.world->bodies[0]), 1e-15);
  steps(&run, 10);
  check_definite(&run);
  end(&run);
}

/// By how much strain energy and that of jumps change at two cuts, and what there was.
static void measure_cut(const char *model, const char *degree, double rise[2], double *energy) {
  const char *overrides[] = {model, degree, "bodies.0.method.sliver=0"};
  Run run = begin_with(SCENE, 3, overrides);
  bool changed;
  steps(&run, 5);
  CHECK_OK(run.ctx, lth_world_cut_due(run.ctx, run.world, 0.055, &changed));
  const LthChangeNote *note = run.world->notes + 1;
  assert_int_equal(note->n_merged, 0);
  rise[0] = note->strain[1] - note->strain[0];
  rise[1] = note->jump[1] - note->jump[0];
  *energy = note->strain[0];
  end(&run);
}

/// What is inside of elements stays: only jumps that were there are weighed anew. Parts of quadratic corotated elements turn by
/// rotations of their own besides.
static void the_strain_energy_changes_by_that_of_jumps_alone(void **state) {
  (void)state;
  static const char *const ways[][2] = {
      {"bodies.0.material.model=linear", "bodies.0.method.degree=1"},
      {"bodies.0.material.model=linear", "bodies.0.method.degree=3"},
      {"bodies.0.material.model=corotated", "bodies.0.method.degree=1"},
      {"bodies.0.material.model=corotated", "bodies.0.method.degree=2"}};
  for (int i = 0; i < 4; i++) {
    double rise[2], energy;
    measure_cut(ways[i][0], ways[i][1], rise, &energy);
    assert_true(fabs(rise[1]) > 1e-6 * energy);
    CHECK_NEAR(rise[0], rise[1], (i < 3 ? 1e-12 : 0.05) * energy);
  }
}

/// One split made two cells: bases are theirs, face tables those of their faces, matrices theirs and their neighbours'.
static void check_integrated(const LthBody *body, const LthDgStoreCount *before) {
  const LthMesh *mesh = body->mesh;
  LthDgStoreCount now = lth_dg_store_count(body->change->store);
  LitheIndex n_faces = 0, n_cells = 0, last = mesh->n_cells - 2; // births have the highest records
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    bool is_beside = c >= last;
    for (LitheIndex k = mesh->cell_face_off[c]; k < mesh->cell_face_off[c + 1]; k++) {
      const LitheIndex *pair = mesh->face_cell + 2 * (LitheCount)mesh->cell_face[k];
      is_beside |= pair[1] >= last;
      n_faces += pair[0] == c && pair[1] >= last;
    }
    n_cells += is_beside;
  }
  assert_int_equal(now.bases - before->bases, 2);
  assert_int_equal(now.faces - before->faces, n_faces);
  assert_int_equal(now.matrices - before->matrices, n_cells);
}

static void kept_elements_keep_their_bits(void **state) {
  (void)state;
  Run run = begin_with(SCENE, 0, NULL);
  LthBody *body = run.world->bodies[0];
  LthTopology *t = body->change->topology;
  LthSplit split;
  LthPlane plane = {{0, 0, 0}, {0.3, 1, 0.2}};
  steps(&run, 2);
  LitheIndex n = body->mesh->n_cells;
  double *x = NULL, *v = NULL, *young = NULL;
  LitheIndex *first = NULL;
  CHECK_OK(run.ctx, lth_new_(run.ctx, (void **)&x, 3 * body->space->n_funcs, sizeof *x));
  CHECK_OK(run.ctx, lth_new_(run.ctx, (void **)&v, 3 * body->space->n_funcs, sizeof *v));
  CHECK_OK(run.ctx, lth_new_(run.ctx, (void **)&first, n + 1, sizeof *first));
  CHECK_OK(run.ctx, lth_new_(run.ctx, (void **)&young, n, sizeof *young));
  size_t bytes = sizeof *x * 3 * (size_t)body->space->n_funcs;
  memcpy(x, lth_body_position(body), bytes);
  memcpy(v, lth_body_velocity(body), bytes);
  memcpy(first, body->space->func_off, sizeof *first * (size_t)(n + 1));
  memcpy(young, body->young, sizeof *young * (size_t)n);
  lth_v3_copy(t->cells[7].centroid, plane.point);
  CHECK_OK(run.ctx, lth_topology_split(run.ctx, t, 7, &plane, -1, &split));
  assert_int_equal(split.n, 2);
  LthDgStoreCount count = lth_dg_store_count(body->change->store);
  CHECK_OK(run.ctx, lth_world_renew(run.ctx, run.world));
  check_integrated(body, &count);
  assert_int_equal(body->mesh->n_cells, n + 1);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    LitheIndex record = body->change->cell_record[c];
    assert_int_equal(body->change->record_cell[record], c);
    if (record >= n || record == 7) continue;
    size_t size = 3 * sizeof *x * (size_t)lth_dg_funcs(body->space, c);
    LitheCount at = 3 * (LitheCount)body->space->func_off[c], was = 3 * (LitheCount)first[record];
    assert_memory_equal(lth_body_position(body) + at, x + was, size);
    assert_memory_equal(lth_body_velocity(body) + at, v + was, size);
    CHECK_NEAR(body->young[c], young[record], 0);
  }
  lth_free(run.ctx, x);
  lth_free(run.ctx, v);
  lth_free(run.ctx, young);
  lth_free(run.ctx, first);
  end(&run);
}

/// Mass, and Young's modulus and Poisson's ratio summed over the volume.
static void sum_material(const LthBody *body, double sum[3]) {
  memset(sum, 0, 3 * sizeof *sum);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    double of[3] = {body->density[c], body->young[c], body->poisson[c]};
    lth_v3_axpy(body->mesh->cell_volume[c], of, sum);
  }
}

/// Momentum and angular momentum to rounding of what they are summed up from.
static void check_motion(const LthStepReport *before, const LthStepReport *after) {
  for (int a = 0; a < 3; a++) {
    CHECK_NEAR(after->momentum[a], before->momentum[a], 1e-13 * 10);
    CHECK_NEAR(after->angular_momentum[a], before->angular_momentum[a], 1e-13 * 2);
  }
}

static void splits_and_merges_in_one_turn_keep_momentum(void **state) {
  (void)state;
  Run run = begin_with(SCENE, 0, NULL);
  LthBody *body = run.world->bodies[0];
  LthTopology *t = body->change->topology;
  LitheIndex n_merged;
  LthSplit split;
  double before[3], after[3];
  sum_material(body, before);
  steps(&run, 4);
  lth_simulation_measure(run.ctx, run.world->sim);
  LthStepReport r0 = *lth_simulation_report(run.world->sim);
  for (LitheIndex c = 0; c < 20; c++)
    CHECK_OK(run.ctx, lth_topology_split_eight(run.ctx, t, c, &split));
  CHECK_OK(run.ctx, lth_body_change_hold(run.ctx, body));
  CHECK_OK(run.ctx, lth_topology_merge_slivers(run.ctx, t, 0, NULL, 1e-5, &n_merged));
  assert_true(n_merged > 20);
  CHECK_OK(run.ctx, lth_world_renew(run.ctx, run.world));
  lth_simulation_measure(run.ctx, run.world->sim);
  LthStepReport r1 = *lth_simulation_report(run.world->sim);
  const char *even = "bodies.0.material.density=1000";
  // cells of different density are merged too: momentum stays, centres of mass do not
  for (int a = 0; a < 3; a++) {
    CHECK_NEAR(r1.momentum[a], r0.momentum[a], 1e-13 * 10);
    CHECK_NEAR(r1.angular_momentum[a], r0.angular_momentum[a], 1e-3);
  }
  sum_material(body, after);
  for (int a = 0; a < 3; a++) CHECK_NEAR(after[a] / before[a], 1, 1e-12);
  end(&run);

  run = begin_with(SCENE, 1, &even);
  body = run.world->bodies[0];
  t = body->change->topology;
  steps(&run, 4);
  lth_simulation_measure(run.ctx, run.world->sim);
  r0 = *lth_simulation_report(run.world->sim);
  for (LitheIndex c = 0; c < 20; c++)
    CHECK_OK(run.ctx, lth_topology_split_eight(run.ctx, t, c, &split));
  CHECK_OK(run.ctx, lth_body_change_hold(run.ctx, body));
  CHECK_OK(run.ctx, lth_topology_merge_slivers(run.ctx, t, 0, NULL, 1e-5, &n_merged));
  CHECK_OK(run.ctx, lth_world_renew(run.ctx, run.world));
  lth_simulation_measure(run.ctx, run.world->sim);
  r1 = *lth_simulation_report(run.world->sim);
  check_motion(&r0, &r1);
  assert_true(r1.kinetic_energy <= r0.kinetic_energy * (1 + 1e-14));
  end(&run);
}

static void a_cut_that_misses_changes_nothing(void **state) {
  (void)state;
  const char *away = "cuts.0.plane.point=[1, 0, 0]", *late = "cuts.1.at=0.5";
  Run run = begin_with(SCENE, 2, (const char *const[]){away, late});
  bool changed;
  const LthSimulation *sim = run.world->sim;
  const LthMesh *mesh = run.world->bodies[0]->mesh;
  steps(&run, 5);
  const uint64_t pattern = lth_simulation_matrix(sim)->pattern_revision;
  CHECK_OK(run.ctx, lth_world_cut_due(run.ctx, run.world, 0.055, &changed));
  assert_false(changed);
  assert_true(lth_simulation_matrix(sim)->pattern_revision == pattern); // nor is it analysed again
  assert_ptr_equal(run.world->sim, sim);
  assert_ptr_equal(run.world->bodies[0]->mesh, mesh);
  assert_int_equal(run.world->n_notes, 1);
  assert_int_equal(run.world->notes[0].n_split, 0);
  assert_int_equal(lithe_ctx_warning_count(run.ctx), 1);
  assert_non_null(strstr(lithe_ctx_warning(run.ctx, 0), "cuts.0: it misses its body"));
  end(&run);
}

#define HANGING                                                                                    \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: bar\n"                                                                                \
  "    shape: {box: {min: [0, 0, 0], max: [8, 1, 1]}}\n"                                           \
  "    material: {model: linear, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}\n"         \
  "    method: {kind: dg, mesh: hexahedra, cells: [24, 3, 3], degree: 1, flux: ip}\n"              \
  "    constraints: [{where: {plane: {point: [0.01, 0, 0], normal: [1, 0, 0]}}, displacement: "    \
  "[0, 0, 0]}]\n"                                                                                  \
  "    loads: [{body_force: [0, -10, 0]}]\n"                                                       \
  "gravity: [0, 0, 0]\n"                                                                           \
  "cuts: [{at: 0.5, plane: {point: [7.1, 0, 0], normal: [1, 0.2, 0]}, within: {box: {min: [6, "    \
  "0.7, -1], max: [8, 2, 2]}}, space: rest}]\n"                                                    \
  "time: {kind: quasistatic, steps: 2, duration: 1}\n"                                             \
  "solver: {linear: pcg, tolerance: 1e-6, newton: {tolerance: 1e-6}}\n"

/// Iterations to the equilibrium of a bar that hangs, one element of which is divided: from the solution of before, or from rest.
static LitheIndex solve_divided(bool from_rest, double *energy) {
  Run run = begin_with(HANGING, 0, NULL);
  LthTopology *t = run.world->bodies[0]->change->topology;
  LthPlane plane = {{0, 0, 0}, {0.3, 1, 0.2}};
  LthSplit split;
  if (!from_rest) CHECK_OK(run.ctx, lth_simulation_equilibrium(run.ctx, run.world->sim, 0.5));
  lth_v3_copy(t->cells[40].centroid, plane.point);
  CHECK_OK(run.ctx, lth_topology_split(run.ctx, t, 40, &plane, -1, &split));
  assert_int_equal(split.n, 2);
  CHECK_OK(run.ctx, lth_world_renew(run.ctx, run.world));
  LitheIndex before = lth_simulation_report(run.world->sim)->linear_total;
  CHECK_OK(run.ctx, lth_simulation_equilibrium(run.ctx, run.world->sim, 1));
  lth_simulation_measure(run.ctx, run.world->sim);
  const LthStepReport *report = lth_simulation_report(run.world->sim);
  LitheIndex n = report->linear_total - before;
  assert_true(report->converged);
  *energy = report->strain_energy;
  end(&run);
  return n;
}

static void a_solve_after_a_change_starts_from_the_solution_before(void **state) {
  (void)state;
  double energy[2];
  LitheIndex warm = solve_divided(false, energy), cold = solve_divided(true, energy + 1);
  printf("%d iterations after a division, %d from rest\n", warm, cold);
  CHECK_AT_MOST(4 * warm, 3 * cold);
  CHECK_NEAR(energy[0], energy[1], 1e-5 * energy[1]);
}

/// A body that flies on as it is: its velocity solves the step after a cut, and conjugate gradients that begin with it have nothing
/// to do.
static void a_step_after_a_cut_starts_from_the_velocity_before(void **state) {
  (void)state;
  const char *overrides[] = {"gravity=[0, 0, 0]", "bodies.0.initial.velocity=[1, 0, 0]",
                             "bodies.1.initial={velocity: [1, 0, 0]}", "solver={linear: pcg}"};
  Run run = begin_with(SCENE, 4, overrides);
  bool changed;
  steps(&run, 5);
  CHECK_OK(run.ctx, lth_world_cut_due(run.ctx, run.world, 0.055, &changed));
  assert_true(changed);
  LitheIndex before = lth_simulation_report(run.world->sim)->linear_total;
  steps(&run, 1);
  CHECK_AT_MOST(lth_simulation_report(run.world->sim)->linear_total - before, 1);
  end(&run);
}

/// The matrix that a linear body has after a cut is that of its operator to the bit, and only what the cut touched was written.
static void a_linear_body_keeps_its_matrix(void **state) {
  (void)state;
  const char *overrides[] = {"bodies.0.material.model=linear", "cuts.1.at=0.07"};
  Run run = begin_with(SCENE, 2, overrides);
  LthBody *body = run.world->bodies[0];
  bool changed;
  steps(&run, 5);
  assert_null(run.world->bodies[1]->change);
  for (int cut = 0; cut < 2; cut++) {
    LthBlockMatrix *K = NULL, *whole = NULL;
    double *f0 = NULL;
    CHECK_OK(run.ctx, lth_world_cut_due(run.ctx, run.world, 0.055 + 0.02 * cut, &changed));
    assert_true(changed);
    CHECK_OK(run.ctx, lth_new_(run.ctx, (void **)&f0, body->disc->n_dofs, sizeof *f0));
    CHECK_OK(run.ctx, body->disc->table->matrix_create(run.ctx, body->disc, &K));
    CHECK_OK(run.ctx, lth_dg_matrix_create(run.ctx, body->op, &whole));
    body->disc->table->assemble(body->disc, 0, K, f0);
    lth_dg_assemble(body->op, 0, whole, f0);
    assert_memory_equal(K->values, whole->values,
                        sizeof(double) * (size_t)K->value_off[K->block_off[K->n_rows]]);
    lth_block_matrix_destroy(run.ctx, &K);
    lth_block_matrix_destroy(run.ctx, &whole);
    lth_free(run.ctx, f0);
  }
  assert_int_equal(run.world->n_renewals, 2);
  end(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_moves_when_a_body_is_cut),
      cmocka_unit_test(the_strain_energy_changes_by_that_of_jumps_alone),
      cmocka_unit_test(kept_elements_keep_their_bits),
      cmocka_unit_test(splits_and_merges_in_one_turn_keep_momentum),
      cmocka_unit_test(a_cut_that_misses_changes_nothing),
      cmocka_unit_test(a_solve_after_a_change_starts_from_the_solution_before),
      cmocka_unit_test(a_step_after_a_cut_starts_from_the_velocity_before),
      cmocka_unit_test(a_linear_body_keeps_its_matrix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
