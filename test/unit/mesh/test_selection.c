/// Selections: divided areas are exact, complements add up, patches stop at edges, quadrature is exact.
#include "check.h"
#include "one_cell.h"
#include "polyhedra.h"

#include "failing_memory.h"
#include "mesh/selection.h"

static const double ring_outer[8] = {-1, -0.75, 1, -0.75, 1, 1, -1, 1};
static const double ring_hole[8] = {-0.25, -0.5, 0.75, -0.5, 0.75, 0.5, -0.25, 0.5};
/// A comb with two teeth upwards.
static const double comb[16] = {-1, -1, 1, -1, 1, 1, 0.5, 1, 0.5, 0, -0.5, 0, -0.5, 1, -1, 1};

static LthMesh *grid_mesh(LitheCtx *ctx, bool tets, int nx, int ny, int nz) {
  LthGrid grid = {{-1, 0, 0.5}, {1, 1.5, 2}, {nx, ny, nz}};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx,
           tets ? lth_mesh_tetrahedra(ctx, &grid, &mesh) : lth_mesh_hexahedra(ctx, &grid, &mesh));
  return mesh;
}

static LthWhere all(void) { return (LthWhere){.kind = LTH_WHERE_ALL}; }

static LthWhere plane(double px, double py, double pz, double nx, double ny, double nz) {
  LthWhere w = {.kind = LTH_WHERE_PLANE, .point = {px, py, pz}, .normal = {nx, ny, nz}};
  lth_v3_normalize(w.normal);
  return w;
}

static LthWhere box(double ax, double ay, double az, double bx, double by, double bz) {
  return (LthWhere){.kind = LTH_WHERE_SHAPE,
                    .shape = {.kind = LTH_SHAPE_BOX, .a = {ax, ay, az}, .b = {bx, by, bz}}};
}

static LthWhere combine(LthWhereKind kind, LthWhere *children, LitheIndex n) {
  return (LthWhere){.kind = kind, .children = children, .n_children = n};
}

/// Area and int x dA of a selection, and the number of pieces.
typedef struct Sum {
  double area, first[3];
  LitheIndex n;
} Sum;

static Sum measure(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where) {
  LthPatches *p = NULL;
  CHECK_OK(ctx, lth_select_boundary(ctx, mesh, where, &p));
  Sum sum = {.n = p->n};
  for (LitheIndex i = 0; i < p->n; i++) {
    CHECK_AT_LEAST(p->area[i], 0);
    assert_int_equal(mesh->face_cell[2 * p->face[i] + 1], -1);
    sum.area += p->area[i];
    lth_v3_axpy(p->area[i], p->centroid + 3 * i, sum.first);
  }
  lth_patches_destroy(ctx, &p);
  return sum;
}

static double area_of(LitheCtx *ctx, const LthMesh *mesh, LthWhere where) {
  return measure(ctx, mesh, &where).area;
}

