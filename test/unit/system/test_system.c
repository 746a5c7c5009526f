/// Several bodies as one system: its matrix is theirs, couplings and held unknowns are where they belong.
#include "beam.h"

/// Two beams of one context each see their own; the pair is one system on the first one's context.
typedef struct Pair {
  Beam a, b;
  LthSystem *system;
} Pair;

static void pair_create(Pair *p, const LthCoupling *coupling) {
  beam_create(&p->a, (BeamDef){.cells = {2, 1, 1}, .clamp_strong = true, .poisson = 0.3});
  beam_create(&p->b, (BeamDef){.cells = {3, 1, 2}, .degree = 2, .density = 2, .clamp_weak = true});
  LthSystemBody bodies[2] = {p->a.system->bodies[0], p->b.system->bodies[0]};
  bodies[0].damping_mass = 3;
  LthSystemDef def = {.bodies = bodies,
                      .n_bodies = 2,
                      .couplings = coupling,
                      .n_couplings = coupling ? 1 : 0,
                      .gravity = {0, 0, -1}};
  CHECK_OK(p->a.ctx, lth_system_create(p->a.ctx, &def, &p->system));
}

static void pair_destroy(Pair *p) {
  lth_system_destroy(p->a.ctx, &p->system);
  beam_destroy(&p->a);
  beam_destroy(&p->b);
}

/// Fail unless the rows [first, ...) of A hold exactly the blocks of `own`.
static void check_rows(const LthBlockMatrix *A, LitheIndex first, const LthBlockMatrix *own) {
  for (LitheIndex i = 0; i < own->n_rows; i++)
    for (LitheCount e = own->block_off[i]; e < own->block_off[i + 1]; e++) {
      LitheCount at = lth_block_matrix_find(A, first + i, first + own->block_col[e]);
      assert_true(at >= 0);
      assert_memory_equal(A->values + A->value_off[at], own->values + own->value_off[e],
                          sizeof(double) * (size_t)(own->value_off[e + 1] - own->value_off[e]));
    }
}

static void matrix_of_two_bodies_is_theirs_bit_for_bit(void **state) {
  (void)state;
  Pair p;
  LthBlockMatrix *A = NULL, *own[2];
  pair_create(&p, NULL);
  LitheCtx *ctx = p.a.ctx;
  CHECK_OK(ctx, lth_system_matrix_create(ctx, p.system, &A));
  double *f0 = calloc((size_t)p.system->n, sizeof *f0);
  lth_system_update_rotations(p.system, NULL);
  lth_system_assemble(p.system, 0, A, f0);
  Beam *beams[2] = {&p.a, &p.b};
  for (int b = 0; b < 2; b++) {
    double *own_f0 = calloc((size_t)beams[b]->space->n_dofs, sizeof *own_f0);
    CHECK_OK(ctx, lth_dg_matrix_create(ctx, beams[b]->op, &own[b]));
    lth_dg_assemble(beams[b]->op, 0, own[b], own_f0);
    check_rows(A, p.system->row_first[b], own[b]);
    assert_memory_equal(f0 + p.system->dof_first[b], own_f0,
                        sizeof *f0 * (size_t)beams[b]->space->n_dofs);
    free(own_f0);
  }
  assert_int_equal(A->block_off[A->n_rows],
                   own[0]->block_off[own[0]->n_rows] + own[1]->block_off[own[1]->n_rows]);
  for (int b = 0; b < 2; b++) lth_block_matrix_destroy(ctx, own + b);
  lth_block_matrix_destroy(ctx, &A);
  free(f0);
  pair_destroy(&p);
}

static void bodies_move_together_as_they_do_alone(void **state) {
  (void)state;
  Pair p;
  LthSimulation *sim = NULL;
  LthStepOptions options = lth_step_options_default();
  pair_create(&p, NULL);
  LitheCtx *ctx = p.a.ctx;
  options.tolerance = 1e-12;
  CHECK_OK(ctx, lth_simulation_create(ctx, p.system, &options, &sim));
  for (int i = 0; i < 10; i++) CHECK_OK(ctx, lth_simulation_step(ctx, sim, 0.02));
  const double *u = lth_simulation_displacement(sim);
  for (LitheIndex b = 0; b < 2; b++) {
    LthSystem *alone = NULL;
    LthSimulation *one = NULL;
    LthSystemDef def = {.bodies = p.system->bodies + b, .n_bodies = 1, .gravity = {0, 0, -1}};
    CHECK_OK(ctx, lth_system_create(ctx, &def, &alone));
    CHECK_OK(ctx, lth_simulation_create(ctx, alone, &options, &one));
    for (int i = 0; i < 10; i++) CHECK_OK(ctx, lth_simulation_step(ctx, one, 0.02));
    const double *v = lth_simulation_displacement(one);
    double largest = 0;
    for (LitheCount i = 0; i < alone->n; i++) largest = fmax(largest, fabs(v[i]));
    CHECK_AT_LEAST(largest, 1e-3); // it moves
    for (LitheCount i = 0; i < alone->n; i++)
      CHECK_NEAR(u[p.system->dof_first[b] + i], v[i], 1e-9 * largest);
    lth_simulation_destroy(ctx, &one);
    lth_system_destroy(ctx, &alone);
  }
  lth_simulation_destroy(ctx, &sim);
  pair_destroy(&p);
}

