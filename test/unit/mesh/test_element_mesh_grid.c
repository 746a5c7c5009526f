/// Tables of the element kinds against the places of their nodes, and elements of a grid.
#include "check.h"

#include "base/tensor.h"
#include "mesh/element_mesh.h"

#include <string.h>

/// Places of the nodes in the kind's reference cell, from VTK's documentation of its cells.
static const double tet_place[10][3] = {{0, 0, 0},   {1, 0, 0},   {0, 1, 0},  {0, 0, 1},
                                        {.5, 0, 0},  {.5, .5, 0}, {0, .5, 0}, {0, 0, .5},
                                        {.5, 0, .5}, {0, .5, .5}};
static const double hex_place[27][3] = {
    {0, 0, 0},   {1, 0, 0},   {1, 1, 0},   {0, 1, 0},   {0, 0, 1},   {1, 0, 1},   {1, 1, 1},
    {0, 1, 1},   {.5, 0, 0},  {1, .5, 0},  {.5, 1, 0},  {0, .5, 0},  {.5, 0, 1},  {1, .5, 1},
    {.5, 1, 1},  {0, .5, 1},  {0, 0, .5},  {1, 0, .5},  {1, 1, .5},  {0, 1, .5},  {0, .5, .5},
    {1, .5, .5}, {.5, 0, .5}, {.5, 1, .5}, {.5, .5, 0}, {.5, .5, 1}, {.5, .5, .5}};
static const double wedge_place[18][3] = {
    {0, 0, 0},  {1, 0, 0},   {0, 1, 0},  {0, 0, 1},   {1, 0, 1},    {0, 1, 1},
    {.5, 0, 0}, {.5, .5, 0}, {0, .5, 0}, {.5, 0, 1},  {.5, .5, 1},  {0, .5, 1},
    {0, 0, .5}, {1, 0, .5},  {0, 1, .5}, {.5, 0, .5}, {.5, .5, .5}, {0, .5, .5}};
static const double pyramid_place[14][3] = {
    {0, 0, 0},      {1, 0, 0},      {1, 1, 0},      {0, 1, 0},  {.5, .5, 1},
    {.5, 0, 0},     {1, .5, 0},     {.5, 1, 0},     {0, .5, 0}, {.25, .25, .5},
    {.75, .25, .5}, {.75, .75, .5}, {.25, .75, .5}, {.5, .5, 0}};

static const struct {
  LthElementKind kind;
  const double (*place)[3];
  int corners;
} kinds[] = {{LTH_TET4, tet_place, 4},         {LTH_TET10, tet_place, 4},
             {LTH_HEX8, hex_place, 8},         {LTH_HEX20, hex_place, 8},
             {LTH_HEX27, hex_place, 8},        {LTH_WEDGE6, wedge_place, 6},
             {LTH_WEDGE15, wedge_place, 6},    {LTH_WEDGE18, wedge_place, 6},
             {LTH_PYRAMID5, pyramid_place, 5}, {LTH_PYRAMID13, pyramid_place, 5},
             {LTH_PYRAMID14, pyramid_place, 5}};

static void mean_of(const double (*place)[3], const int8_t *node, int n, double mean[3]) {
  for (int a = 0; a < 3; a++) {
    mean[a] = 0;
    for (int i = 0; i < n; i++) mean[a] += place[node[i]][a] / n;
  }
}