static void finish(LitheCtx *ctx, LthMesh *mesh) {
  lth_mesh_destroy(ctx, &mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void all_is_the_whole_boundary(void **state) {
  (void)state;
  for (int tets = 0; tets < 2; tets++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *mesh = grid_mesh(ctx, tets, 3, 2, 2);
    LthWhere w = all();
    Sum sum = measure(ctx, mesh, &w);
    CHECK_NEAR(sum.area, 2 * (2 * 1.5 + 2 * 1.5 + 1.5 * 1.5), 1e-13);
    assert_int_equal(sum.n, tets ? 4 * (6 + 6 + 4) : 2 * (6 + 6 + 4));
    finish(ctx, mesh);
  }
}

static void boxes_divide_faces_exactly(void **state) {
  (void)state;
  for (int tets = 0; tets < 2; tets++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *mesh = grid_mesh(ctx, tets, 3, 2, 2);
    // a slab below y = 0.3: floor and a strip of the four walls
    CHECK_NEAR(area_of(ctx, mesh, box(-9, -9, -9, 9, 0.3, 9)), 2 * 1.5 + 0.3 * 2 * (2 + 1.5),
               1e-13);
    // a box over one corner: three rectangles
    CHECK_NEAR(area_of(ctx, mesh, box(0.7, 1.1, 1.8, 9, 9, 9)), 0.3 * 0.4 + 0.3 * 0.2 + 0.4 * 0.2,
               1e-14);
    // a window inside one wall
    CHECK_NEAR(area_of(ctx, mesh, box(-0.3, 0.2, 1.9, 0.45, 1.1, 2.1)), 0.75 * 0.9, 1e-14);
    finish(ctx, mesh);
  }
}

static void a_closed_box_takes_the_face_it_touches(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = grid_mesh(ctx, false, 3, 2, 2);
  CHECK_NEAR(area_of(ctx, mesh, box(-9, -9, -9, 9, 0, 9)), 3, 1e-14);
  CHECK_NEAR(area_of(ctx, mesh, box(-9, -9, -9, 9, -1e-9, 9)), 3,
             1e-14); // within 1e-9 of the size, 2
  CHECK_NEAR(area_of(ctx, mesh, box(-9, -9, -9, 9, -1e-8, 9)), 0, 0);
  CHECK_NEAR(area_of(ctx, mesh, plane(0, 1.5, 0, 0, 1, 0)), 3, 1e-14);
  finish(ctx, mesh);
}

static void cuts_holed_and_forked_faces_exactly(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  TestSolid s;
  test_prism(&s, 4, ring_outer, 4, ring_hole, 0, 1);
  LthMesh *mesh = test_one_cell(ctx, &s);
  // through the hole: x >= 0.25. Top and bottom 0.75 * 1.75 - 0.5 * 1, walls 1.75 + 2 * 0.75, hole 1 + 2 * 0.5
  CHECK_NEAR(area_of(ctx, mesh, plane(0.25, 0, 0, 1, 0, 0)), 2 * 0.8125 + 3.25 + 2, 1e-14);
  // along an edge of the hole, both sides; its wall counts on both, as the sets are closed
  CHECK_NEAR(area_of(ctx, mesh, plane(-0.25, 0, 0, -1, 0, 0)), 2 * 0.75 * 1.75 + 3.25 + 1, 1e-14);
  CHECK_NEAR(area_of(ctx, mesh, plane(-0.25, 0, 0, 1, 0, 0)), 2 * (1.25 * 1.75 - 1) + 4.25 + 4,
             1e-14);
  // across two corners of the hole: y >= 0.5 - (x + 0.25). The hole gives half of itself
  double outer = 2 * 1.75 - 0.5 * (1 + 1) * (1 + 1) + 0.5 * 0.25 * 0.25;
  LthWhere parts[2] = {plane(-0.25, 0.5, 0, 1, 1, 0),
                       {.kind = LTH_WHERE_NORMAL, .normal = {0, 0, 1}, .angle = 0.1}};
  CHECK_NEAR(area_of(ctx, mesh, combine(LTH_WHERE_AND, parts, 2)), outer - 0.5, 1e-14);
  lth_mesh_destroy(ctx, &mesh);
  // a cut that leaves two separate teeth
  test_prism(&s, 8, comb, 0, NULL, 0, 1);
  mesh = test_one_cell(ctx, &s);
  parts[0] = plane(0, 0.5, 0, 0, 1, 0);
  CHECK_NEAR(area_of(ctx, mesh, combine(LTH_WHERE_AND, parts, 2)), 2 * 0.25, 1e-15);
  parts[0] = plane(0, 0, 0, 0, 1, 0); // along the valley's floor
  CHECK_NEAR(area_of(ctx, mesh, combine(LTH_WHERE_AND, parts, 2)), 1, 1e-15);
  parts[0] = plane(0, 0, 0, 0, -1, 0);
  CHECK_NEAR(area_of(ctx, mesh, combine(LTH_WHERE_AND, parts, 2)), 2, 1e-15);
  finish(ctx, mesh);
}

static LthWhere random_leaf(uint64_t *seed) {
  double r[6];
  for (int i = 0; i < 6; i++) r[i] = 2 * test_random(seed) - 1;
  if (test_random(seed) < 0.5) return plane(r[0], r[1], r[2], r[3], r[4], r[5]);
  return box(fmin(r[0], r[3]), fmin(r[1], r[4]), fmin(r[2], r[5]), fmax(r[0], r[3]),
             fmax(r[1], r[4]), fmax(r[2], r[5]));
}

static void complements_and_unions_add_up(void **state) {
  (void)state;
  uint64_t seed = 21;
  for (int repeat = 0; repeat < 60; repeat++) {
    LitheCtx *ctx = test_ctx();
    TestSolid s;
    double R[9], zero[3] = {0};
    if (repeat % 2)
      test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.5);
    else
      test_prism(&s, 8, comb, 0, NULL, -0.5, 0.5);
    if (repeat % 3) {
      test_axis_rotation((double[3]){1, 2, repeat}, repeat, R);
      test_transform(&s, R, zero);
    }
    LthMesh *mesh = test_one_cell(ctx, &s);
    LthWhere ab[2] = {random_leaf(&seed), random_leaf(&seed)};
    LthWhere both = combine(LTH_WHERE_AND, ab, 2), either = combine(LTH_WHERE_OR, ab, 2);
    LthWhere neither = combine(LTH_WHERE_NOT, &either, 1), whole = all();
    Sum sum[6] = {measure(ctx, mesh, &ab[0]),   measure(ctx, mesh, &ab[1]),
                  measure(ctx, mesh, &both),    measure(ctx, mesh, &either),
                  measure(ctx, mesh, &neither), measure(ctx, mesh, &whole)};
    // closed sets share at most a face that lies in both planes, which random planes do not
    CHECK_NEAR(sum[0].area + sum[1].area, sum[2].area + sum[3].area, 1e-13);
    CHECK_NEAR(sum[3].area + sum[4].area, sum[5].area, 1e-13);
    for (int i = 0; i < 3; i++) {
      CHECK_NEAR(sum[0].first[i] + sum[1].first[i], sum[2].first[i] + sum[3].first[i], 1e-13);
      CHECK_NEAR(sum[3].first[i] + sum[4].first[i], sum[5].first[i], 1e-13);
    }
    finish(ctx, mesh);
  }
}

static void half_spaces_agree_with_the_divergence_theorem(void **state) {
  (void)state;
  // the boundary above z = h, closed by the section: sum of area normals is minus the section's area
  uint64_t seed = 2;
  for (int repeat = 0; repeat < 20; repeat++) {
    LitheCtx *ctx = test_ctx();
    TestSolid s;
    double R[9], zero[3] = {0};
    test_prism(&s, 8, comb, 0, NULL, -0.5, 0.5);
    test_axis_rotation((double[3]){1, 1 + repeat, 2}, 0.3 * repeat, R);
    test_transform(&s, R, zero);
    LthMesh *mesh = test_one_cell(ctx, &s);
    LthWhere above = plane(0, 0, test_random(&seed) - 0.5, 0, 0, 1);
    LthPatches *p = NULL;
    CHECK_OK(ctx, lth_select_boundary(ctx, mesh, &above, &p));
    double sum[3] = {0};
    for (LitheIndex i = 0; i < p->n; i++)
      lth_v3_axpy(p->area[i], mesh->face_normal + 3 * p->face[i], sum);
    CHECK_NEAR(sum[0], 0, 1e-14);
    CHECK_NEAR(sum[1], 0, 1e-14);
    CHECK_AT_LEAST(sum[2], 0.1);
    lth_patches_destroy(ctx, &p);
    finish(ctx, mesh);
  }
}

static void other_shapes_go_by_centroid(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = grid_mesh(ctx, false, 4, 3, 3);
  LthWhere ball = {.kind = LTH_WHERE_SHAPE,
                   .shape = {.kind = LTH_SHAPE_SPHERE, .a = {-1, 0, 0.5}, .radius = 0.4}};
  Sum sum = measure(ctx, mesh, &ball);
  assert_int_equal(sum.n, 3); // the three faces at the corner, centroids 0.25 sqrt(2) from it
  CHECK_NEAR(sum.area, 3 * 0.25, 1e-15);
  finish(ctx, mesh);
}

static void normals_select_sides(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = grid_mesh(ctx, true, 3, 2, 2);
  LthWhere up = {.kind = LTH_WHERE_NORMAL, .normal = {0, 1, 0}, .angle = acos(-1) / 6};
  CHECK_NEAR(area_of(ctx, mesh, up), 3, 1e-14);
  up.angle = acos(-1) / 2; // closed: the walls too, but not the floor
  CHECK_NEAR(area_of(ctx, mesh, up), 3 + 1.5 * 2 * (2 + 1.5), 1e-13);
  finish(ctx, mesh);
}

static void patches_grow_up_to_sharp_edges(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = grid_mesh(ctx, true, 3, 2, 2);
  LthWhere side = {.kind = LTH_WHERE_FACE, .point = {0.1, 0.7, 2.6}, .angle = acos(-1) / 9};
  CHECK_NEAR(area_of(ctx, mesh, side), 3, 1e-14);
  side.angle = 1.6;
  CHECK_NEAR(area_of(ctx, mesh, side), 16.5, 1e-13);
  lth_mesh_destroy(ctx, &mesh);
  // a ring: from a point in the hole only the hole's wall that is nearest, then around it
  TestSolid s;
  test_prism(&s, 4, ring_outer, 4, ring_hole, 0, 1);
  mesh = test_one_cell(ctx, &s);
  side = (LthWhere){.kind = LTH_WHERE_FACE, .point = {0.25, 0.45, 0.5}, .angle = 0.5};
  CHECK_NEAR(area_of(ctx, mesh, side), 1, 1e-15);
  // above the hole the nearest boundary is the top's inner edge, not the top's plane
  side.point[2] = 1.01;
  side.point[1] = 0.499;
  CHECK_AT_LEAST(area_of(ctx, mesh, side), 0.99);
  finish(ctx, mesh);
}

static void cells_touch_the_selection_or_lie_in_it(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = grid_mesh(ctx, false, 4, 3, 3);
  uint8_t chosen[36];
  LthWhere w = box(-9, -9, -9, 9, 0.1, 9);
  int n = 0;
  CHECK_OK(ctx, lth_select_cells(ctx, mesh, &w, chosen));
  for (int c = 0; c < 36; c++) {
    assert_int_equal(chosen[c], mesh->cell_centroid[3 * c + 1] < 0.5);
    n += chosen[c];
  }
  assert_int_equal(n, 12);
  w = all();
  CHECK_OK(ctx, lth_select_cells(ctx, mesh, &w, chosen));
  for (int c = 0; c < 36; c++) assert_int_equal(chosen[c], 1);
  LthPatches *p = NULL;
  CHECK_OK(ctx, lth_select_boundary(ctx, mesh, &w, &p));
  lth_patches_cells(mesh, p, chosen);
  for (int c = n = 0; c < 36; c++) n += chosen[c];
  assert_int_equal(n, 36 - 2); // two cells in the middle have no boundary
  lth_patches_destroy(ctx, &p);
  // what only the boundary knows selects nothing inside, nor does its negation
  LthWhere up = {.kind = LTH_WHERE_NORMAL, .normal = {0, 1, 0}, .angle = 0.1};
  w = combine(LTH_WHERE_NOT, &up, 1);
  CHECK_OK(ctx, lth_select_cells(ctx, mesh, &w, chosen));
  for (int c = n = 0; c < 36; c++) n += chosen[c];
  assert_int_equal(n, 36 - 2 - 2); // also without the two whose only boundary is the top
  finish(ctx, mesh);
}

/// Area that a label selects of the boundary, and the number of cells.
static double labelled(LitheCtx *ctx, const LthMesh *m, const LthWhere *w, LitheIndex *n_cells) {
  LthPatches *patches = NULL;
  uint8_t chosen[8];
  double area = 0;
  CHECK_OK(ctx, lth_select_boundary(ctx, m, w, &patches));
  for (LitheIndex i = 0; i < patches->n; i++) area += patches->area[i];
  lth_patches_destroy(ctx, &patches);
  CHECK_OK(ctx, lth_select_cells(ctx, m, w, chosen));
  *n_cells = 0;
  for (LitheIndex c = 0; c < m->n_cells; c++) *n_cells += chosen[c];
  return area;
}

/// Two by two by two cubes; the groups are freed with the mesh.
static void labels_select_groups_of_faces_or_of_cells(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const LthGrid grid = {{0, 0, 0}, {2, 2, 2}, {2, 2, 2}};
  LthMesh *m = NULL;
  LitheIndex n = 0, n_top = 0;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &m));
  m->groups = lth_alloc(ctx, 2, sizeof *m->groups);
  for (m->n_groups = 0; m->n_groups < 2; m->n_groups++) {
    LthMeshGroup *g = &m->groups[m->n_groups];
    g->of_cells = m->n_groups == 1;
    g->tag = 5 + m->n_groups;
    g->member = lth_alloc(ctx, 4, sizeof *g->member);
    CHECK_OK(ctx, lth_copy_text(ctx, g->of_cells ? "low" : "Top", &g->name));
  }
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (m->face_centroid[3 * f + 2] == 2) m->groups[0].member[n_top++] = f;
  m->groups[0].n = m->groups[1].n = 4;
  for (LitheIndex c = 0; c < 4; c++) m->groups[1].member[c] = c; // z below 1
  LthWhere top = {.kind = LTH_WHERE_LABEL, .label = (char[]){"Top"}},
           low = {.kind = LTH_WHERE_LABEL, .label = (char[]){"6"}},
           not_low = combine(LTH_WHERE_NOT, &low, 1), not_top = combine(LTH_WHERE_NOT, &top, 1);
  CHECK_NEAR(labelled(ctx, m, &top, &n), 4, 1e-14);
  assert_int_equal(n, 4); // those at the faces
  CHECK_NEAR(labelled(ctx, m, &low, &n), 4 + 8, 1e-14);
  assert_int_equal(n, 4);
  CHECK_NEAR(labelled(ctx, m, &not_low, &n), 24 - 12, 1e-14);
  assert_int_equal(n, 4);
  CHECK_NEAR(labelled(ctx, m, &not_top, &n), 24 - 4, 1e-14);
  top.label = (char[]){"tOP"};
  CHECK_NEAR(labelled(ctx, m, &top, &n), 4, 1e-14);

  LthPatches *patches = NULL;
  top.label = (char[]){"side"};
  assert_int_equal(lth_select_boundary(ctx, m, &not_top, &patches), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx),
                      "where.label: the mesh has no group side; it has Top, low");
  lth_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void quadrature_is_exact_on_divided_faces(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  TestSolid s;
  double R[9], zero[3] = {0}, unit[3] = {1, 1, 1};
  test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.5);
  test_axis_rotation((double[3]){1, 2, 0.5}, 1, R);
  test_transform(&s, R, zero);
  LthMesh *mesh = test_one_cell(ctx, &s);
  LthWhere w = plane(0.1, 0, 0, 1, 0.4, 0.2);
  LthPatches *p = NULL;
  CHECK_OK(ctx, lth_select_boundary(ctx, mesh, &w, &p));
  const int(*e)[3] = lth_monomial3_exponents();
  for (LitheIndex i = 0; i < p->n; i++) {
    LthFaceView piece = lth_patches_view(mesh, p, i);
    double m[455] = {0};
    lth_moments_add_face_area(7, zero, unit, &piece, m);
    CHECK_NEAR(m[0], p->area[i], 1e-15);
    for (int degree = 0; degree <= 7; degree++) {
      LitheIndex n;
      double *x, *weight;
      CHECK_OK(ctx, lth_patch_quadrature(ctx, &piece, degree, &n, &x, &weight));
      for (int q = 0; q < lth_monomials3(degree); q++) {
        double sum = 0;
        for (LitheIndex g = 0; g < n; g++)
          sum += weight[g] * pow(x[3 * g], e[q][0]) * pow(x[3 * g + 1], e[q][1]) *
                 pow(x[3 * g + 2], e[q][2]);
        CHECK_NEAR(sum, m[q], 2e-14);
      }
      lth_free(ctx, x);
      lth_free(ctx, weight);
    }
  }
  LitheIndex n;
  double *x, *weight;
  LthFaceView piece = lth_patches_view(mesh, p, 0);
  assert_int_equal(lth_patch_quadrature(ctx, &piece, 99, &n, &x, &weight), LITHE_BAD_INPUT);
  lth_patches_destroy(ctx, &p);
  finish(ctx, mesh);
}

