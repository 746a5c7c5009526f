/// Surfaces of bodies that are cut: closed, with the volume of the body, whatever is done to it.
#include "closed_soup.h"
#include "failing_memory.h"
#include "mesh/skin.h"
#include "topology_ops.h"

typedef struct Body {
  LitheCtx *ctx;
  LthTopology *t;
  LthSkin *skin;
} Body;

/// A skin of the boundary faces of a mesh, each a polygon; texture coordinates linear in the place.
static LthSoup *boundary_soup(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *point,
                              LitheIndex *face_facet) {
  LthSoup *s = NULL;
  LitheIndex n = 0, k = 0;
  CHECK_OK(ctx, lth_mesh_boundary_soup(ctx, mesh, &s));
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    face_facet[f] = mesh->face_cell[2 * f + 1] < 0 ? n++ : -1;
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         face_facet[f] >= 0 && i < mesh->loop_off[mesh->face_loop_off[f] + 1]; i++)
      point[s->poly_point[k++]] = mesh->loop_point[i];
  return s;
}

static void texture(const double x[3], double uv[2]) {
  uv[0] = 0.3 * x[0] - 0.2 * x[1] + 0.7 * x[2] + 0.1;
  uv[1] = -0.1 * x[0] + 0.9 * x[1] + 0.2 * x[2];
}

static void add_texture(LitheCtx *ctx, LthSoup *s) {
  LitheIndex n = s->poly_off[s->n_polys];
  s->n_uvs = s->n_points;
  s->uvs = lth_alloc(ctx, 2 * s->n_uvs, sizeof *s->uvs);
  s->poly_uv = lth_alloc(ctx, n, sizeof *s->poly_uv);
  for (LitheIndex p = 0; p < s->n_points; p++) texture(s->points + 3 * p, s->uvs + 2 * p);
  memcpy(s->poly_uv, s->poly_point, sizeof *s->poly_uv * (size_t)n);
}

static Body begin(LitheCtx *ctx, LthMesh *mesh) {
  Body b = {.ctx = ctx};
  LitheIndex *facet = calloc((size_t)mesh->n_faces, sizeof *facet),
             *point = calloc((size_t)mesh->n_points, sizeof *point);
  LthSoup *soup = boundary_soup(ctx, mesh, point, facet);
  add_texture(ctx, soup);
  LitheIndex *poly = calloc((size_t)soup->n_polys, sizeof *poly);
  for (LitheIndex i = 0; i < soup->n_polys; i++) poly[i] = i;
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &b.t));
  LthSkinDef def = {.topology = b.t,
                    .soup = soup,
                    .point = point,
                    .n_facets = soup->n_polys,
                    .facet_poly = poly,
                    .face_facet = facet,
                    .n_faces = mesh->n_faces};
  CHECK_OK(ctx, lth_skin_create(ctx, &def, &b.skin));
  lth_soup_destroy(ctx, &soup);
  lth_mesh_destroy(ctx, &mesh);
  free(facet);
  free(point);
  free(poly);
  return b;
}

/// The same of a sliced surface: its triangles are the polygons.
static Body begin_sliced(LitheCtx *ctx, LthSurface *s, int cells) {
  Body b = {.ctx = ctx};
  LthMesh *mesh = NULL;
  LthGrid g = cubic_grid(s, cells);
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &mesh));
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &b.t));
  LitheIndex *point = calloc((size_t)s->n_points, sizeof *point),
             *off = calloc((size_t)s->n_tris + 1, sizeof *off);
  for (LitheIndex i = 0; i < s->n_points; i++) point[i] = i;
  for (LitheIndex i = 0; i <= s->n_tris; i++) off[i] = 3 * i;
  LthSoup soup = {.n_points = s->n_points,
                  .n_polys = s->n_tris,
                  .points = s->points,
                  .poly_off = off,
                  .poly_point = s->tris};
  LitheIndex *poly = calloc((size_t)s->n_tris, sizeof *poly);
  for (LitheIndex i = 0; i < s->n_tris; i++) poly[i] = i;
  LthSkinDef def = {.topology = b.t,
                    .soup = &soup,
                    .point = point,
                    .n_facets = s->n_tris,
                    .facet_poly = poly,
                    .face_facet = mesh->face_tag,
                    .n_faces = mesh->n_faces};
  CHECK_OK(ctx, lth_skin_create(ctx, &def, &b.skin));
  lth_mesh_destroy(ctx, &mesh);
  solid_free(ctx, &s);
  free(point);
  free(off);
  free(poly);
  return b;
}

