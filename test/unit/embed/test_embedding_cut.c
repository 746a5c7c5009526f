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

/// A plate of 8 x 6 x 2 cells of size 1, cut along y = 2.5 from its left up to x = 4.
static Cut cracked_plate(void) {
  LitheCtx *ctx = test_ctx();
  LthGrid plate = {.min = {0, 0, 0}, .max = {8, 6, 2}, .cells = {8, 6, 2}};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &plate, &mesh));
  LthPlane plane = {{0, 2.5, 1}, {0, 1, 0}};
  return cut_mesh(ctx, mesh, 1, &plane, 4.1);
}

/// Embed n places, each in the element around it (on the cut: above it where `above`).
static LthEmbedding *embed_places(const Cut *c, LitheIndex n, double *x, const bool *above) {
  LthEmbedding *e = NULL;
  LitheIndex *cell = calloc((size_t)n, sizeof *cell);
  for (LitheIndex p = 0; p < n; p++) {
    double in[3] = {x[3 * p], x[3 * p + 1] + (above[p] ? 1e-6 : -1e-6), x[3 * p + 2]};
    bool inside = false;
    CHECK_OK(c->ctx, lth_find_cell(c->ctx, c->mesh, in, &cell[p], &inside));
    assert_true(inside);
  }
  CHECK_OK(c->ctx,
           lth_embedding_create(c->ctx, c->space, n, x, cell, LTH_EMBED_MLS, LTH_SAMPLE_NODES, &e));
  free(cell);
  return e;
}

/// Share of a point's weights, in absolute value, that elements beyond the cut have behind its front.
static double share_beyond(const Cut *c, const LthEmbedding *e, LitheIndex p, bool above) {
  double all = 0, beyond = 0;
  for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) {
    LitheIndex s = e->sample[i];
    double n = (double)(e->sample_row_off[s + 1] - e->sample_row_off[s]);
    for (LitheCount k = e->sample_row_off[s]; k < e->sample_row_off[s + 1]; k++) {
      const double *middle = c->mesh->cell_centroid + 3 * e->sample_row[k];
      bool is_beyond = middle[0] < 4 && (middle[1] > 2.5) != above;
      all += fabs(e->weight[i]) / n;
      beyond += is_beyond * fabs(e->weight[i]) / n;
    }
  }
  return beyond / all;
}

/// Along both faces of a cut the other side counts less and less, and nothing from half a radius behind the front on:
/// there and back is a radius.
static void sides_do_not_mix_behind_a_front(void **state) {
  (void)state;
  Cut c = cracked_plate();
  enum { N = 40 };
  double x[2 * N * 3];
  bool above[2 * N];
  for (LitheIndex k = 0; k < 2 * N; k++) {
    above[k] = k >= N;
    x[3 * k] = 4 - 0.1 * (k % N), x[3 * k + 1] = 2.5, x[3 * k + 2] = 0.8;
  }
  LthEmbedding *e = embed_places(&c, 2 * N, x, above);
  for (LitheIndex k = 0; k < 2 * N; k++) {
    double share = share_beyond(&c, e, k, above[k]), behind = 4 - x[3 * k];
    double before = k % N ? share_beyond(&c, e, k - 1, above[k]) : 1;
    assert_true(share <= before + 0.02);
    if (behind > 2.01) assert_true(share == 0);
  }
  lth_embedding_destroy(c.ctx, &e);
  free_cut(&c);
}

/// The largest change of a weight from place to place on a circle around the front, from one side of the cut to the other.
static double largest_change(const Cut *c, LitheIndex n) {
  double *x = calloc(3 * (size_t)n, sizeof *x), largest = 0;
  bool *above = calloc((size_t)n, sizeof *above);
  for (LitheIndex k = 0; k < n; k++) {
    double angle = M_PI * (2.0 * k / (n - 1) - 1);
    x[3 * k] = 4.03 + 0.45 * cos(angle), x[3 * k + 1] = 2.5 + 0.45 * sin(angle);
    x[3 * k + 2] = 0.8;
    if (k == 0 || k == n - 1) x[3 * k + 1] = 2.5;
    above[k] = angle > 0;
  }
  LthEmbedding *e = embed_places(c, n, x, above);
  double *w[2];
  for (int i = 0; i < 2; i++) w[i] = calloc((size_t)e->n_funcs, sizeof *w[i]);
  for (LitheIndex k = 0; k < n; k++) {
    lth_embedding_weights(e, k, w[k % 2]);
    for (LitheIndex i = 0; k > 0 && i < e->n_funcs; i++)
      largest = fmax(largest, fabs(w[0][i] - w[1][i]));
  }
  for (int i = 0; i < 2; i++) free(w[i]);
  lth_embedding_destroy(c->ctx, &e);
  free(x);
  free(above);
  return largest;
}

