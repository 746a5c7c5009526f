/// Bodies on a floor: contact within the dynamic step and within equilibria.
#include "beam.h"

#include "embed/contact.h"

typedef struct Floor {
  Beam beam;
  LthEmbedding *points;
  LthContact *contact;
  LthCollider plane;
  LthSystem *system;
  LthSimulation *sim;
} Floor;

/// A soft block of 1 x 1 x 1 (2 x 2 x 2 cells, E = 1000, rho = 1, g = 10, weight 10) on the plane z = `height`.
static void floor_create_for(Floor *f, double height, double friction, bool clamp, bool linear,
                             double stiffness_damping, LthIntegrator kind) {
  LthStepOptions options = lth_step_options_default();
  options.integrator = kind;
  memset(f, 0, sizeof *f);
  beam_create(&f->beam, (BeamDef){.size = {1, 1, 1},
                                  .cells = {2, 2, 2},
                                  .poisson = 0.3,
                                  .linear = linear,
                                  .clamp_strong = clamp});
  Beam *b = &f->beam;
  double *points = calloc(3 * (size_t)b->mesh->n_points, sizeof *points);
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < b->mesh->n_points; i++)
    if (b->mesh->points[3 * i + 2] == 0)
      memcpy(points + 3 * n++, b->mesh->points + 3 * i, 3 * sizeof *points);
  CHECK_OK(b->ctx, lth_embedding_create(b->ctx, b->space, n, points, NULL, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, &f->points));
  free(points);
  f->plane =
      (LthCollider){.kind = LTH_COLLIDER_PLANE, .point = {0, 0, height}, .normal = {0, 0, 1}};
  LthContactDef def = {.points = f->points,
                       .colliders = &f->plane,
                       .n_colliders = 1,
                       .stiffness = 1000,
                       .friction = friction,
                       .modulus = 1300,
                       .cell_size = 0.5,
                       .body_size = 1,
                       .body_weight = 10};
  CHECK_OK(b->ctx, lth_contact_create(b->ctx, &def, &f->contact));
  f->system = beam_system(b,
                          &(BeamDef){.gravity = {0, 0, -10},
                                     .damping_mass = linear ? 0 : 1,
                                     .damping_stiffness = stiffness_damping,
                                     .linear = linear},
                          f->contact);
  CHECK_OK(b->ctx, lth_simulation_create(b->ctx, f->system, &options, &f->sim));
}

static void floor_create(Floor *f, double height, double friction, bool clamp) {
  floor_create_for(f, height, friction, clamp, false, 0, LTH_IMPLICIT_EULER);
}

static void floor_destroy(Floor *f) {
  lth_simulation_destroy(f->beam.ctx, &f->sim);
  lth_system_destroy(f->beam.ctx, &f->system);
  lth_contact_destroy(f->beam.ctx, &f->contact);
  lth_embedding_destroy(f->beam.ctx, &f->points);
  beam_destroy(&f->beam);
}

static double lowest(Floor *f) {
  double *x = calloc(3 * (size_t)f->points->n_points, sizeof *x), z = INFINITY;
  lth_embedding_apply(f->points, 1, lth_simulation_displacement(f->sim), x);
  for (LitheIndex i = 0; i < f->points->n_points; i++) z = fmin(z, x[3 * i + 2]);
  free(x);
  return z;
}

static void dropped_block_comes_to_rest_on_the_floor(void **state) {
  (void)state;
  Floor f;
  floor_create(&f, -0.05, 0.3, false);
  for (int i = 0; i < 400; i++) CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.01));
  lth_simulation_measure(f.beam.ctx, f.sim);
  const LthStepReport *r = lth_simulation_report(f.sim);
  double n_points = f.points->n_points, force, depth;
  LitheIndex n;
  assert_true(r->converged);
  CHECK_AT_MOST(r->kinetic_energy, 1e-8);
  lth_contact_report(f.contact, &n, &depth, &force);
  CHECK_NEAR(force, 10, 1e-4); // the weight
  CHECK_NEAR(lowest(&f), -0.05 - depth, 1e-6);
  CHECK_AT_MOST(depth, 4 * 10 / (1000 * n_points)); // the mean, and more under the middle
  assert_int_equal(r->contacts, (LitheIndex)n_points);
  floor_destroy(&f);
}

static void iterating_integrators_come_to_rest_as_well(void **state) {
  (void)state;
  for (int kind = LTH_NEWTON_EULER; kind <= LTH_NEWMARK; kind++) {
    Floor f;
    floor_create_for(&f, -0.05, 0.3, false, false, 0.02, (LthIntegrator)kind);
    for (int i = 0; i < 400; i++)
      CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.01));
    lth_simulation_measure(f.beam.ctx, f.sim);
    const LthStepReport *r = lth_simulation_report(f.sim);
    assert_true(r->converged);
    CHECK_AT_MOST(r->kinetic_energy, 1e-8);
    CHECK_NEAR(lowest(&f), -0.053, 2e-3);
    floor_destroy(&f);
  }
}

