/// Random splits, cuts, separations, merges and carves of random solids keep every invariant.
#include "topology_ops.h"

#include <time.h>

static uint64_t seed;

/// The mesh of now passes its own checks and holds the volume.
static void check_mesh(LitheCtx *ctx, const LthTopology *t) {
  LthMesh *mesh = NULL;
  LthMeshQuality q;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  CHECK_OK(ctx, lth_mesh_quality(ctx, mesh, &q));
  assert_int_equal(mesh->n_cells, t->n_live_cells);
  assert_int_equal(mesh->n_faces, t->n_live_faces);
  CHECK_NEAR(q.volume, t->volume, 1e-12 * t->volume);
  lth_mesh_destroy(ctx, &mesh);
}

/// `n` operations on one solid, all checked after each of them.
static void run_solid(int kind, int n, int most_cells, TopologyRun *run) {
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = topology_solid(ctx, kind);
  LthTopology *t = NULL;
  LthPlane last = {{0, 0, 0}, {0, 0, 1}};
  uint64_t begin = seed;
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  lth_mesh_destroy(ctx, &mesh);
  for (int i = 0; i < n; i++) {
    topology_random_operation(ctx, t, &last, most_cells, &seed, run);
    if (lth_topology_check(ctx, t, 0, NULL) != LITHE_OK)
      fail_msg("solid %d, seed %llu, operation %d: %s", kind, (unsigned long long)begin, i,
               lithe_ctx_message(ctx));
    if (i % 8 == 0) CHECK_OK(ctx, lth_topology_forget(ctx, t));
  }
  check_mesh(ctx, t);
  lth_topology_destroy(ctx, &t);
  lithe_ctx_destroy(&ctx);
}

static void operations_keep_every_invariant(void **state) {
  (void)state;
  TopologyRun run = {.carves = true};
  const char *much = getenv("LITHE_TEST_OPERATIONS");
  int n = much ? atoi(much) : 3000, each = 60;
  for (int i = 0; i < n / each; i++) run_solid(i % TOPOLOGY_SOLIDS, each, 60, &run);
  printf("%d splits, %d missed, %d cells cut, %d merges, %d carves\n", run.n_splits, run.n_missed,
         run.n_cuts, run.n_merges, run.n_carves);
  assert_true(run.n_splits > n / 4);
  assert_true(run.n_merges > n / 20);
  assert_true(run.n_carves > n / 100);
}

int main(void) {
  const char *fixed = getenv("LITHE_TEST_SEED");
  seed = fixed ? strtoull(fixed, NULL, 10) : (uint64_t)time(NULL);
  printf("LITHE_TEST_SEED=%llu\n", (unsigned long long)seed);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(operations_keep_every_invariant),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
