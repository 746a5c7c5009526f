/// Four integrators: their orders in the step, what they keep, what they damp, what they hold.
#include "beam_mode.h"
#include "step/simulation_priv.h"

#define N_KINDS 4

static const int order_of[N_KINDS] = {1, 1, 2, 2};

static LthStepOptions options_of(int kind, double tolerance) {
  LthStepOptions options = lth_step_options_default();
  options.integrator = (LthIntegrator)kind;
  options.tolerance = tolerance;
  options.newton_tolerance = tolerance;
  return options;
}

static void steps(Beam *b, int n, double dt) {
  for (int i = 0; i < n; i++) CHECK_OK(b->ctx, lth_simulation_step(b->ctx, b->sim, dt));
  assert_true(lth_simulation_report(b->sim)->converged);
}

/// y'' = -w2 y - 2 d y' from y = 1, y' = 0 by each scheme, for what a mode should do.
static double scalar_scheme(int kind, double w2, double d, double h, int n) {
  double y = 1, v = 0, y_old = 0, v_old = 0, a = -w2;
  for (int i = 0; i < n; i++) {
    double H = h, y_hat = y, v_hat = v;
    if (kind == LTH_BDF2 && i > 0)
      H = h * 2 / 3, y_hat = (4 * y - y_old) / 3, v_hat = (4 * v - v_old) / 3;
    if (kind == LTH_NEWMARK) H = h / 2, y_hat = y + H * v, v_hat = v + H * a;
    double next = (v_hat - H * w2 * y_hat) / (1 + 2 * d * H + H * H * w2);
    y_old = y, v_old = v;
    a = (next - v_hat) / H;
    v = next, y = y_hat + H * v;
  }
  return y;
}

typedef struct Mode {
  Beam beam;
  double *shape, size; // coefficients and the largest of them
  double w2, decay;
} Mode;

/// A linear bar, clamped or free, let go in one of its modes.
static void mode_create(Mode *m, int kind, int number, double damping_mass,
                        double damping_stiffness, bool is_free) {
  beam_create(&m->beam, (BeamDef){.linear = true,
                                  .clamp_weak = !is_free,
                                  .poisson = 0.3,
                                  .damping_mass = damping_mass,
                                  .damping_stiffness = damping_stiffness,
                                  .options = options_of(kind, 1e-13)});
  LitheCount n = m->beam.space->n_dofs;
  m->shape = calloc((size_t)n, sizeof *m->shape);
  m->w2 = mode_of(&m->beam, number, m->shape);
  m->decay = 0.5 * (damping_mass + damping_stiffness * m->w2);
  m->size = 0;
  for (LitheCount i = 0; i < n; i++) {
    lth_simulation_position(m->beam.sim)[i] = m->beam.rest[i] + m->shape[i];
    m->size = fmax(m->size, fabs(m->shape[i]));
  }
}

static void mode_destroy(Mode *m) {
  free(m->shape);
  beam_destroy(&m->beam);
}

/// Largest coefficient of u - amplitude mode over the largest of the mode.
static double mode_distance(Mode *m, double amplitude) {
  const double *u = lth_simulation_displacement(m->beam.sim);
  double largest = 0;
  for (LitheCount i = 0; i < m->beam.space->n_dofs; i++)
    largest = fmax(largest, fabs(u[i] - amplitude * m->shape[i]));
  return largest / m->size;
}

static void a_mode_moves_as_the_scheme_says_to_rounding(void **state) {
  (void)state;
  for (int kind = 0; kind < N_KINDS; kind++) {
    Mode m;
    mode_create(&m, kind, 2, 0.7, 2e-3, false);
    steps(&m.beam, 40, 0.025);
    // 40 solves to 1e-13
    CHECK_AT_MOST(mode_distance(&m, scalar_scheme(kind, m.w2, m.decay, 0.025, 40)), 1e-10);
    mode_destroy(&m);
  }
}

