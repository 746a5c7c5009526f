/// Points beside a cut follow their own side, and nothing of the other.
#include "base/disjoint_sets.h"
#include "embed/embedding.h"
#include "embed/samples.h"
#include "topology_ops.h"

/// A mesh that was cut, its parts that hang together, and the points to be embedded, each with a cell.
typedef struct Cut {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  LitheIndex *part; ///< of each cell: its lowest cell
  LitheIndex n, n_cut;
  double *points;
  LitheIndex *cells;
} Cut;

/// Every corner of every boundary face with the cell behind it, and the centroids of all cells.
static void list_points(Cut *c) {
  const LthMesh *m = c->mesh;
  LitheIndex cap = m->loop_off[m->face_loop_off[m->n_faces]] + m->n_cells;
  c->points = calloc(3 * (size_t)cap, sizeof *c->points);
  c->cells = calloc((size_t)cap, sizeof *c->cells);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_cell[2 * f + 1] >= 0) continue;
    c->n_cut += m->face_tag[f] <= LTH_TAG_CUT;
    for (LitheIndex k = m->loop_off[m->face_loop_off[f]]; k < m->loop_off[m->face_loop_off[f + 1]];
         k++) {
      lth_v3_copy(m->points + 3 * m->loop_point[k], c->points + 3 * c->n);
      c->cells[c->n++] = m->face_cell[2 * f];
    }
  }
  for (LitheIndex i = 0; i < m->n_cells; i++) {
    lth_v3_copy(m->cell_centroid + 3 * i, c->points + 3 * c->n);
    c->cells[c->n++] = i;
  }
}

static void find_parts(Cut *c) {
  const LthMesh *m = c->mesh;
  c->part = calloc((size_t)m->n_cells, sizeof *c->part);
  lth_sets_reset(c->part, m->n_cells);
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (m->face_cell[2 * f + 1] >= 0)
      lth_sets_unite(c->part, m->face_cell[2 * f], m->face_cell[2 * f + 1]);
  for (LitheIndex i = 0; i < m->n_cells; i++) lth_sets_root(c->part, i);
  for (LitheIndex i = 0; i < m->n_cells; i++) c->part[i] = lth_sets_root(c->part, i);
}

/// Cut those cells of a mesh whose centroid is nearer than `radius` to the plane's point.
static Cut cut_mesh(LitheCtx *ctx, LthMesh *mesh, int n_planes, const LthPlane *planes,
                    double radius) {
  Cut c = {.ctx = ctx};
  LthTopology *t = NULL;
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  for (int k = 0; k < n_planes; k++) {
    LitheIndex *cells = calloc((size_t)t->n_cells, sizeof *cells), n = 0;
    LthCut cut;
    for (LitheIndex i = 0; i < t->n_cells; i++)
      if (t->cells[i].is_live && lth_v3_distance(t->cells[i].centroid, planes[k].point) < radius)
        cells[n++] = i;
    CHECK_OK(ctx, lth_topology_cut(ctx, t, n, cells, 1, planes + k, LTH_TAG_CUT - k, &cut));
    assert_true(cut.n_split > 0);
    free(cells);
  }
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &c.mesh, NULL, NULL));
  lth_topology_destroy(ctx, &t);
  lth_mesh_destroy(ctx, &mesh);
  CHECK_OK(ctx, lth_dg_space_create(ctx, c.mesh, 1, NULL, &c.space));
  find_parts(&c);
  list_points(&c);
  return c;
}

static void free_cut(Cut *c) {
  lth_dg_space_destroy(c->ctx, &c->space);
  lth_mesh_destroy(c->ctx, &c->mesh);
  assert_int_equal(lth_alloc_bytes(c->ctx), 0);
  lithe_ctx_destroy(&c->ctx);
  free(c->part);
  free(c->points);
  free(c->cells);
}

/// Affine map of a part: part 0 has number 0, others are far from it.
static void map(LitheIndex part, const double x[3], double u[3]) {
  double F[9] = {0.3, -1.1, 0.2, 0.7, 0.1, -0.4, 1.5, 0.6, -0.9};
  lth_v3_scale(1 + part % 5, F);
  lth_m3_apply(F, x, u);
  for (int a = 0; a < 3; a++) u[a] += 100.0 * (part % 7) + a;
}

static double *fields_of_parts(const Cut *c) {
  double *x0 = calloc((size_t)c->space->n_dofs, sizeof *x0);
  double *u = calloc((size_t)c->space->n_dofs, sizeof *u), zero[3] = {0}, shift[3];
  lth_dg_rest(c->space, x0);
  for (LitheIndex cell = 0; cell < c->mesh->n_cells; cell++) {
    map(c->part[cell], zero, shift);
    for (LitheIndex i = c->space->func_off[cell]; i < c->space->func_off[cell + 1]; i++) {
      map(c->part[cell], x0 + 3 * i, u + 3 * i);
      if (i > c->space->func_off[cell]) lth_v3_axpy(-1, shift, u + 3 * i);
    }
  }
  free(x0);
  return u;
}

