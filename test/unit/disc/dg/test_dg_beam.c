/// Deflections: against independent codes, the beam tables of docs/theory/dg.md, and under rotation.
#include "dg_body.h"

/// value of the position at a point: mean over the cells whose boxes hold it.
static void position_at(const TestBody *b, const double at[3], double mean[3]) {
  int n = 0;
  mean[0] = mean[1] = mean[2] = 0;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    const double *box = b->mesh->cell_box + 6 * c;
    bool in = true;
    for (int a = 0; a < 3; a++) in = in && at[a] > box[a] - 1e-9 && at[a] < box[3 + a] + 1e-9;
    if (!in) continue;
    double v[3];
    lth_dg_sample(b->space, c, b->x, at, v);
    lth_v3_add(mean, v, mean);
    n++;
  }
  assert_true(n > 0);
  lth_v3_scale(1.0 / n, mean);
}

static void compliance_agrees_with_independent_codes(void **state) {
  (void)state;
  // they solve to 1e-8
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_IP, 1, 20), 2.81695505e-4, 1e-8 * 3e-4);
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_BZ, 1, 20), 2.96783578e-4, 1e-8 * 3e-4);
}

static double beam_tip(TestMesh kind, LitheIndex nx, LitheIndex ny, int degree, double poisson,
                       LthFlux flux) {
  TestBody b = test_body(kind, (LthGrid){{0, -0.5, -0.5}, {4, 0.5, 0.5}, {nx, ny, ny}}, degree);
  test_set_material(&b, 1000, poisson);
  b.def.flux = flux;
  test_hold(&b, test_facing_down_x);
  test_assemble(&b, 0);
  test_add_weight(&b, (double[3]){0, 0, -1});
  test_solve_sparse(&b, b.K, b.f0);
  double tip[3];
  position_at(&b, (double[3]){4, 0, 0}, tip);
  test_body_free(&b);
  return tip[2];
}

/// Linear cantilever 4 x 1 x 1 under its weight, tip over the converged -0.39862.
static void coarse_linear_elements_bend(void **state) {
  (void)state;
  const struct {
    TestMesh kind;
    LitheIndex nx, ny;
    double want;
  } rows[] = {
      {TEST_HEXAHEDRA, 2, 1, 1.26},  {TEST_HEXAHEDRA, 4, 1, 1.08},  {TEST_HEXAHEDRA, 8, 1, 1.03},
      {TEST_HEXAHEDRA, 16, 1, 1.02}, {TEST_HEXAHEDRA, 4, 2, 0.86},  {TEST_HEXAHEDRA, 8, 2, 0.96},
      {TEST_TETRAHEDRA, 4, 1, 1.11}, {TEST_TETRAHEDRA, 8, 2, 0.98},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    double tip = beam_tip(rows[i].kind, rows[i].nx, rows[i].ny, 1, 0.3, LTH_FLUX_IP);
    CHECK_NEAR(tip / -0.39862, rows[i].want, 0.0075);
  }
}

static void quadratic_elements_bend(void **state) {
  (void)state;
  CHECK_NEAR(beam_tip(TEST_HEXAHEDRA, 4, 1, 2, 0.3, LTH_FLUX_IP) / -0.39862, 0.960, 0.002);
  CHECK_NEAR(beam_tip(TEST_HEXAHEDRA, 8, 2, 2, 0.3, LTH_FLUX_IP) / -0.39862, 0.989, 0.002);
}

/// Tip of the corotated cantilever under five times its weight, at the fixed point of the rotations.
static void check_warped_tip(int degree, double z, double x) {
  TestBody b =
      test_body(TEST_HEXAHEDRA, (LthGrid){{0, -0.5, -0.5}, {4, 0.5, 0.5}, {4, 1, 1}}, degree);
  b.def.warped = true;
  test_hold(&b, test_facing_down_x);
  test_assemble(&b, 0);
  test_add_weight(&b, (double[3]){0, 0, -5});
  LitheCount n = b.K->n;
  double *last = lth_alloc(b.ctx, n, sizeof *last), change = 1, tip[3];
  for (int round = 0; round < 60 && change > 1e-7; round++) {
    memcpy(last, b.x, sizeof *last * (size_t)n);
    lth_dg_update_rotations(b.op, b.x);
    test_assemble(&b, 0);
    test_solve(&b);
    for (LitheCount i = 0; i < n; i++) b.x[i] = 0.5 * (b.x[i] + last[i]); // the plain round swings
    for (LitheCount i = 0; i < n; i++) last[i] -= b.x[i];
    change = test_max(n, last);
  }
  CHECK_AT_MOST(change, 1e-7);
  position_at(&b, (double[3]){4, 0, 0}, tip);
  CHECK_NEAR(tip[2], z, 0.001);
  CHECK_NEAR(tip[0] - 4, x, 0.001);
  lth_free(b.ctx, last);
  test_body_free(&b);
}