/// Faces turn counter-clockwise seen from outside, edge nodes stand between the corners before and behind
/// them, and the face node in the middle.
static void faces_of_every_kind_are_outward_and_complete(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
    const LthElementShape *s = lth_element_shape(kinds[k].kind);
    double centre[3] = {0}, volume = 0;
    int used[LTH_ELEMENT_MAX_NODES] = {0};
    assert_int_equal(s->n_corners, kinds[k].corners);
    for (int i = 0; i < s->n_corners; i++)
      for (int a = 0; a < 3; a++) centre[a] += kinds[k].place[i][a] / s->n_corners;
    for (int f = 0; f < s->n_faces; f++) {
      const int8_t *node = s->face[f].node;
      int nc = s->face[f].n_corners;
      double middle[3], mean[3];
      mean_of(kinds[k].place, node, nc, middle);
      for (int i = 0; i < nc; i++) {
        const double *p = kinds[k].place[node[i]], *q = kinds[k].place[node[(i + 1) % nc]];
        double a[3], b[3], n[3], out[3];
        lth_v3_sub(p, middle, a);
        lth_v3_sub(q, middle, b);
        lth_v3_cross(a, b, n);
        lth_v3_sub(middle, centre, out);
        CHECK_AT_LEAST(lth_v3_dot(n, out), 1e-3);
        volume += lth_v3_dot(n, out) / 6;
        used[node[i]]++;
        if (s->degree == 1) continue;
        for (int c = 0; c < 3; c++)
          CHECK_NEAR(kinds[k].place[node[nc + i]][c], 0.5 * (p[c] + q[c]), 0);
      }
      assert_int_equal(s->face[f].n_nodes == 2 * nc + 1 || s->face[f].n_nodes == nc * s->degree, 1);
      if (s->face[f].n_nodes != 2 * nc + 1) continue;
      mean_of(kinds[k].place, node + 2 * nc, 1, mean);
      for (int c = 0; c < 3; c++) CHECK_NEAR(mean[c], middle[c], 0);
    }
    double want = s->n_corners == 4   ? 1.0 / 6
                  : s->n_corners == 8 ? 1
                  : s->n_corners == 6 ? .5
                                      : 1.0 / 3;
    CHECK_NEAR(volume, want, 1e-15);
    for (int i = 0; i < s->n_corners; i++) assert_in_range(used[i], 3, 4);
  }
}

static const LthGrid grid = {{-1, 2, 0.5}, {2, 3, 2.5}, {3, 2, 4}};

static double tet_volume(const LthElementMesh *m, LitheIndex e) {
  const LitheIndex *v = m->element_node + m->element_off[e];
  double a[3], b[3], c[3], n[3];
  lth_v3_sub(m->nodes + 3 * v[1], m->nodes + 3 * v[0], a);
  lth_v3_sub(m->nodes + 3 * v[2], m->nodes + 3 * v[0], b);
  lth_v3_sub(m->nodes + 3 * v[3], m->nodes + 3 * v[0], c);
  lth_v3_cross(a, b, n);
  return lth_v3_dot(n, c) / 6;
}

/// Mean of an element's corners against the centroid of the mesh's cell of the same number.
static void check_centroids(const LthElementMesh *m, const LthMesh *cells) {
  assert_int_equal(m->n_elements, cells->n_cells);
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    const LthElementShape *s = lth_element_shape(m->kind[e]);
    double mean[3] = {0};
    assert_int_equal(m->element_off[e + 1] - m->element_off[e], s->n_nodes);
    for (int i = 0; i < s->n_corners; i++)
      for (int a = 0; a < 3; a++)
        mean[a] += m->nodes[3 * m->element_node[m->element_off[e] + i] + a] / s->n_corners;
    for (int a = 0; a < 3; a++) CHECK_NEAR(mean[a], cells->cell_centroid[3 * e + a], 1e-14);
  }
}

static void cells_have_the_numbers_of_the_polyhedral_mesh(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *hex = NULL, *tet = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &hex));
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &tet));
  for (int degree = 1; degree <= 2; degree++)
    for (int serendipity = 0; serendipity < degree; serendipity++) {
      LthElementMesh *m = NULL;
      CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, degree, serendipity, false, NULL, &m));
      check_centroids(m, hex);
      LitheIndex corners = 4 * 3 * 5, all = 7 * 5 * 9, edges = 3 * 3 * 5 + 4 * 2 * 5 + 4 * 3 * 4;
      assert_int_equal(m->n_nodes, degree == 1 ? corners : serendipity ? corners + edges : all);
      lth_element_mesh_destroy(ctx, &m);
      CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, degree, serendipity, true, NULL, &m));
      check_centroids(m, tet);
      // the only places of the lattice without a node would be none: face and body diagonals use all
      assert_int_equal(m->n_nodes, degree == 1 ? corners : all);
      for (LitheIndex e = 0; e < m->n_elements; e++) CHECK_NEAR(tet_volume(m, e), 0.25 / 6, 1e-15);
      lth_element_mesh_destroy(ctx, &m);
    }
  lth_mesh_destroy(ctx, &hex);
  lth_mesh_destroy(ctx, &tet);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Every node of an element stands where the kind's table and the cell's box say.