/// Memory fails from the n-th allocation on.
static int allocations_left;

static void survives_failing_allocations(void **state) {
  (void)state;
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = test_failing_allocate;
  def.memory_user = &allocations_left;
  TestSolid s;
  test_prism(&s, 4, ring_outer, 4, ring_hole, 0, 1);
  LthWhere either[3] = {box(-1, -1, -1, 0.25, 0.25, 0.5),
                        plane(0.25, 0, 0, 1, 1, 0),
                        {.kind = LTH_WHERE_FACE, .point = {0.25, 0.45, 0.5}, .angle = 0.5}};
  LthWhere w = combine(LTH_WHERE_OR, either, 3);
  for (int n = 0, done = 0; !done; n++) {
    allocations_left = INT32_MAX;
    LitheCtx *ctx = lithe_ctx_create(&def);
    LthMesh *mesh = test_one_cell(ctx, &s);
    LthPatches *p = NULL;
    LthFaceView face = lth_mesh_face(mesh, 0);
    LitheIndex n_quad;
    double *x = NULL, *weight = NULL;
    uint8_t chosen[1];
    allocations_left = n;
    LitheStatus status = lth_select_boundary(ctx, mesh, &w, &p);
    if (!status) status = lth_select_cells(ctx, mesh, &w, chosen);
    if (!status) status = lth_patch_quadrature(ctx, &face, 3, &n_quad, &x, &weight);
    done = status == LITHE_OK;
    assert_true(done || status == LITHE_NO_MEMORY);
    lth_free(ctx, x);
    lth_free(ctx, weight);
    lth_patches_destroy(ctx, &p);
    finish(ctx, mesh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_is_the_whole_boundary),
      cmocka_unit_test(boxes_divide_faces_exactly),
      cmocka_unit_test(a_closed_box_takes_the_face_it_touches),
      cmocka_unit_test(cuts_holed_and_forked_faces_exactly),
      cmocka_unit_test(complements_and_unions_add_up),
      cmocka_unit_test(half_spaces_agree_with_the_divergence_theorem),
      cmocka_unit_test(other_shapes_go_by_centroid),
      cmocka_unit_test(normals_select_sides),
      cmocka_unit_test(patches_grow_up_to_sharp_edges),
      cmocka_unit_test(cells_touch_the_selection_or_lie_in_it),
      cmocka_unit_test(labels_select_groups_of_faces_or_of_cells),
      cmocka_unit_test(quadrature_is_exact_on_divided_faces),
      cmocka_unit_test(survives_failing_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
