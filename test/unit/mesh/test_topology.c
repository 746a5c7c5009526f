/// Splits, cuts, separations and merges with known results.
#include "topology_ops.h"

static LthTopology *begin(LitheCtx *ctx, LthMesh *mesh) {
  LthTopology *t = NULL;
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  lth_mesh_destroy(ctx, &mesh);
  return t;
}

static LthTopology *hexahedra(LitheCtx *ctx, int n) {
  LthMesh *mesh = NULL;
  LthGrid g = {{0, 0, 0}, {n, n, n}, {n, n, n}};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &g, &mesh));
  return begin(ctx, mesh);
}

static LthPlane plane(double x, double y, double z, double nx, double ny, double nz) {
  return (LthPlane){{x, y, z}, {nx, ny, nz}};
}

static double volume_of_birth(const LthTopology *t, const LthSplit *s, LitheIndex i) {
  return t->cells[t->log.births[s->first + i].cell].volume;
}

static void end(LitheCtx *ctx, LthTopology *t) {
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  lth_topology_destroy(ctx, &t);
  lithe_ctx_destroy(&ctx);
}

static void a_cell_is_halved_and_its_neighbours_only_see_more_faces(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LthPlane p = plane(0.5, 0, 0, 1, 0, 0);
  LthSplit s;
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, -1, &s));
  assert_int_equal(s.n, 2);
  assert_int_equal(s.n_below, 1);
  CHECK_NEAR(volume_of_birth(t, &s, 0), 0.5, 1e-15);
  assert_int_equal(t->n_live_cells, 9);
  assert_int_equal(t->n_live_faces, 36 + 4 + 1); // four faces became two, and the cap
  assert_int_equal(t->log.n_changed_cells, 2);   // across y and z; boundary faces have nobody
  assert_int_equal(t->cells[1].n_faces, 6);      // across x: untouched
  assert_int_equal(t->cells[2].n_faces, 7);
  LthFaceView f = lth_topology_face(t, lth_topology_cell_faces(t, 6)[0]);
  assert_int_equal(f.loop_off[1], 4);
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  LitheIndex merged = -1;
  CHECK_OK(ctx, lth_topology_merge(ctx, t, t->log.births[s.first].cell,
                                   t->log.births[s.first + 1].cell, &merged));
  assert_int_equal(t->n_live_faces, 36); // faces side by side became one again
  for (LitheIndex i = 0; i < t->n_faces; i++)
    if (t->faces[i].is_live) assert_int_equal(t->faces[i].n_corners, 4);
  end(ctx, t);
}

static void a_plane_that_misses_changes_nothing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LthPlane planes[4] = {plane(-1, 0, 0, 1, 0, 0), plane(1, 0, 0, 1, 0, 0), plane(0, 0, 0, 1, 1, 1),
                        plane(1e-14, 0, 0, -1, 0, 0)};
  LitheIndex n_points = t->n_points;
  for (int i = 0; i < 4; i++) {
    LthSplit s;
    CHECK_OK(ctx, lth_topology_split(ctx, t, 0, planes + i, -1, &s));
    assert_int_equal(s.n, 0);
  }
  assert_int_equal(t->n_points, n_points);
  assert_int_equal(t->log.n_dead_faces + t->log.n_dead_cells + t->log.n_births, 0);
  end(ctx, t);
}

static void pieces_that_do_not_hang_together_are_cells_of_their_own(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  // three towers on a floor: the plane in which they stand cuts them off, one cell each
  LthTopology *t = begin(ctx, topology_letter(ctx, "\1\1\1\1\1\1\0\1\0\1", 5, 1, 2));
  LthSplit s;
  LthPlane p = plane(0, 0, 1, 0, 0, 1);
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, -1, &s));
  assert_int_equal(s.n, 4);
  assert_int_equal(s.n_below, 1);
  CHECK_NEAR(volume_of_birth(t, &s, 0), 5, 1e-14);
  for (int i = 1; i < 4; i++) CHECK_NEAR(volume_of_birth(t, &s, i), 1, 1e-14);
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  lth_topology_destroy(ctx, &t);

  // the same upside down, and sideways through the towers
  t = begin(ctx, topology_letter(ctx, "\1\0\1\0\1\1\1\1\1\1", 5, 1, 2));
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, -1, &s));
  assert_int_equal(s.n, 4);
  assert_int_equal(s.n_below, 3);
  lth_topology_destroy(ctx, &t);
  t = begin(ctx, topology_letter(ctx, "\1\1\1\1\1\1\0\1\0\1", 5, 1, 2));
  p.point[2] = 1.5;
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, -1, &s));
  assert_int_equal(s.n, 4);
  CHECK_NEAR(volume_of_birth(t, &s, 0), 6.5, 1e-14);
  end(ctx, t);
}

