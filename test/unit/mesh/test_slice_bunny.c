/// The Stanford bunny of Debian's glmark2-data at 4 to 64 cells: exact, connected, ears apart.
#include "check.h"
#include "io/surface_file.h"
#include "mesh/mesh.h"
#include "slice_checks.h"

#include <unistd.h>

static const char *bunny = "/usr/share/glmark2/models/bunny.obj";

static LthSurface *read_bunny(LitheCtx *ctx) {
  LthSoup *soup = NULL;
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_soup_read(ctx, bunny, &soup));
  CHECK_OK(ctx, lth_surface_from_soup(ctx, soup, "bunny", NULL, &s));
  lth_soup_destroy(ctx, &soup);
  return s;
}

static void bunny_is_sliced_exactly_at_every_size(void **state) {
  (void)state;
  if (access(bunny, R_OK) != 0) fail_msg("%s is missing: install glmark2-data", bunny);
  LitheCtx *ctx = test_ctx();
  LthSurface *s = read_bunny(ctx);
  LitheIndex elements[5], n = 0;
  for (int cells = 4; cells <= 64; cells *= 2) {
    LthGrid g = cubic_grid(s, cells);
    LthMesh *m = NULL;
    LthMeshQuality q;
    double start = lth_now();
    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
    print_message("%2d cells: %d elements, %d faces, %.2f s\n", cells, m->n_cells, m->n_faces,
                  lth_now() - start);
    check_sliced(ctx, s, m, 1);
    elements[n++] = m->n_cells;
    lth_mesh_destroy(ctx, &m);

    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.05, &m));
    check_sliced(ctx, s, m, 1);
    CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
    assert_int_equal(q.n_components, 1);
    assert_int_equal(q.n_elements + q.n_merged, elements[n - 1]);
    CHECK_AT_LEAST(q.min_volume, 0.05 * pow(m->cell_size, 3));
    lth_mesh_destroy(ctx, &m);
  }
  lth_surface_destroy(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Elements of the cells across the ears never share a face, so the ears move on their own.
static void ears_do_not_couple(void **state) {
  (void)state;
  if (access(bunny, R_OK) != 0) fail_msg("%s is missing: install glmark2-data", bunny);
  LitheCtx *ctx = test_ctx();
  LthSurface *s = read_bunny(ctx);
  double lo[3], hi[3];
  solid_bounds(s, lo, hi);

  // one slab over the upper fifth, where there is nothing but the two ears
  LthGrid g = {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}, {1, 5, 1}};
  LthMesh *m = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
  check_cell_volumes(s, &g, m, 1e-12);
  LitheIndex n_top = 0;
  for (LitheIndex c = 0; c < m->n_cells; c++)
    n_top += m->cell_centroid[3 * c + 1] > lth_grid_plane(&g, 1, 4);
  assert_int_equal(n_top, 2);
  lth_mesh_destroy(ctx, &m);
  lth_surface_destroy(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bunny_is_sliced_exactly_at_every_size),
      cmocka_unit_test(ears_do_not_couple),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
