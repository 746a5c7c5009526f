/// Pattern, product, lookup and condition of block matrices.
#include "random_matrix.h"

#include "la/krylov.h"

static const int mixed_sizes[] = {12, 30, 60, 105};

/// The product as the definition says it.
static void apply_ref(const LthBlockMatrix *A, const double *x, double *y) {
  for (LitheIndex i = 0; i < A->n_rows; i++)
    for (LitheCount r = A->row_off[i]; r < A->row_off[i + 1]; r++) {
      y[r] = 0;
      for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++) {
        LitheIndex j = A->block_col[e];
        LitheCount n = A->row_off[j + 1] - A->row_off[j];
        for (LitheCount c = 0; c < n; c++)
          y[r] += A->values[A->value_off[e] + (r - A->row_off[i]) * n + c] * x[A->row_off[j] + c];
      }
    }
}

static void product_equals_reference_for_all_block_sizes(void **state) {
  (void)state;
  static const int cases[][4] = {
      {12, 12, 12, 12}, {3, 3, 3, 3}, {12, 30, 60, 105}, {1, 2, 3, 5}, {7, 4, 10, 11}};
  LitheCtx *ctx = test_ctx();
  for (int k = 0; k < 5; k++) {
    LthBlockMatrix *A = random_matrix(ctx, 40, cases[k], 4, 7 + (uint64_t)k);
    double *x = calloc((size_t)A->n, sizeof *x), *y = calloc((size_t)A->n, sizeof *y);
    double *want = calloc((size_t)A->n, sizeof *want);
    random_vector(A->n, 3, x);
    lth_block_matrix_apply(A, 2, x, y);
    apply_ref(A, x, want);
    // sums of at most 525 terms below 66 in size: 525 eps * sum
    for (LitheCount i = 0; i < A->n; i++) CHECK_NEAR(y[i], want[i], 525 * 0x1p-53 * 200);
    free(x), free(y), free(want);
    lth_block_matrix_destroy(ctx, &A);
  }
  lithe_ctx_destroy(&ctx);
}

static void product_has_same_bits_on_any_number_of_threads(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthBlockMatrix *A = random_matrix(ctx, 60, mixed_sizes, 4, 11);
  size_t bytes = sizeof(double) * (size_t)A->n;
  double *x = malloc(bytes), *one = malloc(bytes), *more = malloc(bytes);
  random_vector(A->n, 5, x);
  lth_block_matrix_apply(A, 1, x, one);
  for (int threads = 2; threads <= 7; threads++) {
    lth_block_matrix_apply(A, threads, x, more);
    assert_memory_equal(one, more, bytes);
  }
  free(x), free(one), free(more);
  lth_block_matrix_destroy(ctx, &A);
  lithe_ctx_destroy(&ctx);
}

static void find_gives_every_block_and_no_other(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthBlockMatrix *A = random_matrix(ctx, 20, mixed_sizes, 1, 1);
  for (LitheIndex i = 0; i < 20; i++)
    for (LitheIndex j = 0; j < 20; j++) {
      LitheIndex d = j - i;
      LitheCount e = lth_block_matrix_find(A, i, j);
      assert_true((e >= 0) == (d == 0 || d == 1 || d == -1 || d == 7 || d == -7));
      if (e >= 0) assert_int_equal(A->block_col[e], j);
      if (d == 0) assert_int_equal(e, A->diagonal[i]);
    }
  lth_block_matrix_destroy(ctx, &A);
  lithe_ctx_destroy(&ctx);
}

static void rejects_pattern_without_diagonal_or_order(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthBlockMatrix *A = NULL;
  static const LitheCount row_off[] = {0, 2, 4}, block_off[] = {0, 2, 4};
  static const LitheIndex descends[] = {1, 0, 0, 1}, no_diagonal[] = {0, 1, 0, 2};
  assert_int_equal(lth_block_matrix_create(ctx, 2, row_off, block_off, descends, &A),
                   LITHE_BAD_INPUT);
  assert_null(A);
  assert_int_equal(lth_block_matrix_create(ctx, 2, row_off, block_off, no_diagonal, &A),
                   LITHE_BAD_INPUT);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void asymmetry_is_found(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthBlockMatrix *A = random_matrix(ctx, 30, mixed_sizes, 2, 4);
  assert_true(lth_block_matrix_asymmetry(A) == 0);
  double largest = 0;
  for (LitheCount i = 0; i < A->value_off[A->block_off[A->n_rows]]; i++)
    largest = fmax(largest, fabs(A->values[i]));
  A->values[A->value_off[lth_block_matrix_find(A, 3, 10)] + 5] += 1e-3 * largest;
  CHECK_NEAR(lth_block_matrix_asymmetry(A), 1e-3, 1e-12);
  lth_block_matrix_destroy(ctx, &A);
  lithe_ctx_destroy(&ctx);
}

/// Chain of n unknowns in blocks of 4: 2 on the diagonal, -1 beside it.
static LthBlockMatrix *laplace_chain(LitheCtx *ctx, LitheIndex n_rows) {
  static const int four = 4;
  LthBlockMatrix *A = random_matrix(ctx, n_rows, &four, 1, 1);
  for (LitheIndex i = 0; i < n_rows; i++)
    for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++)
      for (LitheCount r = 0; r < 4; r++)
        for (LitheCount c = 0; c < 4; c++) {
          LitheCount distance = llabs(4 * i + r - 4 * A->block_col[e] - c);
          A->values[A->value_off[e] + 4 * r + c] = distance == 0 ? 2 : distance == 1 ? -1 : 0;
        }
  return A;
}

static void condition_of_a_chain_is_known(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const LitheIndex rows[] = {20, 800}; // dense eigenvalues, Lanczos
  for (int k = 0; k < 2; k++) {
    LthBlockMatrix *A = laplace_chain(ctx, rows[k]);
    double condition, half = 0.5 * 3.14159265358979323846 / (double)(A->n + 1);
    CHECK_OK(ctx, lth_block_matrix_condition(ctx, A, &condition));
    double want = pow(cos(half) / sin(half), 2);
    CHECK_NEAR(condition / want, 1, k == 0 ? 1e-10 : 1e-3);
    lth_block_matrix_destroy(ctx, &A);
  }
  lithe_ctx_destroy(&ctx);
}

static void condition_of_indefinite_matrix_is_refused(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const LitheIndex rows[] = {20, 800};
  for (int k = 0; k < 2; k++) {
    LthBlockMatrix *A = laplace_chain(ctx, rows[k]);
    A->values[A->value_off[A->diagonal[5]]] = -2;
    double condition;
    assert_int_equal(lth_block_matrix_condition(ctx, A, &condition), LITHE_BAD_INPUT);
    lth_block_matrix_destroy(ctx, &A);
  }
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(product_equals_reference_for_all_block_sizes),
      cmocka_unit_test(product_has_same_bits_on_any_number_of_threads),
      cmocka_unit_test(find_gives_every_block_and_no_other),
      cmocka_unit_test(rejects_pattern_without_diagonal_or_order),
      cmocka_unit_test(asymmetry_is_found),
      cmocka_unit_test(condition_of_a_chain_is_known),
      cmocka_unit_test(condition_of_indefinite_matrix_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