/// Error at t = 1 of the damped mode, whose motion is known.
static double mode_error(int kind, int n_steps) {
  Mode m;
  mode_create(&m, kind, 2, 0.7, 2e-3, false);
  steps(&m.beam, n_steps, 1.0 / n_steps);
  double w = sqrt(m.w2 - m.decay * m.decay);
  double error = mode_distance(&m, exp(-m.decay) * (cos(w) + m.decay / w * sin(w)));
  mode_destroy(&m);
  return error;
}

static void a_vibrating_bar_shows_the_order(void **state) {
  (void)state;
  for (int kind = 0; kind < N_KINDS; kind++) {
    double coarse = mode_error(kind, 400), fine = mode_error(kind, 800);
    CHECK_NEAR(log2(coarse / fine), order_of[kind], 0.08);
  }
}

static void newmark_keeps_the_energy_of_a_linear_bar(void **state) {
  (void)state;
  Mode m;
  mode_create(&m, LTH_NEWMARK, 2, 0, 0, false);
  LthSimulation *sim = m.beam.sim;
  // further modes, up to those that the step does not resolve
  for (LitheCount i = 0; i < m.beam.space->n_dofs; i++)
    lth_simulation_velocity(sim)[i] = m.size * sin((double)(7 * i));
  lth_simulation_measure(m.beam.ctx, sim);
  LthStepReport first = *lth_simulation_report(sim);
  double energy = first.strain_energy + first.kinetic_energy;
  for (int i = 0; i < 200; i++) {
    steps(&m.beam, 1, 0.05);
    lth_simulation_measure(m.beam.ctx, sim);
    const LthStepReport *r = lth_simulation_report(sim);
    CHECK_NEAR(r->strain_energy + r->kinetic_energy, energy, 1e-10 * energy);
  }
  mode_destroy(&m);
}

static void bdf2_forgets_what_the_step_does_not_resolve(void **state) {
  (void)state;
  static const double left[N_KINDS] = {1e-6, 1e-6, 1e-6, 1};
  for (int kind = 0; kind < N_KINDS; kind++) {
    Mode m;
    mode_create(&m, kind, 40, 0, 0, false);
    assert_true(sqrt(m.w2) * 0.1 > 5);
    steps(&m.beam, 20, 0.1);
    double amplitude = mode_distance(&m, 0);
    CHECK_AT_MOST(amplitude, left[kind] * (1 + 1e-9));
    mode_destroy(&m);
  }
}

static double wave(const void *self, const double x[3], double t) {
  (void)x;
  return *(const double *)self *
         (t - sin(2 * t) / 2); // starts smoothly: rate and second rate are 0
}

/// Tip of a corotated bar under way: large swings, a weak end that moves, strong cells that do.
static void swing(int kind, int n_steps, bool is_strong, double uneven, double tip[3]) {
  static const double far[2] = {0.4, -0.3};
  Beam b;
  BeamDef def = {.cells = {4, 1, 1},
                 .poisson = 0.3,
                 .gravity = {0, 0, -10},
                 .damping_mass = 0.2,
                 .damping_stiffness = 5e-3,
                 .options = options_of(kind, 1e-11)};
  if (is_strong)
    def.clamp_strong = true;
  else
    def.pull_weak = true, def.pull[0] = (LthValue){.eval = wave, .self = far},
    def.pull[2] = (LthValue){.eval = wave, .self = far + 1};
  beam_create(&b, def);
  b.speed = 0.5;
  double h = 0.8 / n_steps;
  for (int i = 0; i < n_steps; i += 2) {
    steps(&b, 1, h * (1 + uneven));
    steps(&b, 1, h * (1 - uneven));
  }
  beam_displacement(&b, is_strong ? (double[]){4, 0.5, 0.5} : (double[]){0, 0.5, 0.5}, tip);
  beam_destroy(&b);
}

/// Order from three step lengths, each half the one before.
static double swing_order(int kind, bool is_strong, double uneven) {
  double tip[3][3];
  for (int i = 0; i < 3; i++) swing(kind, 80 << i, is_strong, uneven, tip[i]);
  return log2(lth_v3_distance(tip[1], tip[0]) / lth_v3_distance(tip[2], tip[1]));
}