/// A roof with a groove whose bottom is an edge in the plane: what lies to its sides below hangs together by nothing.
static void a_ridge_in_the_plane_parts_what_lies_beside_it(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  TestSolid solid;
  double polygon[10] = {-2, 0, 0, 1,  2,
                        0,  2, 2, -2, 2}; // a notch from below with its tip at (0, 1)
  test_prism(&solid, 5, polygon, 0, NULL, 0, 1);
  for (int up = 0; up < 2; up++) {
    LthTopology *t = begin(ctx, test_one_cell(ctx, &solid));
    LthSplit s;
    LthPlane p = plane(0, 1, 0, 0, up ? 1 : -1, 0);
    CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, -1, &s));
    assert_int_equal(s.n, 3);
    assert_int_equal(s.n_below, up ? 2 : 1);
    CHECK_NEAR(volume_of_birth(t, &s, up ? 2 : 0), 4, 1e-14);
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
    lth_topology_destroy(ctx, &t);
  }
  lithe_ctx_destroy(&ctx);
}

static void a_ring_and_a_cavity_are_cut(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = begin(ctx, topology_ring(ctx));
  LthSplit s;
  LthPlane across = plane(0, 0, 0, 1, 0, 0), along = plane(0, 0, 0.3, 0, 0, 1);
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &along, -1, &s));
  assert_int_equal(s.n, 2); // two rings, joined by a face with a hole
  LitheIndex ring = t->log.births[s.first].cell;
  CHECK_OK(ctx, lth_topology_split(ctx, t, ring, &across, -1, &s));
  assert_int_equal(s.n, 2); // the halves of a ring meet in two faces
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  lth_topology_destroy(ctx, &t);
  t = begin(ctx, topology_solid(ctx, 6));
  LthPlane beside = plane(0.8, 0, 0, 1, 0, 0), through = plane(0.1, 0, 0, 1, 0.1, 0);
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &beside, -1, &s));
  assert_int_equal(s.n, 2); // the cavity stays with what is around it
  LitheIndex rest = t->log.births[s.first].cell;
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  CHECK_OK(ctx, lth_topology_split(ctx, t, rest, &through, -1, &s));
  assert_int_equal(s.n, 2);
  end(ctx, t);
}

static void neighbours_are_cut_in_the_same_points_in_any_order(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double first[300];
  LitheIndex n = 0;
  for (int order = 0; order < 2; order++) {
    LthTopology *t = hexahedra(ctx, 3);
    LthPlane p = plane(1.4, 1.3, 1.7, 0.3, 0.5, 0.7);
    LitheIndex before = t->n_points;
    for (LitheIndex i = 0; i < 27; i++) {
      LthSplit s;
      CHECK_OK(ctx, lth_topology_split(ctx, t, order ? 26 - i : i, &p, -1, &s));
    }
    if (order == 0) {
      n = t->n_points - before;
      assert_in_range(n, 10, 100);
      memcpy(first, t->points + 3 * before, sizeof *first * 3 * (size_t)n);
    }
    assert_int_equal(t->n_points - before, n);
    for (LitheIndex i = 0; i < n; i++) {
      int found = 0;
      for (LitheIndex j = 0; j < n; j++)
        found += memcmp(first + 3 * i, t->points + 3 * (before + j), 3 * sizeof *first) == 0;
      assert_int_equal(found, 1);
    }
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
    lth_topology_destroy(ctx, &t);
  }
  lithe_ctx_destroy(&ctx);
}

/// Number of parts that hang together by inner faces.
static LitheIndex components(LitheCtx *ctx, const LthTopology *t) {
  LthMesh *mesh = NULL;
  LthMeshQuality q;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  CHECK_OK(ctx, lth_mesh_quality(ctx, mesh, &q));
  lth_mesh_destroy(ctx, &mesh);
  return q.n_components;
}

