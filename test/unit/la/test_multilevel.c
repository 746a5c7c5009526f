/// The multilevel preconditioner: symmetric, definite, the same bits on any threads, iterations that do not grow.
#include "dg_body.h"

#include "la/multilevel.h"

static const double weight[3] = {0, 0, -1};

static TestBody cube(LitheIndex n, int degree) {
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  TestBody b = test_body(TEST_HEXAHEDRA, grid, degree);
  test_hold(&b, test_facing_down_z);
  return b;
}

static double *ones(const TestBody *b) {
  double *one = lth_alloc(b->ctx, b->space->n_funcs, sizeof *one);
  for (LitheIndex c = 0; c < b->space->n_cells; c++) one[b->space->func_off[c]] = 1;
  return one;
}

static LthMultilevel *levels(const TestBody *b, const double *one) {
  LthMultilevel *M = NULL;
  LthMultilevelDef def = {.A = b->K, .one = one, .position = b->x0, .n_linear = 12};
  CHECK_OK(b->ctx, lth_multilevel_create(b->ctx, &def, &M));
  return M;
}

/// Solve K x = weight; the true residual is part of the report.
static LthSolveReport solve(TestBody *b, double tolerance) {
  LthCg *cg = NULL;
  double *one = ones(b);
  LthMultilevel *M = levels(b, one);
  CHECK_OK(b->ctx, lth_cg_create(b->ctx, b->K->n, &cg));
  LthOperator A = lth_block_matrix_operator(b->K);
  memset(b->x, 0, sizeof *b->x * (size_t)b->K->n);
  LthSolveReport r =
      lth_multilevel_solve(M, cg, lth_threads(b->ctx), &A, b->f, b->x, tolerance, 500);
  lth_cg_destroy(b->ctx, &cg);
  lth_multilevel_destroy(b->ctx, &M);
  lth_free(b->ctx, one);
  return r;
}

static LthSolveReport solve_cube(LitheIndex n, int degree, double poisson) {
  TestBody b = cube(n, degree);
  test_set_material(&b, 1000, poisson);
  test_assemble(&b, 0);
  test_add_weight(&b, weight);
  LthSolveReport r = solve(&b, 1e-8);
  if (!r.converged) fail_msg("%d cells of degree %d: residual %g", (int)n, degree, r.residual);
  test_body_free(&b);
  return r;
}

static void fill_random(LitheCount n, uint64_t seed, double *v) {
  for (LitheCount i = 0; i < n; i++) v[i] = test_random(&seed) - 0.5;
}

// y (M x) = x (M y) up to the rounding of some thousand sums; x (M x) > 0.
static void check_symmetric(int strong) {
  TestBody b = cube(4, MIXED);
  test_assemble(&b, 0);
  double *one = ones(&b), *z = lth_alloc(b.ctx, b.K->n, sizeof *z);
  LthMultilevel *M = levels(&b, one);
  if (strong) lth_multilevel_strengthen(M);
  assert_true(lth_multilevel_levels(M) >= 3);
  LthOperator B = lth_multilevel_operator(M);
  for (uint64_t seed = 1; seed < 6; seed++) {
    fill_random(b.K->n, seed, b.x);
    fill_random(b.K->n, seed + 100, b.f);
    B.apply(B.self, 1, b.x, b.r);
    B.apply(B.self, 1, b.f, z);
    double xx = lth_dot(1, b.K->n, b.x, b.r), yy = lth_dot(1, b.K->n, b.f, z);
    assert_true(xx > 0 && yy > 0);
    CHECK_NEAR(lth_dot(1, b.K->n, b.f, b.r), lth_dot(1, b.K->n, b.x, z), 1e-12 * sqrt(xx * yy));
  }
  lth_multilevel_destroy(b.ctx, &M);
  lth_free(b.ctx, one);
  lth_free(b.ctx, z);
  test_body_free(&b);
}

static void cycle_is_symmetric_and_definite(void **state) {
  (void)state;
  check_symmetric(false);
}

static void polynomial_cycle_is_symmetric_and_definite(void **state) {
  (void)state;
  check_symmetric(true);
}

