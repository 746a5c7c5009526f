/// Slicing: exact volumes and areas, closed elements and the right number of them on many solids.
#include "check.h"
#include "failing_memory.h"
#include "mesh/mesh.h"
#include "slice_checks.h"
#include "solids.h"

static LthGrid grid_about(const LthSurface *s, LitheIndex n, double margin) {
  LthGrid g;
  double size = 0;
  solid_bounds(s, g.min, g.max);
  for (int a = 0; a < 3; a++) size = fmax(size, g.max[a] - g.min[a]);
  for (int a = 0; a < 3; a++) {
    g.cells[a] = (LitheIndex)fmax(1, ceil(n * (g.max[a] - g.min[a]) / size - 1e-9));
    g.min[a] -= margin * size;
    g.max[a] += margin * size;
  }
  return g;
}

static LthGrid unit_grid(LitheIndex nx, LitheIndex ny, LitheIndex nz) {
  return (LthGrid){{0, 0, 0}, {nx, ny, nz}, {nx, ny, nz}};
}

/// Slice, check, compare with the octant volumes and give the number of elements; frees the solid.
static LitheIndex slice_solid(LthSurface *s, LitheCtx *ctx, const LthGrid *g, double tolerance) {
  LthMesh *m = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, g, 0, &m));
  check_sliced(ctx, s, m, 1);
  check_cell_volumes(s, g, m, tolerance);
  LitheIndex n = m->n_cells;
  lth_mesh_destroy(ctx, &m);

  // merging slivers changes who owns what, nothing else
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, g, 0.2, &m));
  check_sliced(ctx, s, m, 1);
  assert_true(m->n_cells <= n);
  lth_mesh_destroy(ctx, &m);
  solid_free(ctx, &s);
  return n;
}

static void expect_elements(LthSurface *s, LitheCtx *ctx, const LthGrid *g, LitheIndex want) {
  LitheIndex n = slice_solid(s, ctx, g, 1e-13);
  if (n != want) fail_msg("%d elements, expected %d", n, want);
}

static void end(LitheCtx *ctx) {
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void box_on_the_grid_gives_its_cells(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = unit_grid(4, 3, 2), wide = {{-2, -1, -3}, {6, 5, 4}, {8, 6, 7}};
  double lo[3] = {0, 0, 0}, hi[3] = {4, 3, 2};
  expect_elements(solid_box(ctx, lo, hi), ctx, &g, 24);
  expect_elements(solid_box(ctx, lo, hi), ctx, &wide, 24);
  LthSurface *s = solid_box(ctx, lo, hi);
  LthMesh *m = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &wide, 0, &m));
  for (LitheIndex c = 0; c < m->n_cells; c++) CHECK_NEAR(m->cell_volume[c], 1, 1e-15);
  LitheIndex n_inner = 0;
  for (LitheIndex f = 0; f < m->n_faces; f++) n_inner += m->face_cell[2 * f + 1] >= 0;
  assert_int_equal(n_inner, 3 * 6 + 2 * 8 + 12);
  for (LitheIndex i = 0; i < m->n_points; i++) assert_true(m->point_rank[i] >= 2);
  lth_mesh_destroy(ctx, &m);
  solid_free(ctx, &s);
  end(ctx);
}

static void box_off_the_grid_is_cut_by_its_planes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = unit_grid(4, 3, 2), beyond = {{1, 1, 0.5}, {3, 2, 1.5}, {2, 1, 2}};
  double lo[3] = {0.3, 0.25, 0.5}, hi[3] = {3.6, 2.75, 1.9}, far[3] = {4, 3, 2}, o[3] = {0, 0, 0};
  expect_elements(solid_box(ctx, lo, hi), ctx, &g, 4 * 3 * 2);
  expect_elements(solid_box(ctx, o, far), ctx, &beyond, 2 * 1 * 2);
  end(ctx);
}

static void solid_inside_one_cell_is_one_element(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = unit_grid(2, 2, 2);
  double shift[3] = {0.5, 1.5, 0.5};
  expect_elements(solid_move(solid_sphere(ctx, 6), NULL, 0.4, shift), ctx, &g, 1);
  expect_elements(solid_move(solid_sphere(ctx, 6), NULL, 1e-4, shift), ctx, &g, 1);
  expect_elements(solid_move(solid_torus(ctx, 0.3, 0.1, 12, 8), NULL, 1, shift), ctx, &g, 1);
  end(ctx);
}