static void end(Body *b) {
  lth_skin_destroy(b->ctx, &b->skin);
  lth_topology_destroy(b->ctx, &b->t);
  assert_int_equal(lth_alloc_bytes(b->ctx), 0);
  lithe_ctx_destroy(&b->ctx);
}

static void renew(Body *b) {
  CHECK_OK(b->ctx, lth_skin_follow(b->ctx, b->skin, b->t));
  CHECK_OK(b->ctx, lth_skin_update(b->ctx, b->skin, b->t));
  CHECK_OK(b->ctx, lth_topology_forget(b->ctx, b->t));
}

static void check_closed(const LthSoup *s) {
  LitheIndex open[2];
  if (!soup_is_closed(s, open))
    fail_msg("edge %d %d is open: (%g %g %g)", open[0], open[1], s->points[3 * open[0]],
             s->points[3 * open[0] + 1], s->points[3 * open[0] + 2]);
  if (!soup_is_manifold(s, open))
    fail_msg("edge %d %d has other than two polygons: (%g %g %g)", open[0], open[1],
             s->points[3 * open[0]], s->points[3 * open[0] + 1], s->points[3 * open[0] + 2]);
}

static double polygon_volume(const LthSoup *s, LitheIndex p, double *area) {
  double volume = 0, sum[3] = {0, 0, 0};
  for (LitheIndex i = s->poly_off[p] + 1; i + 1 < s->poly_off[p + 1]; i++) {
    const double *x = s->points + 3 * s->poly_point[s->poly_off[p]],
                 *y = s->points + 3 * s->poly_point[i], *z = s->points + 3 * s->poly_point[i + 1];
    double c[3], e[3], f[3];
    lth_v3_sub(y, x, e);
    lth_v3_sub(z, x, f);
    lth_v3_cross(e, f, c);
    lth_v3_axpy(0.5, c, sum);
    volume += lth_v3_dot(c, x) / 6;
  }
  *area += lth_v3_norm(sum);
  return volume;
}

/// The surface is closed; each polygon's points belong to one part of the body, and what the polygons of a part
/// enclose is its volume; all together they have the area of the boundary.
static void check_skin(const Body *b) {
  const LthTopology *t = b->t;
  const LthSoup *s = b->skin->soup;
  LitheIndex *part = find_parts(t);
  double *volume = calloc((size_t)t->n_cells, sizeof *volume), area = 0, want = 0;
  check_closed(s);
  for (LitheIndex p = 0; p < s->n_polys; p++) {
    LitheIndex of = part[b->skin->cell[s->poly_point[s->poly_off[p]]]];
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++)
      assert_int_equal(part[b->skin->cell[s->poly_point[i]]], of);
    volume[of] += polygon_volume(s, p, &area);
  }
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (t->cells[c].is_live) volume[part[c]] -= t->cells[c].volume;
  for (LitheIndex c = 0; c < t->n_cells; c++) CHECK_NEAR(volume[c], 0, 1e-12 * t->volume);
  for (LitheIndex f = 0; f < t->n_faces; f++)
    if (t->faces[f].is_live && t->faces[f].cell[1] < 0) want += t->faces[f].area;
  CHECK_NEAR(area, want, 1e-12 * want);
  free(part);
  free(volume);
}

