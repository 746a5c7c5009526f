/// Sparse grids: cells and slots are each other's inverse, steps cross blocks, what is not there is -1.
#include "check.h"

#include "geometry/sparse_grid.h"

static const double origin[3] = {1, 2, 3}, h[3] = {0.5, 0.25, 0.125};

static void every_slot_is_the_slot_of_its_cell(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int dim = 2; dim <= 3; dim++) {
    LthSparseGrid *g = NULL;
    CHECK_OK(ctx,
             lth_sparse_grid_create(ctx, dim, origin, h, (LitheIndex[3]){37, 20, 9}, NULL, &g));
    assert_int_equal(g->n_blocks, dim == 3 ? 5 * 3 * 2 : 3 * 2);
    assert_int_equal(g->n_slots, (LitheCount)g->n_blocks * (dim == 3 ? 512 : 256));
    for (LitheCount slot = 0; slot < g->n_slots; slot++) {
      LitheIndex c[3];
      lth_sparse_grid_cell(g, slot, c);
      assert_int_equal(lth_sparse_grid_slot(g, c[0], c[1], c[2]), slot);
    }
    assert_int_equal(lth_sparse_grid_slot(g, -1, 0, 0), -1);
    assert_int_equal(lth_sparse_grid_slot(g, 0, 0, dim == 3 ? 16 : 1), -1);
    lth_sparse_grid_destroy(ctx, &g);
  }
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Only blocks with an even sum of places are there.
static void blocks_that_are_not_wanted_have_no_slots(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSparseGrid *g = NULL;
  uint8_t wanted[27];
  for (int b = 0; b < 27; b++) wanted[b] = (b % 3 + b / 3 % 3 + b / 9) % 2 == 0;
  CHECK_OK(ctx, lth_sparse_grid_create(ctx, 3, origin, h, (LitheIndex[3]){24, 24, 24}, wanted, &g));
  assert_int_equal(g->n_blocks, 14);
  for (LitheIndex c = 0; c < 24 * 24 * 24; c++) {
    LitheIndex at[3] = {c % 24, c / 24 % 24, c / 576};
    LitheCount slot = lth_sparse_grid_slot(g, at[0], at[1], at[2]);
    assert_int_equal(slot >= 0, wanted[at[0] / 8 + 3 * (at[1] / 8) + 9 * (at[2] / 8)]);
    if (slot < 0) continue;
    for (int q = 0; q < 27; q++) {
      int d[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 - 1};
      assert_int_equal(lth_sparse_grid_step(g, slot, d),
                       lth_sparse_grid_slot(g, at[0] + d[0], at[1] + d[1], at[2] + d[2]));
    }
  }
  lth_sparse_grid_destroy(ctx, &g);
  lithe_ctx_destroy(&ctx);
}

static void neighbour_blocks_are_numbered_as_said(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSparseGrid *g = NULL;
  CHECK_OK(ctx, lth_sparse_grid_create(ctx, 3, origin, h, (LitheIndex[3]){24, 24, 24}, NULL, &g));
  for (int q = 0; q < 27; q++) {
    int d[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 - 1};
    assert_int_equal(g->neighbor[13 * 27 + q], 13 + d[0] + 3 * d[1] + 9 * d[2]);
    assert_int_equal(g->neighbor[q] >= 0, d[0] >= 0 && d[1] >= 0 && d[2] >= 0);
  }
  lth_sparse_grid_destroy(ctx, &g);
  lithe_ctx_destroy(&ctx);
}

static void places_are_those_of_the_plane_in_2d(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSparseGrid *g = NULL;
  double x[3];
  CHECK_OK(ctx, lth_sparse_grid_create(ctx, 2, origin, h, (LitheIndex[3]){24, 24, 24}, NULL, &g));
  lth_sparse_grid_place(g, (LitheIndex[3]){3, 5, 0}, (double[3]){0.5, 0, 0.5}, x);
  CHECK_NEAR(x[0], 2.75, 1e-15);
  CHECK_NEAR(x[1], 3.25, 1e-15);
  CHECK_NEAR(x[2], 0, 1e-15);
  CHECK_NEAR(lth_sparse_grid_cell_volume(g), 0.125, 1e-16);
  lth_sparse_grid_destroy(ctx, &g);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_slot_is_the_slot_of_its_cell),
      cmocka_unit_test(blocks_that_are_not_wanted_have_no_slots),
      cmocka_unit_test(neighbour_blocks_are_numbered_as_said),
      cmocka_unit_test(places_are_those_of_the_plane_in_2d),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
