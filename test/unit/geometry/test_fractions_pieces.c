/// Connected pieces of solids on a grid.
#include "check.h"

#include "geometry/fractions_pieces.h"

typedef struct Fixture {
  LitheCtx *ctx;
} Fixture;

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  *state = f;
  return 0;
}

static int teardown(void **state) {
  Fixture *f = *state;
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f);
  return leaked;
}

static const double origin[3] = {-1, -1, -1}, h[3] = {0.1, 0.1, 0.1};
static const LitheIndex n[3] = {20, 20, 20};

/// A large ball and a small box, with a cell of air between them, and a shell around nothing.
static LthFractions *create(LitheCtx *ctx, LthFractionMethod method) {
  LthShape three[] = {
      {.kind = LTH_SHAPE_SPHERE, .a = {-0.3, -0.3, 0}, .radius = 0.52},
      {.kind = LTH_SHAPE_BOX, .a = {0.51, 0.5, -0.22}, .b = {0.8, 0.9, 0.33}},
      {.kind = LTH_SHAPE_SHELL, .a = {0.5, -0.4, 0.7}, .radius = 0.25, .inner = 0.1}};
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = three, .n_children = 3};
  LthFractionDef def = {.method = method, .samples = 4};
  LthFractions *f = NULL;
  CHECK_OK(ctx, lth_fractions_create(ctx, &tree, 3, origin, h, n, &def, &f));
  return f;
}

static const double box_volume = 0.29 * 0.4 * 0.55,
                    shell_volume = 4 * M_PI / 3 * (0.015625 - 0.001);

static void pieces_have_their_own_volumes_and_boxes(void **state) {
  Fixture *x = *state;
  LthFractions *f = create(x->ctx, LTH_FRACTIONS_EXACT);
  LthPieces *p = NULL;
  CHECK_OK(x->ctx, lth_pieces_create(x->ctx, f, 0, &p));
  assert_int_equal(p->n, 3);
  double sum = 0;
  LitheCount cells = 0, held = 0;
  for (LitheIndex i = 0; i < 3; i++) {
    sum += p->volume[i];
    cells += p->cells[i];
    if (p->box[6 * i] > 0.45) { // the box
      CHECK_NEAR(p->volume[i], box_volume, 1e-12);
      CHECK_NEAR(p->box[6 * i], 0.5, 1e-12);
      CHECK_NEAR(p->box[6 * i + 4], 0.9, 1e-12);
      CHECK_NEAR(p->box[6 * i + 5], 0.4, 1e-12);
      assert_int_equal(p->cells[i], 3 * 4 * 7);
    } else if (p->box[6 * i] > 0) {
      CHECK_NEAR(p->volume[i], shell_volume, 1e-9);
    }
  }
  for (LitheCount s = 0; s < f->grid->n_slots; s++) held += f->cell[s] != LTH_CELL_EMPTY;
  CHECK_NEAR(sum, f->volume, 1e-13);
  assert_int_equal(cells, held);
  lth_pieces_destroy(x->ctx, &p);
  lth_fractions_destroy(x->ctx, &f);
}

static void dropped_pieces_leave_the_others_as_they_were(void **state) {
  Fixture *x = *state;
  LthFractions *f = create(x->ctx, LTH_FRACTIONS_EXACT),
               *whole = create(x->ctx, LTH_FRACTIONS_EXACT);
  LthPieces *p = NULL, *left = NULL;
  bool keep[3];
  CHECK_OK(x->ctx, lth_pieces_create(x->ctx, f, 1e-3, &p));
  assert_int_equal(p->n, 3);
  LitheIndex dropped = 0;
  for (LitheIndex i = 0; i < 3; i++) {
    keep[i] = p->box[6 * i] < 0.45;
    if (!keep[i]) dropped = i;
  }
  CHECK_OK(x->ctx, lth_pieces_keep(x->ctx, p, keep, f));
  for (LitheCount s = 0; s < f->grid->n_slots; s++)
    for (int q = 0; q < 8; q++)
      assert_true(lth_fractions_part(f, s, q) ==
                  (p->piece[s] == dropped ? 0 : lth_fractions_part(whole, s, q)));
  CHECK_NEAR(f->volume, whole->volume - box_volume, 1e-12);
  CHECK_OK(x->ctx, lth_pieces_create(x->ctx, f, 1e-3, &left));
  assert_int_equal(left->n, 2);
  lth_pieces_destroy(x->ctx, &left);
  lth_pieces_destroy(x->ctx, &p);
  lth_fractions_destroy(x->ctx, &whole);
  lth_fractions_destroy(x->ctx, &f);
}

static void cells_that_meet_in_an_edge_are_apart(void **state) {
  Fixture *x = *state;
  LthShape two[] = {{.kind = LTH_SHAPE_BOX, .a = {-0.5, -0.5, -0.5}, .b = {0, 0, 0.5}},
                    {.kind = LTH_SHAPE_BOX, .a = {0, 0, -0.5}, .b = {0.5, 0.5, 0.5}}};
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = two, .n_children = 2};
  LthFractionDef def = {.method = LTH_FRACTIONS_EXACT};
  for (int dim = 2; dim <= 3; dim++) {
    LthFractions *f = NULL;
    LthPieces *p = NULL;
    CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &tree, dim, origin, h, n, &def, &f));
    CHECK_OK(x->ctx, lth_pieces_create(x->ctx, f, 0, &p));
    assert_int_equal(p->n, 2);
    assert_int_equal(p->cells[0], dim == 3 ? 250 : 25);
    lth_pieces_destroy(x->ctx, &p);
    lth_fractions_destroy(x->ctx, &f);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(pieces_have_their_own_volumes_and_boxes),
      TEST(dropped_pieces_leave_the_others_as_they_were),
      TEST(cells_that_meet_in_an_edge_are_apart),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
