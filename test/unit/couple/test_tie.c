/// Ties: exact on linear fields across grids that do not match, the whole where they do, order, contrast, springs.
#include "tied_pair.h"

#include "step/simulation.h"

/// What one of the two halves of a beam along x is made of.
typedef struct Half {
  TestMesh kind;
  LitheIndex cells[3];
  int degree;
  LthFlux flux;
  double young, poisson;
} Half;

#define HEX(x, y, z) .kind = TEST_HEXAHEDRA, .cells = {x, y, z}
#define TET(x, y, z) .kind = TEST_TETRAHEDRA, .cells = {x, y, z}

static TestBody make_half(Half h, double from, double to) {
  LthGrid grid = {{from, -0.4, -0.4}, {to, 0.4, 0.4}, {h.cells[0], h.cells[1], h.cells[2]}};
  TestBody b = test_body(h.kind, grid, h.degree);
  test_set_material(&b, h.young > 0 ? h.young : 1000, h.poisson != 0 ? h.poisson : 0.3);
  b.def.flux = h.flux;
  return b;
}

static TiedPair make_pair(Half left, Half right) {
  return (TiedPair){.body = {make_half(left, -0.4, 0), make_half(right, 0, 0.4)}};
}

/// u = G x, with its normal derivative changed at x > 0 by `jump` (continuous at x = 0).
typedef struct Linear {
  double G[9], jump[3];
} Linear;
typedef struct LinearValue {
  const Linear *field;
  int row;
} LinearValue;

static double linear_value(const void *self, const double x[3], double t) {
  const LinearValue *v = self;
  double sum = x[0] > 0 ? v->field->jump[v->row] * x[0] : 0;
  (void)t;
  for (int a = 0; a < 3; a++) sum += v->field->G[3 * v->row + a] * x[a];
  return sum;
}

/// Hold both on the outside at a linear field, tie, solve; the largest error inside.
static double patch_error(TiedPair *p, const Linear *field) {
  LinearValue value[3];
  double worst = 0;
  for (int a = 0; a < 3; a++) value[a] = (LinearValue){field, a};
  for (int s = 0; s < 2; s++) {
    LthWeakConstraint *hold = test_hold(&p->body[s], test_off_joint);
    for (int a = 0; a < 3; a++) hold->value[a] = (LthValue){0, linear_value, &value[a]};
  }
  CHECK_OK(p->ctx, tied_pair_build(p, test_at_joint));
  CHECK_NEAR(p->tie->face_area, 0.64, 1e-14);
  assert_int_equal(p->tie->n_springs, 0);
  tied_pair_solve(p);
  for (int s = 0; s < 2; s++)
    for (LitheIndex c = 0; c < p->body[s].mesh->n_cells; c++) {
      const double *x = p->body[s].mesh->cell_centroid + 3 * c;
      double got[3];
      lth_dg_sample(p->body[s].space, c, p->body[s].x, x, got);
      for (int a = 0; a < 3; a++)
        worst = fmax(worst, fabs(got[a] - x[a] - linear_value(&value[a], x, 0)));
    }
  return worst;
}

static const Linear shear = {.G = {0.1, 0.03, -0.05, 0.02, -0.07, 0.04, 0.06, -0.01, 0.08}};

static void linear_fields_pass_grids_that_do_not_match(void **state) {
  (void)state;
  const Half halves[][2] = {
      {{HEX(2, 2, 3), .degree = 1}, {HEX(1, 3, 2), .degree = 1}},
      {{HEX(2, 3, 2), .degree = 1}, {TET(1, 2, 1), .degree = 2}},
      {{TET(1, 2, 2), .degree = MIXED}, {TET(2, 3, 3), .degree = 1, .poisson = 0.3}}};
  for (size_t i = 0; i < sizeof halves / sizeof *halves; i++) {
    TiedPair p = make_pair(halves[i][0], halves[i][1]);
    CHECK_AT_MOST(patch_error(&p, &shear), 1e-11);
    tied_pair_free(&p);
  }
}