static void a_cut_parts_the_body_inside_cells_and_along_their_faces(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int i = 0; i < 3; i++) {
    LthTopology *t = hexahedra(ctx, 4);
    LthPlane p = i == 0 ? plane(1.7, 2, 2, 1, 0.2, 0.1) : plane(2, 0, 0, 1, 0, 0);
    if (i == 2) p = plane(2, 2, 2, 1, 1, 0); // through edges and along diagonals
    double area = t->area;
    LitheIndex n_split = topology_cut_all(ctx, t, &p, LTH_TAG_CUT - i);
    assert_int_equal(n_split, i == 1 ? 0 : i == 2 ? 16 : n_split);
    assert_int_equal(components(ctx, t), 2);
    double cut = 0;
    for (LitheIndex f = 0; f < t->n_faces; f++)
      if (t->faces[f].is_live && t->faces[f].tag == LTH_TAG_CUT - i) cut += t->faces[f].area;
    double exact[3] = {2 * 16 * sqrt(1.05), 32, 2 * 16 * sqrt(2)};
    CHECK_NEAR(cut, exact[i], 1e-13 * exact[i]);
    assert_int_equal(topology_cut_all(ctx, t, &p, LTH_TAG_CUT - i), 0); // again: it is cut
    CHECK_NEAR(t->area, area, 0);
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
    lth_topology_destroy(ctx, &t);
  }
  lithe_ctx_destroy(&ctx);
}

static void a_cut_ends_where_its_cells_end(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int along = 0; along < 2; along++) { // inside cells, and along their faces
    LthTopology *t = hexahedra(ctx, 4);
    LitheIndex cells[64], n = 0;
    for (LitheIndex c = 0; c < 64; c++)
      if (t->cells[c].centroid[0] < 2) cells[n++] = c;
    LthPlane p = plane(0, 0, along ? 2 : 1.7, 0, 0, 1);
    LthCut cut;
    CHECK_OK(ctx, lth_topology_cut(ctx, t, n, cells, 1, &p, LTH_TAG_CUT, &cut));
    assert_int_equal(cut.n_split, along ? 0 : 8);
    assert_int_equal(cut.n_separated, along ? 8 : 0);
    CHECK_NEAR(cut.area, 8, 1e-14);
    assert_int_equal(components(ctx, t), 1);
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));

    // the rest of it later, with another number: now there are two pieces
    n = 0;
    for (LitheIndex c = 0; c < t->n_cells; c++)
      if (t->cells[c].is_live && t->cells[c].centroid[0] > 2) cells[n++] = c;
    CHECK_OK(ctx, lth_topology_cut(ctx, t, n, cells, 1, &p, LTH_TAG_CUT - 1, &cut));
    assert_int_equal(components(ctx, t), 2);
    CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
    lth_topology_destroy(ctx, &t);
  }
  lithe_ctx_destroy(&ctx);
}

static void planes_that_do_not_meet_part_all_the_same(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 3);
  LitheIndex cells[27];
  LthPlane planes[27];
  uint64_t seed = 5;
  for (int i = 0; i < 27; i++) {
    cells[i] = i;
    planes[i] = plane(1.5, 1.5, 1.5, 1, 0.1, 0.2);
    for (int a = 0; a < 3; a++) {
      planes[i].point[a] += 0.05 * test_random(&seed);
      planes[i].normal[a] += 0.05 * test_random(&seed);
    }
  }
  LthCut cut;
  CHECK_OK(ctx, lth_topology_cut(ctx, t, 27, cells, 27, planes, LTH_TAG_CUT, &cut));
  assert_true(cut.n_separated > 0);
  assert_int_equal(components(ctx, t), 2);
  end(ctx, t);
}

static void slivers_merge_but_never_across_a_cut(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 3);
  LthPlane p = plane(1.001, 0, 0, 1, 0, 0);
  assert_int_equal(topology_cut_all(ctx, t, &p, LTH_TAG_CUT), 9);
  assert_int_equal(t->n_live_cells, 36);
  LitheIndex n = 0;
  CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 0.01, &n));
  assert_int_equal(n, 9);
  assert_int_equal(t->n_live_cells, 27);
  assert_int_equal(components(ctx, t), 2);

  // a sliver between two cuts has no neighbour to go to
  LthPlane q = plane(1.002, 0, 0, 1, 0, 0);
  assert_int_equal(topology_cut_all(ctx, t, &q, LTH_TAG_CUT - 1), 9);
  LitheIndex before = t->n_live_cells;
  CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 1e-4, &n));
  assert_int_equal(components(ctx, t), 3);
  assert_int_equal(before - t->n_live_cells, n);
  end(ctx, t);
}