/// Texture is the linear function that it was where the polygon is one of the first, and the same on both sides of cuts.
static void check_texture(const Body *b) {
  const LthSoup *s = b->skin->soup;
  for (LitheIndex p = 0; p < s->n_polys - b->skin->n_caps; p++)
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++) {
      double want[2];
      texture(s->points + 3 * s->poly_point[i], want);
      for (int a = 0; a < 2; a++) CHECK_NEAR(s->uvs[2 * s->poly_uv[i] + a], want[a], 1e-11);
    }
}

static void a_cube_falls_into_two_boxes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  LthGrid g = {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &g, &mesh));
  Body b = begin(ctx, mesh);
  LthPlane plane = {{0.25, 0, 0}, {1, 0, 0}};
  renew(&b);
  assert_int_equal(b.skin->soup->n_polys, 6);
  assert_int_equal(b.skin->n_caps, 0);
  assert_int_equal(topology_cut_all(ctx, b.t, &plane, LTH_TAG_CUT), 1);
  renew(&b);
  const LthSoup *s = b.skin->soup;
  assert_int_equal(s->n_points, 8 + 8);
  assert_int_equal(s->n_polys, 2 + 8 + 2);
  assert_int_equal(b.skin->n_caps, 2);
  assert_string_equal(s->group_names[s->poly_group[11]], "cut");
  for (LitheIndex p = 0; p < 12; p++) assert_int_equal(s->poly_off[p + 1] - s->poly_off[p], 4);
  for (LitheIndex p = 0; p < 8; p++)
    for (int a = 0; a < 3; a++) assert_true(s->points[3 * p + a] == 0 || s->points[3 * p + a] == 1);
  // texture of the two caps: the same at the same place, in metres
  for (LitheIndex i = s->poly_off[10]; i < s->poly_off[11]; i++) {
    int n = 0;
    for (LitheIndex j = s->poly_off[11]; j < s->poly_off[12]; j++) {
      const double *x = s->points + 3 * s->poly_point[i], *y = s->points + 3 * s->poly_point[j];
      const double *u = s->uvs + 2 * s->poly_uv[i], *v = s->uvs + 2 * s->poly_uv[j];
      n += lth_v3_distance(x, y) == 0 && u[0] == v[0] && u[1] == v[1];
      CHECK_NEAR(hypot(u[0] - v[0], u[1] - v[1]), lth_v3_distance(x, y), 1e-15);
    }
    assert_int_equal(n, 1);
  }
  check_skin(&b);
  check_texture(&b);
  end(&b);
}

/// A blade that ends inside a polygon: the slit is open, its end is one point, and the surface is closed.
static void a_cut_may_end_inside_a_polygon(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
  Body b = begin_sliced(ctx, solid_box(ctx, low, high), 4);
  LthPlane plane = {{0, 0.4, 0}, {0.1, 1, 0}};
  lth_v3_normalize(plane.normal);
  LitheIndex cells[64], n = 0;
  for (LitheIndex c = 0; c < b.t->n_cells; c++)
    if (b.t->cells[c].centroid[0] < 0.5) cells[n++] = c;
  LthCut cut;
  CHECK_OK(ctx, lth_topology_cut(ctx, b.t, n, cells, 1, &plane, LTH_TAG_CUT, &cut));
  assert_int_equal(cut.n_split, 8);
  renew(&b);
  check_skin(&b);
  const LthSoup *s = b.skin->soup;
  int n_front = 0, n_mouth = 0;
  for (LitheIndex p = 0; p < s->n_points; p++) {
    const double *x = s->points + 3 * p;
    double height = (x[0] - plane.point[0]) * 0.1 + x[1] - plane.point[1];
    if (fabs(height) > 1e-14) continue;
    n_front += x[0] == 0.5;
    n_mouth += x[0] == 0;
  }
  assert_int_equal(n_front, 5);
  assert_int_equal(n_mouth, 12); // the diagonal of that side as well
  // a second blade goes on from there: the body falls apart
  for (n = 0; n < 8; n++) cells[n] = -1;
  n = 0;
  for (LitheIndex c = 0; c < b.t->n_cells; c++)
    if (b.t->cells[c].is_live && b.t->cells[c].centroid[0] > 0.5) cells[n++] = c;
  LitheIndex before = s->n_points;
  double *old = malloc(sizeof *old * 3 * (size_t)before);
  memcpy(old, s->points, sizeof *old * 3 * (size_t)before);
  CHECK_OK(ctx, lth_topology_cut(ctx, b.t, n, cells, 1, &plane, LTH_TAG_CUT - 1, &cut));
  renew(&b);
  check_skin(&b);
  assert_memory_equal(old, s->points, sizeof *old * 3 * (size_t)before);
  assert_true(s->n_points > before);
  LitheIndex *part = find_parts(b.t), n_parts = 0;
  for (LitheIndex c = 0; c < b.t->n_cells; c++) n_parts += b.t->cells[c].is_live && part[c] == c;
  assert_int_equal(n_parts, 2);
  free(part);
  free(old);
  end(&b);
}