static void staircase_in_grid_planes_gives_whole_cells(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  // three steps, two deep; every face lies in a grid plane
  const char steps[] = {1, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 0};
  LthGrid g = {{-1, -1, -1}, {4, 3, 4}, {5, 4, 5}};
  LthSurface *s = solid_cubes(ctx, steps, 3, 2, 3);
  LthMesh *m = NULL;
  LthMeshQuality q;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
  CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
  assert_int_equal(m->n_cells, 12);
  assert_int_equal(q.n_components, 1);
  for (LitheIndex c = 0; c < 12; c++) CHECK_NEAR(m->cell_volume[c], 1, 1e-15);

  // x: 2 + 1 in each depth, y: 6, z: 2 + 1 in each depth
  assert_int_equal(q.n_inner_faces, 6 + 6 + 6);
  lth_mesh_destroy(ctx, &m);
  expect_elements(s, ctx, &g, 12);
  g.min[0] += 0.25, g.max[0] += 0.25, g.min[2] -= 0.5, g.max[2] -= 0.5;
  slice_solid(solid_cubes(ctx, steps, 3, 2, 3), ctx, &g, 1e-13);
  end(ctx);
}

static void ring_with_a_hole_on_the_grid(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const char ring[] = {1, 1, 1, 1, 0, 1, 1, 1, 1};
  LthGrid g = unit_grid(3, 3, 1), one = {{-1, -1, -1}, {4, 4, 2}, {1, 1, 1}},
          half = {{0.5, -0.5, -0.5}, {2.5, 3.5, 1.5}, {1, 2, 2}};
  expect_elements(solid_cubes(ctx, ring, 3, 3, 1), ctx, &g, 8);
  expect_elements(solid_cubes(ctx, ring, 3, 3, 1), ctx, &one, 1);
  expect_elements(solid_cubes(ctx, ring, 3, 3, 1), ctx, &half, 4);
  end(ctx);
}

static void legs_in_one_cell_are_two_elements(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const char u[] = {1, 0, 1, 1, 0, 1, 1, 1, 1};
  LthGrid g = {{-1, -1, -1.5}, {4, 4, 2}, {1, 1, 1}};
  g.cells[1] = 2; // the plane y = 1.5 leaves the legs below and the bridge above
  expect_elements(solid_cubes(ctx, u, 3, 3, 1), ctx, &g, 3);
  LthSurface *s = solid_cubes(ctx, u, 3, 3, 1);
  LthMesh *m = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
  CHECK_NEAR(m->cell_volume[0], 1.5, 1e-14);
  CHECK_NEAR(m->cell_volume[1], 1.5, 1e-14);
  CHECK_NEAR(m->cell_volume[2], 4, 1e-14);
  for (LitheIndex f = 0; f < m->n_faces; f++)
    assert_false(m->face_cell[2 * f] == 0 && m->face_cell[2 * f + 1] == 1);
  lth_mesh_destroy(ctx, &m);
  solid_free(ctx, &s);
  end(ctx);
}

static void cubes_that_touch_in_a_vertex_stay_apart(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const char two[] = {1, 0, 0, 0, 0, 0, 0, 1};
  LthGrid one = {{-1, -1, -1}, {4, 4, 4}, {1, 1, 1}}, g = unit_grid(2, 2, 2);
  expect_elements(solid_cubes(ctx, two, 2, 2, 2), ctx, &one, 2);
  expect_elements(solid_cubes(ctx, two, 2, 2, 2), ctx, &g, 2);
  g.min[0] = -0.5, g.max[0] = 2.5, g.cells[0] = 3; // planes x = 0.5 and 1.5: each cube in two
  expect_elements(solid_cubes(ctx, two, 2, 2, 2), ctx, &g, 4);
  end(ctx);
}