static void a_large_swing_shows_the_order(void **state) {
  (void)state;
  CHECK_NEAR(swing_order(LTH_NEWTON_EULER, false, 0), 1, 0.15);
  for (int kind = LTH_BDF2; kind <= LTH_NEWMARK; kind++) {
    CHECK_NEAR(swing_order(kind, false, 0), 2, 0.15);   // a weak end that moves, both dampings
    CHECK_NEAR(swing_order(kind, true, 0), 2, 0.15);    // strong cells that move
    CHECK_NEAR(swing_order(kind, false, 0.2), 2, 0.15); // steps of changing length
  }
}

static void strong_cells_move_as_prescribed(void **state) {
  (void)state;
  for (int kind = 0; kind < N_KINDS; kind++) {
    Beam b;
    beam_create(&b, (BeamDef){.clamp_strong = true, .options = options_of(kind, 1e-10)});
    b.speed = 0.5;
    steps(&b, 20, 0.05);
    const double *u = lth_simulation_displacement(b.sim), *v = lth_simulation_velocity(b.sim);
    for (LitheIndex c = 0; c < b.space->n_cells; c++)
      for (LitheIndex i = b.space->func_off[c]; b.strong[c] && i < b.space->func_off[c + 1]; i++) {
        bool constant = i == b.space->func_off[c];
        CHECK_NEAR(u[3 * i], constant ? 0.5 : 0, 1e-13);
        CHECK_NEAR(v[3 * i], constant ? 0.5 : 0, 1e-12);
      }
    beam_destroy(&b);
  }
}

static void a_falling_body_falls_as_the_scheme_says(void **state) {
  (void)state;
  // g h^2 times: 1 + ... + 20; the same; by recurrence; exactly 20^2 / 2
  double y[2] = {0, 1}, v[2] = {0, 1};
  for (int i = 1; i < 20; i++) {
    double v_next = (4 * v[1] - v[0] + 2) / 3, y_next = (4 * y[1] - y[0] + 2 * v_next) / 3;
    v[0] = v[1], v[1] = v_next, y[0] = y[1], y[1] = y_next;
  }
  const double fall[N_KINDS] = {210, 210, y[1], 200}, speed[N_KINDS] = {20, 20, v[1], 20};
  for (int kind = 0; kind < N_KINDS; kind++) {
    Beam b;
    double u[3];
    beam_create(&b, (BeamDef){.gravity = {0, 0, -9.81},
                              .damping_stiffness = 0.01,
                              .options = options_of(kind, 1e-10)});
    steps(&b, 20, 0.01);
    beam_displacement(&b, (double[]){0.5, 0.5, 0.5}, u);
    CHECK_NEAR(u[2], -9.81 * 1e-4 * fall[kind], 1e-9);
    lth_simulation_measure(b.ctx, b.sim);
    CHECK_NEAR(lth_simulation_report(b.sim)->momentum[2], -9.81 * 4 * 0.01 * speed[kind], 1e-11);
    beam_destroy(&b);
  }
}

static void a_kept_state_goes_on_with_the_same_bits(void **state) {
  (void)state;
  for (int kind = 0; kind < N_KINDS; kind++)
    for (int linear = LTH_LINEAR_AUTO; linear < LTH_LINEAR_COUNT; linear++) {
      BeamDef def = {.cells = {6, 2, 2},
                     .poisson = 0.3,
                     .gravity = {0, 0, -5},
                     .clamp_weak = true,
                     .damping_stiffness = 1e-3,
                     .options = options_of(kind, 1e-8)};
      def.options.linear = (LthLinearChoice)linear;
      Beam a, b;
      LthArchive out = {0}, in;
      beam_create(&a, def);
      beam_create(&b, def);
      steps(&a, 13, 0.03);
      lth_archive_begin(&out, a.ctx);
      lth_simulation_archive(a.sim, &out);
      CHECK_OK(a.ctx, out.status);
      steps(&a, 9, 0.03);
      lth_archive_open(&in, b.ctx, out.data, out.size);
      lth_simulation_archive(b.sim, &in);
      CHECK_OK(b.ctx, in.status);
      assert_int_equal(in.at, out.size);
      steps(&b, 9, 0.03);
      size_t bytes = sizeof(double) * (size_t)a.space->n_dofs;
      assert_memory_equal(lth_simulation_position(a.sim), lth_simulation_position(b.sim), bytes);
      assert_memory_equal(lth_simulation_velocity(a.sim), lth_simulation_velocity(b.sim), bytes);
      assert_int_equal(lth_simulation_report(a.sim)->linear_total,
                       lth_simulation_report(b.sim)->linear_total);
      lth_archive_free(a.ctx, &out);
      beam_destroy(&a);
      beam_destroy(&b);
    }
}

