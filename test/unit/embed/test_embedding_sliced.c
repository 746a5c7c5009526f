/// Embedding on sliced meshes: elements of any shape, hanging nodes, prongs that must not feel each other.
#include "check.h"

#include "embed/embedding.h"
#include "io/surface_file.h"
#include "solids.h"

#include <unistd.h>

static const char *bunny = "/usr/share/glmark2/models/bunny.obj";

static LthGrid grid_over(const LthSurface *s, LitheIndex x, LitheIndex y, LitheIndex z) {
  LthGrid g = {.cells = {x, y, z}};
  solid_bounds(s, g.min, g.max);
  return g;
}

static const double F[9] = {0.3, -1.1, 0.2, 0.7, 0.1, -0.4, 1.5, 0.6, -0.9};
static const double shift[3] = {0.5, -0.25, 2};

static double *affine_field(const LthDgSpace *space) {
  double *u = calloc((size_t)space->n_dofs, sizeof *u), x[3];
  lth_dg_rest(space, u);
  for (LitheIndex i = 0; i < space->n_funcs; i++) {
    lth_v3_copy(u + 3 * i, x);
    lth_m3_apply(F, x, u + 3 * i);
  }
  for (LitheIndex c = 0; c < space->n_cells; c++)
    lth_v3_add(u + 3 * space->func_off[c], shift, u + 3 * space->func_off[c]);
  return u;
}

/// Every vertex of the surface follows an affine field to 1e-10 of the body, weights sum to one.
static void check_surface(LitheCtx *ctx, const LthSurface *s, LitheIndex cells,
                          LthInterpolation how, LthSamples samples) {
  LthGrid g = grid_over(s, cells, cells, cells);
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthEmbedding *e = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.05, &mesh));
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, 1, NULL, &space));
  LitheIndex *cell = calloc((size_t)mesh->n_surface_points, sizeof *cell);
  CHECK_OK(ctx, lth_surface_point_cells(ctx, mesh, cell));
  CHECK_OK(ctx, lth_embedding_create(ctx, space, s->n_points, s->points, cell, how, samples, &e));
  double *u = affine_field(space), *x = calloc(3 * (size_t)s->n_points, sizeof *x);
  double size = 0, worst = 0, worst_sum = 0, extrapolation = 0;
  for (int i = 0; i < 3; i++) size = fmax(size, g.max[i] - g.min[i]);
  lth_embedding_apply(e, 2, u, x);
  for (LitheIndex p = 0; p < s->n_points; p++) {
    double want[3], one = 0, absolute = 0;
    lth_m3_apply(F, s->points + 3 * p, want);
    for (int a = 0; a < 3; a++)
      worst = fmax(worst, fabs(x[3 * p + a] - s->points[3 * p + a] - want[a] - shift[a]));
    for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) {
      one += e->weight[i];
      absolute += fabs(e->weight[i]);
    }
    worst_sum = fmax(worst_sum, fabs(one - 1));
    extrapolation = fmax(extrapolation, absolute);
    assert_true(e->off[p + 1] > e->off[p]);
    assert_true(cell[p] >= 0);
  }
  CHECK_AT_MOST(worst, 1e-10 * size);
  CHECK_AT_MOST(worst_sum, 1e-13);
  CHECK_AT_MOST(extrapolation, 6); // jumps of the field may grow on the surface, but not much
  assert_int_equal(e->n_own, 0);
  free(u), free(x), free(cell);
  lth_embedding_destroy(ctx, &e);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
}

static void sliced_surfaces_follow_affine_fields(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double R[9];
  solid_rotation(1, 2, 3, 0.7, R);
  LthSurface *s = solid_move(solid_torus(ctx, 1, 0.35, 40, 16), R, 1, NULL);
  for (int samples = LTH_SAMPLE_NODES; samples <= LTH_SAMPLE_CELLS; samples++)
    check_surface(ctx, s, 5, LTH_EMBED_MLS, (LthSamples)samples);
  check_surface(ctx, s, 5, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
  check_surface(ctx, s, 1, LTH_EMBED_MLS, LTH_SAMPLE_NODES); // one element, no node at all
  solid_free(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void bunny_follows_affine_fields(void **state) {
  (void)state;
  if (access(bunny, R_OK) != 0) fail_msg("%s is missing: install glmark2-data", bunny);
  LitheCtx *ctx = test_ctx();
  LthSoup *soup = NULL;
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_soup_read(ctx, bunny, &soup));
  CHECK_OK(ctx, lth_surface_from_soup(ctx, soup, "bunny", NULL, &s));
  for (int cells = 4; cells <= 16; cells *= 2)
    check_surface(ctx, s, cells, LTH_EMBED_MLS, LTH_SAMPLE_NODES);
  check_surface(ctx, s, 8, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
  check_surface(ctx, s, 8, LTH_EMBED_MLS, LTH_SAMPLE_CELLS);
  lth_surface_destroy(ctx, &s);
  lth_soup_destroy(ctx, &soup);
  lithe_ctx_destroy(&ctx);
}

/// A fork whose two prongs lie in the same cells, one unit apart; the weights reach two to three units.
static void prongs_in_the_same_cells_never_mix(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char full[3 * 14];
  for (int i = 0; i < 42; i++) full[i] = i / 3 < 2 || i % 3 != 1;
  LthSurface *s = solid_cubes(ctx, full, 3, 14, 1);
  LthGrid g = grid_over(s, 1, 7, 1);
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthEmbedding *e = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &mesh));
  assert_int_equal(mesh->n_cells, 1 + 6 * 2);
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, 1, NULL, &space));
  CHECK_OK(ctx, lth_embedding_create(ctx, space, s->n_points, s->points, NULL, LTH_EMBED_MLS,
                                     LTH_SAMPLE_NODES, &e));
  double *weight = calloc((size_t)space->n_funcs, sizeof *weight);
  int checked = 0;
  for (LitheIndex p = 0; p < s->n_points; p++) {
    const double *x = s->points + 3 * p;
    if (x[1] < 8) continue; // nearer to the root the body does connect the prongs
    lth_embedding_weights(e, p, weight);
    for (LitheIndex c = 0; c < space->n_cells; c++) {
      if ((mesh->cell_centroid[3 * c] < 1.5) == (x[0] < 1.5)) continue;
      if (mesh->cell_centroid[3 * c + 1] < 2) continue; // the root
      for (LitheIndex i = space->func_off[c]; i < space->func_off[c + 1]; i++)
        CHECK_NEAR(weight[i], 0, 0);
    }
    checked++;
  }
  assert_true(checked >= 40);
  free(weight);
  lth_embedding_destroy(ctx, &e);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
  solid_free(ctx, &s);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sliced_surfaces_follow_affine_fields),
      cmocka_unit_test(bunny_follows_affine_fields),
      cmocka_unit_test(prongs_in_the_same_cells_never_mix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