static void towers_on_a_floor_in_a_plane_stay_apart(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  // two towers on a slab, with a wall behind; the cell above the floor line holds towers and wall
  const char towers[] = {1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1},
             hanging[] = {1, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  LthGrid g = {{0, 0, 0}, {3, 2, 2}, {1, 2, 2}};
  // floor and roof rows are whole; of the other two rows one is whole, one is two towers
  expect_elements(solid_cubes(ctx, towers, 3, 2, 2), ctx, &g, 5);
  expect_elements(solid_cubes(ctx, hanging, 3, 2, 2), ctx, &g, 5);
  end(ctx);
}

/// A sphere with a concentric cavity of radius `inner`, and a core of radius `core` if that is > 0.
static LthSurface *shell(LitheCtx *ctx, double inner, double core, int n) {
  LthSurface *s = solid_sphere(ctx, n);
  s = solid_join(ctx, s, solid_flip(solid_move(solid_sphere(ctx, n), NULL, inner, NULL)));
  if (core > 0) s = solid_join(ctx, s, solid_move(solid_sphere(ctx, n), NULL, core, NULL));
  return s;
}

static void cavities_belong_to_what_is_around_them(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid one = {{-2, -2, -2}, {2, 2, 2}, {1, 1, 1}}, three = {{-2, -2, -2}, {2, 2, 2}, {3, 3, 3}},
          cross = {{-2, -2, -2}, {2, 2, 2}, {2, 2, 2}};
  expect_elements(shell(ctx, 0.5, 0, 6), ctx, &one, 1);
  expect_elements(shell(ctx, 0.5, 0.25, 6), ctx, &one, 2);
  expect_elements(shell(ctx, 0.3, 0, 6), ctx, &three, 27 - 8);
  expect_elements(shell(ctx, 0.3, 0.2, 6), ctx, &three, 27 - 8 + 1);
  expect_elements(shell(ctx, 0.8, 0.4, 7), ctx, &cross, 16);

  // two spheres with cavities and a core beside each other in one cell
  double left[3] = {-0.9, 0, 0}, right[3] = {0.9, 0, 0};
  expect_elements(solid_join(ctx, solid_move(shell(ctx, 0.9, 0.8, 5), NULL, 0.8, left),
                             solid_move(shell(ctx, 0.7, 0.3, 5), NULL, 0.8, right)),
                  ctx, &one, 4);
  end(ctx);
}

static void hollow_cubes_on_the_grid(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char hollow[125], core[125];
  for (int i = 0; i < 125; i++) {
    int x = i % 5, y = i / 5 % 5, z = i / 25;
    int depth = (int)fmin(fmin(fmin(x, 4 - x), fmin(y, 4 - y)), fmin(z, 4 - z));
    hollow[i] = depth == 0;
    core[i] = depth != 1;
  }
  LthGrid g = {{-1, -1, -1}, {6, 6, 6}, {7, 7, 7}}, coarse = {{0, 0, 0}, {5, 5, 5}, {1, 1, 1}},
          odd = {{-0.7, -0.7, -1}, {5.3, 6.7, 6}, {4, 3, 2}};
  expect_elements(solid_cubes(ctx, hollow, 5, 5, 5), ctx, &g, 98);
  expect_elements(solid_cubes(ctx, core, 5, 5, 5), ctx, &g, 99);
  expect_elements(solid_cubes(ctx, core, 5, 5, 5), ctx, &coarse, 2);
  slice_solid(solid_cubes(ctx, core, 5, 5, 5), ctx, &odd, 1e-13);
  end(ctx);
}

static void thin_shell_in_many_cells(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = shell(ctx, 0.995, 0, 12);
  LthGrid g = grid_about(s, 5, 0.01);
  slice_solid(s, ctx, &g, 1e-13);
  double lo[3] = {0.1, 0.2, 0.5}, hi[3] = {2.9, 2.7, 0.5 + 1e-7};
  LthGrid u = unit_grid(3, 3, 1);
  expect_elements(solid_box(ctx, lo, hi), ctx, &u, 9);
  end(ctx);
}

static void vertices_and_edges_on_planes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = {{-2, -2, -2}, {2, 2, 2}, {4, 4, 4}}, fine = {{-2, -2, -2}, {2, 2, 2}, {8, 8, 8}};
  LthGrid thirds = {{-1, -1, -1}, {1, 1, 1}, {6, 6, 6}};
  // octahedron: all vertices and edges on the planes through the origin
  expect_elements(solid_sphere(ctx, 1), ctx, &g, 8);
  expect_elements(solid_sphere(ctx, 1), ctx, &fine, 32);
  expect_elements(solid_stretch(solid_sphere(ctx, 2), 1, 1, 2), ctx, &g, 16);
  slice_solid(solid_sphere(ctx, 4), ctx, &thirds, 1e-13);
  // a wedge whose ridge lies in a plane, from below and from above
  double wedge[8] = {1, 0, 0, 1, -1, 0, 0, -1};
  slice_solid(solid_prism(ctx, wedge, 4, 1), ctx, &fine, 1e-13);
  slice_solid(solid_torus(ctx, 1, 0.5, 8, 8), ctx, &fine, 1e-13);
  slice_solid(solid_torus(ctx, 1, 0.5, 8, 8), ctx, &g, 1e-13);
  end(ctx);
}