static void same_bits_on_any_number_of_threads(void **state) {
  (void)state;
  for (int kind = LTH_NEWTON_EULER; kind < N_KINDS; kind++) {
    BeamDef def = {.cells = {12, 4, 4},
                   .poisson = 0.3,
                   .gravity = {0, 0, -5},
                   .clamp_weak = true,
                   .options = options_of(kind, 1e-8)};
    Beam one, three;
    def.threads = 1;
    beam_create(&one, def);
    def.threads = 3;
    beam_create(&three, def);
    steps(&one, 3, 0.05);
    steps(&three, 3, 0.05);
    assert_memory_equal(lth_simulation_position(one.sim), lth_simulation_position(three.sim),
                        sizeof(double) * (size_t)one.space->n_dofs);
    beam_destroy(&one);
    beam_destroy(&three);
  }
}

static void steps_after_the_second_allocate_nothing(void **state) {
  (void)state;
  for (int kind = 0; kind < N_KINDS; kind++) {
    Beam b;
    LthStepOptions options = options_of(kind, 1e-8);
    options.linear = LTH_LINEAR_PCG;
    beam_create(&b, (BeamDef){.clamp_weak = true, .gravity = {0, 0, -5}, .options = options});
    steps(&b, 2, 0.01);
    LitheCount before = lth_alloc_count(b.ctx);
    steps(&b, 10, 0.01);
    lth_simulation_measure(b.ctx, b.sim);
    assert_int_equal(lth_alloc_count(b.ctx), before);
    beam_destroy(&b);
  }
}

/// Steps whose iteration does not end are those of implicit Euler, to the bit.
static void steps_without_an_end_are_taken_with_the_rotations_of_their_start(void **state) {
  (void)state;
  const int kinds[] = {LTH_NEWTON_EULER, LTH_BDF2, LTH_NEWMARK};
  for (int k = 0; k < 3; k++) {
    LthStepOptions options = options_of(kinds[k], 1e-10),
                   plain = options_of(LTH_IMPLICIT_EULER, 1e-10);
    options.newton_iterations = 1;
    Beam b, euler;
    beam_create(&b, (BeamDef){.clamp_weak = true, .gravity = {0, 0, -20}, .options = options});
    beam_create(&euler, (BeamDef){.clamp_weak = true, .gravity = {0, 0, -20}, .options = plain});
    steps(&b, 5, 0.1);
    steps(&euler, 5, 0.1);
    const LthStepReport *r = lth_simulation_report(b.sim);
    assert_true(r->converged);
    assert_int_equal(r->frozen_steps, 5);
    assert_int_equal(lithe_ctx_warning_count(b.ctx), 1);
    assert_memory_equal(lth_simulation_position(b.sim), lth_simulation_position(euler.sim),
                        sizeof(double) * (size_t)b.system->n);
    beam_destroy(&b);
    beam_destroy(&euler);
  }
}

