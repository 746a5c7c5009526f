/// The operator's structure: symmetry, kernels, warping, energy, definiteness, reactions, determinism.
#include "dg_body.h"
#include "failing_memory.h"

static const LthGrid block = {{-1, 0, 0.5}, {1, 1.5, 2}, {3, 2, 2}};

/// A grid with uneven tetrahedra or boxes; contrast in stiffness from cell to cell.
static void uneven_material(TestBody *b, double contrast, double poisson) {
  uint64_t seed = 5;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    b->young[c] = 1000 * pow(contrast, test_random(&seed));
    b->poisson[c] = poisson;
  }
}

static void random_vector(uint64_t *seed, LitheCount n, double size, double *v) {
  for (LitheCount i = 0; i < n; i++) v[i] += size * (2 * test_random(seed) - 1);
}

/// Rotations that differ at random from cell to cell, through random positions.
static void random_rotations(TestBody *b, uint64_t seed) {
  random_vector(&seed, b->K->n, 1, b->x);
  lth_dg_update_rotations(b->op, b->x);
}

static void matrix_is_symmetric(void **state) {
  (void)state;
  for (int k = 1; k <= MIXED; k++)
    for (int kind = 0; kind < 2; kind++)
      for (int flux = 0; flux < 2; flux++) {
        TestBody b = test_body(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA,
                               (LthGrid){{0, 0, 0}, {1, 1, 2}, {2, 1, 2}}, k);
        uneven_material(&b, 100, 0.4);
        b.def.flux = flux ? LTH_FLUX_BZ : LTH_FLUX_IP;
        b.def.warped = true;
        test_hold(&b, test_facing_down_x);
        LthWeakConstraint *roller = test_hold(&b, test_facing_down_z);
        roller->normal_only = true;
        test_assemble(&b, 0);
        random_rotations(&b, 3);
        test_assemble(&b, 0);
        CHECK_AT_MOST(lth_block_matrix_asymmetry(b.K), 1e-13);
        test_body_free(&b);
      }
}

static void rigid_motions_of_a_linear_body_give_no_force(void **state) {
  (void)state;
  for (int k = 1; k <= MIXED; k++)
    for (int flux = 0; flux < 2; flux++) {
      TestBody b = test_body(k == 2 ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, block, k);
      uneven_material(&b, 100, 0.4);
      b.def.flux = flux ? LTH_FLUX_BZ : LTH_FLUX_IP;
      test_assemble(&b, 0);
      // x = X0 + W X0 + shift with W skew
      double W[9] = {1, -0.3, 0.2, 0.3, 1, -0.5, -0.2, 0.5, 1}, shift[3] = {1, 2, 3};
      test_affine(&b, W, shift, b.x0, b.x);
      test_force(&b, b.x, b.r);
      CHECK_AT_MOST(test_max(b.K->n, b.r), 1e-13 * test_force_scale(&b, b.x));
      test_body_free(&b);
    }
}

static void rigid_motions_of_a_warped_body_give_no_force(void **state) {
  (void)state;
  for (int k = 1; k <= MIXED; k++)
    for (int flux = 0; flux < 2; flux++) {
      TestBody b = test_body(k == 2 ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, block, k);
      uneven_material(&b, 100, 0.4);
      b.def.flux = flux ? LTH_FLUX_BZ : LTH_FLUX_IP;
      b.def.warped = true;
      test_assemble(&b, 0);
      double R[9], shift[3] = {1, 2, 3};
      test_rotation(2.5, R);
      test_affine(&b, R, shift, b.x0, b.x);
      lth_dg_update_rotations(b.op, b.x);
      test_assemble(&b, 0);
      test_force(&b, b.x, b.r);
      CHECK_AT_MOST(test_max(b.K->n, b.r), 1e-13 * test_force_scale(&b, b.x));
      double stretched[9];
      for (int i = 0; i < 9; i++) stretched[i] = 1.1 * R[i];
      double rigid = test_norm(b.K->n, b.r);
      test_affine(&b, stretched, shift, b.x0, b.x);
      test_force(&b, b.x, b.r);
      CHECK_AT_LEAST(test_norm(b.K->n, b.r), 1e8 * rigid);
      CHECK_NEAR(lth_dg_energy(b.op, 0, b.x) > 0, 1, 0);
      test_body_free(&b);
    }
}

/// A body under constraints of all kinds, rotated at random.
static TestBody constrained_body(TestMesh kind, int degree, bool bz);

static double varying_value(const void *self, const double x[3], double t) {
  (void)self;
  return 0.1 * t + 0.2 * x[1] * x[1] - 0.1 * x[2];
}

