/// Strong constraints: places that the space holds come out exactly, free elements are left alone.
#include "check.h"

#include "disc/dg/dg_strong.h"

static double stretch(const void *self, const double x[3], double t) {
  (void)self;
  return t * (0.5 * x[0] - 2 * x[2]);
}

static void prescribed_elements_follow_linear_fields_and_no_others(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const LthGrid grid = {{-1, 0, 0.5}, {1, 1.5, 2}, {2, 2, 1}};
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthDgStrong *strong = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, 2, NULL, &space));
  const LitheIndex whole[4] = {1, -1, 0, -1};
  LitheIndex motion_of[12];
  for (int i = 0; i < 12; i++) motion_of[i] = whole[i / 3];
  const LthStrongMotion motions[2] = {
      {.factor = 1, .value = {{.eval = stretch}, {.constant = 0.25}, {0}}},
      {.is_position = true, .factor = 1, .value = {{.eval = stretch}, {.constant = 3}, {0}}}};
  CHECK_OK(ctx, lth_dg_strong_create(ctx, space, motion_of, 2, motions, &strong));
  double *x = calloc((size_t)space->n_dofs, sizeof *x);
  for (LitheCount i = 0; i < space->n_dofs; i++) x[i] = 7;
  CHECK_OK(ctx, lth_dg_strong_prescribe(strong, 0.5, x));

  for (LitheIndex c = 0; c < 4; c++) {
    const double *box = mesh->cell_box + 6 * (size_t)c;
    double at[3] = {box[0], box[4], 0.3 * box[2] + 0.7 * box[5]}, value[3];
    assert_int_equal(lth_dg_strong_held(strong)[3 * space->func_off[c]], whole[c] >= 0);
    for (LitheCount i = 3 * (LitheCount)space->func_off[c];
         whole[c] < 0 && i < 3 * (LitheCount)space->func_off[c + 1]; i++)
      assert_true(x[i] == 7);
    if (whole[c] < 0) continue;
    lth_dg_sample(space, c, x, at, value);
    bool moved = whole[c] == 0;
    double along = 0.5 * (0.5 * at[0] - 2 * at[2]);
    // some hundred products of numbers up to 4
    CHECK_NEAR(value[0], along + (moved ? at[0] : 0), 1e-13);
    CHECK_NEAR(value[1], moved ? at[1] + 0.25 : 3, 1e-13);
    CHECK_NEAR(value[2], moved ? at[2] : 0, 1e-13);
  }
  free(x);
  lth_dg_strong_destroy(ctx, &strong);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// One component follows a roller whose normal points against its axis, another a field, the third is free.
static void components_are_held_one_by_one(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const LthGrid grid = {{-1, 0, 0.5}, {1, 1.5, 2}, {2, 1, 1}};
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthDgStrong *strong = NULL;
  const uint8_t degree[2] = {3, 2};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, 0, degree, &space));
  const LitheIndex motion_of[6] = {-1, 0, 1, -1, -1, -1};
  const LthStrongMotion motions[2] = {
      {.factor = -1, .value = {{0}, {.constant = 0.25}, {0}}, .constraint = 1},
      {.factor = 1, .value = {{0}, {0}, {.eval = stretch}}}};
  CHECK_OK(ctx, lth_dg_strong_create(ctx, space, motion_of, 2, motions, &strong));
  double *x = calloc((size_t)space->n_dofs, sizeof *x), value[3], reaction[6] = {0};
  for (LitheCount i = 0; i < space->n_dofs; i++) x[i] = 7;
  CHECK_OK(ctx, lth_dg_strong_prescribe(strong, 0.5, x));
  for (LitheCount i = 0; i < space->n_dofs; i++) {
    bool held = i < 3 * space->func_off[1] && i % 3 > 0;
    assert_int_equal(lth_dg_strong_held(strong)[i], held);
    if (!held) assert_true(x[i] == 7);
  }
  const double at[3] = {-0.9, 0.2, 1.8};
  lth_dg_sample(space, 0, x, at, value);
  CHECK_NEAR(value[1], at[1] - 0.25, 1e-13);
  CHECK_NEAR(value[2], at[2] + 0.5 * (0.5 * at[0] - 2 * at[2]), 1e-13);

  // the force on a component goes to the constraint that holds it
  for (int a = 0; a < 3; a++) x[a] = a + 1;
  lth_dg_strong_add_reactions(strong, x, reaction);
  const double want[6] = {0, 0, -3, 0, -2, 0};
  for (int i = 0; i < 6; i++) CHECK_NEAR(reaction[i], want[i], 0);
  free(x);
  lth_dg_strong_destroy(ctx, &strong);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(prescribed_elements_follow_linear_fields_and_no_others),
      cmocka_unit_test(components_are_held_one_by_one),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