static void turned_solids(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const char l[] = {1, 1, 1, 1, 0, 0};
  double R[9], lo[3] = {-1, -0.5, -0.75}, hi[3] = {1, 0.5, 0.75};
  for (int i = 0; i < 4; i++) {
    solid_rotation(1, 0.3 * i, 0.7, 0.4 + i, R);
    LthSurface *solids[] = {solid_box(ctx, lo, hi), solid_cubes(ctx, l, 3, 2, 1),
                            solid_torus(ctx, 1, 0.3, 20, 10), solid_star(ctx, 7, 0.3, 1, 0.6),
                            shell(ctx, 0.9, 0.5, 6)};
    for (int j = 0; j < 5; j++) {
      solid_move(solids[j], R, 1, NULL);
      LthGrid g = grid_about(solids[j], 3 + i, 0.001);
      slice_solid(solids[j], ctx, &g, 1e-13);
    }
  }
  end(ctx);
}

static void turned_by_right_angles_within_rounding(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const char l[] = {1, 1, 1, 1, 0, 0};
  double R[9], shift[3] = {2, 2, 2};
  LthGrid g = {{-2, -2, -2}, {6, 6, 6}, {8, 8, 8}};
  for (int i = 0; i < 3; i++) {
    solid_rotation(i == 0, i == 1, i == 2, M_PI / 2, R);
    expect_elements(solid_move(solid_cubes(ctx, l, 3, 2, 1), R, 1, shift), ctx, &g, 4);
  }
  end(ctx);
}

static void needle_triangles(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double polygon[128];
  for (int i = 0; i < 64; i++) {
    double t = i < 32 ? i / 32.0 : 2 - i / 32.0;
    // a lens a thousand times longer than thick
    polygon[2 * i] = 500 * cos(M_PI * t);
    polygon[2 * i + 1] = (i < 32 ? -0.5 : 0.5) * sin(M_PI * t) * (i % 32 ? 1 : 0) * -1;
  }
  for (int i = 0; i < 64; i++) polygon[2 * i] *= -1;
  LthSurface *s = solid_prism(ctx, polygon, 64, 1);
  if (solid_volume(s) < 0) solid_flip(s);
  LthGrid g = grid_about(s, 16, 0.01);
  slice_solid(s, ctx, &g, 1e-13);
  s = solid_stretch(solid_sphere(ctx, 8), 1, 1e-3, 1e-5);
  double R[9];
  solid_rotation(1, 2, 3, 1, R);
  solid_move(s, R, 1, NULL);
  g = grid_about(s, 8, 0.01);
  slice_solid(s, ctx, &g, 1e-13);
  end(ctx);
}

static void faces_almost_parallel_to_planes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1}, R[9];
  LthGrid g = {{-2, -2, -2}, {2, 2, 2}, {4, 4, 4}};
  for (int i = 0; i < 16; i++) {
    solid_rotation(0.3, 1, 0.2 * (i % 3), pow(10, -i), R);
    // plates thinner than 1e-12 of a cell have no volume of their own and join the cell beside them
    slice_solid(solid_move(solid_box(ctx, lo, hi), R, 1, NULL), ctx, &g, 1e-11);
  }
  end(ctx);
}

