/// Volume fractions: one lattice for all control volumes, margins, volumes, threads.
#include "ctx_fixture.h"

#include "base/tensor.h"
#include "geometry/fractions.h"
#include "geometry/fractions_fill.h"

#include <string.h>

static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.03, -0.02, 0.05}, .radius = 0.7};
static const double origin[3] = {-1, -0.9, -0.95}, h[3] = {0.1, 0.09, 0.095};
static const LitheIndex n[3] = {20, 20, 20};
static const LthFractionDef by_samples = {.method = LTH_FRACTIONS_SAMPLES, .samples = 4};

static LthFractions *create(LitheCtx *ctx, const LthShape *shape, int dim,
                            const LthFractionDef *def) {
  LthFractions *f = NULL;
  CHECK_OK(ctx, lth_fractions_create(ctx, shape, dim, origin, h, n, def, &f));
  return f;
}

/// Mean over a part by the two samples an axis of the lattice that lie in it, asked one by one.
static double sampled_mean(const LthShape *shape, int dim, const double center[3]) {
  int count = 0, n_samples = 1 << dim;
  for (int i = 0; i < n_samples; i++) {
    double x[3] = {0, 0, 0};
    for (int a = 0; a < dim; a++) x[a] = center[a] + h[a] * (i >> a & 1 ? 0.125 : -0.125);
    count += lth_shape_value(shape, x) <= 0;
  }
  return (double)count / n_samples;
}

static void every_part_is_the_mean_of_its_own_samples(void **state) {
  Fixture *x = *state;
  for (int dim = 2; dim <= 3; dim++) {
    LthFractions *f = create(x->ctx, &ball, dim, &by_samples);
    const LthSparseGrid *g = f->grid;
    for (LitheCount slot = 0; slot < g->n_slots; slot++) {
      LitheIndex cell[3];
      double center[3], sum = 0;
      lth_sparse_grid_cell(g, slot, cell);
      for (int q = 0; q < f->n_parts; q++) {
        double offset[3] = {0, 0, 0};
        for (int a = 0; a < dim; a++) offset[a] = q >> a & 1 ? 0.75 : 0.25;
        lth_sparse_grid_place(g, cell, offset, center);
        CHECK_NEAR(lth_fractions_part(f, slot, q), sampled_mean(&ball, dim, center), 1e-14);
        sum += lth_fractions_part(f, slot, q);
      }
      CHECK_NEAR(lth_fractions_cell(f, slot), sum / f->n_parts, 1e-14);
    }
    lth_fractions_destroy(x->ctx, &f);
  }
}

static void all_that_is_inside_is_in_a_block_with_all_its_neighbours(void **state) {
  Fixture *x = *state;
  LthShape block = {.kind = LTH_SHAPE_BOX, .a = {-1, -0.9, -0.95}, .b = {1, 0.9, 0.95}};
  for (int dim = 2; dim <= 3; dim++)
    for (int full = 0; full < 2; full++) {
      LthFractions *f = create(x->ctx, full ? &block : &ball, dim, &by_samples);
      const LthSparseGrid *g = f->grid;
      LitheCount held = 0;
      for (LitheCount slot = 0; slot < g->n_slots; slot++) {
        if (f->cell[slot] == LTH_CELL_EMPTY) continue;
        held++;
        for (int q = 0; q < (dim == 3 ? 27 : 9); q++)
          assert_true(lth_sparse_grid_step(
                          g, slot, (int[3]){q % 3 - 1, q / 3 % 3 - 1, dim == 3 ? q / 9 - 1 : 0}) >=
                      0);
      }
      if (full) {
        assert_int_equal(held, dim == 3 ? 8000 : 400);
        CHECK_NEAR(f->volume, dim == 3 ? 2 * 1.8 * 1.9 : 2 * 1.8, 1e-13);
        assert_true(f->grid->origin[0] < -1 - h[0] + 1e-12);
        assert_true(f->grid->n[0] * h[0] + f->grid->origin[0] > 1 + h[0] - 1e-12);
      }
      lth_fractions_destroy(x->ctx, &f);
    }
}