/// Follow some operations: points that were there stay where they are, and keep their numbers.
static void renew_and_compare(Body *b) {
  LitheIndex n = b->skin->soup->n_points;
  size_t size = sizeof(double) * 3 * (size_t)n;
  double *old = malloc(size);
  memcpy(old, b->skin->soup->points, size);
  renew(b);
  assert_true(b->skin->soup->n_points >= n);
  assert_memory_equal(old, b->skin->soup->points, size);
  free(old);
}

/// Random cuts, splits, separations and merges of random solids.
static void surfaces_stay_closed_under_random_operations(void **state) {
  (void)state;
  const char *text = getenv("LITHE_TEST_OPERATIONS");
  int n = text ? atoi(text) : 1500, n_updates = 0;
  uint64_t seed = 20;
  TopologyRun run = {0};
  for (int done = 0, kind = 0; done < n; done += 40, kind = (kind + 1) % TOPOLOGY_SOLIDS) {
    LitheCtx *ctx = test_ctx();
    LthMesh *mesh = topology_solid(ctx, kind);
    bool has_holes = false;
    for (LitheIndex f = 0; f < mesh->n_faces; f++)
      has_holes |= mesh->face_loop_off[f + 1] - mesh->face_loop_off[f] > 1;
    if (has_holes) {
      lth_mesh_destroy(ctx, &mesh);
      lithe_ctx_destroy(&ctx);
      continue;
    }
    Body b = begin(ctx, mesh);
    LthPlane last = {{0, 0, 0}, {1, 0, 0}};
    for (int i = 0; i < 40; i++) {
      topology_random_operation(ctx, b.t, &last, 60, &seed, &run);
      if (topology_int(&seed, 3)) continue;
      renew_and_compare(&b);
      check_skin(&b);
      check_texture(&b);
      n_updates++;
    }
    end(&b);
  }
  print_message("%d updates, %d splits, %d cuts, %d merges\n", n_updates, run.n_splits, run.n_cuts,
                run.n_merges);
  assert_true(n_updates > n / 6);
}