static bool facing_up_y(const double c[3], const double n[3]) {
  (void)c;
  return n[1] > 0.999999;
}

static TestBody constrained_body(TestMesh kind, int degree, bool bz) {
  TestBody b = test_body(kind, (LthGrid){{0, 0, 0}, {2, 1, 1}, {2, 1, 1}}, degree);
  uneven_material(&b, 10, 0.4);
  b.def.flux = bz ? LTH_FLUX_BZ : LTH_FLUX_IP;
  b.def.warped = true;
  LthWeakConstraint *whole = test_hold(&b, test_facing_down_x);
  whole->value[0].eval = varying_value;
  whole->value[2].constant = 0.3;
  LthWeakConstraint *roller = test_hold(&b, test_facing_down_z);
  roller->normal_only = true;
  roller->value[0].constant = 0.2;
  LthWeakConstraint *position = test_hold(&b, test_facing_up_x);
  position->is_position = true;
  position->fixed[1] = false;
  position->value[0].constant = 2.2;
  position->value[2].eval = varying_value;
  LthWeakConstraint *slide = test_hold(&b, facing_up_y);
  slide->normal_only = true;
  slide->value[0].eval = varying_value;
  if (kind == TEST_TETRAHEDRA) // constant data take another way
    for (int i = 0; i < 4; i++)
      for (int a = 0; a < 3; a++)
        b.weak[i].value[a] = lth_value_constant(b.weak[i].value[a].constant + 0.05 * (i - a));
  test_assemble(&b, 1);
  random_rotations(&b, 9);
  test_assemble(&b, 1);
  return b;
}

/// E is quadratic with frozen rotations: (E(x + h) - E(x - h)) / 2 = f(x) . h exactly.
static void force_is_the_gradient_of_the_energy(void **state) {
  (void)state;
  for (int k = 1; k <= MIXED; k++)
    for (int bz = 0; bz < 2; bz++)
      for (int kind = 0; kind < 2; kind++) {
        TestBody b = constrained_body(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, k, bz);
        uint64_t seed = 17;
        LitheCount n = b.K->n;
        double *h = lth_alloc(b.ctx, n, sizeof *h), *y = lth_alloc(b.ctx, n, sizeof *y);
        random_vector(&seed, n, 1, h);
        test_force(&b, b.x, b.r);
        double slope = 0;
        for (LitheCount i = 0; i < n; i++) slope += b.r[i] * h[i];
        for (LitheCount i = 0; i < n; i++) y[i] = b.x[i] + h[i];
        double up = lth_dg_energy(b.op, 1, y);
        for (LitheCount i = 0; i < n; i++) y[i] = b.x[i] - h[i];
        double down = lth_dg_energy(b.op, 1, y);
        CHECK_NEAR((up - down) / 2, slope, 1e-12 * (up + down));
        // and the second difference is the matrix: E(x + h) + E(x - h) - 2 E(x) = h K h
        double middle = lth_dg_energy(b.op, 1, b.x), curvature = 0;
        lth_block_matrix_apply(b.K, 1, h, y);
        for (LitheCount i = 0; i < n; i++) curvature += h[i] * y[i];
        CHECK_NEAR(up + down - 2 * middle, curvature, 1e-12 * (up + down));
        lth_free(b.ctx, h);
        lth_free(b.ctx, y);
        test_body_free(&b);
      }
}

/// Internal forces tested with constants are the constraints' alone.
static void reactions_balance_the_internal_force(void **state) {
  (void)state;
  for (int k = 1; k <= MIXED; k++)
    for (int bz = 0; bz < 2; bz++) {
      TestBody b = constrained_body(TEST_HEXAHEDRA, k, bz);
      double total[3] = {0}, reaction[12];
      test_force(&b, b.x, b.r);
      for (LitheIndex c = 0; c < b.space->n_cells; c++)
        lth_v3_add(total, b.r + 3 * b.space->func_off[c], total);
      lth_dg_reactions(b.op, 1, b.x, reaction);
      for (int w = 0; w < 4; w++) lth_v3_add(total, reaction + 3 * w, total);
      CHECK_AT_MOST(lth_v3_norm(total), 1e-12 * test_force_scale(&b, b.x));
      test_body_free(&b);
    }
}