/// All sides move by different affine maps: their points with them, to rounding.
static void check_sides_move_apart(const Cut *c, LthInterpolation how, LthSamples samples) {
  LthEmbedding *e = NULL;
  CHECK_OK(c->ctx,
           lth_embedding_create(c->ctx, c->space, c->n, c->points, c->cells, how, samples, &e));
  double *u = fields_of_parts(c);
  for (LitheIndex p = 0; p < c->n; p++) {
    double got[3], want[3];
    lth_embedding_point(e, p, u, got);
    map(c->part[c->cells[p]], c->points + 3 * p, want);
    for (int a = 0; a < 3; a++) CHECK_NEAR(got[a], want[a], 1e-11 * 600);
  }
  free(u);
  lth_embedding_destroy(c->ctx, &e);
}

static const LthGrid grid = {.min = {1, 2, 3}, .max = {2.2, 2.6, 3.9}, .cells = {4, 2, 3}};

static LthMesh *box(LitheCtx *ctx, bool tetrahedra) {
  LthMesh *mesh = NULL;
  if (tetrahedra)
    CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &mesh));
  else
    CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  return mesh;
}

static void sides_of_a_cut_never_mix(void **state) {
  (void)state;
  LthPlane planes[2] = {{{1.55, 2.3, 3.4}, {0.8, 0.5, 0.2}}, {{1.55, 2.3, 3.4}, {-0.3, 0.2, 0.9}}};
  for (int k = 0; k < 2; k++) lth_v3_normalize(planes[k].normal);
  for (int solid = 0; solid < 3; solid++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *mesh =
        solid < 2
            ? box(ctx, solid)
            : topology_sliced(ctx, solid_move(solid_sphere(ctx, 8), NULL, 0.7, planes[0].point), 3);
    Cut c = cut_mesh(ctx, mesh, 2, planes, 100);
    assert_true(c.n_cut > 8);
    for (int s = LTH_SAMPLE_NODES; s <= LTH_SAMPLE_CELLS; s++)
      check_sides_move_apart(&c, LTH_EMBED_MLS, (LthSamples)s);
    check_sides_move_apart(&c, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
    free_cut(&c);
  }
}

/// A cut along cell faces splits nothing, but all its points have two sides.
static void sides_of_a_cut_along_faces_never_mix(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = NULL;
  LthMesh *mesh = box(ctx, false);
  LthPlane plane = {{1.6, 2, 3}, {1, 0, 0}};
  Cut c = {.ctx = ctx};
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  assert_int_equal(topology_cut_all(ctx, t, &plane, LTH_TAG_CUT), 0);
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &c.mesh, NULL, NULL));
  lth_topology_destroy(ctx, &t);
  lth_mesh_destroy(ctx, &mesh);
  CHECK_OK(ctx, lth_dg_space_create(ctx, c.mesh, 2, NULL, &c.space));
  find_parts(&c);
  list_points(&c);
  assert_int_equal(c.n_cut, 12);
  for (int s = LTH_SAMPLE_NODES; s <= LTH_SAMPLE_CELLS; s++)
    check_sides_move_apart(&c, LTH_EMBED_MLS, (LthSamples)s);
  check_sides_move_apart(&c, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
  free_cut(&c);
}

/// A ring that is cut through at one place hangs together all the way round, but its two ends do not see each other.
static void ends_of_a_ring_do_not_see_each_other(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = topology_sliced(ctx, solid_torus(ctx, 1, 0.3, 24, 12), 10);
  LthPlane plane = {{1, 0.01, 0}, {0, 1, 0}};
  Cut c = cut_mesh(ctx, mesh, 1, &plane, 0.5);
  LthEmbedding *e = NULL;
  CHECK_OK(ctx, lth_embedding_create(ctx, c.space, c.n, c.points, c.cells, LTH_EMBED_MLS,
                                     LTH_SAMPLE_NODES, &e));
  LitheIndex n_near = 0;
  for (LitheIndex i = 0; i < c.mesh->n_cells; i++) assert_int_equal(c.part[i], 0);
  for (LitheIndex p = 0; p < c.n; p++) {
    double side = c.mesh->cell_centroid[3 * c.cells[p] + 1] - plane.point[1];
    if (lth_v3_distance(c.points + 3 * p, plane.point) > 0.4) continue;
    n_near++;
    for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++)
      for (LitheCount k = e->sample_row_off[e->sample[i]]; k < e->sample_row_off[e->sample[i] + 1];
           k++)
        assert_true(side * (c.mesh->cell_centroid[3 * e->sample_row[k] + 1] - plane.point[1]) > 0);
  }
  assert_true(n_near > 100);
  lth_embedding_destroy(ctx, &e);
  free_cut(&c);
}

