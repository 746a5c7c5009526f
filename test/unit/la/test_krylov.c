/// Conjugate gradients, block-Jacobi and the sparse Cholesky against each other.
#include "random_matrix.h"

#include "la/engine.h"
#include "la/krylov.h"
#include "la/reduction.h"

static const int mixed_sizes[] = {12, 30, 60, 105};

typedef struct Problem {
  LitheCtx *ctx;
  LthBlockMatrix *A;
  LthBlockJacobi *M;
  LthCg *cg;
  double *b, *x, *y;
} Problem;

static Problem problem(LitheIndex n_rows, int threads) {
  Problem p = {.ctx = test_ctx()};
  lth_set_threads(p.ctx, threads);
  p.A = random_matrix(p.ctx, n_rows, mixed_sizes, 4, 21);
  CHECK_OK(p.ctx, lth_block_jacobi_create(p.ctx, p.A, &p.M));
  CHECK_OK(p.ctx, lth_cg_create(p.ctx, p.A->n, &p.cg));
  CHECK_OK(p.ctx, lth_block_jacobi_update(p.ctx, p.M, p.A, NULL));
  p.b = calloc((size_t)p.A->n, sizeof *p.b);
  p.x = calloc((size_t)p.A->n, sizeof *p.x);
  p.y = calloc((size_t)p.A->n, sizeof *p.y);
  random_vector(p.A->n, 77, p.b);
  return p;
}

static void end(Problem *p) {
  free(p->b), free(p->x), free(p->y);
  lth_cg_destroy(p->ctx, &p->cg);
  lth_block_jacobi_destroy(p->ctx, &p->M);
  lth_block_matrix_destroy(p->ctx, &p->A);
  assert_int_equal(lth_alloc_bytes(p->ctx), 0);
  lithe_ctx_destroy(&p->ctx);
}

static LthSolveReport solve(Problem *p, double tolerance) {
  LthOperator A = lth_block_matrix_operator(p->A), M = lth_block_jacobi_operator(p->M);
  return lth_cg_solve(p->cg, lth_threads(p->ctx), &A, &M, p->b, p->x, tolerance, 1000);
}

static double residual_of(const Problem *p, const double *x) {
  double sum = 0, norm = 0;
  lth_block_matrix_apply(p->A, 1, x, p->y);
  for (LitheCount i = 0; i < p->A->n; i++) {
    sum += pow(p->b[i] - p->y[i], 2);
    norm += pow(p->b[i], 2);
  }
  return sqrt(sum / norm);
}

static void gradients_and_cholesky_agree(void **state) {
  (void)state;
  Problem p = problem(50, 2);
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  LthSolveReport report = solve(&p, 1e-12);
  assert_true(report.converged);
  CHECK_AT_MOST(residual_of(&p, p.x), 1.01e-12);

  double *direct = calloc((size_t)p.A->n, sizeof *direct), bytes, flops;
  CHECK_OK(p.ctx, engine->analyse(p.ctx, p.A, &factor));
  engine->predict(factor, &bytes, &flops);
  CHECK_AT_LEAST(bytes, 8.0 * (double)p.A->n);
  CHECK_AT_LEAST(flops, (double)p.A->n);
  for (int twice = 0; twice < 2; twice++) { // the analysis serves again
    CHECK_OK(p.ctx, engine->factorize(p.ctx, factor, p.A));
    CHECK_OK(p.ctx, engine->solve(p.ctx, factor, p.b, direct));
    CHECK_AT_MOST(residual_of(&p, direct), 1e-14);
  }
  // diagonal dominance keeps the condition near 2
  for (LitheCount i = 0; i < p.A->n; i++) CHECK_NEAR(p.x[i], direct[i], 1e-11 * 0.5);
  free(direct);
  engine->destroy(p.ctx, &factor);
  end(&p);
}

static void same_bits_on_any_number_of_threads(void **state) {
  (void)state;
  double *first = NULL;
  static const int threads[] = {1, 2, 4, 7};
  for (int k = 0; k < 4; k++) {
    Problem p = problem(120, threads[k]);
    solve(&p, 1e-9);
    if (k == 0) {
      first = malloc(sizeof *first * (size_t)p.A->n);
      memcpy(first, p.x, sizeof *first * (size_t)p.A->n);
    }
    assert_memory_equal(first, p.x, sizeof *first * (size_t)p.A->n);
    end(&p);
  }
  free(first);
}