static void nodes_stand_in_the_order_of_their_kind(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int pass = 0; pass < 4; pass++) {
    LthElementMesh *m = NULL;
    CHECK_OK(ctx,
             lth_element_mesh_grid(ctx, &grid, pass == 0 ? 1 : 2, pass == 1, pass == 3, NULL, &m));
    for (LitheIndex e = 0; e < m->n_elements; e++) {
      const LthElementShape *s = lth_element_shape(m->kind[e]);
      const LitheIndex *v = m->element_node + m->element_off[e];
      for (int i = 0; i < s->n_nodes; i++)
        for (int a = 0; a < 3; a++) {
          double x0 = m->nodes[3 * v[0] + a], want = x0;
          const double(*place)[3] = pass == 3 ? tet_place : hex_place;
          for (int c = 0; c < 3; c++) {
            int axis_corner = pass == 3 ? c + 1 : c == 0 ? 1 : c == 1 ? 3 : 4;
            want += place[i][c] * (m->nodes[3 * v[axis_corner] + a] - x0);
          }
          CHECK_NEAR(m->nodes[3 * v[i] + a], want, 1e-14);
        }
    }
    lth_element_mesh_destroy(ctx, &m);
  }
  lithe_ctx_destroy(&ctx);
}

static void cells_can_be_left_out(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthElementMesh *m = NULL;
  uint8_t keep[24] = {0};
  keep[0] = keep[23] = 1;
  CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, 2, false, false, keep, &m));
  assert_int_equal(m->n_elements, 2);
  assert_int_equal(m->n_nodes, 54);
  CHECK_NEAR(m->nodes[0], -1, 0);
  CHECK_NEAR(m->nodes[3 * 53], 2, 0);
  lth_element_mesh_destroy(ctx, &m);
  keep[0] = keep[23] = 0;
  assert_int_equal(lth_element_mesh_grid(ctx, &grid, 1, false, false, keep, &m), LITHE_BAD_INPUT);
  assert_null(m);
  LthGrid huge = {{0, 0, 0}, {1, 1, 1}, {2000, 2000, 2000}};
  assert_int_equal(lth_element_mesh_grid(ctx, &huge, 2, false, false, NULL, &m), LITHE_UNSUPPORTED);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void groups_are_found_by_name_and_number(void **state) {
  (void)state;
  LthElementGroup groups[] = {{"2", 7, LTH_GROUP_NODES, 0, NULL},
                              {"top", 2, LTH_GROUP_NODES, 0, NULL},
                              {"top", -1, LTH_GROUP_ELEMENTS, 0, NULL}};
  LthElementMesh m = {.groups = groups, .n_groups = 3};
  assert_ptr_equal(lth_element_group(&m, LTH_GROUP_NODES, "top"), &groups[1]);
  assert_ptr_equal(lth_element_group(&m, LTH_GROUP_ELEMENTS, "top"), &groups[2]);
  assert_ptr_equal(lth_element_group(&m, LTH_GROUP_NODES, "2"), &groups[0]);
  assert_ptr_equal(lth_element_group(&m, LTH_GROUP_NODES, "7"), &groups[0]);
  assert_null(lth_element_group(&m, LTH_GROUP_ELEMENTS, "-1"));
  assert_null(lth_element_group(&m, LTH_GROUP_FACES, "top"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(faces_of_every_kind_are_outward_and_complete),
      cmocka_unit_test(cells_have_the_numbers_of_the_polyhedral_mesh),
      cmocka_unit_test(nodes_stand_in_the_order_of_their_kind),
      cmocka_unit_test(cells_can_be_left_out),
      cmocka_unit_test(groups_are_found_by_name_and_number),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
