/// The linearly implicit Euler step: what it keeps, what it damps, what it holds.
#include "beam_mode.h"

static double norm3(const double a[3]) { return lth_v3_norm(a); }

static void steps(Beam *b, int n, double dt) {
  for (int i = 0; i < n; i++) CHECK_OK(b->ctx, lth_simulation_step(b->ctx, b->sim, dt));
}

static void free_flight_keeps_momentum_to_rounding(void **state) {
  (void)state;
  for (int degree = 1; degree <= 2; degree++) {
    Beam b;
    beam_create(&b, (BeamDef){.degree = degree, .cells = {4, 2, 1}});
    beam_set_velocity(&b, (double[]){1, -2, 0.5}, (double[]){0.3, 1, 2});
    // a kick out of the rigid motion, so that stresses act
    for (LitheCount i = 0; i < b.space->n_dofs; i++)
      lth_simulation_velocity(b.sim)[i] += 0.2 * sin((double)(7 * i));
    lth_simulation_measure(b.ctx, b.sim);
    LthStepReport first = *lth_simulation_report(b.sim);
    steps(&b, 60, 1.0 / 30);
    lth_simulation_measure(b.ctx, b.sim);
    const LthStepReport *last = lth_simulation_report(b.sim);
    double lost[3];
    lth_v3_sub(last->momentum, first.momentum, lost);
    CHECK_AT_MOST(norm3(lost) / norm3(first.momentum), 1e-13);
    assert_true(last->converged);
    beam_destroy(&b);
  }
}

static void one_step_damps_a_mode_as_the_theory_says(void **state) {
  (void)state;
  static const int modes[] = {0, 3, 20};
  for (int k = 0; k < 3; k++) {
    Beam b;
    LthStepOptions options = lth_step_options_default();
    options.tolerance = 1e-13;
    beam_create(&b, (BeamDef){.linear = true,
                              .clamp_weak = true,
                              .poisson = 0.3,
                              .damping_mass = 0.7,
                              .damping_stiffness = 1e-3,
                              .options = options});
    LitheCount n = b.space->n_dofs;
    double *mode = calloc((size_t)n, sizeof *mode), *v = lth_simulation_velocity(b.sim), h = 0.05;
    double om2 = mode_of(&b, modes[k], mode), size = 0;
    for (LitheCount i = 0; i < n; i++) size = fmax(size, fabs(v[i] = mode[i]));
    steps(&b, 1, h);
    double factor = 1 / (1 + h * 0.7 + (h * h + h * 1e-3) * om2);
    const double *u = lth_simulation_displacement(b.sim);
    for (LitheCount i = 0; i < n; i++) {
      CHECK_NEAR(v[i], factor * mode[i], 1e-10 * size);
      CHECK_NEAR(u[i], h * factor * mode[i], 1e-10 * h * size);
    }
    // and from a displacement: v1 = -h om^2 u0 factor
    lth_simulation_position(b.sim)[0] += 0;
    for (LitheCount i = 0; i < n; i++) {
      lth_simulation_position(b.sim)[i] = b.rest[i] + mode[i];
      v[i] = 0;
    }
    steps(&b, 1, h);
    for (LitheCount i = 0; i < n; i++)
      CHECK_NEAR(v[i], -h * om2 * factor * mode[i], 1e-9 * h * om2 * factor * size + 1e-10 * size);
    free(mode);
    beam_destroy(&b);
  }
}

static void falling_body_follows_the_difference_scheme(void **state) {
  (void)state;
  Beam b;
  beam_create(&b, (BeamDef){.gravity = {0, 0, -9.81}, .damping_stiffness = 0.01});
  steps(&b, 20, 0.01);
  double u[3];
  beam_displacement(&b, (double[]){0.5, 0.5, 0.5}, u);
  // g h^2 (1 + 2 + ... + 20), no strain, so no damping
  CHECK_NEAR(u[2], -9.81 * 1e-4 * 210, 1e-9);
  CHECK_NEAR(u[0], 0, 1e-9);
  lth_simulation_measure(b.ctx, b.sim);
  const LthStepReport *r = lth_simulation_report(b.sim);
  CHECK_NEAR(r->momentum[2], -9.81 * 4 * 0.2, 1e-12 * 8);
  CHECK_NEAR(r->work, 9.81 * 4 * 9.81 * 1e-4 * 210, 1e-9);
  CHECK_NEAR(r->kinetic_energy, 0.5 * 4 * pow(9.81 * 0.2, 2), 1e-9);
  CHECK_AT_MOST(r->strain_energy, 1e-9);
  beam_destroy(&b);
}

