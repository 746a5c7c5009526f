/// The bunny: sliced and cut again, and as one cell of 70 000 faces.
#include "io/surface_file.h"
#include "topology_ops.h"

#include <unistd.h>

static const char *bunny = "/usr/share/glmark2/models/bunny.obj";

static LthTopology *sliced_bunny(LitheCtx *ctx, int cells) {
  LthSoup *soup = NULL;
  LthSurface *s = NULL;
  LthMesh *mesh = NULL;
  LthTopology *t = NULL;
  if (access(bunny, R_OK) != 0) fail_msg("%s is missing: install glmark2-data", bunny);
  CHECK_OK(ctx, lth_soup_read(ctx, bunny, &soup));
  CHECK_OK(ctx, lth_surface_from_soup(ctx, soup, "bunny", NULL, &s));
  LthGrid g = cubic_grid(s, cells);
  for (int a = 0; a < 3 && cells == 1; a++) g.cells[a] = 1;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.05, &mesh));
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  lth_soup_destroy(ctx, &soup);
  lth_surface_destroy(ctx, &s);
  lth_mesh_destroy(ctx, &mesh);
  return t;
}

/// A plane through the middle of a random cell, along an axis every third time, or through a corner.
static LthPlane random_plane(const LthTopology *t, int i, uint64_t *seed) {
  LitheIndex cell = topology_random_cell(t, seed);
  LthPlane p;
  lth_v3_copy(t->cells[cell].centroid, p.point);
  topology_direction(seed, p.normal);
  if (i % 3 == 0)
    for (int a = 0; a < 3; a++) p.normal[a] = a == i / 3 % 3;
  if (i % 3 == 1) lth_v3_copy(topology_random_point(t, cell, seed), p.point);
  return p;
}

static void check_cut(int cells, int n_planes) {
  LitheCtx *ctx = test_ctx();
  LthTopology *t = sliced_bunny(ctx, cells);
  uint64_t seed = 17;
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  LitheIndex begin = t->n_live_cells, n_split = 0, n_merged = 0;
  for (int i = 0; i < n_planes; i++) {
    LthPlane p = random_plane(t, i, &seed);
    n_split += topology_cut_all(ctx, t, &p, i % 4 == 3 ? LTH_TAG_CUT - i : -1);
    if (i % 5 == 4)
      CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 1e-3 * t->volume / 100, &n_merged));
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
    CHECK_OK(ctx, lth_topology_forget(ctx, t));
  }
  print_message("%d cells: %d elements, %d splits, %d elements\n", cells, begin, n_split,
                t->n_live_cells);
  assert_true(n_split > n_planes);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  assert_int_equal(mesh->n_cells, t->n_live_cells);
  lth_mesh_destroy(ctx, &mesh);
  lth_topology_destroy(ctx, &t);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void one_element_falls_into_many(void **state) {
  (void)state;
  check_cut(1, 20);
}

static void a_sliced_bunny_is_cut_again(void **state) {
  (void)state;
  check_cut(4, 20);
  check_cut(10, 12);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_element_falls_into_many),
      cmocka_unit_test(a_sliced_bunny_is_cut_again),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
