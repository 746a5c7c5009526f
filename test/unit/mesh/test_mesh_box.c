/// Hexahedra and tetrahedra of a box: counts, exact measures, orientation; and what create() refuses.
#include "check.h"

#include "base/tensor.h"
#include "failing_memory.h"
#include "mesh/mesh.h"

#include <string.h>

static const LthGrid grid = {{-1, 2, 0.5}, {2, 3, 2.5}, {3, 2, 4}};

static void faces_point_from_owner_to_neighbour(const LthMesh *m) {
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    double d[3];
    LitheIndex a = m->face_cell[2 * f], b = m->face_cell[2 * f + 1];
    lth_v3_sub(b >= 0 ? m->cell_centroid + 3 * b : m->face_centroid + 3 * f,
               m->cell_centroid + 3 * a, d);
    CHECK_AT_LEAST(lth_v3_dot(d, m->face_normal + 3 * f), 1e-3);
    if (b >= 0) assert_true(a < b);
  }
}

static void hexahedra_fill_the_box(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  LthMeshQuality q;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &m));
  CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
  assert_int_equal(m->n_cells, 24);
  assert_int_equal(m->n_faces, 4 * 8 + 3 * 12 + 5 * 6);
  assert_int_equal(q.n_inner_faces, 2 * 8 + 1 * 12 + 3 * 6);
  assert_int_equal(q.n_components, 1);
  CHECK_NEAR(q.volume, 6, 1e-14 * 6);
  CHECK_NEAR(q.surface_area, 2 * (3 + 6 + 2), 1e-14 * 22);
  CHECK_NEAR(q.min_volume, 0.25, 1e-15);
  CHECK_NEAR(q.max_aspect, 2, 1e-14);
  CHECK_AT_MOST(q.max_gap, 1e-15);
  CHECK_NEAR(m->cell_size, cbrt(0.25), 1e-15);
  for (int i = 0; i < 3; i++) {
    CHECK_NEAR(m->cell_centroid[i], grid.min[i] + (i == 0 ? 0.5 : 0.25), 1e-15);
    CHECK_NEAR(m->cell_box[i], grid.min[i], 0);
  }
  faces_point_from_owner_to_neighbour(m);
  lth_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void tetrahedra_fill_the_box(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  LthMeshQuality q;
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &m));
  CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
  assert_int_equal(m->n_cells, 6 * 24);
  assert_int_equal(q.n_boundary_faces, 2 * 2 * (6 + 12 + 8));
  assert_int_equal(q.n_components, 1);
  CHECK_NEAR(q.volume, 6, 1e-14 * 6);
  CHECK_NEAR(q.surface_area, 22, 1e-14 * 22);
  CHECK_NEAR(q.min_volume, 0.25 / 6, 1e-15);
  CHECK_NEAR(q.max_volume, 0.25 / 6, 1e-15);
  CHECK_AT_MOST(q.max_gap, 1e-15);
  faces_point_from_owner_to_neighbour(m);
  lth_mesh_destroy(ctx, &m);
  lithe_ctx_destroy(&ctx);
}

static void planes_of_a_grid_end_exactly(void **state) {
  (void)state;
  LthGrid g = {{0.1, 0, 0}, {0.7, 1, 1}, {7, 1, 1}};
  assert_true(lth_grid_plane(&g, 0, 0) == 0.1);
  assert_true(lth_grid_plane(&g, 0, 7) == 0.7);
  for (LitheIndex k = 0; k < 7; k++)
    assert_true(lth_grid_plane(&g, 0, k) < lth_grid_plane(&g, 0, k + 1));
}

/// One tetrahedron, whose faces the cases below spoil.
typedef struct Tetrahedron {
  double points[12];
  LitheIndex off[5], loop_off[5], loop_point[12], face_cell[8];
} Tetrahedron;