/// A spring between the first functions of row 1 and row 3.
typedef struct Spring {
  LitheIndex pairs[4];
  double stiffness;
} Spring;

static void add_spring(void *self, double t, LthBlockMatrix *A, double *f0) {
  const Spring *s = self;
  (void)t, (void)f0;
  for (int r = 0; r < 2; r++)
    for (int c = 0; c < 2; c++) {
      LitheIndex row = s->pairs[r], col = s->pairs[c];
      LitheCount n = A->row_off[col + 1] - A->row_off[col];
      double *B = A->values + A->value_off[lth_block_matrix_find(A, row, col)];
      for (int a = 0; a < 3; a++) B[a * n + a] += r == c ? s->stiffness : -s->stiffness;
    }
}

static void no_load(void *self, double t, double *f0) { (void)self, (void)t, (void)f0; }
static double no_energy(void *self, double t, const double *x) {
  (void)self, (void)t, (void)x;
  return 0;
}

static void coupling_adds_blocks_between_bodies_and_damping_keeps_it_symmetric(void **state) {
  (void)state;
  Pair p;
  LthBlockMatrix *A = NULL;
  Spring spring = {.pairs = {1, 3}, .stiffness = 7};
  LthCoupling coupling = {.self = &spring,
                          .n_pairs = 1,
                          .pairs = spring.pairs,
                          .add = add_spring,
                          .add_load = no_load,
                          .energy = no_energy};
  pair_create(&p, &coupling);
  LitheCtx *ctx = p.a.ctx;
  CHECK_OK(ctx, lth_system_matrix_create(ctx, p.system, &A));
  double *f0 = calloc((size_t)p.system->n, sizeof *f0);
  lth_system_update_rotations(p.system, NULL);
  for (int twice = 0; twice < 2; twice++) lth_system_assemble(p.system, 0, A, f0);
  LitheCount e = lth_block_matrix_find(A, 1, 3);
  assert_true(e >= 0);
  CHECK_NEAR(A->values[A->value_off[e]], -7, 0); // not -14: assembly starts from nothing
  const double cm[2] = {1.5, 1}, ck[2] = {0.25, 0.125};
  lth_system_combine(ctx, p.system, cm, ck, A);
  CHECK_NEAR(A->values[A->value_off[e]], -7 * 0.125, 0);
  CHECK_AT_MOST(lth_block_matrix_asymmetry(A), 1e-15);
  lth_block_matrix_destroy(ctx, &A);
  free(f0);
  pair_destroy(&p);
}

static void held_unknowns_have_rows_of_the_identity(void **state) {
  (void)state;
  Pair p;
  LthBlockMatrix *A = NULL;
  pair_create(&p, NULL);
  LitheCtx *ctx = p.a.ctx;
  CHECK_OK(ctx, lth_system_matrix_create(ctx, p.system, &A));
  double *f0 = calloc((size_t)p.system->n, sizeof *f0), *x = calloc((size_t)p.system->n, sizeof *x),
         *y = calloc((size_t)p.system->n, sizeof *y);
  lth_system_update_rotations(p.system, NULL);
  lth_system_assemble(p.system, 0, A, f0);
  lth_system_hold(ctx, p.system, A);
  assert_true(p.system->has_held);
  for (LitheCount i = 0; i < p.system->n; i++) x[i] = p.system->held[i] ? 1 + (double)i : 0;
  lth_block_matrix_apply(A, 1, x, y);
  LitheCount n_held = 0;
  for (LitheCount i = 0; i < p.system->n; i++) {
    n_held += p.system->held[i];
    CHECK_NEAR(y[i], x[i], 0);
  }
  assert_int_equal(n_held, 12); // one element of degree 1
  lth_block_matrix_destroy(ctx, &A);
  free(f0), free(x), free(y);
  pair_destroy(&p);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(matrix_of_two_bodies_is_theirs_bit_for_bit),
      cmocka_unit_test(bodies_move_together_as_they_do_alone),
      cmocka_unit_test(coupling_adds_blocks_between_bodies_and_damping_keeps_it_symmetric),
      cmocka_unit_test(held_unknowns_have_rows_of_the_identity),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