static void warm_start_needs_no_step_at_the_solution(void **state) {
  (void)state;
  Problem p = problem(50, 2);
  LthSolveReport cold = solve(&p, 1e-8), warm = solve(&p, 1e-8);
  assert_true(cold.iterations > 3);
  assert_int_equal(warm.iterations, 0);
  assert_true(warm.converged);
  end(&p);
}

static void zero_load_gives_zero(void **state) {
  (void)state;
  Problem p = problem(20, 2);
  memset(p.b, 0, sizeof *p.b * (size_t)p.A->n);
  random_vector(p.A->n, 3, p.x);
  LthSolveReport report = solve(&p, 1e-8);
  assert_true(report.converged && report.iterations == 0);
  for (LitheCount i = 0; i < p.A->n; i++) assert_true(p.x[i] == 0);
  end(&p);
}

static void solves_allocate_nothing(void **state) {
  (void)state;
  Problem p = problem(50, 2);
  LitheCount before = lth_alloc_count(p.ctx);
  solve(&p, 1e-8);
  CHECK_OK(p.ctx, lth_block_jacobi_update(p.ctx, p.M, p.A, NULL));
  assert_int_equal(lth_alloc_count(p.ctx), before);
  end(&p);
}

static void tolerance_out_of_reach_is_told(void **state) {
  (void)state;
  Problem p = problem(50, 2);
  LthSolveReport report = solve(&p, 1e-30);
  assert_false(report.converged);
  CHECK_AT_MOST(report.residual, 1e-14);
  assert_true(report.iterations < 1000);
  end(&p);
}

static void block_jacobi_solves_a_block_diagonal_system(void **state) {
  (void)state;
  Problem p = problem(20, 2);
  for (LitheIndex i = 0; i < p.A->n_rows; i++)
    for (LitheCount e = p.A->block_off[i]; e < p.A->block_off[i + 1]; e++)
      if (p.A->block_col[e] != i)
        memset(p.A->values + p.A->value_off[e], 0,
               sizeof(double) * (size_t)(p.A->value_off[e + 1] - p.A->value_off[e]));
  LthSolveReport report = solve(&p, 1e-13);
  assert_true(report.converged);
  assert_int_equal(report.iterations, 1);
  end(&p);
}

static void extra_diagonal_is_added(void **state) {
  (void)state;
  Problem p = problem(8, 1);
  LitheCount size = 0;
  for (LitheIndex i = 0; i < p.A->n_rows; i++)
    size += (LitheCount)pow((double)(p.A->row_off[i + 1] - p.A->row_off[i]), 2);
  double *extra = calloc((size_t)size, sizeof *extra);
  LitheCount at = 0;
  for (LitheIndex i = 0; i < p.A->n_rows; i++) { // A's own block again: half the inverse
    LitheCount d = p.A->diagonal[i], n = p.A->value_off[d + 1] - p.A->value_off[d];
    memcpy(extra + at, p.A->values + p.A->value_off[d], sizeof *extra * (size_t)n);
    at += n;
  }
  LthOperator M = lth_block_jacobi_operator(p.M);
  M.apply(M.self, 1, p.b, p.x);
  CHECK_OK(p.ctx, lth_block_jacobi_update(p.ctx, p.M, p.A, extra));
  M.apply(M.self, 1, p.b, p.y);
  for (LitheCount i = 0; i < p.A->n; i++) CHECK_NEAR(2 * p.y[i], p.x[i], 1e-14 * fabs(p.x[i]));
  free(extra);
  end(&p);
}