static void size_and_place_do_not_matter(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double shifts[2][3] = {{0, 0, 0}, {1e3, -2e3, 1.5e3}}, R[9];
  solid_rotation(1, 1, 0.2, 0.7, R);
  LitheIndex n[2][3];
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 3; j++) {
      double scale = pow(1e-3, j), shift[3];
      for (int k = 0; k < 3; k++) shift[k] = scale * shifts[i][k];
      LthSurface *s = solid_move(solid_torus(ctx, 1, 0.4, 16, 12), R, scale, shift);
      LthGrid g = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}, {5, 5, 5}};
      for (int k = 0; k < 3; k++) {
        g.min[k] = scale * g.min[k] + shift[k];
        g.max[k] = scale * g.max[k] + shift[k];
      }
      LthMesh *m = NULL;
      CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.05, &m));
      // new points are rounded to the last digit of their distance from the origin
      check_sliced(ctx, s, m, i == 0 ? 1 : 1e3);
      n[i][j] = m->n_cells;
      lth_mesh_destroy(ctx, &m);
      solid_free(ctx, &s);
    }
  for (int j = 0; j < 3; j++) {
    assert_int_equal(n[0][j], n[0][0]);
    assert_int_equal(n[1][j], n[0][0]);
  }
  end(ctx);
}

static void refuses_bad_requests(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_sphere(ctx, 2);
  LthMesh *m = NULL;
  LthGrid g = {{-1, -1, -1}, {1, 1, -1}, {2, 2, 2}};
  assert_int_equal(lth_mesh_slice(ctx, s, &g, 0, &m), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "axis z"));
  g.max[2] = 1;
  assert_int_equal(lth_mesh_slice(ctx, s, &g, 2, &m), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "sliver"));
  solid_flip(s);
  assert_int_equal(lth_mesh_slice(ctx, s, &g, 0, &m), LITHE_BAD_INPUT);
  assert_null(m);
  solid_flip(s);
  lithe_ctx_cancel(ctx);
  assert_int_equal(lth_mesh_slice(ctx, s, &g, 0, &m), LITHE_INTERRUPTED);
  assert_null(m);
  solid_free(ctx, &s);
  end(ctx);
}

/// Memory fails from the n-th allocation on.
static int allocations_left;

static void survives_failing_allocations(void **state) {
  (void)state;
  LitheCtx *plain = test_ctx();
  LthSurface *s = shell(plain, 0.5, 0.25, 3);
  LthGrid g = grid_about(s, 3, 0);
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = test_failing_allocate;
  def.memory_user = &allocations_left;
  for (int n = 0, done = 0; !done; n++) {
    LitheCtx *ctx = lithe_ctx_create(&def);
    LthMesh *m = NULL;
    allocations_left = n;
    LitheStatus status = lth_mesh_slice(ctx, s, &g, 0.1, &m);
    done = status == LITHE_OK;
    assert_true(done || (status == LITHE_NO_MEMORY && !m));
    lth_mesh_destroy(ctx, &m);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
  solid_free(plain, &s);
  end(plain);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(box_on_the_grid_gives_its_cells),
      cmocka_unit_test(box_off_the_grid_is_cut_by_its_planes),
      cmocka_unit_test(solid_inside_one_cell_is_one_element),
      cmocka_unit_test(staircase_in_grid_planes_gives_whole_cells),
      cmocka_unit_test(ring_with_a_hole_on_the_grid),
      cmocka_unit_test(legs_in_one_cell_are_two_elements),
      cmocka_unit_test(towers_on_a_floor_in_a_plane_stay_apart),
      cmocka_unit_test(cubes_that_touch_in_a_vertex_stay_apart),
      cmocka_unit_test(cavities_belong_to_what_is_around_them),
      cmocka_unit_test(hollow_cubes_on_the_grid),
      cmocka_unit_test(thin_shell_in_many_cells),
      cmocka_unit_test(vertices_and_edges_on_planes),
      cmocka_unit_test(turned_solids),
      cmocka_unit_test(turned_by_right_angles_within_rounding),
      cmocka_unit_test(needle_triangles),
      cmocka_unit_test(faces_almost_parallel_to_planes),
      cmocka_unit_test(size_and_place_do_not_matter),
      cmocka_unit_test(refuses_bad_requests),
      cmocka_unit_test(survives_failing_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
