/// Matrix Market files read back as the matrix they were written from.
#include "random_matrix.h"

#include "io/matrix_market.h"

static void reads_back(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const int sizes[] = {3, 2};
  LthBlockMatrix *A = random_matrix(ctx, 9, sizes, 2, 2);
  double *dense = calloc((size_t)(A->n * A->n), sizeof *dense);
  CHECK_OK(ctx, lth_matrix_market_write(ctx, "test_matrix_market.mtx", A));
  FILE *file = fopen("test_matrix_market.mtx", "r");
  assert_non_null(file);
  long long rows, cols, entries, i, j;
  double v;
  assert_int_equal(fscanf(file, "%%%%MatrixMarket matrix coordinate real symmetric %lld %lld %lld",
                          &rows, &cols, &entries),
                   3);
  assert_int_equal(rows, A->n);
  for (long long k = 0; k < entries; k++) {
    assert_int_equal(fscanf(file, "%lld %lld %lf", &i, &j, &v), 3);
    assert_true(j <= i);
    dense[(i - 1) * A->n + j - 1] = dense[(j - 1) * A->n + i - 1] = v;
  }
  fclose(file);
  remove("test_matrix_market.mtx");
  double x[32] = {0}, y[32];
  random_vector(A->n, 9, x);
  lth_block_matrix_apply(A, 1, x, y);
  for (LitheCount r = 0; r < A->n; r++) {
    double sum = 0;
    for (LitheCount c = 0; c < A->n; c++) sum += dense[r * A->n + c] * x[c];
    CHECK_NEAR(sum, y[r], 1e-15 * 300 * (double)A->n);
  }
  free(dense);
  lth_block_matrix_destroy(ctx, &A);
  lithe_ctx_destroy(&ctx);
}

static void fails_without_folder(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const int sizes[] = {12, 30};
  LthBlockMatrix *A = random_matrix(ctx, 9, sizes, 2, 2);
  assert_int_equal(lth_matrix_market_write(ctx, "no/such/folder/K.mtx", A), LITHE_NO_SPACE);
  lth_block_matrix_destroy(ctx, &A);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_back),
      cmocka_unit_test(fails_without_folder),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