/// Surfaces whose triangles lie across many elements.
static void sliced_surfaces_stay_closed(void **state) {
  (void)state;
  uint64_t seed = 3;
  for (int kind = 0; kind < 3; kind++) {
    LitheCtx *ctx = test_ctx();
    double low[3] = {0, 0, 0}, high[3] = {1, 0.7, 0.9};
    LthSurface *s = kind == 0   ? solid_torus(ctx, 1, 0.4, 16, 9)
                    : kind == 1 ? solid_box(ctx, low, high)
                                : solid_star(ctx, 5, 0.4, 1, 0.5);
    Body b = begin_sliced(ctx, s, 4);
    for (int i = 0; i < 12; i++) {
      LitheIndex cells[1000], n = 0, middle = topology_random_cell(b.t, &seed);
      LthPlane plane;
      LthCut cut;
      lth_v3_copy(b.t->cells[middle].centroid, plane.point);
      topology_direction(&seed, plane.normal);
      if (i % 4 == 3) plane.normal[0] = 0, plane.normal[1] = 0, plane.normal[2] = 1;
      double reach = i % 3 == 2 ? 10 : 0.2 + 0.4 * test_random(&seed);
      for (LitheIndex c = 0; c < b.t->n_cells && n < 1000; c++)
        if (b.t->cells[c].is_live && lth_v3_distance(b.t->cells[c].centroid, plane.point) < reach)
          cells[n++] = c;
      LitheIndex tag = i % 5 == 4 ? -1 : LTH_TAG_CUT - i;
      CHECK_OK(ctx, lth_topology_cut(ctx, b.t, n, cells, 1, &plane, tag, &cut));
      renew_and_compare(&b);
      check_skin(&b);
    }
    end(&b);
  }
}

/// Memory fails from the n-th allocation on.
static int allocations_left;

/// Memory may run out anywhere: it is told, and nothing is lost.
static void running_out_of_memory_is_told(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_torus(ctx, 1, 0.4, 8, 5);
  LthMesh *mesh = NULL;
  LthTopology *t = NULL;
  LthGrid g = cubic_grid(s, 2);
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &mesh));
  LitheIndex point[40], off[81], poly[80];
  for (LitheIndex i = 0; i <= 80; i++) off[i] = 3 * i;
  for (LitheIndex i = 0; i < 80; i++) poly[i] = i;
  for (LitheIndex i = 0; i < 40; i++) point[i] = i;
  LthSoup soup = {
      .n_points = 40, .n_polys = 80, .points = s->points, .poly_off = off, .poly_point = s->tris};
  add_texture(ctx, &soup);
  LthPlane plane = {{0, 0, 0}, {0.6, 0, 0.8}};
  for (int n = 0, done = 0; !done; n++) {
    LitheCtxDef ctx_def = lithe_ctx_def_default();
    LthSkin *skin = NULL;
    CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
    LthSkinDef def = {.topology = t,
                      .soup = &soup,
                      .point = point,
                      .n_facets = 80,
                      .facet_poly = poly,
                      .face_facet = mesh->face_tag,
                      .n_faces = mesh->n_faces};
    ctx_def.allocate = test_failing_allocate;
    ctx_def.memory_user = &allocations_left;
    allocations_left = n;
    LitheCtx *failing = lithe_ctx_create(&ctx_def);
    LitheStatus status = failing ? lth_skin_create(failing, &def, &skin) : LITHE_NO_MEMORY;
    topology_cut_all(ctx, t, &plane, LTH_TAG_CUT);
    if (status == LITHE_OK) status = lth_skin_follow(failing, skin, t);
    if (status == LITHE_OK) status = lth_skin_update(failing, skin, t);
    done = status == LITHE_OK;
    assert_true(done || status == LITHE_NO_MEMORY);
    lth_skin_destroy(failing, &skin);
    if (failing) assert_int_equal(lth_alloc_bytes(failing), 0);
    lithe_ctx_destroy(&failing);
    lth_topology_destroy(ctx, &t);
  }
  lth_free(ctx, soup.uvs);
  lth_free(ctx, soup.poly_uv);
  lth_mesh_destroy(ctx, &mesh);
  solid_free(ctx, &s);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_falls_into_two_boxes),
      cmocka_unit_test(a_cut_may_end_inside_a_polygon),
      cmocka_unit_test(running_out_of_memory_is_told),
      cmocka_unit_test(sliced_surfaces_stay_closed),
      cmocka_unit_test(surfaces_stay_closed_under_random_operations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