static void bits_do_not_depend_on_threads(void **state) {
  (void)state;
  double *result[2] = {NULL, NULL};
  LitheCount n = 0;
  for (int k = 0; k < 2; k++) {
    TestBody b = cube(6, 2);
    lth_set_threads(b.ctx, k == 0 ? 1 : 3);
    test_assemble(&b, 0);
    double *one = ones(&b);
    LthMultilevel *M = levels(&b, one);
    LthOperator B = lth_multilevel_operator(M);
    n = b.K->n;
    result[k] = malloc(2 * sizeof **result * (size_t)n);
    fill_random(n, 7, b.f);
    B.apply(B.self, lth_threads(b.ctx), b.f, result[k]);
    lth_multilevel_strengthen(M);
    B.apply(B.self, lth_threads(b.ctx), b.f, result[k] + n);
    lth_multilevel_destroy(b.ctx, &M);
    lth_free(b.ctx, one);
    test_body_free(&b);
  }
  assert_memory_equal(result[0], result[1], 2 * sizeof **result * (size_t)n);
  free(result[0]), free(result[1]);
}

static void a_cycle_and_an_update_allocate_nothing(void **state) {
  (void)state;
  TestBody b = cube(5, 2);
  test_assemble(&b, 0);
  double *one = ones(&b);
  LthMultilevel *M = levels(&b, one);
  LthOperator B = lth_multilevel_operator(M);
  LitheCount before = lth_alloc_count(b.ctx), n = b.K->n;
  fill_random(n, 3, b.f);
  B.apply(B.self, lth_threads(b.ctx), b.f, b.r);
  memcpy(b.x, b.r, sizeof *b.x * (size_t)n);
  CHECK_OK(b.ctx, lth_multilevel_update(b.ctx, M, b.x0, NULL));
  B.apply(B.self, lth_threads(b.ctx), b.f, b.r);
  assert_memory_equal(b.x, b.r, sizeof *b.x * (size_t)n); // the same values give the same levels
  assert_int_equal(lth_alloc_count(b.ctx), before);
  lth_multilevel_destroy(b.ctx, &M);
  lth_free(b.ctx, one);
  test_body_free(&b);
}

/// Stiff springs between the first functions of rows of the lower and of the upper half: what a contact of two parts is.
typedef struct Springs {
  LthBlockMatrix *touch;
  double *extra;
} Springs;

static Springs springs(const TestBody *b, double stiffness) {
  const LitheIndex n = b->K->n_rows, half = n / 2;
  Springs s = {0};
  LitheCount *off = lth_alloc(b->ctx, n + 1, sizeof *off);
  LitheIndex *col = lth_alloc(b->ctx, 2 * n, sizeof *col);
  for (LitheIndex row = 0; row < n; row++) {
    LitheIndex other = row < half ? row + half : row - half;
    off[row + 1] = off[row] + 2;
    col[off[row]] = row < other ? row : other;
    col[off[row] + 1] = row < other ? other : row;
  }
  CHECK_OK(b->ctx, lth_block_matrix_create(b->ctx, n, b->K->row_off, off, col, &s.touch));
  s.extra = lth_alloc(b->ctx, 144 * (LitheCount)n, sizeof *s.extra);
  for (LitheIndex row = 0; row < n; row++)
    for (LitheCount e = off[row]; e < off[row + 1]; e++)
      for (int a = 0; a < 3; a++) {
        s.touch->values[s.touch->value_off[e] + 13 * a] = col[e] == row ? stiffness : -stiffness;
        s.extra[144 * (LitheCount)row + 13 * a] = 2 * stiffness;
      }
  lth_free(b->ctx, off);
  lth_free(b->ctx, col);
  return s;
}

static void add_springs(const void *self, int threads, const double *x, double *y) {
  const Springs *s = self;
  double *t = calloc((size_t)s->touch->n, sizeof *t);
  lth_block_matrix_apply(s->touch, threads, x, t);
  for (LitheCount i = 0; i < s->touch->n; i++) y[i] += t[i];
  free(t);
}

typedef struct Joined {
  const TestBody *b;
  const Springs *s;
} Joined;

static void apply_joined(const void *self, int threads, const double *x, double *y) {
  const Joined *j = self;
  lth_block_matrix_apply(j->b->K, threads, x, y);
  add_springs(j->s, threads, x, y);
}

