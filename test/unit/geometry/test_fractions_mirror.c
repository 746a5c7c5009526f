/// Smooth fractions of parts of solids at planes of symmetry: those of the whole solids.
#include "check.h"

#include "geometry/fractions_mirror.h"

#define W 0.06 // 1.2 cells

static const double h[3] = {0.05, 0.05, 0.05}, origin[3] = {-1, -1, -1};
static const LitheIndex n[3] = {40, 40, 40};
static const LthFractionDef smooth = {.method = LTH_FRACTIONS_SMOOTH};

static bool anywhere(const void *self, const double x[3]) {
  (void)self, (void)x;
  return true;
}

static LthFractions *create(LitheCtx *ctx, const LthShape *shape, int dim) {
  LthFractions *f = NULL;
  CHECK_OK(ctx, lth_fractions_create(ctx, shape, dim, origin, h, n, &smooth, &f));
  return f;
}

static LthFractions *create_mirrored(LitheCtx *ctx, const LthShape *shape, int dim, double place) {
  LthMirror mirror[3];
  LthFractions *f = create(ctx, shape, dim);
  for (int a = 0; a < dim; a++)
    mirror[a] = (LthMirror){.axis = a, .sign = -1, .place = place, .contains = anywhere};
  CHECK_OK(ctx, lth_fractions_mirror(ctx, f, shape, &smooth, mirror, dim));
  return f;
}

/// Largest difference of parts behind the planes, and largest part beyond any.
static void compare(const LthFractions *f, const LthFractions *whole, double place,
                    double *difference, double *beyond) {
  *difference = *beyond = 0;
  for (LitheCount slot = 0; slot < whole->grid->n_slots; slot++) {
    LitheIndex at[3];
    double x[3];
    lth_sparse_grid_cell(whole->grid, slot, at);
    for (int q = 0; q < f->n_parts; q++) {
      double offset[3];
      bool is_behind = true;
      for (int a = 0; a < 3; a++) offset[a] = q >> a & 1 ? 0.75 : 0.25;
      lth_sparse_grid_place(whole->grid, at, offset, x);
      LitheIndex cell[3] = {0};
      for (int a = 0; a < f->grid->dim; a++) {
        is_behind = is_behind && x[a] > place;
        cell[a] = (LitheIndex)floor((x[a] - f->grid->origin[a]) / h[a]);
      }
      LitheCount own = lth_sparse_grid_slot(f->grid, cell[0], cell[1], cell[2]);
      double v = own < 0 ? 0 : lth_fractions_part(f, own, q);
      if (is_behind)
        *difference = fmax(*difference, fabs(v - lth_fractions_part(whole, slot, q)));
      else
        *beyond = fmax(*beyond, v);
    }
  }
}

static void a_quarter_of_a_ring_has_the_rings_fractions(void **state) {
  LthShape children[2] = {{.kind = LTH_SHAPE_ANNULUS, .radius = 0.8, .inner = 0.325},
                          {.kind = LTH_SHAPE_BOX, .b = {0.8, 0.8, 1}}};
  children[1].a[2] = -1;
  LthShape quarter = {.kind = LTH_SHAPE_INTERSECTION, .children = children, .n_children = 2};
  LitheCtx *ctx = test_ctx();
  double difference, beyond;
  (void)state;
  LthFractions *whole = create(ctx, &children[0], 2), *f = create_mirrored(ctx, &quarter, 2, 0);
  compare(f, whole, 0, &difference, &beyond);
  // a distance sqrt(y^2 + t^2) - r, continued from t = W and 1.5 W by what is even: the rest is t^4 / (8 r^3)
  assert_true(difference < 2.25 * W * W * W / (8 * 0.325 * 0.325 * 0.325) + 1e-12);
  assert_true(beyond == 0);
  CHECK_NEAR(f->volume, whole->volume / 4, 1e-5);
  lth_fractions_destroy(ctx, &f);
  lth_fractions_destroy(ctx, &whole);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void an_eighth_of_a_cube_has_the_cubes_fractions(void **state) {
  LthShape eighth = {.kind = LTH_SHAPE_BOX, .b = {0.7, 0.7, 0.7}}, cube = eighth;
  LitheCtx *ctx = test_ctx();
  double difference, beyond;
  (void)state;
  for (int a = 0; a < 3; a++) cube.a[a] = -0.7;
  LthFractions *whole = create(ctx, &cube, 3), *f = create_mirrored(ctx, &eighth, 3, 0);
  compare(f, whole, 0, &difference, &beyond);
  assert_true(difference < 1e-12);
  assert_true(beyond == 0);
  lth_fractions_destroy(ctx, &f);
  lth_fractions_destroy(ctx, &whole);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// A plane inside of parts: they have the share that is behind it.
static void a_plane_through_parts_divides_them(void **state) {
  const double place = 0.01;
  LthShape strip = {.kind = LTH_SHAPE_BOX, .a = {0.01, 0.01, -1}, .b = {0.61, 0.61, 1}};
  LitheCtx *ctx = test_ctx();
  (void)state;
  LthFractions *f = create_mirrored(ctx, &strip, 2, place);
  double corner = (f->volume - 0.6 * 0.6) / (W * W);
  // straight sides keep their place; what is left is the free corner: 0.1167 by integration, sums over parts see 0.127
  CHECK_NEAR(corner, 0.1167, 0.02);
  lth_fractions_destroy(ctx, &f);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_quarter_of_a_ring_has_the_rings_fractions),
      cmocka_unit_test(an_eighth_of_a_cube_has_the_cubes_fractions),
      cmocka_unit_test(a_plane_through_parts_divides_them),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