/// Behind the front of a cut that ends inside, the sides meet: points there are single, and fields stay linear.
static void points_of_a_front_have_one_side(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthGrid plate = {.min = {0, 0, 0}, .max = {6, 4, 1}, .cells = {6, 4, 1}};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &plate, &mesh));
  LthPlane plane = {{0, 2, 0.5}, {0, 1, 0}};
  Cut c = cut_mesh(ctx, mesh, 0, NULL, 0);
  free_cut(&c);
  ctx = test_ctx();
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &plate, &mesh));
  plane.point[1] = 1.5; // through the middles of the second row, as far as x = 3
  c = cut_mesh(ctx, mesh, 1, &plane, 3.1);
  LthSampleSet *s = NULL;
  CHECK_OK(ctx, lth_samples_create_points(ctx, c.mesh, &s));
  int n_two = 0, n_front = 0;
  for (LitheIndex p = 0; p < c.mesh->n_points; p++) {
    const double *x = c.mesh->points + 3 * p;
    if (s->of_point[p] < 0 || x[1] != 1.5) continue;
    bool is_front = x[0] == 3;
    assert_int_equal(s->is_parted[p], !is_front);
    n_two += !is_front, n_front += is_front;
  }
  assert_int_equal(n_front, 2);
  assert_int_equal(n_two, 6);
  lth_samples_destroy(ctx, &s);
  for (int k = LTH_SAMPLE_NODES; k <= LTH_SAMPLE_CELLS; k++)
    check_sides_move_apart(&c, LTH_EMBED_MLS, (LthSamples)k); // one part: one affine field
  check_sides_move_apart(&c, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
  free_cut(&c);
}

static void no_point_of_a_whole_body_is_parted(void **state) {
  (void)state;
  for (int kind = 0; kind < TOPOLOGY_SOLIDS; kind++) {
    LitheCtx *ctx = test_ctx();
    LthMesh *mesh = topology_solid(ctx, kind);
    LthSampleSet *s = NULL;
    CHECK_OK(ctx, lth_samples_create_points(ctx, mesh, &s));
    LitheIndex n = 0;
    for (LitheIndex p = 0; p < mesh->n_points; p++) {
      assert_false(s->is_parted[p]);
      n += s->of_point[p] >= 0;
    }
    assert_int_equal(s->n, n);
    lth_samples_destroy(ctx, &s);
    lth_mesh_destroy(ctx, &mesh);
    lithe_ctx_destroy(&ctx);
  }
}

/// Contact nodes: both sides of a cut have theirs, and all areas add up to both sides' surface.
static void nodes_stand_on_both_sides(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthTopology *t = NULL;
  LthMesh *mesh = box(ctx, false);
  LthPlane plane = {{1.6, 2, 3}, {1, 0, 0}};
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  lth_mesh_destroy(ctx, &mesh);
  topology_cut_all(ctx, t, &plane, LTH_TAG_CUT);
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  lth_topology_destroy(ctx, &t);
  LthDgSpace *space = NULL;
  LthEmbedding *e = NULL;
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, 1, NULL, &space));
  LthDisc disc = {.mesh = mesh};
  CHECK_OK(ctx, lth_embedding_create_nodes(ctx, &disc, space, NULL, &e));
  double area = 0, want = 2 * (1.2 * 0.6 + 1.2 * 0.9 + 0.6 * 0.9) + 2 * 0.6 * 0.9;
  int left = 0, right = 0;
  for (LitheIndex p = 0; p < e->n_points; p++) {
    bool is_left = mesh->cell_centroid[3 * e->cell[p]] < 1.6;
    area += e->area[p];
    if (e->rest[3 * p] == 1.6) left += is_left, right += !is_left;
  }
  CHECK_NEAR(area, want, 1e-12 * want);
  assert_int_equal(left, 12);
  assert_int_equal(right, 12);
  lth_embedding_destroy(ctx, &e);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sides_of_a_cut_never_mix),
      cmocka_unit_test(sides_of_a_cut_along_faces_never_mix),
      cmocka_unit_test(ends_of_a_ring_do_not_see_each_other),
      cmocka_unit_test(points_of_a_front_have_one_side),
      cmocka_unit_test(no_point_of_a_whole_body_is_parted),
      cmocka_unit_test(nodes_stand_on_both_sides),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