static void indefinite_matrix_is_found_by_all(void **state) {
  (void)state;
  Problem p = problem(30, 2);
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  p.A->values[p.A->value_off[p.A->diagonal[4]]] = -1e3;
  assert_int_equal(lth_block_jacobi_update(p.ctx, p.M, p.A, NULL), LITHE_NOT_CONVERGED);
  assert_non_null(strstr(lithe_ctx_message(p.ctx), "element 4"));
  CHECK_OK(p.ctx, engine->analyse(p.ctx, p.A, &factor));
  assert_int_equal(engine->factorize(p.ctx, factor, p.A), LITHE_NOT_CONVERGED);
  engine->destroy(p.ctx, &factor);

  LthOperator A = lth_block_matrix_operator(p.A);
  memset(p.b, 0, sizeof *p.b * (size_t)p.A->n);
  p.b[p.A->row_off[4]] = 1;
  assert_false(lth_cg_solve(p.cg, 2, &A, NULL, p.b, p.x, 1e-8, 100).converged);
  end(&p);
}

static void stale_analysis_is_refused(void **state) {
  (void)state;
  Problem p = problem(30, 2);
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  CHECK_OK(p.ctx, engine->analyse(p.ctx, p.A, &factor));
  LthBlockMatrix *other = random_matrix(p.ctx, 30, mixed_sizes, 4, 21);
  assert_int_equal(engine->factorize(p.ctx, factor, other), LITHE_BAD_INPUT);
  lth_block_matrix_destroy(p.ctx, &other);
  engine->destroy(p.ctx, &factor);
  end(&p);
}

static void reduction_gives_the_same_solution_in_half_the_steps(void **state) {
  (void)state;
  Problem p = problem(120, 2);
  LthReduction *reduction = NULL;
  CHECK_OK(p.ctx, lth_reduction_create(p.ctx, p.A, p.M, &reduction));
  // couplings reach 1 and 7: both odd, a chessboard exists and is found
  assert_int_equal(lth_reduction_red(reduction), 60);
  LthSolveReport whole = solve(&p, 1e-10);
  LitheCount before = lth_alloc_count(p.ctx);
  double *x = calloc((size_t)p.A->n, sizeof *x);
  LthSolveReport half = lth_reduction_solve(reduction, p.cg, 2, p.b, x, 1e-10, 1000);
  assert_int_equal(lth_alloc_count(p.ctx), before);
  assert_true(half.converged);
  CHECK_AT_MOST(residual_of(&p, x), 1.01e-10);
  CHECK_NEAR(half.residual, residual_of(&p, x), 1e-14);
  assert_true(half.iterations <= (whole.iterations + 1) / 2 + 1);
  for (LitheCount i = 0; i < p.A->n; i++) CHECK_NEAR(x[i], p.x[i], 1e-9 * 0.5);
  for (int threads = 1; threads < 8; threads += 3) { // the same bits
    double *y = calloc((size_t)p.A->n, sizeof *y);
    lth_reduction_solve(reduction, p.cg, threads, p.b, y, 1e-10, 1000);
    assert_memory_equal(x, y, sizeof *x * (size_t)p.A->n);
    assert_int_equal(lth_reduction_solve(reduction, p.cg, threads, p.b, y, 1e-10, 1000).iterations,
                     0);
    free(y);
  }
  free(x);
  lth_reduction_destroy(p.ctx, &reduction);
  end(&p);
}