static void weights_pass_smoothly_around_a_front(void **state) {
  (void)state;
  Cut c = cracked_plate();
  double coarse = largest_change(&c, 200), fine = largest_change(&c, 1600);
  print_message("%g %g\n", coarse, fine);
  assert_true(fine < coarse / 4);
  free_cut(&c);
}

static LthEmbedding *renew_ball(const Cut *c, const LthTopology *t, const LthSurface *s,
                                LthMesh **mesh, LthDgSpace **space, LthEmbeddingRows **rows) {
  LitheIndex *record = NULL, *cell = calloc((size_t)s->n_points, sizeof *cell);
  LthEmbedding *e = NULL;
  CHECK_OK(c->ctx, lth_topology_mesh(c->ctx, t, 0, NULL, mesh, &record, NULL));
  CHECK_OK(c->ctx, lth_dg_space_create(c->ctx, *mesh, 1, NULL, space));
  CHECK_OK(c->ctx, lth_surface_point_cells(c->ctx, *mesh, cell));
  CHECK_OK(c->ctx, lth_embedding_renew(c->ctx, *space, s->n_points, s->points, cell, LTH_EMBED_MLS,
                                       LTH_SAMPLE_FACES, record, rows, &e));
  lth_free(c->ctx, record);
  free(cell);
  return e;
}

/// Few cells at a time are divided, cut or merged: rows are taken from before, and all are those of an embedding from nothing.
static void rows_that_are_kept_are_what_they_would_be(void **state) {
  (void)state;
  Cut c = {.ctx = test_ctx()};
  LthSurface *s = solid_sphere(c.ctx, 24);
  LthTopology *t = NULL;
  LthMesh *mesh = NULL;
  LthEmbeddingRows *rows = NULL;
  LthGrid g = cubic_grid(s, 12);
  uint64_t random = 7;
  LitheCount n_kept = 0, n_points = 0;
  LthPlane last = {{0, 0, 0}, {1, 0, 0}};
  TopologyRun run = {0};
  CHECK_OK(c.ctx, lth_mesh_slice(c.ctx, s, &g, 0.05, &mesh));
  CHECK_OK(c.ctx, lth_topology_create(c.ctx, mesh, &t));
  lth_mesh_destroy(c.ctx, &mesh);
  for (int turn = 0; turn < 6; turn++) {
    LthDgSpace *space = NULL;
    LthEmbedding *full = NULL;
    LthEmbeddingRows *none = NULL;
    LthEmbedding *kept = renew_ball(&c, t, s, &mesh, &space, &rows);
    n_kept += lth_embedding_rows_kept(rows);
    n_points += turn > 0 ? s->n_points : 0;
    lth_dg_space_destroy(c.ctx, &space);
    lth_mesh_destroy(c.ctx, &mesh);
    full = renew_ball(&c, t, s, &mesh, &space, &none);
    assert_int_equal(lth_embedding_rows_kept(none), 0);
    assert_int_equal(kept->n_samples, full->n_samples);
    size_t n = (size_t)full->off[full->n_points];
    assert_memory_equal(kept->off, full->off, sizeof *full->off * ((size_t)s->n_points + 1));
    assert_memory_equal(kept->sample, full->sample, sizeof *full->sample * n);
    assert_memory_equal(kept->weight, full->weight, sizeof *full->weight * n);
    lth_embedding_rows_destroy(c.ctx, &none);
    lth_embedding_destroy(c.ctx, &kept);
    lth_embedding_destroy(c.ctx, &full);
    lth_dg_space_destroy(c.ctx, &space);
    lth_mesh_destroy(c.ctx, &mesh);
    if (turn % 3 == 1) continue; // nothing happened
    for (int i = 0; i < 2; i++) topology_random_operation(c.ctx, t, &last, 4, &random, &run);
    CHECK_OK(c.ctx, lth_topology_forget(c.ctx, t));
  }
  print_message("%lld of %lld rows kept\n", (long long)n_kept, (long long)n_points);
  assert_true(n_kept > n_points / 3);
  lth_embedding_rows_destroy(c.ctx, &rows);
  lth_topology_destroy(c.ctx, &t);
  solid_free(c.ctx, &s);
  assert_int_equal(lth_alloc_bytes(c.ctx), 0);
  lithe_ctx_destroy(&c.ctx);
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
      cmocka_unit_test(rows_that_are_kept_are_what_they_would_be),
      cmocka_unit_test(sides_do_not_mix_behind_a_front),
      cmocka_unit_test(weights_pass_smoothly_around_a_front),
      cmocka_unit_test(nodes_stand_on_both_sides),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
