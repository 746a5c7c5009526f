/// Elements as polyhedra: what is shared, what is split, what the groups become, and what is warned of.
#include "check.h"

#include "base/tensor.h"
#include "lithe/lithe.h"
#include "mesh/element_mesh.h"

#include <string.h>

/// A mesh of elements from arrays on the stack; nothing of it is freed.
static LthElementMesh elements_of(double *nodes, LitheIndex n_nodes, uint8_t *kind,
                                  LitheIndex n_elements, LitheIndex *off, LitheIndex *node) {
  off[0] = 0;
  for (LitheIndex e = 0; e < n_elements; e++)
    off[e + 1] = off[e] + lth_element_shape(kind[e])->n_nodes;
  return (LthElementMesh){.n_nodes = n_nodes,
                          .n_elements = n_elements,
                          .nodes = nodes,
                          .kind = kind,
                          .element_off = off,
                          .element_node = node};
}

/// Two cubes side by side along x; the four nodes between them may be moved.
static double cubes[36] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1,
                           1, 1, 1, 0, 1, 1, 2, 0, 0, 2, 1, 0, 2, 0, 1, 2, 1, 1};
static LitheIndex cube_nodes[16] = {0, 1, 2, 3, 4, 5, 6, 7, 1, 8, 9, 2, 5, 10, 11, 6};