/// Largest relative change of total energy and of angular momentum of a bar that spins for 2 s.
static void spin(int kind, int per_second, double *energy, double *angular) {
  Beam b;
  beam_create(&b, (BeamDef){.poisson = 0.3, .options = options_of(kind, 1e-9)});
  beam_set_velocity(&b, (double[]){1, 2, 3}, (double[]){0.3, 1, 2});
  lth_simulation_measure(b.ctx, b.sim);
  LthStepReport first = *lth_simulation_report(b.sim);
  *energy = *angular = 0;
  for (int i = 0; i < 2 * per_second; i++) {
    double lost[3];
    steps(&b, 1, 1.0 / per_second);
    lth_simulation_measure(b.ctx, b.sim);
    const LthStepReport *r = lth_simulation_report(b.sim);
    lth_v3_sub(r->angular_momentum, first.angular_momentum, lost);
    *angular = fmax(*angular, lth_v3_norm(lost) / lth_v3_norm(first.angular_momentum));
    *energy =
        fmax(*energy, fabs((r->kinetic_energy + r->strain_energy) / first.kinetic_energy - 1));
    lth_v3_sub(r->momentum, first.momentum, lost);
    CHECK_AT_MOST(lth_v3_norm(lost) / lth_v3_norm(first.momentum), 1e-13);
  }
  beam_destroy(&b);
}

static void a_spinning_bar_keeps_its_momenta_to_rounding(void **state) {
  (void)state;
  // measured 6.4e-3, 6.2e-3, 6.8e-3, 1.7e-4 of the kinetic energy
  static const double energy_kept[N_KINDS] = {8e-3, 8e-3, 8e-3, 2.5e-4};
  for (int kind = 0; kind < N_KINDS; kind++) {
    double energy, angular;
    spin(kind, 30, &energy, &angular);
    CHECK_AT_MOST(angular, 1e-12);
    CHECK_AT_MOST(energy, energy_kept[kind]);
  }
}

/// Place of one end of a soft bar that spins and stretches, free of all constraints.
static void free_end(int kind, int n_steps, double place[3]) {
  Beam b;
  beam_create(&b, (BeamDef){.poisson = 0.3, .young = 200, .options = options_of(kind, 1e-11)});
  beam_set_velocity(&b, (double[3]){0}, (double[]){0.3, 1, 2});
  steps(&b, n_steps, 0.2 / n_steps);
  beam_displacement(&b, (double[]){4, 0.5, 0.5}, place);
  beam_destroy(&b);
}

static void turns_that_restore_angular_momentum_keep_the_order(void **state) {
  (void)state;
  for (int kind = LTH_BDF2; kind < N_KINDS; kind++) {
    double place[3][3];
    for (int i = 0; i < 3; i++) free_end(kind, 80 << i, place[i]);
    double order = log2(lth_v3_distance(place[1], place[0]) / lth_v3_distance(place[2], place[1]));
    CHECK_NEAR(order, order_of[kind], 0.15);
  }
}

static void mass_damping_damps_a_free_mode_and_spares_its_flight(void **state) {
  (void)state;
  const double a = 0.8, h = 0.025;
  for (int kind = 0; kind < N_KINDS; kind++) {
    Mode m;
    mode_create(&m, kind, 6, a, 0, true);
    Beam *b = &m.beam;
    LitheCount n = b->space->n_dofs;
    double *flight = calloc((size_t)n, sizeof *flight), largest = 0;
    beam_set_velocity(b, (double[]){3, -1, 2}, (double[3]){0});
    memcpy(flight, lth_simulation_velocity(b->sim), sizeof *flight * (size_t)n);
    lth_simulation_measure(b->ctx, b->sim);
    LthStepReport first = *lth_simulation_report(b->sim);
    steps(b, 40, h);
    double amplitude = scalar_scheme(kind, m.w2, 0.5 * a, h, 40);
    const double *u = lth_simulation_displacement(b->sim);
    for (LitheCount i = 0; i < n; i++)
      largest = fmax(largest, fabs(u[i] - 40 * h * flight[i] - amplitude * m.shape[i]));
    CHECK_AT_MOST(largest / m.size, 1e-9);
    lth_simulation_measure(b->ctx, b->sim);
    const LthStepReport *r = lth_simulation_report(b->sim);
    CHECK_AT_MOST(lth_v3_distance(r->momentum, first.momentum) / lth_v3_norm(first.momentum),
                  1e-13);
    free(flight);
    mode_destroy(&m);
  }
}