static void cells_at_the_tip_of_a_cut_do_not_close_it(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LthPlane p = plane(0, 0, 0.4, 0, 0, 1);
  LthSplit s;
  LitheIndex tip = 1, below = 0, above = 0;
  CHECK_OK(ctx, lth_topology_split(ctx, t, 0, &p, LTH_TAG_CUT, &s));
  below = t->log.births[s.first].cell, above = t->log.births[s.first + 1].cell;
  assert_false(lth_topology_may_merge(t, below, above));
  assert_true(lth_topology_may_merge(t, below, tip) && lth_topology_may_merge(t, above, tip));
  CHECK_OK(ctx, lth_topology_merge(ctx, t, below, tip, &tip));
  assert_false(lth_topology_may_merge(t, above, tip));
  LitheIndex n = 0;
  CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 1, &above, 0.7, &n));
  assert_int_equal(n, 1); // into a neighbour that the cut does not touch
  assert_false(lth_topology_may_merge(t, lth_topology_now(t, above), tip));
  end(ctx, t);
}

static void eight_and_two_make_as_many_and_merging_takes_them_back(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LthSplit s;
  CHECK_OK(ctx, lth_topology_split_eight(ctx, t, 0, &s));
  assert_int_equal(s.n, 8);
  assert_int_equal(t->n_live_cells, 15);
  CHECK_OK(ctx, lth_topology_split_eight(ctx, t, 7, &s));
  assert_int_equal(t->n_live_cells, 22);
  CHECK_OK(ctx, lth_topology_split_two(ctx, t, 1, (double[3]){1, 2, 3}, &s));
  assert_int_equal(t->n_live_cells, 23);
  CHECK_OK(ctx, lth_topology_check(ctx, t, 0, NULL));
  LitheIndex n = 0;
  CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 0.9, &n));
  assert_int_equal(n, 23 - t->n_live_cells);
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (t->cells[c].is_live) CHECK_AT_LEAST(t->cells[c].volume, 0.9);
  end(ctx, t);
}

static void records_and_points_are_used_again(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LitheIndex n_cells = 0, n_faces = 0, n_points = 0;
  LitheCount n_pool = 0;
  for (int i = 0; i < 200; i++) {
    LthSplit s;
    LitheIndex n = 0, cell = 0;
    while (!t->cells[cell].is_live) cell++;
    double normal[3] = {sin(i), cos(i), 0.3};
    CHECK_OK(ctx, lth_topology_split_two(ctx, t, cell, normal, &s));
    CHECK_OK(ctx, lth_topology_merge(ctx, t, t->log.births[s.first].cell,
                                     t->log.births[s.first + 1].cell, &n));
    CHECK_OK(ctx, lth_topology_forget(ctx, t));
    assert_int_equal(t->n_live_faces, 36);
    if (i == 20)
      n_cells = t->n_cells, n_faces = t->n_faces, n_points = t->n_points, n_pool = t->pool_cap;
  }
  assert_int_equal(t->n_cells, n_cells);
  assert_int_equal(t->n_faces, n_faces);
  assert_true(t->n_points <= n_points + 4);
  assert_true(t->pool_cap <= 4 * n_pool);
  end(ctx, t);
}

static void a_part_of_the_cells_is_a_mesh_of_its_own(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 3);
  LthSplit s;
  CHECK_OK(ctx, lth_topology_split_eight(ctx, t, 13, &s));
  LitheIndex cells[3] = {t->log.births[t->log.n_births - 1].cell, 14, 12}, *of_cell = NULL,
             *of_face = NULL;
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 3, cells, &mesh, &of_cell, &of_face));
  assert_int_equal(mesh->n_cells, 3);
  assert_memory_equal(of_cell, cells, sizeof cells);
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    CHECK_NEAR(mesh->face_area[f], t->faces[of_face[f]].area, 1e-15);
  lth_free(ctx, of_cell);
  lth_free(ctx, of_face);
  lth_mesh_destroy(ctx, &mesh);
  end(ctx, t);
}

