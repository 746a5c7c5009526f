/// Bodies that push each other, and the pieces of one: whatever they begin with, contact makes no energy (docs/theory/contact.md, section 8).
#include "base/tensor.h"
#include "random_text.h"
#include "scene/world.h"
#include "scene_text.h"
#include "system/system.h"

#define STEP 0.01
#define SIDE 0.2 ///< of the blocks [m]

typedef struct Run {
  Reading reading;
  LitheCtx *ctx;
  LthWorld *world;
} Run;

static Text text;

static void add_block(const char *name, double low, double shift, bool turned, const char *more) {
  ADD(&text,
      "  - name: %s\n    shape: {box: {min: [%g, %g, %g], max: [%g, %g, %g]}}\n"
      "    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}\n"
      "    method: {kind: dg, cells: 2, degree: 1%s}\n%s%s",
      name, shift, low, -shift, shift + SIDE, low + SIDE, SIDE - shift,
      turned ? "" : ", mesh: hexahedra",
      turned ? "    place: {rotate: {axis: [1, 0.3, 0.7], angle: 35 deg}}\n" : "", more);
}

static void begin_text(void) {
  text.n = 0;
  ADD(&text, "lithe: 1\nbodies:\n");
}

/// The lowest block's bottom.
#define HELD                                                                                       \
  "    constraints: [{where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: [0, "  \
  "0, 0]}]\n"

static Run begin(const char *integrator, double gravity, double friction) {
  double times[2];
  ADD(&text,
      "gravity: [0, %g, 0]\ncontact: {friction: %g}\n"
      "time: {kind: dynamic, duration: 1, step: %g, integrator: %s}\n"
      "solver: {linear: cholesky, tolerance: 1e-10}\n",
      -gravity, friction, STEP, integrator);
  Run run = {.reading = read_good(text.at)};
  run.ctx = run.reading.ctx;
  lth_set_threads(run.ctx, 1);
  CHECK_OK(run.ctx, lth_world_create(run.ctx, run.reading.scene, times, &run.world));
  lth_simulation_measure(run.ctx, run.world->sim);
  return run;
}

static void end(Run *run) {
  lth_world_destroy(run->ctx, &run->world);
  end_reading(&run->reading);
}

/// Energy of all kinds but what loads have worked [J].
static double energy(const Run *run) {
  const LthStepReport *r = lth_simulation_report(run->world->sim);
  return r->kinetic_energy + r->strain_energy + r->contact_energy - r->work;
}

/// Steps in none of which there is more energy than before, what springs have lost and may give others among it, but for `part` of
/// `size`: what linear solves leave. Returns the largest penetration.
static double take_steps(Run *run, int n, double size, double part) {
  const LthStepReport *r = lth_simulation_report(run->world->sim);
  double deepest = 0;
  for (int i = 0; i < n; i++) {
    const double before = energy(run) + r->contact_spare;
    CHECK_OK(run->ctx, lth_simulation_step(run->ctx, run->world->sim, STEP));
    lth_simulation_measure(run->ctx, run->world->sim);
    CHECK_AT_MOST(energy(run) + r->contact_spare - before, part * size);
    deepest = fmax(deepest, r->penetration);
  }
  return deepest;
}

static const char *const integrators[] = {"implicit-euler", "newmark", "newton-euler", "bdf2"};

/// A tenth of each is in the other when the run begins: springs as deep as that would make 7 J in the first step.
static void blocks_that_begin_inside_each_other_do_not_fly_apart(void **state) {
  (void)state;
  for (int i = 0; i < 4; i++) {
    begin_text();
    add_block("lower", 0, 0, false, "");
    add_block("upper", 0.9 * SIDE, 0.01, false, "");
    Run run = begin(integrators[i], 0, 0.3);
    CHECK_NEAR(take_steps(&run, 20, 1, 1e-20), 0.1 * SIDE, 1e-12);
    CHECK_AT_MOST(energy(&run), 1e-20);
    assert_int_equal(lithe_ctx_warning_count(run.ctx), 1);
    assert_non_null(strstr(lithe_ctx_warning(run.ctx, 0),
                           "lower and upper begin up to 0.02 m inside each other"));
    end(&run);
  }
}

/// ... nor do they sink into each other where something presses them: the weight goes in by what it would from the outside.
static void what_begins_inside_carries_what_stands_on_it(void **state) {
  (void)state;
  for (int i = 0; i < 2; i++) {
    begin_text();
    add_block("lower", 0, 0, false, HELD);
    add_block("upper", 0.9 * SIDE, 0.01, false, "");
    Run run = begin(integrators[i], 9.81, 0.3);
    CHECK_AT_MOST(take_steps(&run, 100, 9.81 * 8 * SIDE, 1e-9), 0.15 * SIDE);
    end(&run);
  }
}

/// Height of the centre of the upper block.
static double height(const Run *run) {
  const LthBody *body = run->world->bodies[1];
  const double *x = lth_simulation_position(run->world->sim) + run->world->system->dof_first[1];
  double sum = 0;
  LitheIndex n = body->space->n_cells;
  for (LitheIndex c = 0; c < n; c++) sum += x[3 * body->space->func_off[c] + 1] / n;
  return sum;
}

/// Rules of two steps keep another energy (docs/theory/stepping.md): of those the height alone is looked at.
static void what_is_dropped_bounces_no_higher_than_it_fell(void **state) {
  (void)state;
  const double fall = 0.1;
  for (int i = 0; i < 4; i++)
    for (int turned = 0; turned < 2; turned++) {
      begin_text();
      add_block("lower", 0, 0, false, HELD);
      add_block("upper", SIDE + fall, 0.01, turned, "");
      Run run = begin(integrators[i], 9.81, 0.3);
      const double start = height(&run), size = 9.81 * 8 * fall;
      double highest = 0;
      bool touched = false;
      for (int k = 0; k < 60; k++) {
        double depth = take_steps(&run, 1, size, i < 3 ? 1e-9 : INFINITY);
        touched = touched || depth > 0;
        if (touched) highest = fmax(highest, height(&run));
      }
      assert_true(touched);
      CHECK_AT_MOST(highest, start);
      end(&run);
    }
}

static void a_stack_at_rest_stays_at_rest(void **state) {
  (void)state;
  begin_text();
  add_block("lower", 0, 0, false, HELD);
  add_block("middle", SIDE, 0.01, false, "");
  add_block("upper", 2 * SIDE, 0.02, false, "");
  Run run = begin("implicit-euler", 9.81, 0.3);
  take_steps(&run, 200, 9.81 * 8 * SIDE, 1e-9);
  const LthStepReport *r = lth_simulation_report(run.world->sim);
  const double settled = height(&run);
  CHECK_AT_MOST(r->kinetic_energy, 1e-6 * 9.81 * 8 * SIDE);
  take_steps(&run, 100, 9.81 * 8 * SIDE, 1e-9);
  CHECK_NEAR(height(&run), settled, 1e-4 * SIDE);
  end(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blocks_that_begin_inside_each_other_do_not_fly_apart),
      cmocka_unit_test(what_begins_inside_carries_what_stands_on_it),
      cmocka_unit_test(what_is_dropped_bounces_no_higher_than_it_fell),
      cmocka_unit_test(a_stack_at_rest_stays_at_rest),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