static void a_quad_that_is_not_planar_is_split_once_for_both_sides(void **state) {
  (void)state;
  for (int warped = 0; warped < 2; warped++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *m = NULL;
    LitheIndex off[3];
    uint8_t kind[2] = {LTH_HEX8, LTH_HEX8};
    double x[36];
    memcpy(x, cubes, sizeof x);
    if (warped) x[3 * 6] = 1.25; // along x: the sides y = 1 and z = 1 stay planar
    LthElementMesh e = elements_of(x, 12, kind, 2, off, cube_nodes);
    CHECK_OK(ctx, lth_element_mesh_check(ctx, &e, "f"));
    CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
    assert_int_equal(m->n_faces, 11 + warped);
    LitheIndex n_inner = 0;
    for (LitheIndex f = 0; f < m->n_faces; f++) n_inner += m->face_cell[2 * f + 1] >= 0;
    assert_int_equal(n_inner, 1 + warped);
    // the triangles share the shorter way, from node 1 to 6 or 2 to 5, and the volumes are those they bound
    CHECK_NEAR(m->cell_volume[0] + m->cell_volume[1], 2, 1e-14);
    double cone = 0.25 / 6;
    CHECK_AT_MOST(fmin(fabs(m->cell_volume[0] - 1 - warped * cone),
                       fabs(m->cell_volume[0] - 1 - warped * 2 * cone)),
                  1e-14);
    LthMeshQuality q;
    CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
    CHECK_AT_MOST(q.max_gap, 1e-15);
    assert_int_equal(lithe_ctx_warning_count(ctx), 0);
    lth_mesh_destroy(ctx, &m);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
}

static void planar_within_rounding_is_planar(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  LitheIndex off[3];
  uint8_t kind[2] = {LTH_HEX8, LTH_HEX8};
  double x[36], R[9], axis[3] = {0.6, 0, 0.8};
  lth_m3_rotation(axis, 1.1, R);
  for (int i = 0; i < 12; i++) lth_m3_apply(R, cubes + 3 * i, x + 3 * i);
  for (int i = 0; i < 36; i++) x[i] = 1e-3 * (x[i] + 1e4); // far from the origin for its size
  LthElementMesh e = elements_of(x, 12, kind, 2, off, cube_nodes);
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
  assert_int_equal(m->n_faces, 11);
  lth_mesh_destroy(ctx, &m);
  for (int i = 0; i < 36; i++) x[i] = (float)x[i];
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
  assert_true(m->n_faces > 11);
  lth_mesh_destroy(ctx, &m);
  e.rounding = 0x1p-24 * 10; // as the reader of a file of floats says
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
  assert_int_equal(m->n_faces, 11);
  lth_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// A hexahedron whose corners 2 and 3, and 6 and 7, are one is a wedge.
static void collapsed_hexahedra_are_wedges(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  LitheIndex off[2], node[8] = {0, 1, 2, 2, 4, 5, 6, 6};
  uint8_t kind[1] = {LTH_HEX8};
  LthElementMesh e = elements_of(cubes, 12, kind, 1, off, node);
  CHECK_OK(ctx, lth_element_mesh_check(ctx, &e, "f"));
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
  assert_int_equal(m->n_faces, 5);
  assert_int_equal(m->n_points, 6);
  CHECK_NEAR(m->cell_volume[0], 0.5, 1e-15);
  lth_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void groups_become_cells_and_boundary_faces(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *m = NULL;
  LitheIndex off[3], second[1] = {1}, floor[6] = {0, 1, 2, 3, 8, 9}, wall[4] = {1, 2, 5, 6},
                     sides[3] = {1, 4, 8 + 1};
  uint8_t kind[2] = {LTH_HEX8, LTH_HEX8};
  LthElementMesh e = elements_of(cubes, 12, kind, 2, off, cube_nodes);
  // `sides`: the inner face of the first cube, its floor, and the far end of the second
  LthElementGroup groups[] = {{"second", -1, LTH_GROUP_ELEMENTS, 1, second},
                              {"floor", 3, LTH_GROUP_NODES, 6, floor},
                              {"wall", 4, LTH_GROUP_NODES, 4, wall},
                              {"sides", -1, LTH_GROUP_FACES, 3, sides}};
  e.groups = groups;
  e.n_groups = 4;
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
  assert_int_equal(m->n_groups, 4);
  assert_string_equal(m->groups[0].name, "sides"); // faces first, cells last
  assert_int_equal(m->groups[0].n, 2);
  CHECK_NEAR(m->face_centroid[3 * m->groups[0].member[0] + 2], 0, 1e-15);
  CHECK_NEAR(m->face_centroid[3 * m->groups[0].member[1]], 2, 1e-15);
  assert_int_equal(m->groups[1].n, 2);
  for (int i = 0; i < 2; i++)
    CHECK_NEAR(m->face_centroid[3 * m->groups[1].member[i] + 2], 0, 1e-15);
  assert_int_equal(m->groups[2].n, 0); // the face between the cubes is not of the boundary
  assert_int_equal(m->groups[2].tag, 4);
  assert_true(m->groups[3].of_cells);
  assert_int_equal(m->groups[3].member[0], 1);
  lth_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// The second cube with corners of its own, or one step up: joined it is not.
static void faces_that_touch_without_being_one_are_told(void **state) {
  (void)state;
  for (int shifted = 0; shifted < 3; shifted++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *m = NULL;
    LitheIndex off[3], node[16];
    uint8_t kind[2] = {LTH_HEX8, LTH_HEX8};
    double x[48];
    memcpy(x, cubes, 24 * sizeof *x);
    memcpy(x + 24, cubes, 24 * sizeof *x);
    for (int i = 0; i < 16; i++) node[i] = i;
    for (int i = 8; i < 16; i++) {
      x[3 * i] += 1;
      x[3 * i + 2] = shifted == 2 ? x[3 * i + 2] + 2 : x[3 * i + 2] / (1 + shifted);
    }
    LthElementMesh e = elements_of(x, 16, kind, 2, off, node);
    CHECK_OK(ctx, lth_mesh_from_elements(ctx, &e, "f", &m));
    assert_int_equal(lithe_ctx_warning_count(ctx), shifted < 2);
    if (shifted < 2)
      assert_non_null(
          strstr(lithe_ctx_warning(ctx, 0), "touch without sharing the corners of a face"));
    lth_mesh_destroy(ctx, &m);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
}

static void the_boundary_is_a_surface(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const LthGrid grid = {{0, 0, 0}, {3, 2, 2}, {3, 2, 2}};
  LthElementMesh *e = NULL;
  LthMesh *m = NULL;
  LthSoup *soup = NULL;
  double area[3] = {0}, whole = 0;
  CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, 2, false, true, NULL, &e));
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, e, "grid", &m));
  CHECK_OK(ctx, lth_mesh_boundary_soup(ctx, m, &soup));
  assert_int_equal(soup->n_points, 4 * 3 * 3 - 2);
  assert_int_equal(soup->n_polys, 2 * (4 + 6 + 6) * 2);
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    const LitheIndex *v = soup->poly_point + soup->poly_off[p];
    double a[3], b[3], n[3];
    lth_v3_sub(soup->points + 3 * v[1], soup->points + 3 * v[0], a);
    lth_v3_sub(soup->points + 3 * v[2], soup->points + 3 * v[0], b);
    lth_v3_cross(a, b, n);
    lth_v3_add(area, n, area);
    whole += lth_v3_norm(n) / 2;
  }
  CHECK_NEAR(whole, 32, 1e-13);
  CHECK_NEAR(lth_v3_norm(area), 0, 1e-13);
  lth_soup_destroy(ctx, &soup);
  lth_mesh_destroy(ctx, &m);
  lth_element_mesh_destroy(ctx, &e);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_quad_that_is_not_planar_is_split_once_for_both_sides),
      cmocka_unit_test(planar_within_rounding_is_planar),
      cmocka_unit_test(collapsed_hexahedra_are_wedges),
      cmocka_unit_test(groups_become_cells_and_boundary_faces),
      cmocka_unit_test(faces_that_touch_without_being_one_are_told),
      cmocka_unit_test(the_boundary_is_a_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