static void reduction_works_where_no_chessboard_exists(void **state) {
  (void)state;
  // a ring of three coupled blocks: one red, two black
  LitheCtx *ctx = test_ctx();
  static const LitheCount row_off[] = {0, 2, 4, 6}, block_off[] = {0, 3, 6, 9};
  static const LitheIndex block_col[] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
  LthBlockMatrix *A = NULL;
  LthBlockJacobi *M = NULL;
  LthReduction *reduction = NULL;
  LthCg *cg = NULL;
  CHECK_OK(ctx, lth_block_matrix_create(ctx, 3, row_off, block_off, block_col, &A));
  for (LitheCount e = 0; e < 9; e++)
    for (int k = 0; k < 4; k++)
      A->values[4 * e + k] = e % 4 == 0 ? (k % 3 == 0 ? 4 : 1) : (k % 3 == 0 ? -0.5 : 0);
  CHECK_OK(ctx, lth_block_jacobi_create(ctx, A, &M));
  CHECK_OK(ctx, lth_block_jacobi_update(ctx, M, A, NULL));
  CHECK_OK(ctx, lth_reduction_create(ctx, A, M, &reduction));
  CHECK_OK(ctx, lth_cg_create(ctx, A->n, &cg));
  assert_int_equal(lth_reduction_red(reduction), 1);
  double b[6] = {1, 2, 3, -1, 0, 5}, x[6] = {9, 9, 9, 9, 9, 9}, y[6] = {0};
  assert_true(lth_reduction_solve(reduction, cg, 1, b, x, 1e-14, 100).converged);
  lth_block_matrix_apply(A, 1, x, y);
  for (int i = 0; i < 6; i++) CHECK_NEAR(y[i], b[i], 1e-13);
  lth_cg_destroy(ctx, &cg);
  lth_reduction_destroy(ctx, &reduction);
  lth_block_jacobi_destroy(ctx, &M);
  lth_block_matrix_destroy(ctx, &A);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void dot_has_same_bits_and_value(void **state) {
  (void)state;
  enum { N = 100003 };
  double *x = malloc(sizeof *x * N), *y = malloc(sizeof *y * N);
  random_vector(N, 1, x);
  random_vector(N, 2, y);
  long double want = 0;
  for (int i = 0; i < N; i++) want += (long double)x[i] * y[i];
  double one = lth_dot(1, N, x, y);
  CHECK_NEAR(one, (double)want, 0x1p-53 * 2100 * 0.25 * 100);
  for (int threads = 2; threads < 9; threads++) assert_true(lth_dot(threads, N, x, y) == one);
  free(x), free(y);
}

typedef struct Failing {
  int left; // allocations that succeed
} Failing;

static void *allocate_some(void *user, size_t alignment, size_t bytes) {
  Failing *f = user;
  return f->left-- > 0 ? aligned_alloc(alignment, bytes) : NULL;
}

static void release_all(void *user, void *block) {
  (void)user;
  free(block);
}

static void every_failed_allocation_is_clean(void **state) {
  (void)state;
  static const LitheCount row_off[] = {0, 3, 6}, block_off[] = {0, 2, 4};
  static const LitheIndex block_col[] = {0, 1, 0, 1};
  bool failed = true;
  for (int k = 0; failed; k++) {
    Failing failing = {k};
    LitheCtxDef def = lithe_ctx_def_default();
    def.allocate = allocate_some, def.release = release_all, def.memory_user = &failing;
    LitheCtx *ctx = lithe_ctx_create(&def);
    LthBlockMatrix *A = NULL;
    LthBlockJacobi *M = NULL;
    LthReduction *reduction = NULL;
    LthCg *cg = NULL;
    LitheStatus status = lth_block_matrix_create(ctx, 2, row_off, block_off, block_col, &A);
    if (status == LITHE_OK) status = lth_block_jacobi_create(ctx, A, &M);
    if (status == LITHE_OK) status = lth_reduction_create(ctx, A, M, &reduction);
    if (status == LITHE_OK) status = lth_cg_create(ctx, A->n, &cg);
    failed = status != LITHE_OK;
    if (failed) assert_int_equal(status, LITHE_NO_MEMORY);
    lth_cg_destroy(ctx, &cg);
    lth_reduction_destroy(ctx, &reduction);
    lth_block_jacobi_destroy(ctx, &M);
    lth_block_matrix_destroy(ctx, &A);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gradients_and_cholesky_agree),
      cmocka_unit_test(same_bits_on_any_number_of_threads),
      cmocka_unit_test(warm_start_needs_no_step_at_the_solution),
      cmocka_unit_test(zero_load_gives_zero),
      cmocka_unit_test(solves_allocate_nothing),
      cmocka_unit_test(tolerance_out_of_reach_is_told),
      cmocka_unit_test(block_jacobi_solves_a_block_diagonal_system),
      cmocka_unit_test(extra_diagonal_is_added),
      cmocka_unit_test(indefinite_matrix_is_found_by_all),
      cmocka_unit_test(stale_analysis_is_refused),
      cmocka_unit_test(reduction_gives_the_same_solution_in_half_the_steps),
      cmocka_unit_test(reduction_works_where_no_chessboard_exists),
      cmocka_unit_test(every_failed_allocation_is_clean),
      cmocka_unit_test(dot_has_same_bits_and_value),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