static void parts_belong_to_the_groups_of_the_whole(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid g = {{0, 0, 0}, {2, 2, 2}, {2, 2, 2}};
  LthMesh *first = NULL, *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &g, &first));
  LthMeshGroup groups[2] = {{.name = "soft", .tag = 7, .of_cells = true, .n = 1},
                            {.name = "down", .tag = -1, .n = 0}};
  LitheIndex soft = 3, down[4];
  for (LitheIndex f = 0; f < first->n_faces; f++)
    if (first->face_cell[2 * f + 1] < 0 && first->face_normal[3 * f + 2] < -0.5)
      down[groups[1].n++] = f;
  assert_int_equal(groups[1].n, 4);
  groups[0].member = &soft;
  groups[1].member = down;
  first->groups = groups;
  first->n_groups = 2;
  LthTopology *t = NULL;
  CHECK_OK(ctx, lth_topology_create(ctx, first, &t));
  LthPlane p = plane(1.5, 1.5, 0, 1, 1, 0.2);
  topology_cut_all(ctx, t, &p, LTH_TAG_CUT);
  LitheIndex *of_cell = NULL, *of_face = NULL;
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, &of_cell, &of_face));
  CHECK_OK(ctx, lth_topology_groups(ctx, t, first, of_cell, of_face, mesh));
  assert_int_equal(mesh->n_groups, 2);
  assert_string_equal(mesh->groups[0].name, "soft");
  double volume = 0, area = 0;
  for (LitheIndex i = 0; i < mesh->groups[0].n; i++)
    volume += mesh->cell_volume[mesh->groups[0].member[i]];
  for (LitheIndex i = 0; i < mesh->groups[1].n; i++)
    area += mesh->face_area[mesh->groups[1].member[i]];
  assert_true(mesh->groups[0].n > 1 && mesh->groups[1].n > 4);
  CHECK_NEAR(volume, 1, 1e-14);
  CHECK_NEAR(area, 4, 1e-14);
  first->groups = NULL;
  first->n_groups = 0;
  lth_free(ctx, of_cell);
  lth_free(ctx, of_face);
  lth_mesh_destroy(ctx, &first);
  lth_mesh_destroy(ctx, &mesh);
  end(ctx, t);
}

static void what_cells_were_and_became_is_known(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = hexahedra(ctx, 2);
  LthSplit s;
  CHECK_OK(ctx, lth_topology_split_eight(ctx, t, 5, &s));
  LitheIndex child = t->log.births[t->log.n_births - 1].cell, merged = -1;
  assert_int_equal(lth_topology_before(t, child), 5);
  assert_int_equal(lth_topology_before(t, 2), 2);
  assert_int_equal(lth_topology_now(t, 5), -1);
  assert_true(lth_topology_may_merge(t, 0, 1));
  CHECK_OK(ctx, lth_topology_merge(ctx, t, 0, 1, &merged));
  assert_int_equal(lth_topology_now(t, 0), merged);
  assert_int_equal(lth_topology_now(t, 1), merged);
  assert_int_equal(lth_topology_before(t, merged), -1);
  CHECK_OK(ctx, lth_topology_forget(ctx, t));
  assert_int_equal(lth_topology_before(t, child), child);
  end(ctx, t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cell_is_halved_and_its_neighbours_only_see_more_faces),
      cmocka_unit_test(a_plane_that_misses_changes_nothing),
      cmocka_unit_test(pieces_that_do_not_hang_together_are_cells_of_their_own),
      cmocka_unit_test(a_ridge_in_the_plane_parts_what_lies_beside_it),
      cmocka_unit_test(a_ring_and_a_cavity_are_cut),
      cmocka_unit_test(neighbours_are_cut_in_the_same_points_in_any_order),
      cmocka_unit_test(a_cut_parts_the_body_inside_cells_and_along_their_faces),
      cmocka_unit_test(a_cut_ends_where_its_cells_end),
      cmocka_unit_test(planes_that_do_not_meet_part_all_the_same),
      cmocka_unit_test(slivers_merge_but_never_across_a_cut),
      cmocka_unit_test(cells_at_the_tip_of_a_cut_do_not_close_it),
      cmocka_unit_test(eight_and_two_make_as_many_and_merging_takes_them_back),
      cmocka_unit_test(records_and_points_are_used_again),
      cmocka_unit_test(parts_belong_to_the_groups_of_the_whole),
      cmocka_unit_test(what_cells_were_and_became_is_known),
      cmocka_unit_test(a_part_of_the_cells_is_a_mesh_of_its_own),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