/// The traction of both sides agrees for du/dx = (a, b, c) / stiffness beside equal Poisson's ratios.
static void stiffness_may_jump_by_a_million(void **state) {
  (void)state;
  for (int k = 0; k < 2; k++) {
    double contrast = k ? 1e6 : 1e-6;
    Linear field = {.G = {0.1, 0, 0, 0.04, 0, 0, -0.03, 0, 0}};
    for (int a = 0; a < 3; a++) field.jump[a] = field.G[3 * a] * (1 / contrast - 1);
    TiedPair p =
        make_pair((Half){HEX(2, 2, 2), .degree = 1},
                  (Half){HEX(2, 3, 3), .degree = 2, .young = 1000 * contrast, .poisson = 0.3});
    double error = patch_error(&p, &field);
    CHECK_AT_MOST(error, k ? 1e-9 : 1e-9 * 1e6); // of displacements of 0.1 and of 1e5
    tied_pair_free(&p);
  }
}

/// A beam in two parts of one grid is the whole beam: the tie's faces are the inner ones it lacks.
static void tied_halves_of_one_grid_are_the_whole(void **state) {
  (void)state;
  for (int flux = 0; flux < 2; flux++) {
    Half part = {HEX(2, 2, 3), .degree = 2, .flux = flux ? LTH_FLUX_BZ : LTH_FLUX_IP};
    TiedPair p = make_pair(part, part);
    TestBody whole =
        test_body(TEST_HEXAHEDRA, (LthGrid){{-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, {4, 2, 3}}, 2);
    whole.def.flux = part.flux;
    test_hold(&p.body[0], test_facing_down_x);
    test_hold(&whole, test_facing_down_x);
    test_assemble(&whole, 0);
    double weight[3] = {0, 1, -3};
    for (int s = 0; s < 2; s++) test_add_weight(&p.body[s], weight);
    test_add_weight(&whole, weight);
    CHECK_OK(p.ctx, tied_pair_build(&p, test_at_joint));
    assert_int_equal(p.tie->n_faces, 6);
    tied_pair_solve(&p);
    test_solve_sparse(&whole, whole.K, whole.f0);
    double compliance = test_compliance(&whole), sum = 0;
    for (int s = 0; s < 2; s++) sum += test_compliance(&p.body[s]);
    CHECK_NEAR(sum, compliance, 1e-10 * compliance);
    tied_pair_free(&p);
    test_body_free(&whole);
  }
}

/// Errors of both halves against two materials that meet at x = 0.
static TestErrors solution_errors(LitheIndex n, int degree, double contrast) {
  TiedPair p = make_pair((Half){HEX(n, n, n), .degree = degree},
                         (Half){TET(n / 2, n - 1, n), .degree = degree});
  TestSolution s = {.poisson = 0.3, .contrast = contrast};
  TestComponent component[9];
  lth_lame(1000, s.poisson, &s.lambda, &s.mu);
  for (int i = 0; i < 9; i++) component[i] = (TestComponent){&s, i / 3, i % 3};
  for (int k = 0; k < 2; k++) {
    TestBody *b = &p.body[k];
    for (LitheIndex c = 0; c < b->space->n_cells; c++)
      b->young[c] = 1000 * test_stiffness(&s, b->mesh->cell_centroid + 3 * c);
    LthWeakConstraint *hold = test_hold(b, test_off_joint);
    for (int a = 0; a < 3; a++)
      hold->value[a] = (LthValue){0, test_solution_value, &component[3 * a]};
    LthLoad volume = {.kind = LTH_LOAD_BODY_FORCE};
    for (int a = 0; a < 3; a++)
      volume.value[a] = (LthValue){0, test_solution_force, &component[3 * a]};
    CHECK_OK(b->ctx, lth_dg_add_load(b->ctx, b->space, &volume, 0, NULL, b->f));
  }
  CHECK_OK(p.ctx, tied_pair_build(&p, test_at_joint));
  tied_pair_solve(&p);
  TestErrors left = test_errors(&p.body[0], &s), right = test_errors(&p.body[1], &s);
  tied_pair_free(&p);
  return (TestErrors){hypot(left.l2, right.l2), hypot(left.h1, right.h1)};
}

static void the_order_is_kept_across_a_tie(void **state) {
  (void)state;
  for (int degree = 1; degree < 3; degree++)
    for (int k = 0; k < 2; k++) {
      LitheIndex n = degree == 1 ? 4 : 2;
      TestErrors coarse = solution_errors(n, degree, k ? 1e3 : 1),
                 fine = solution_errors(2 * n, degree, k ? 1e3 : 1);
      double l2 = log2(coarse.l2 / fine.l2), h1 = log2(coarse.h1 / fine.h1);
      print_message("degree %d, contrast %g: orders %.2f, %.2f\n", degree, k ? 1e3 : 1, l2, h1);
      CHECK_AT_LEAST(l2, degree + 1 - 0.25);
      CHECK_AT_LEAST(h1, degree - 0.15);
    }
}

/// A tied pair free in space, turning: momenta stay, and the joint does not open.
static void a_turning_pair_keeps_its_momenta(void **state) {
  (void)state;
  TiedPair p = make_pair((Half){HEX(1, 2, 2), .degree = 1, .young = 2e4},
                         (Half){HEX(1, 3, 1), .degree = 1, .young = 1e4});
  for (int s = 0; s < 2; s++) p.body[s].def.warped = true;
  CHECK_OK(p.ctx, tied_pair_build(&p, test_at_joint));
  tied_pair_system(&p);
  LthSimulation *sim = NULL;
  LthStepOptions options = lth_step_options_default();
  options.tolerance = 1e-12;
  CHECK_OK(p.ctx, lth_simulation_create(p.ctx, p.system, &options, &sim));
  double *x = lth_simulation_position(sim), *v = lth_simulation_velocity(sim);
  for (LitheCount i = 0; i < p.system->n / 3; i++) { // v = w x x + (1, 0, 0)
    double w[3] = {0, 0, 2}, one[3] = {p.system->one[i], 0, 0};
    lth_v3_cross(w, x + 3 * i, v + 3 * i);
    lth_v3_add(v + 3 * i, one, v + 3 * i);
  }
  lth_simulation_measure(p.ctx, sim);
  LthStepReport before = *lth_simulation_report(sim);
  for (int k = 0; k < 100; k++) CHECK_OK(p.ctx, lth_simulation_step(p.ctx, sim, 0.005));
  lth_simulation_measure(p.ctx, sim);
  const LthStepReport *after = lth_simulation_report(sim);
  for (int a = 0; a < 3; a++)
    CHECK_NEAR(after->momentum[a], before.momentum[a], 1e-12 * fabs(before.momentum[0]));
  CHECK_NEAR(after->angular_momentum[2], before.angular_momentum[2],
             5e-3 * fabs(before.angular_momentum[2])); // of order one in the step, as in one body
  CHECK_AT_MOST(after->kinetic_energy + after->strain_energy,
                1.001 * before.kinetic_energy); // linearly implicit steps
  CHECK_AT_LEAST(after->kinetic_energy, 0.95 * before.kinetic_energy);
  for (int corner = 0; corner < 4; corner++) { // of the joint, seen from both sides
    double at[3] = {0, corner % 2 ? 0.39 : -0.39, corner / 2 ? 0.39 : -0.39}, seen[2][3];
    for (int s = 0; s < 2; s++) {
      LitheIndex cell = -1;
      const LthMesh *m = p.body[s].mesh;
      for (LitheIndex c = 0; c < m->n_cells; c++) {
        const double *box = m->cell_box + 6 * c;
        if (at[1] >= box[1] && at[1] <= box[4] && at[2] >= box[2] && at[2] <= box[5]) cell = c;
      }
      lth_disc_sample(p.disc[s], cell, x + p.system->dof_first[s], at, seen[s]);
    }
    CHECK_AT_MOST(lth_v3_distance(seen[0], seen[1]), 1e-3);
  }
  lth_simulation_destroy(p.ctx, &sim);
  tied_pair_free(&p);
}

/// The same halves a twentieth of a cell apart: springs, and nearly the same deflection.
static void springs_hold_across_a_gap(void **state) {
  (void)state;
  double sum[2] = {0, 0};
  for (int gap = 0; gap < 2; gap++) {
    TiedPair p = {
        .body = {make_half((Half){HEX(2, 4, 4), .degree = 2}, -0.4, 0),
                 make_half((Half){HEX(2, 3, 3), .degree = 2}, gap * 1e-5, 0.4 + gap * 1e-5)}};
    double weight[3] = {0, 1, -3};
    test_hold(&p.body[0], test_facing_down_x);
    for (int s = 0; s < 2; s++) test_add_weight(&p.body[s], weight);
    CHECK_OK(p.ctx, tied_pair_build(&p, test_at_joint));
    if (gap) {
      assert_int_equal(p.tie->n_faces, 0);
      assert_true(p.tie->n_springs > 100);
      CHECK_NEAR(p.tie->spring_area, 0.64, 1e-12);
    }
    tied_pair_solve(&p);
    for (int s = 0; s < 2; s++) sum[gap] += test_compliance(&p.body[s]);

    // a rigid motion stretches no spring
    double R[9], *x = lth_alloc(p.ctx, p.system->n, sizeof *x);
    test_rotation(0.7, R);
    for (int s = 0; s < 2; s++)
      test_affine(&p.body[s], R, (double[3]){0.3, 2, 1}, p.body[s].x0, x + p.system->dof_first[s]);
    if (gap) {
      double turned = p.tie->coupling[0].energy(p.tie->coupling[0].self, 0, x);
      CHECK_AT_MOST(fabs(turned), 1e-12 * 1000 * 0.64 * 50 / 0.2);
    }
    lth_free(p.ctx, x);
    tied_pair_free(&p);
  }
  CHECK_NEAR(sum[1], sum[0], 0.01 * sum[0]);
}

static void what_is_apart_is_refused_with_the_gap(void **state) {
  (void)state;
  TiedPair p = {.body = {make_half((Half){HEX(2, 2, 2), .degree = 1}, -0.4, 0),
                         make_half((Half){HEX(2, 2, 2), .degree = 1}, 0.3, 0.7)}};
  assert_int_equal(tied_pair_build(&p, test_everywhere), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(p.ctx), "tie.0: left and right"));
  assert_non_null(
      strstr(lithe_ctx_message(p.ctx), "0.3")); // 0.3 and what the rule's points lie off
  tied_pair_free(&p);
}

