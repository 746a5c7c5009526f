/// What algebraic levels are made of, against plain loops: products, coarse matrices, sweeps, aggregates.
#include "dg_body.h"

#include "la/ml_priv.h"

static void fill_random(LitheCount n, uint64_t seed, double *v) {
  for (LitheCount i = 0; i < n; i++) v[i] = test_random(&seed) - 0.5;
}

/// W += B Q for every number of rows and columns, B as it stands and transposed.
static void products_are_those_of_plain_loops(void **state) {
  (void)state;
  enum { MOST = 13 };
  double B[MOST * MOST], W[MOST * LTH_ML_PADDED], wanted[MOST * LTH_ML_PADDED];
  double Q[MOST * LTH_ML_PADDED];
  float P[MOST * LTH_ML_MODES];
  for (int columns = 1; columns <= LTH_ML_MODES; columns++)
    for (int m = 1; m <= MOST; m++)
      for (int n = 1; n <= MOST; n++)
        for (int turned = 0; turned < 2; turned++) {
          uint64_t seed = (uint64_t)(100 * m + n);
          fill_random(MOST * MOST, seed, B);
          fill_random(MOST * LTH_ML_PADDED, seed + 1, W);
          for (int i = 0; i < n * columns; i++) P[i] = (float)(test_random(&seed) - 0.5);
          memcpy(wanted, W, sizeof W);
          for (int r = 0; r < m; r++)
            for (int k = 0; k < n; k++)
              for (int c = 0; c < columns; c++)
                wanted[LTH_ML_PADDED * r + c] +=
                    (turned ? B[k * m + r] : B[r * n + k]) * (double)P[k * columns + c];
          lth_ml_pad(n, columns, P, Q);
          lth_ml_add_product(m, n, B, turned ? 1 : n, turned ? m : 1, Q, W);
          for (int i = 0; i < MOST * LTH_ML_PADDED; i++) CHECK_NEAR(W[i], wanted[i], 1e-14);
        }
}

/// A cube with levels of 12 and of 6 unknowns a row above the coarsest one.
typedef struct Levels {
  TestBody b;
  double *one;
  LthMultilevel *M;
} Levels;

static void levels_create(Levels *L) {
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {12, 12, 12}};
  L->b = test_body(TEST_HEXAHEDRA, grid, 1);
  test_assemble(&L->b, 0);
  L->one = lth_alloc(L->b.ctx, L->b.space->n_funcs, sizeof *L->one);
  for (LitheIndex c = 0; c < L->b.space->n_cells; c++) L->one[L->b.space->func_off[c]] = 1;
  LthMultilevelDef def = {.A = L->b.K, .one = L->one, .position = L->b.x0, .n_linear = 12};
  // springs, so that nothing is left without energy
  for (LitheIndex row = 0; row < L->b.K->n_rows; row++)
    for (int i = 0; i < 12; i++)
      L->b.K->values[L->b.K->value_off[L->b.K->diagonal[row]] + 13 * i] += 1;
  CHECK_OK(L->b.ctx, lth_multilevel_create(L->b.ctx, &def, &L->M));
  assert_true(L->M->n_levels >= 3);
  assert_int_equal(L->M->level[0].size, 12);
  assert_int_equal(L->M->level[1].size, 6);
}

static void levels_destroy(Levels *L) {
  lth_multilevel_destroy(L->b.ctx, &L->M);
  lth_free(L->b.ctx, L->one);
  test_body_free(&L->b);
}

static void coarse_matrices_are_those_of_the_prolongation(void **state) {
  (void)state;
  Levels L;
  levels_create(&L);
  for (int l = 0; l + 1 < L.M->n_levels; l++) {
    const LthLevel *fine = &L.M->level[l], *coarse = fine + 1;
    const LitheCount n = fine->A->n, m = coarse->A->n;
    double *e = calloc((size_t)m, sizeof *e), *y = calloc((size_t)m, sizeof *y),
           *z = calloc((size_t)m, sizeof *z), *x = calloc((size_t)n, sizeof *x),
           *r = calloc((size_t)n, sizeof *r);
    fill_random(m, 5, e);
    lth_ml_prolong(fine->P, 1, e, x);
    lth_block_matrix_apply(fine->A, 1, x, r);
    lth_ml_restrict(fine->P, 1, r, y);
    lth_block_matrix_apply(coarse->A, 1, e, z);
    const double size = sqrt(lth_dot(1, m, y, y) / (double)m);
    for (LitheCount i = 0; i < m; i++) CHECK_NEAR(z[i], y[i], 1e-11 * size);
    free(e), free(y), free(z), free(x), free(r);
  }
  levels_destroy(&L);
}

static void residuals_of_sweeps_are_those_of_the_matrix(void **state) {
  (void)state;
  Levels L;
  levels_create(&L);
  for (int l = 0; l + 1 < L.M->n_levels; l++) {
    const LthLevel *level = &L.M->level[l];
    const LitheCount n = level->A->n;
    double *b = calloc((size_t)n, sizeof *b), *x = calloc((size_t)n, sizeof *x),
           *r = calloc((size_t)n, sizeof *r), *y = calloc((size_t)n, sizeof *y);
    fill_random(n, 6, b);
    lth_ml_smooth_down(level, 1, b, x, r);
    lth_block_matrix_apply(level->A, 1, x, y);
    for (LitheCount i = 0; i < n; i++) CHECK_NEAR(r[i], b[i] - y[i], 1e-12);
    free(b), free(x), free(r), free(y);
  }
  levels_destroy(&L);
}

/// Unknowns in other units, by powers of two, so that nothing is rounded.
static void aggregates_do_not_depend_on_the_scale_of_rows(void **state) {
  (void)state;
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {6, 5, 4}};
  TestBody b = test_body(TEST_HEXAHEDRA, grid, 1);
  test_assemble(&b, 0);
  const LthBlockMatrix *K = b.K;
  LitheIndex *own = calloc((size_t)K->n_rows, sizeof *own), n_own = 0;
  LitheIndex *scaled = calloc((size_t)K->n_rows, sizeof *scaled), n_scaled = 0;
  CHECK_OK(b.ctx, lth_ml_aggregate(b.ctx, K, 0, own, &n_own));
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      for (LitheCount i = K->value_off[e]; i < K->value_off[e + 1]; i++)
        K->values[i] = ldexp(K->values[i], row % 5 + K->block_col[e] % 5);
  CHECK_OK(b.ctx, lth_ml_aggregate(b.ctx, K, 0, scaled, &n_scaled));
  assert_int_equal(n_scaled, n_own);
  assert_memory_equal(scaled, own, sizeof *own * (size_t)K->n_rows);
  free(own), free(scaled);
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(products_are_those_of_plain_loops),
      cmocka_unit_test(coarse_matrices_are_those_of_the_prolongation),
      cmocka_unit_test(residuals_of_sweeps_are_those_of_the_matrix),
      cmocka_unit_test(aggregates_do_not_depend_on_the_scale_of_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
