/// Points that touch: a pressure on them is carried as the elements carry it.
#include "cg_body.h"

/// Force on every node by a unit pressure along x, y and z on the whole boundary: as the points carry it.
static void carry(const CgBody *b, const LthTouchPoints *t, double *f) {
  memset(f, 0, sizeof *f * (size_t)b->disc->n_funcs);
  for (LitheIndex p = 0; p < t->n; p++) {
    LitheIndex func[LTH_DISC_MAX_FUNCS];
    double phi[3 * LTH_DISC_MAX_FUNCS];
    int n = b->disc->table->eval(b->disc, t->cells[p], t->points + 3 * p, func, phi);
    for (int i = 0; i < n; i++) f[func[i]] += t->area[p] * phi[3 * i];
  }
}

static const LthElementKind quadratic[] = {LTH_TET10,   LTH_HEX20,   LTH_HEX27,
                                           LTH_WEDGE15, LTH_WEDGE18, LTH_PYRAMID14};

static void uniform_pressure_is_carried_as_by_the_elements(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof quadratic / sizeof quadratic[0]; k++) {
    CgBody b = cg_body(quadratic[k], 2, 0.15);
    cg_build(&b);
    LthLoad load = {.kind = LTH_LOAD_TRACTION, .patches = cg_select(&b, 0, NULL, NULL)};
    load.value[0] = lth_value_constant(1);
    memset(b.f, 0, sizeof *b.f * (size_t)b.disc->n_dofs);
    CHECK_OK(b.ctx, b.disc->table->add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
    LthTouchPoints t;
    assert_true(lth_cg_touches_by_faces(b.disc));
    CHECK_OK(b.ctx, lth_cg_touch_points(b.ctx, b.disc, &t));
    carry(&b, &t, b.r);
    for (LitheIndex i = 0; i < b.disc->n_funcs; i++) CHECK_NEAR(b.r[i], b.f[3 * i], 1e-12);
    for (LitheIndex p = 0; p < t.n; p++) assert_true(t.area[p] > 0);
    lth_touch_points_free(b.ctx, &t);
    cg_free(&b);
  }
}

static void neighbouring_faces_share_their_points(void **state) {
  (void)state;
  CgBody b = cg_body(LTH_HEX27, 2, 0);
  cg_build(&b);
  LthTouchPoints t;
  double whole = 0;
  CHECK_OK(b.ctx, lth_cg_touch_points(b.ctx, b.disc, &t));
  // a lattice of 5^3 places less the 3^3 inside
  assert_int_equal(t.n, 125 - 27);
  for (LitheIndex p = 0; p < t.n; p++) whole += t.area[p];
  CHECK_NEAR(whole, 6, 1e-12);
  lth_touch_points_free(b.ctx, &t);
  cg_free(&b);
}

static void linear_elements_touch_at_their_corners(void **state) {
  (void)state;
  CgBody b = cg_body(LTH_HEX8, 2, 0);
  cg_build(&b);
  LthTouchPoints t;
  assert_false(lth_cg_touches_by_faces(b.disc));
  CHECK_OK(b.ctx, lth_cg_touch_points(b.ctx, b.disc, &t));
  assert_int_equal(t.n, 26);
  double whole = 0;
  for (LitheIndex p = 0; p < t.n; p++) whole += t.area[p];
  CHECK_NEAR(whole, 6, 1e-12);
  lth_touch_points_free(b.ctx, &t);
  cg_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(uniform_pressure_is_carried_as_by_the_elements),
      cmocka_unit_test(neighbouring_faces_share_their_points),
      cmocka_unit_test(linear_elements_touch_at_their_corners),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