static void check_definite(TestMesh kind, int degree, double poisson, double contrast, bool warped,
                           bool bz) {
  TestBody b = test_body(kind,
                         kind == TEST_HEXAHEDRA ? (LthGrid){{0, 0, 0}, {1, 0.7, 0.4}, {2, 2, 1}}
                                                : (LthGrid){{0, 0, 0}, {1, 0.7, 0.4}, {1, 2, 1}},
                         degree);
  uneven_material(&b, contrast, poisson);
  b.def.warped = warped;
  b.def.flux = bz ? LTH_FLUX_BZ : LTH_FLUX_IP;
  test_assemble(&b, 0);
  if (warped) random_rotations(&b, 21), test_assemble(&b, 0);
  double min, max;
  test_eigenvalues(&b, &min, &max);
  CHECK_AT_LEAST(min, -1e-12 * max);
  test_body_free(&b);
}

static void matrix_is_never_indefinite(void **state) {
  (void)state;
  for (int kind = 0; kind < 2; kind++)
    for (int k = 1; k <= 2; k++)
      for (int warped = 0; warped < 2; warped++) {
        check_definite(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, k, -0.5, 1, warped, false);
        check_definite(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, k, 0.3, 1e6, warped, false);
        check_definite(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, k, 0.499, 1, warped, false);
        check_definite(kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, k, 0.499, 1e6, warped, false);
      }
  check_definite(TEST_HEXAHEDRA, 1, 0.499, 1e6, true, true);
  check_definite(TEST_HEXAHEDRA, 3, 0.499, 10, true, false);
}

/// The shape floats: six motions cost nothing, the seventh does.
static void kernel_holds_the_rigid_motions_only(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 1);
  test_assemble(&b, 0);
  double *A = test_dense(&b), *w = lth_alloc(b.ctx, b.K->n, sizeof *w);
  int n = (int)b.K->n;
  assert_int_equal(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', n, A, n, w), 0);
  CHECK_AT_MOST(fabs(w[5]), 1e-13 * w[n - 1]);
  CHECK_AT_LEAST(w[6], 1e-5 * w[n - 1]);
  lth_free(b.ctx, A);
  lth_free(b.ctx, w);
  test_body_free(&b);
}

/// The same scene with its origin moved: the same displacement.
static void constraints_do_not_depend_on_the_origin(void **state) {
  (void)state;
  double *u[2] = {NULL, NULL};
  TestBody bodies[2];
  for (int moved = 0; moved < 2; moved++) {
    double o = moved ? 10 : 0;
    bodies[moved] =
        test_body(TEST_HEXAHEDRA, (LthGrid){{o, o, o}, {o + 2, o + 1, o + 1}, {2, 1, 1}}, 1);
    TestBody *b = &bodies[moved];
    b->def.warped = true;
    test_hold(b, test_facing_down_x);
    LthWeakConstraint *roller = test_hold(b, test_facing_up_x);
    roller->normal_only = true;
    roller->value[0].constant = 0.1;
    double R[9];
    test_rotation(0.4, R);
    test_assemble(b, 0);
    test_affine(b, R, (double[3]){0, 0, 0}, b->x0, b->x);
    lth_dg_update_rotations(b->op, b->x);
    test_assemble(b, 0);
    test_solve(b);
    u[moved] = b->x;
    for (LitheCount i = 0; i < b->K->n; i++) u[moved][i] -= b->x0[i];
  }
  for (LitheCount i = 0; i < bodies[0].K->n; i++) CHECK_NEAR(u[1][i], u[0][i], 1e-11);
  test_body_free(&bodies[0]);
  test_body_free(&bodies[1]);
}

static void threads_give_the_same_bits(void **state) {
  (void)state;
  TestBody b = constrained_body(TEST_TETRAHEDRA, 2, false);
  LitheCount n = b.K->value_off[b.K->block_off[b.K->n_rows]];
  double *values = lth_alloc(b.ctx, n, sizeof *values);
  lth_set_threads(b.ctx, 1);
  lth_dg_update_rotations(b.op, b.x);
  lth_dg_assemble(b.op, 1, b.K, b.f0);
  memcpy(values, b.K->values, sizeof *values * (size_t)n);
  memcpy(b.r, b.f0, sizeof *b.r * (size_t)b.K->n);
  double energy = lth_dg_energy(b.op, 1, b.x);
  for (int threads = 2; threads <= 3; threads++) {
    lth_set_threads(b.ctx, threads);
    lth_dg_update_rotations(b.op, b.x);
    lth_dg_assemble(b.op, 1, b.K, b.f0);
    assert_memory_equal(values, b.K->values, sizeof *values * (size_t)n);
    assert_memory_equal(b.r, b.f0, sizeof *b.r * (size_t)b.K->n);
    assert_true(lth_dg_energy(b.op, 1, b.x) == energy);
  }
  lth_free(b.ctx, values);
  test_body_free(&b);
}