static void corotated_cantilever_bends_far(void **state) {
  (void)state;
  check_warped_tip(1, -1.847, -0.470); // converged: -1.73 to -1.75, -.42
  check_warped_tip(2, -1.666, -0.387);
}

/// The beam's mesh, turned by R.
static LthMesh *turned_mesh(LitheCtx *ctx, const double R[9]) {
  LthMesh *flat = NULL, *mesh = NULL;
  LthGrid grid = {{0, -0.5, -0.5}, {4, 0.5, 0.5}, {4, 1, 2}};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &flat));
  for (LitheIndex p = 0; p < flat->n_points; p++) {
    double v[3];
    lth_m3_apply(R, flat->points + 3 * p, v);
    lth_v3_copy(v, flat->points + 3 * p);
  }
  LthMeshDef def = {.n_points = flat->n_points,
                    .n_faces = flat->n_faces,
                    .n_cells = flat->n_cells,
                    .points = flat->points,
                    .face_loop_off = flat->face_loop_off,
                    .loop_off = flat->loop_off,
                    .loop_point = flat->loop_point,
                    .face_cell = flat->face_cell,
                    .cell_size = flat->cell_size};
  CHECK_OK(ctx, lth_mesh_create(ctx, &def, &mesh));
  lth_mesh_destroy(ctx, &flat);
  return mesh;
}

static double clamp_normal[3];
static bool facing_the_clamp(const double c[3], const double n[3]) {
  (void)c;
  return lth_v3_dot(n, clamp_normal) > 0.999999;
}

/// Centroids of the turned, clamped beam after a few rounds of rotations and solves.
static void bend_turned(const double R[9], int degree, LthFlux flux, double centroids[24]) {
  LitheCtx *ctx = test_ctx();
  TestBody b = test_body_of(ctx, turned_mesh(ctx, R), degree);
  double weight[3];
  lth_m3_apply(R, (double[3]){-1, 0, 0}, clamp_normal);
  lth_m3_apply(R, (double[3]){0, 0, -3}, weight);
  b.def.flux = flux;
  b.def.warped = true;
  test_hold(&b, facing_the_clamp);
  test_assemble(&b, 0);
  test_add_weight(&b, weight);
  for (int round = 0; round < 4; round++) {
    lth_dg_update_rotations(b.op, b.x);
    test_assemble(&b, 0);
    test_solve(&b);
  }
  for (LitheIndex c = 0; c < b.space->n_cells; c++)
    lth_v3_copy(b.x + 3 * b.space->func_off[c], centroids + 3 * c);
  test_body_free(&b);
}

static void turned_beam_gives_the_turned_answer(void **state) {
  (void)state;
  double R[9], I[9], straight[24], turned[24];
  test_rotation(0.7, R);
  lth_m3_identity(I);
  for (int degree = 1; degree <= 2; degree++)
    for (int bz = 0; bz < 2; bz++) {
      bend_turned(I, degree, bz ? LTH_FLUX_BZ : LTH_FLUX_IP, straight);
      bend_turned(R, degree, bz ? LTH_FLUX_BZ : LTH_FLUX_IP, turned);
      CHECK_AT_LEAST(fabs(straight[3 * 7 + 2]), 0.3); // it does bend
      for (int c = 0; c < 8; c++) {
        double want[3];
        lth_m3_apply(R, straight + 3 * c, want);
        for (int a = 0; a < 3; a++) CHECK_NEAR(turned[3 * c + a], want[a], 1e-10);
      }
    }
}

/// A bar of nu = 0 in n slabs, pulled and sheared: BZ's springs make it softer by 1 / 51 at most.
static void bz_is_softer_by_less_than_two_percent(void **state) {
  (void)state;
  for (int degree = 1; degree <= 2; degree++)
    for (LitheIndex n = 1; n <= 5; n += 2) {
      TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {3, 1, 1}, {n, 1, 1}}, degree);
      test_set_material(&b, 1000, 0);
      b.def.flux = LTH_FLUX_BZ;
      test_hold(&b, test_facing_down_x);
      test_assemble(&b, 0);
      b.patches[3] = test_patches(b.ctx, b.mesh, test_facing_up_x);
      LthLoad pull = {.kind = LTH_LOAD_TOTAL_FORCE, .patches = b.patches[3]};
      pull.value[0].constant = 10;
      CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &pull, 0, NULL, b.f));
      test_solve(&b);
      double end[3], exact = 10 * 3 / 1000.0;
      position_at(&b, (double[3]){3, 0.5, 0.5}, end);
      CHECK_AT_LEAST((end[0] - 3) / exact, 1);
      CHECK_AT_MOST((end[0] - 3) / exact, 1.02);
      test_body_free(&b);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(compliance_agrees_with_independent_codes),
      cmocka_unit_test(coarse_linear_elements_bend),
      cmocka_unit_test(quadratic_elements_bend),
      cmocka_unit_test(corotated_cantilever_bends_far),
      cmocka_unit_test(turned_beam_gives_the_turned_answer),
      cmocka_unit_test(bz_is_softer_by_less_than_two_percent),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