static Tetrahedron tetrahedron(void) {
  return (Tetrahedron){{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                       {0, 1, 2, 3, 4},
                       {0, 3, 6, 9, 12},
                       {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2},
                       {0, -1, 0, -1, 0, -1, 0, -1}};
}

static LitheStatus create(LitheCtx *ctx, const Tetrahedron *t, LitheIndex n_faces, LthMesh **m) {
  LthMeshDef def = {.n_points = 4,
                    .n_faces = n_faces,
                    .n_cells = 1,
                    .points = t->points,
                    .face_loop_off = t->off,
                    .loop_off = t->loop_off,
                    .loop_point = t->loop_point,
                    .face_cell = t->face_cell,
                    .cell_size = 1};
  return lth_mesh_create(ctx, &def, m);
}

static void measures_a_tetrahedron_far_from_the_origin(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  Tetrahedron t = tetrahedron();
  LthMesh *m = NULL;
  for (int i = 0; i < 12; i++) t.points[i] += 1048576;
  CHECK_OK(ctx, create(ctx, &t, 4, &m));
  CHECK_NEAR(m->cell_volume[0], 1.0 / 6, 1e-15);
  for (int i = 0; i < 3; i++) CHECK_NEAR(m->cell_centroid[i], 1048576.25, 1e-9);
  CHECK_NEAR(m->face_area[0], 0.5, 1e-15);
  CHECK_NEAR(m->face_normal[2], -1, 1e-15);
  lth_mesh_destroy(ctx, &m);
  lithe_ctx_destroy(&ctx);
}

static void refuses(const Tetrahedron *t, LitheIndex n_faces, const char *word) {
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  assert_int_equal(create(ctx, t, n_faces, &m), LITHE_BAD_INPUT);
  assert_null(m);
  if (!strstr(lithe_ctx_message(ctx), word))
    fail_msg("'%s' does not speak of '%s'", lithe_ctx_message(ctx), word);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void refuses_bad_cells(void **state) {
  (void)state;
  Tetrahedron t = tetrahedron();
  refuses(&t, 3, "not closed");
  for (int i = 0; i < 4; i++) t.points[3 * i + 2] *= -1;
  refuses(&t, 4, "volume");
  t = tetrahedron();
  t.face_cell[2] = 1;
  refuses(&t, 4, "lies between");
  t = tetrahedron();
  t.loop_point[3] = 4;
  refuses(&t, 4, "names point 4");
  t = tetrahedron();
  t.loop_point[3] = 1;
  refuses(&t, 4, "no area");
}

/// Memory fails from the n-th allocation on.
static int allocations_left;
static void refuses_more_than_indices_can_count(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  const LthMeshDef def = {.n_points = 4, .n_faces = INT32_MAX / 3 + 1, .n_cells = 1};
  assert_int_equal(lth_mesh_create(ctx, &def, &mesh), LITHE_UNSUPPORTED);
  assert_null(mesh);
  lithe_ctx_destroy(&ctx);
}

static void survives_failing_allocations(void **state) {
  (void)state;
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = test_failing_allocate;
  def.memory_user = &allocations_left;
  for (int n = 0, done = 0; !done; n++) {
    LitheCtx *ctx = lithe_ctx_create(&def);
    LthMesh *m = NULL;
    allocations_left = n;
    LitheStatus status = lth_mesh_tetrahedra(ctx, &grid, &m);
    done = status == LITHE_OK;
    assert_true(done || status == LITHE_NO_MEMORY);
    lth_mesh_destroy(ctx, &m);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(hexahedra_fill_the_box),
      cmocka_unit_test(tetrahedra_fill_the_box),
      cmocka_unit_test(planes_of_a_grid_end_exactly),
      cmocka_unit_test(measures_a_tetrahedron_far_from_the_origin),
      cmocka_unit_test(refuses_bad_cells),
      cmocka_unit_test(refuses_more_than_indices_can_count),
      cmocka_unit_test(survives_failing_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
