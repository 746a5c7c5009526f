/// Matrices on meshes that were split: positive definite, and well conditioned once slivers are merged.
#include "dg_body.h"
#include "topology_ops.h"

static LthTopology *cube(LitheCtx *ctx, LthGrid g) {
  LthMesh *mesh = NULL;
  LthTopology *t = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &g, &mesh));
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  lth_mesh_destroy(ctx, &mesh);
  return t;
}

/// Smallest and largest eigenvalue of the stiffness of a topology, held where it faces down.
static void eigenvalues(LitheCtx *ctx, LthTopology *t, int degree, double *min, double *max) {
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  TestBody b = test_body_of(ctx, mesh, degree);
  test_hold(&b, test_facing_down_z);
  test_assemble(&b, 0);
  CHECK_AT_MOST(lth_block_matrix_asymmetry(b.K), 1e-13);
  test_eigenvalues(&b, min, max);
  test_body_end(&b);
}

static double condition(LitheCtx *ctx, LthTopology *t, int degree) {
  double min = 0, max = 0;
  eigenvalues(ctx, t, degree, &min, &max);
  assert_true(min > 0);
  return max / min;
}

static void random_splits_leave_the_matrix_positive_definite(void **state) {
  (void)state;
  uint64_t seed = 3;
  LitheCtx *ctx = test_ctx();
  for (int i = 0; i < 8; i++) {
    LthTopology *t = cube(ctx, (LthGrid){{0, 0, 0}, {2, 1, 1}, {2, 1, 1}});
    double min = 0, max = 0;
    LitheIndex n = 0;
    for (int k = 0; k < 5; k++) {
      LitheIndex cell = topology_random_cell(t, &seed);
      LthPlane p = topology_plane(t, cell, NULL, &seed);
      LthSplit s;
      CHECK_OK(ctx, lth_topology_split(ctx, t, cell, &p, -1, &s));
    }
    CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 1e-3, &n));
    eigenvalues(ctx, t, 1 + i % 2, &min, &max);
    CHECK_AT_LEAST(min, 1e-10 * max);
    lth_topology_destroy(ctx, &t);
  }
  lithe_ctx_destroy(&ctx);
}

/// A plane beside a layer of faces makes slivers of thickness `by`: the condition grows as 1 / by. Merged, it stays
/// what it was.
static void merging_slivers_bounds_the_condition(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = {{0, 0, 0}, {2, 2, 2}, {2, 2, 2}};
  for (int degree = 1; degree <= 2; degree++) {
    LthTopology *t = cube(ctx, g);
    double whole = condition(ctx, t, degree), last = whole;
    lth_topology_destroy(ctx, &t);
    for (double by = 1e-2; by > 1e-5; by /= 10) {
      t = cube(ctx, g);
      LthPlane p = {{1 + by, 1, 1}, {1, 0.1 * by, 0}};
      assert_int_equal(topology_cut_all(ctx, t, &p, -1), 4);
      double thin = condition(ctx, t, degree);
      CHECK_AT_LEAST(thin, 5 * last);
      LitheIndex n = 0;
      CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 0.1, &n));
      assert_int_equal(n, 4);
      double merged = condition(ctx, t, degree);
      printf("degree %d, thickness %.0e: condition %.3g, merged %.3g, whole %.3g\n", degree, by,
             thin, merged, whole);
      CHECK_AT_MOST(merged, 2 * whole);
      last = thin;
      lth_topology_destroy(ctx, &t);
    }
  }
  lithe_ctx_destroy(&ctx);
}

/// x -> bent and turned, quadratic in the rest position.
static void bend(const void *self, const double x[3], double value[3]) {
  double by = *(const double *)self;
  value[0] = x[1] + by * x[1] * x[1];
  value[1] = -x[0] - by * x[0] * x[2];
  value[2] = 1.1 * x[2] + by * x[0] * x[0];
}

/// Energy of positions of degree 2 that are projected from `bend`.
static double energy(LitheCtx *ctx, LthTopology *t, double by, bool warped) {
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  TestBody b = test_body_of(ctx, mesh, 2);
  b.def.warped = warped;
  test_assemble(&b, 0);
  CHECK_OK(ctx, lth_dg_project(ctx, b.space, bend, &by, 4, b.x));
  lth_dg_update_rotations(b.op, b.x);
  double sum = lth_dg_energy(b.op, 0, b.x);
  test_body_end(&b);
  return sum;
}

/// A continuous state has no jumps that a penalty could see: its energy is the same in more elements. Where the state
/// is curved each child of a corotated element takes its own rotation, which changes the energy by the square of the bend.
static void splitting_keeps_the_strain_energy_of_what_is_continuous(void **state) {
  (void)state;
  uint64_t seed = 9;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = cube(ctx, (LthGrid){{0, 0, 0}, {2, 1, 1}, {2, 1, 1}});
  double linear = energy(ctx, t, 0.1, false), straight = energy(ctx, t, 0, true),
         bent = energy(ctx, t, 1e-2, true);
  for (int i = 0; i < 4; i++) {
    LthSplit s;
    double n[3];
    topology_direction(&seed, n);
    CHECK_OK(ctx, lth_topology_split_two(ctx, t, topology_random_cell(t, &seed), n, &s));
  }
  CHECK_NEAR(energy(ctx, t, 0.1, false), linear, 1e-12 * linear);
  CHECK_NEAR(energy(ctx, t, 0, true), straight, 1e-12 * straight);
  CHECK_NEAR(energy(ctx, t, 1e-2, true), bent, 1e-3 * bent);
  lth_topology_destroy(ctx, &t);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_splits_leave_the_matrix_positive_definite),
      cmocka_unit_test(splitting_keeps_the_strain_energy_of_what_is_continuous),
      cmocka_unit_test(merging_slivers_bounds_the_condition),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