static void reassembly_allocates_nothing(void **state) {
  (void)state;
  TestBody b = constrained_body(TEST_HEXAHEDRA, 2, false);
  LitheCount before = lth_alloc_count(b.ctx);
  lth_dg_update_rotations(b.op, b.x);
  lth_dg_assemble(b.op, 2, b.K, b.f0);
  lth_dg_energy(b.op, 2, b.x);
  double reaction[12];
  lth_dg_reactions(b.op, 2, b.x, reaction);
  assert_int_equal(lth_alloc_count(b.ctx), before);
  test_body_free(&b);
}

static void every_failed_allocation_is_told_and_leaks_nothing(void **state) {
  (void)state;
  int left = 1000000;
  LitheCtxDef ctx_def = lithe_ctx_def_default();
  ctx_def.allocate = test_failing_allocate, ctx_def.memory_user = &left;
  LitheCtx *ctx = lithe_ctx_create(&ctx_def);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &block, &mesh));
  TestBody b = test_body_of(ctx, mesh, 1);
  test_hold(&b, test_facing_down_x)->value[0].eval = varying_value;
  test_hold(&b, test_facing_up_x)->normal_only = true;
  b.def.weak = b.weak;
  LitheCount held = lth_alloc_bytes(ctx);
  LitheStatus status = LITHE_NO_MEMORY;
  int n = 0;
  for (; status != LITHE_OK && n < 200; n++) {
    left = n;
    status = lth_dg_operator_create(ctx, &b.def, &b.op);
    if (status == LITHE_OK) status = lth_dg_matrix_create(ctx, b.op, &b.K);
    if (status == LITHE_OK) break;
    assert_int_equal(status, LITHE_NO_MEMORY);
    lth_dg_operator_destroy(ctx, &b.op);
    assert_null(b.K);
    assert_int_equal(lth_alloc_bytes(ctx), held);
  }
  assert_int_equal(status, LITHE_OK);
  assert_true(n > 25);
  left = 1000000;
  test_body_free(&b);
}

static void stress_of_a_stretched_and_turned_body(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 2);
  b.def.warped = true;
  test_assemble(&b, 0);
  double R[9], U[9] = {1.01, 0, 0, 0, 1, 0, 0, 0, 1}, F[9], want[9], T[9], Rt[9], stress[6];
  test_rotation(1, R);
  lth_m3_mul(R, U, F);
  test_affine(&b, F, (double[3]){5, 0, 0}, b.x0, b.x);
  lth_dg_update_rotations(b.op, b.x);
  double lambda, mu;
  lth_lame(1000, 0.3, &lambda, &mu);
  double S[9] = {0.01 * (lambda + 2 * mu), 0, 0, 0, 0.01 * lambda, 0, 0, 0, 0.01 * lambda};
  lth_m3_mul(R, S, T);
  lth_m3_transpose(R, Rt);
  lth_m3_mul(T, Rt, want);
  lth_dg_stress(b.op, 1, b.x, b.space->center + 3, stress);
  const int voigt[6] = {0, 4, 8, 5, 2, 1};
  for (int i = 0; i < 6; i++) CHECK_NEAR(stress[i], want[voigt[i]], 1e-11);
  test_body_free(&b);
}

static void bad_materials_are_refused(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 1);
  LthDgOperator *op = NULL;
  b.poisson[3] = 0.5;
  assert_int_equal(lth_dg_operator_create(b.ctx, &b.def, &op), LITHE_BAD_INPUT);
  assert_null(op);
  b.poisson[3] = 0.3, b.young[2] = 0;
  assert_int_equal(lth_dg_operator_create(b.ctx, &b.def, &op), LITHE_BAD_INPUT);
  b.young[2] = 1, b.def.penalty = LTH_PENALTY_ETA, b.def.eta = NAN;
  assert_int_equal(lth_dg_operator_create(b.ctx, &b.def, &op), LITHE_BAD_INPUT);
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(matrix_is_symmetric),
      cmocka_unit_test(rigid_motions_of_a_linear_body_give_no_force),
      cmocka_unit_test(rigid_motions_of_a_warped_body_give_no_force),
      cmocka_unit_test(force_is_the_gradient_of_the_energy),
      cmocka_unit_test(reactions_balance_the_internal_force),
      cmocka_unit_test(matrix_is_never_indefinite),
      cmocka_unit_test(kernel_holds_the_rigid_motions_only),
      cmocka_unit_test(constraints_do_not_depend_on_the_origin),
      cmocka_unit_test(threads_give_the_same_bits),
      cmocka_unit_test(reassembly_allocates_nothing),
      cmocka_unit_test(every_failed_allocation_is_told_and_leaks_nothing),
      cmocka_unit_test(stress_of_a_stretched_and_turned_body),
      cmocka_unit_test(bad_materials_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