/// Kinetic energy of what is no rigid motion.
static double vibration(Beam *b, double damping_mass) {
  LthSimulation *s = b->sim;
  double *y = calloc((size_t)s->n, sizeof *y);
  lth_rigid_prepare(s, s->x);
  lth_system_apply_mass(s->system, s->v, y);
  lth_rigid_spare(s, -1 / damping_mass, s->v, y);
  double energy = 0.5 * lth_dot(1, s->n, s->v, y);
  free(y);
  return energy;
}

static void mass_damping_leaves_a_falling_spinning_body_its_momenta(void **state) {
  (void)state;
  const double a = 2, g = 9.81, t = 2.5;
  Beam b;
  beam_create(&b, (BeamDef){.poisson = 0.3,
                            .gravity = {0, 0, -g},
                            .damping_mass = a,
                            .options = options_of(LTH_NEWMARK, 1e-10)});
  // about the axis of largest inertia, with a kick: what stays at the end is a steady spin
  beam_set_velocity(&b, (double[]){1, 2, 3}, (double[]){0, 0, 1});
  for (LitheCount i = 0; i < b.space->n_dofs; i++)
    lth_simulation_velocity(b.sim)[i] += 0.2 * sin((double)(7 * i));
  lth_simulation_measure(b.ctx, b.sim);
  LthStepReport first = *lth_simulation_report(b.sim);
  steps(&b, 1, 0.01);
  double start = vibration(&b, a);
  steps(&b, (int)(t / 0.01) - 1, 0.01);
  lth_simulation_measure(b.ctx, b.sim);
  const LthStepReport *r = lth_simulation_report(b.sim);
  double m = 4, P = lth_v3_norm(first.momentum), L = lth_v3_norm(first.angular_momentum);
  for (int k = 0; k < 3; k++)
    CHECK_NEAR(r->momentum[k], first.momentum[k] - (k == 2 ? m * g * t : 0),
               1e-12 * (P + m * g * t));
  // L(t) = L(0) + integral of c(t) x m g, c(t) = c(0) + P t / m + g t^2 / 2
  double c[3] = {2 + first.momentum[0] / m * t / 2, 0.5 + first.momentum[1] / m * t / 2, 0};
  double want[3] = {first.angular_momentum[0] - c[1] * m * g * t,
                    first.angular_momentum[1] + c[0] * m * g * t, first.angular_momentum[2]};
  for (int k = 0; k < 3; k++)
    CHECK_NEAR(r->angular_momentum[k], want[k], 1e-11 * (L + m * g * t * 5));
  // a mode loses its energy as exp(-a t); spin and stretch couple modes, so this holds roughly
  double left = vibration(&b, a) / start;
  CHECK_AT_MOST(left, 4 * exp(-a * t));
  CHECK_AT_LEAST(left, 0.1 * exp(-a * t));
  beam_destroy(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mode_moves_as_the_scheme_says_to_rounding),
      cmocka_unit_test(a_vibrating_bar_shows_the_order),
      cmocka_unit_test(newmark_keeps_the_energy_of_a_linear_bar),
      cmocka_unit_test(bdf2_forgets_what_the_step_does_not_resolve),
      cmocka_unit_test(a_large_swing_shows_the_order),
      cmocka_unit_test(strong_cells_move_as_prescribed),
      cmocka_unit_test(a_falling_body_falls_as_the_scheme_says),
      cmocka_unit_test(a_kept_state_goes_on_with_the_same_bits),
      cmocka_unit_test(same_bits_on_any_number_of_threads),
      cmocka_unit_test(steps_after_the_second_allocate_nothing),
      cmocka_unit_test(steps_without_an_end_are_taken_with_the_rotations_of_their_start),
      cmocka_unit_test(a_spinning_bar_keeps_its_momenta_to_rounding),
      cmocka_unit_test(turns_that_restore_angular_momentum_keep_the_order),
      cmocka_unit_test(mass_damping_damps_a_free_mode_and_spares_its_flight),
      cmocka_unit_test(mass_damping_leaves_a_falling_spinning_body_its_momenta),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