/// Iterations with levels that know the springs, or their block diagonal alone on the finest.
static LitheIndex solve_joined(TestBody *b, const Springs *s, bool knows, bool strong) {
  double *one = ones(b), *z = lth_alloc(b->ctx, b->K->n, sizeof *z);
  LthMultilevel *M = NULL;
  LthCg *cg = NULL;
  LthMultilevelDef def = {
      .A = b->K, .one = one, .position = b->x0, .n_linear = 12, .touch = knows ? s->touch : NULL};
  CHECK_OK(b->ctx, lth_multilevel_create(b->ctx, &def, &M));
  if (strong) lth_multilevel_strengthen(M);
  LthOperator C = {.n = b->K->n, .apply = add_springs, .self = s};
  if (knows) lth_multilevel_add(M, &C);
  CHECK_OK(b->ctx, lth_multilevel_update(b->ctx, M, NULL, s->extra));
  LthOperator B = lth_multilevel_operator(M);
  fill_random(b->K->n, 5, b->x);
  fill_random(b->K->n, 6, b->f);
  B.apply(B.self, 1, b->x, b->r);
  B.apply(B.self, 1, b->f, z);
  double xx = lth_dot(1, b->K->n, b->x, b->r), yy = lth_dot(1, b->K->n, b->f, z);
  assert_true(xx > 0 && yy > 0);
  CHECK_NEAR(lth_dot(1, b->K->n, b->f, b->r), lth_dot(1, b->K->n, b->x, z), 1e-11 * sqrt(xx * yy));
  Joined joined = {b, s};
  LthOperator A = {.n = b->K->n, .apply = apply_joined, .self = &joined};
  CHECK_OK(b->ctx, lth_cg_create(b->ctx, b->K->n, &cg));
  memset(b->x, 0, sizeof *b->x * (size_t)b->K->n);
  LthSolveReport r = lth_cg_solve(cg, 1, &A, &B, b->f, b->x, 1e-8, 2000);
  assert_true(r.converged);
  lth_cg_destroy(b->ctx, &cg);
  lth_multilevel_destroy(b->ctx, &M);
  lth_free(b->ctx, one);
  lth_free(b->ctx, z);
  return r.iterations;
}

static void levels_that_know_what_is_added_take_a_fraction_of_the_iterations(void **state) {
  (void)state;
  TestBody b = cube(6, 1);
  test_assemble(&b, 0);
  Springs s = springs(&b, 1000 * 10 / 6.0);
  for (int strong = 0; strong < 2; strong++) {
    LitheIndex knows = solve_joined(&b, &s, true, strong == 1);
    LitheIndex does_not = solve_joined(&b, &s, false, strong == 1);
    CHECK_AT_MOST(3 * knows, does_not);
  }
  lth_block_matrix_destroy(b.ctx, &s.touch);
  lth_free(b.ctx, s.extra);
  test_body_free(&b);
}

// Block-Jacobi takes twice the iterations from each of these meshes to the next.
static void iterations_do_not_grow_with_refinement(void **state) {
  (void)state;
  assert_in_range(solve_cube(3, 1, 0.3).iterations, 1, 35);
  assert_in_range(solve_cube(6, 1, 0.3).iterations, 1, 35);
  assert_in_range(solve_cube(12, 1, 0.3).iterations, 1, 35);
  assert_in_range(solve_cube(3, 2, 0.3).iterations, 1, 40);
  assert_in_range(solve_cube(6, 2, 0.3).iterations, 1, 40);
}

static void higher_and_mixed_degrees_converge_alike(void **state) {
  (void)state;
  assert_in_range(solve_cube(4, 3, 0.3).iterations, 1, 60);
  assert_in_range(solve_cube(3, 4, 0.3).iterations, 1, 60);
  assert_in_range(solve_cube(4, MIXED, 0.3).iterations, 1, 60);
}

static void nearly_incompressible_bodies_converge(void **state) {
  (void)state;
  assert_in_range(solve_cube(6, 1, 0.499).iterations, 1, 150);
  assert_in_range(solve_cube(10, 1, 0.499).iterations, 1, 150);
}