static void strong_clamp_holds_and_carries(void **state) {
  (void)state;
  Beam b;
  beam_create(&b, (BeamDef){.clamp_strong = true, .damping_mass = 2, .damping_stiffness = 0.01});
  b.speed = 0.5;
  steps(&b, 200, 0.05);
  const double *u = lth_simulation_displacement(b.sim);
  for (LitheIndex c = 0; c < b.space->n_cells; c++)
    for (LitheIndex i = b.space->func_off[c]; i < b.space->func_off[c + 1]; i++) {
      bool constant = i == b.space->func_off[c];
      // air drag stretches the tail a little; the held layer is exact
      CHECK_NEAR(u[3 * i], constant ? 0.5 * 10 : 0, b.strong[c] ? 1e-12 : 0.1);
      CHECK_NEAR(u[3 * i + 1], 0, 1e-9);
      if (b.strong[c]) CHECK_NEAR(lth_simulation_velocity(b.sim)[3 * i], constant ? 0.5 : 0, 1e-12);
    }
  assert_true(lth_simulation_report(b.sim)->converged);
  beam_destroy(&b);
}

static double travel(const void *self, const double x[3], double t) {
  (void)self, (void)x;
  return 0.5 * t;
}

static void stiffness_damping_lets_a_moving_clamp_go(void **state) {
  (void)state;
  Beam b;
  beam_create(&b,
              (BeamDef){.pull_weak = true, .pull = {{.eval = travel}}, .damping_stiffness = 0.1});
  beam_set_velocity(&b, (double[]){0.5, 0, 0}, (double[3]){0});
  steps(&b, 50, 0.02);
  // clamp and body move alike from the start: no force between them
  const double *v = lth_simulation_velocity(b.sim);
  for (LitheIndex c = 0; c < b.space->n_cells; c++) {
    LitheIndex i = b.space->func_off[c];
    CHECK_NEAR(v[3 * i], 0.5, 1e-7);
    CHECK_NEAR(lth_simulation_displacement(b.sim)[3 * i], 0.5, 1e-7);
  }
  beam_destroy(&b);
}

/// Displacements of all cell centroids in the box's axes after some steps.
static double *bend(BeamDef def, int n_steps, double dt) {
  Beam b;
  def.options = lth_step_options_default();
  def.options.tolerance = 1e-11;
  beam_create(&b, def);
  steps(&b, n_steps, dt);
  double *u = calloc(3 * (size_t)b.mesh->n_cells, sizeof *u);
  const double *coef = lth_simulation_displacement(b.sim);
  for (LitheIndex c = 0; c < b.mesh->n_cells; c++) {
    double value[3];
    lth_dg_sample(b.space, c, coef, b.mesh->cell_centroid + 3 * c, value);
    lth_m3_apply_t(b.Q, value, u + 3 * c);
  }
  beam_destroy(&b);
  return u;
}

static void turned_and_moved_body_gives_turned_motion(void **state) {
  (void)state;
  for (int degree = 1; degree <= 2; degree++) {
    BeamDef def = {.degree = degree,
                   .cells = {4, 2, 1},
                   .poisson = 0.3,
                   .gravity = {0, 1, -5},
                   .clamp_weak = true};
    double *straight = bend(def, 20, 1.0 / 30);
    def.angle = 0.9;
    memcpy(def.axis, (double[]){1, 2, -0.5}, sizeof def.axis);
    memcpy(def.offset, (double[]){30, -20, 10}, sizeof def.offset);
    double *turned = bend(def, 20, 1.0 / 30);
    // far beyond small strain, but not beyond the solver's tolerance
    CHECK_AT_LEAST(fabs(straight[3 * 7 + 2]), 0.2);
    for (int i = 0; i < 24; i++) CHECK_NEAR(turned[i], straight[i], 1e-8);
    free(straight), free(turned);
  }
}

static void same_bits_on_any_number_of_threads(void **state) {
  (void)state;
  static const int threads[] = {1, 2, 4, 7};
  double *first = NULL;
  for (int k = 0; k < 4; k++) {
    BeamDef def = {.cells = {12, 4, 4},
                   .poisson = 0.3,
                   .gravity = {0, 0, -5},
                   .clamp_weak = true,
                   .threads = threads[k]};
    double *u = bend(def, 5, 0.05);
    if (k == 0) first = u;
    assert_memory_equal(first, u, sizeof *u * 3 * 192);
    if (k > 0) free(u);
  }
  free(first);
}