/// Strain, kinetic and contact energy less the work of gravity.
static double energy(Floor *f) {
  double *x = calloc(3 * (size_t)f->points->n_points, sizeof *x), sum;
  lth_simulation_measure(f->beam.ctx, f->sim);
  const LthStepReport *r = lth_simulation_report(f->sim);
  sum = r->strain_energy + r->kinetic_energy - r->work;
  lth_embedding_apply(f->points, 1, lth_simulation_displacement(f->sim), x);
  for (LitheIndex i = 0; i < f->points->n_points; i++)
    sum += 0.5 * 1000 * pow(fmin(0, x[3 * i + 2] + 0.05), 2);
  free(x);
  return sum;
}

static void newmark_gains_no_energy_from_a_floor(void **state) {
  (void)state;
  Floor f;
  floor_create_for(&f, -0.05, 0, false, true, 0, LTH_NEWMARK);
  double start = energy(&f), before = start, weight = 10 * 0.05;
  for (int i = 0; i < 300; i++) {
    CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.01));
    double now = energy(&f);
    // but for points that the last of some rounds found on the wrong side, 2 % of a force
    CHECK_AT_MOST(now - before, 1e-4 * weight);
    before = now;
  }
  CHECK_AT_MOST(before, start - 0.01 * weight);
  floor_destroy(&f);
}

static void equilibrium_on_the_floor_is_that_of_the_motion(void **state) {
  (void)state;
  Floor moves, rests;
  // without friction: what friction holds at rest depends on the way there
  floor_create(&moves, -0.01, 0, false);
  floor_create(&rests, -0.01, 0, false);
  for (int i = 0; i < 600; i++)
    CHECK_OK(moves.beam.ctx, lth_simulation_step(moves.beam.ctx, moves.sim, 0.01));
  CHECK_OK(rests.beam.ctx, lth_simulation_equilibrium(rests.beam.ctx, rests.sim, 0));
  const LthStepReport *r = lth_simulation_report(rests.sim);
  double force, depth;
  LitheIndex n;
  assert_true(r->converged);
  lth_contact_report(rests.contact, &n, &depth, &force);
  CHECK_NEAR(force, 10, 1e-5);
  CHECK_NEAR(lowest(&rests), lowest(&moves), 1e-6);
  floor_destroy(&moves);
  floor_destroy(&rests);
}

static void held_block_presses_on_a_floor_that_is_in_the_way(void **state) {
  (void)state;
  Floor f;
  floor_create(&f, 0.02, 0.3, true);
  CHECK_OK(f.beam.ctx, lth_simulation_equilibrium(f.beam.ctx, f.sim, 0));
  assert_true(lth_simulation_report(f.sim)->converged);
  for (int i = 0; i < 300; i++) CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.02));
  const LthStepReport *r = lth_simulation_report(f.sim);
  assert_true(r->converged);
  CHECK_AT_LEAST(r->contacts, 1);
  for (LitheIndex c = 0; c < f.beam.space->n_cells; c++) // nothing moves the strong cells
    for (LitheCount i = 3 * f.beam.space->func_off[c];
         f.beam.strong[c] && i < 3 * f.beam.space->func_off[c + 1]; i++)
      CHECK_NEAR(lth_simulation_displacement(f.sim)[i], 0, 1e-15);
  floor_destroy(&f);
}

static void steps_with_a_standing_contact_set_allocate_nothing(void **state) {
  (void)state;
  Floor f;
  floor_create(&f, -0.01, 0.3, false);
  for (int i = 0; i < 100; i++) CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.01));
  LitheCount before = lth_alloc_count(f.beam.ctx);
  for (int i = 0; i < 20; i++) CHECK_OK(f.beam.ctx, lth_simulation_step(f.beam.ctx, f.sim, 0.01));
  assert_int_equal(lth_alloc_count(f.beam.ctx), before);
  assert_true(lth_simulation_report(f.sim)->contacts > 0);
  floor_destroy(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(dropped_block_comes_to_rest_on_the_floor),
      cmocka_unit_test(iterating_integrators_come_to_rest_as_well),
      cmocka_unit_test(newmark_gains_no_energy_from_a_floor),
      cmocka_unit_test(equilibrium_on_the_floor_is_that_of_the_motion),
      cmocka_unit_test(held_block_presses_on_a_floor_that_is_in_the_way),
      cmocka_unit_test(steps_with_a_standing_contact_set_allocate_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