/// A plate with a hole and an L of unit cubes: the tie covers what they have in common, for grids that cut both into
/// parts that are not convex.
static void common_parts_of_faces_that_are_not_convex(void **state) {
  (void)state;
  const char *const full[2] = {"#####..##..#####", "##########..##.."};
  const LitheIndex cells[] = {1, 2, 3};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      TiedPair p = {.A = NULL};
      for (int s = 0; s < 2; s++) {
        LitheCtx *ctx = test_ctx();
        char taken[16];
        for (int c = 0; c < 16; c++) taken[c] = full[s][c] == '#';
        LthSurface *surface = solid_cubes(ctx, taken, 1, 4, 4);
        solid_move(surface, NULL, 1, (double[3]){s - 1.0, 0, 0});
        LitheIndex n = cells[s ? j : i];
        LthGrid grid = {{s - 1.0, 0, 0}, {s, 4, 4}, {1, n, n}};
        LthMesh *mesh = NULL;
        CHECK_OK(ctx, lth_mesh_slice(ctx, surface, &grid, 0, &mesh));
        solid_free(ctx, &surface);
        p.body[s] = test_body_of(ctx, mesh, 1);
      }
      CHECK_OK(p.ctx, tied_pair_build(&p, test_at_joint));
      CHECK_NEAR(p.tie->face_area, 16 - 4 - 4 + 1, 1e-12);
      tied_pair_free(&p);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_fields_pass_grids_that_do_not_match),
      cmocka_unit_test(stiffness_may_jump_by_a_million),
      cmocka_unit_test(tied_halves_of_one_grid_are_the_whole),
      cmocka_unit_test(the_order_is_kept_across_a_tie),
      cmocka_unit_test(a_turning_pair_keeps_its_momenta),
      cmocka_unit_test(springs_hold_across_a_gap),
      cmocka_unit_test(what_is_apart_is_refused_with_the_gap),
      cmocka_unit_test(common_parts_of_faces_that_are_not_convex),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