static void a_small_problem_is_solved_by_the_coarsest_level_alone(void **state) {
  (void)state;
  LthSolveReport r = solve_cube(2, 1, 0.3); // 96 unknowns: one level
  assert_int_equal(r.iterations, 1);
}

// A stiff ball in a soft cube, a million to one. The residual's floor is rounding of the stiff part.
static void a_million_to_one_converges(void **state) {
  (void)state;
  TestBody b = cube(8, 1);
  for (LitheIndex c = 0; c < b.mesh->n_cells; c++) {
    const double *x = b.mesh->cell_centroid + 3 * c;
    double r = 0;
    for (int a = 0; a < 3; a++) r += (x[a] - 0.5) * (x[a] - 0.5);
    if (r < 0.09) b.young[c] = 1e9;
  }
  test_assemble(&b, 0);
  test_add_weight(&b, weight);
  LthSolveReport r = solve(&b, 1e-6);
  assert_true(r.converged);
  assert_in_range(r.iterations, 1, 60);
  test_body_free(&b);
}

/// Rows and columns of one become those of the identity.
static void hold_unknown(LthBlockMatrix *K, LitheCount unknown) {
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheCount r0 = K->row_off[row], c0 = K->row_off[K->block_col[e]];
      LitheCount m = K->row_off[row + 1] - r0, n = K->row_off[K->block_col[e] + 1] - c0;
      for (LitheCount r = 0; r < m; r++)
        for (LitheCount c = 0; c < n; c++)
          if (r0 + r == unknown || c0 + c == unknown)
            K->values[K->value_off[e] + r * n + c] = r0 + r == c0 + c;
    }
}

static void held_unknowns_stay_and_do_not_disturb(void **state) {
  (void)state;
  TestBody b = cube(6, 1);
  test_assemble(&b, 0);
  test_add_weight(&b, weight);
  // whole elements, and single unknowns of others
  for (LitheCount i = 0; i < 12 * 6; i++) hold_unknown(b.K, i), b.f[i] = 0;
  for (LitheCount i = 12 * 50; i < 12 * 60; i += 5) hold_unknown(b.K, i), b.f[i] = 0;
  LthSolveReport r = solve(&b, 1e-8);
  assert_true(r.converged);
  assert_in_range(r.iterations, 1, 40);
  for (LitheCount i = 0; i < 12 * 6; i++) assert_true(b.x[i] == 0);
  for (LitheCount i = 12 * 50; i < 12 * 60; i += 5) assert_true(b.x[i] == 0);
  test_body_free(&b);
}

static void a_matrix_that_is_not_definite_is_told(void **state) {
  (void)state;
  TestBody b = cube(6, 1);
  test_assemble(&b, 0);
  LitheCount d = b.K->value_off[b.K->diagonal[7]];
  for (int i = 0; i < 144; i++) b.K->values[d + i] = -b.K->values[d + i];
  double *one = ones(&b);
  LthMultilevel *M = NULL;
  LthMultilevelDef def = {.A = b.K, .one = one, .position = b.x0, .n_linear = 12};
  assert_int_equal(lth_multilevel_create(b.ctx, &def, &M), LITHE_NOT_CONVERGED);
  assert_null(M);
  assert_non_null(strstr(lithe_ctx_message(b.ctx), "not positive definite"));
  lth_free(b.ctx, one);
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cycle_is_symmetric_and_definite),
      cmocka_unit_test(polynomial_cycle_is_symmetric_and_definite),
      cmocka_unit_test(bits_do_not_depend_on_threads),
      cmocka_unit_test(a_cycle_and_an_update_allocate_nothing),
      cmocka_unit_test(levels_that_know_what_is_added_take_a_fraction_of_the_iterations),
      cmocka_unit_test(iterations_do_not_grow_with_refinement),
      cmocka_unit_test(higher_and_mixed_degrees_converge_alike),
      cmocka_unit_test(nearly_incompressible_bodies_converge),
      cmocka_unit_test(a_small_problem_is_solved_by_the_coarsest_level_alone),
      cmocka_unit_test(a_million_to_one_converges),
      cmocka_unit_test(held_unknowns_stay_and_do_not_disturb),
      cmocka_unit_test(a_matrix_that_is_not_definite_is_told),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