static void what_lies_beyond_the_grid_is_cut_off(void **state) {
  Fixture *x = *state;
  LthShape large = {.kind = LTH_SHAPE_BOX, .a = {-5, -0.45, -5}, .b = {5, 5, 5}};
  LthFractions *f = create(x->ctx, &large, 3, &by_samples);
  CHECK_NEAR(f->volume, 2 * 1.35 * 1.9, 1e-13);
  lth_fractions_destroy(x->ctx, &f);
}

static void a_shape_beside_the_grid_is_refused(void **state) {
  Fixture *x = *state;
  LthShape far = {.kind = LTH_SHAPE_SPHERE, .a = {9, 9, 9}, .radius = 1};
  LthFractions *f = NULL;
  assert_int_equal(lth_fractions_create(x->ctx, &far, 3, origin, h, n, &by_samples, &f),
                   LITHE_BAD_INPUT);
  assert_null(f);
  assert_non_null(strstr(lithe_ctx_message(x->ctx), "beside"));
}

static void odd_numbers_of_samples_are_refused(void **state) {
  Fixture *x = *state;
  LthFractionDef odd = {.method = LTH_FRACTIONS_SAMPLES, .samples = 5};
  LthFractions *f = NULL;
  assert_int_equal(lth_fractions_create(x->ctx, &ball, 3, origin, h, n, &odd, &f), LITHE_BAD_INPUT);
}

/// The value at the middle of a part, made linear.
static double linear_part(const void *self, const double low[3], const double size[3]) {
  (void)self;
  return 0.5 + 0.1 * (low[0] + 0.5 * size[0]) + 0.2 * (low[1] + 0.5 * size[1]);
}

static void functions_give_their_own_parts(void **state) {
  Fixture *x = *state;
  LthFractions *f = NULL;
  CHECK_OK(x->ctx, lth_fractions_from(x->ctx, 2, origin, h, n, linear_part, NULL, &f));
  LitheCount slot = lth_sparse_grid_slot(f->grid, f->grid->n[0] / 2, f->grid->n[1] / 2, 0);
  LitheIndex cell[3];
  double low[3];
  lth_sparse_grid_cell(f->grid, slot, cell);
  lth_sparse_grid_place(f->grid, cell, (double[3]){0.5, 0, 0}, low);
  CHECK_NEAR(lth_fractions_part(f, slot, 1),
             0.5 + 0.1 * (low[0] + h[0] / 4) + 0.2 * (low[1] + h[1] / 4), 1e-14);
  lth_fractions_destroy(x->ctx, &f);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

/// (1 - s - sin(pi s) / pi) / 2: what is left of a smooth bump of width 1 beyond s, by docs/theory/fractions.md.
static void profile_falls_without_a_kink(void **state) {
  (void)state;
  CHECK_NEAR(lth_fraction_profile(0.5), 0.25 - 0.5 / M_PI, 1e-15);
  CHECK_NEAR(lth_fraction_profile(-1. / 6), 7. / 12 + 0.25 / M_PI, 1e-15);
  for (double s = -1; s <= 1; s += 0.125)
    CHECK_NEAR(lth_fraction_profile(s) + lth_fraction_profile(-s), 1, 1e-15);
  // slope and curvature end at zero: beyond it starts with the cube, pi^2 / 12 d^3
  const double d = 1e-3;
  CHECK_NEAR(lth_fraction_profile(1 - d) / (d * d * d), M_PI * M_PI / 12, 1e-5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(profile_falls_without_a_kink),
      TEST(every_part_is_the_mean_of_its_own_samples),
      TEST(all_that_is_inside_is_in_a_block_with_all_its_neighbours),
      TEST(what_lies_beyond_the_grid_is_cut_off),
      TEST(a_shape_beside_the_grid_is_refused),
      TEST(odd_numbers_of_samples_are_refused),
      TEST(functions_give_their_own_parts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