static void steps_after_the_first_allocate_nothing(void **state) {
  (void)state;
  Beam b;
  beam_create(&b, (BeamDef){.clamp_weak = true, .gravity = {0, 0, -5}, .poisson = 0.3});
  steps(&b, 1, 0.01);
  LitheCount before = lth_alloc_count(b.ctx);
  steps(&b, 10, 0.01);
  lth_simulation_measure(b.ctx, b.sim);
  assert_int_equal(lth_alloc_count(b.ctx), before);
  beam_destroy(&b);
}

static void cholesky_and_pcg_take_the_same_steps(void **state) {
  (void)state;
  BeamDef def = {.clamp_weak = true, .gravity = {0, 0, -5}, .poisson = 0.3};
  Beam pcg, direct;
  beam_create(&pcg, def);
  def.options = lth_step_options_default();
  def.options.linear = LTH_LINEAR_CHOLESKY;
  beam_create(&direct, def);
  steps(&pcg, 10, 0.05);
  steps(&direct, 10, 0.05);
  assert_string_equal(lth_simulation_report(pcg.sim)->linear, "pcg");
  assert_string_equal(lth_simulation_report(direct.sim)->linear, "cholesky");
  assert_true(lth_simulation_report(direct.sim)->linear_iterations <= 2);
  for (LitheCount i = 0; i < pcg.space->n_dofs; i++)
    CHECK_NEAR(lth_simulation_displacement(pcg.sim)[i], lth_simulation_displacement(direct.sim)[i],
               1e-6);
  beam_destroy(&pcg);
  beam_destroy(&direct);
}

static void bad_steps_are_refused(void **state) {
  (void)state;
  Beam b;
  beam_create(&b, (BeamDef){0});
  static const double bad[] = {0, -1, NAN, INFINITY};
  for (int i = 0; i < 4; i++)
    assert_int_equal(lth_simulation_step(b.ctx, b.sim, bad[i]), LITHE_BAD_INPUT);
  lithe_ctx_cancel(b.ctx);
  assert_int_equal(lth_simulation_step(b.ctx, b.sim, 0.1), LITHE_INTERRUPTED);
  beam_destroy(&b);
}

static void missed_tolerance_is_told(void **state) {
  (void)state;
  LthStepOptions options = lth_step_options_default();
  options.max_iterations = 2;
  options.linear = LTH_LINEAR_PCG;
  Beam b;
  beam_create(
      &b,
      (BeamDef){.cells = {8, 2, 2}, .clamp_weak = true, .gravity = {0, 0, -5}, .options = options});
  steps(&b, 2, 0.1);
  const LthStepReport *r = lth_simulation_report(b.sim);
  assert_false(r->converged);
  assert_int_equal(r->linear_iterations, 2);
  CHECK_AT_LEAST(r->residual, options.tolerance);
  beam_destroy(&b);
}

static void automatic_steps_take_another_solver_where_gradients_miss(void **state) {
  (void)state;
  LthStepOptions options = lth_step_options_default();
  options.max_iterations = 2;
  Beam b;
  beam_create(
      &b,
      (BeamDef){.cells = {8, 2, 2}, .clamp_weak = true, .gravity = {0, 0, -5}, .options = options});
  for (int i = 0; i < 20; i++) { // at times the second best solver is tried again
    steps(&b, 1, 0.1);
    const LthStepReport *r = lth_simulation_report(b.sim);
    assert_true(r->converged);
    CHECK_AT_MOST(r->residual, options.tolerance);
    assert_string_not_equal(r->linear, "pcg");
  }
  beam_destroy(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(free_flight_keeps_momentum_to_rounding),
      cmocka_unit_test(one_step_damps_a_mode_as_the_theory_says),
      cmocka_unit_test(falling_body_follows_the_difference_scheme),
      cmocka_unit_test(strong_clamp_holds_and_carries),
      cmocka_unit_test(stiffness_damping_lets_a_moving_clamp_go),
      cmocka_unit_test(turned_and_moved_body_gives_turned_motion),
      cmocka_unit_test(same_bits_on_any_number_of_threads),
      cmocka_unit_test(steps_after_the_first_allocate_nothing),
      cmocka_unit_test(cholesky_and_pcg_take_the_same_steps),
      cmocka_unit_test(bad_steps_are_refused),
      cmocka_unit_test(missed_tolerance_is_told),
      cmocka_unit_test(automatic_steps_take_another_solver_where_gradients_miss),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
