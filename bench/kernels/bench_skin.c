/// The surface of the bunny (or another file) when a plane cuts its body: time to begin, to cut the elements, to follow them, to
/// write the polygons anew, and to embed all points again, beside the bunny's size. Best of five.
/// `bench_skin [file] [--threads N]`
#include "embed/embedding.h"
#include "io/surface_file.h"
#include "mesh/skin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 5 };

typedef struct Row {
  LitheIndex n_cells, n_split, n_new, n_caps;
  double begin, cut, follow, update, embed, renew; ///< [s]
  LitheIndex n_kept;
} Row;

typedef struct Shape {
  LthSoup *soup;
  LthSurface *surface;
  LthMesh *mesh;
} Shape;

static void keep(double *best, double time) {
  if (*best == 0 || time < *best) *best = time;
}

static LitheStatus slice(LitheCtx *ctx, int cells, Shape *s) {
  double low[3], high[3], longest = 0;
  LthGrid grid;
  lth_surface_bounds(s->surface, low, high);
  for (int a = 0; a < 3; a++) longest = fmax(longest, high[a] - low[a]);
  for (int a = 0; a < 3; a++) {
    grid.min[a] = low[a];
    grid.max[a] = high[a];
    grid.cells[a] = (LitheIndex)ceil((high[a] - low[a]) / longest * cells);
  }
  return lth_mesh_slice(ctx, s->surface, &grid, 0.05, &s->mesh);
}

static LitheStatus begin(LitheCtx *ctx, const Shape *s, const LthTopology *t, LthSkin **skin) {
  LthSkinDef def = {.topology = t,
                    .soup = s->soup,
                    .point = s->surface->soup_point,
                    .n_facets = s->surface->n_tris,
                    .facet_poly = s->surface->tri_poly,
                    .face_facet = s->mesh->face_tag,
                    .n_faces = s->mesh->n_faces};
  return lth_skin_create(ctx, &def, skin);
}

static LitheStatus cut(LitheCtx *ctx, LthTopology *t, Row *row) {
  LitheStatus status = LITHE_OK;
  LitheIndex *cells = NULL, n = 0;
  LthPlane plane = {{0, 0, 0}, {0.2, 0.97, 0.1}};
  LthCut done_cut;
  LTH_NEW(ctx, cells, t->n_cells);
  for (LitheIndex i = 0; i < t->n_cells; i++) {
    cells[n++] = i;
    for (int a = 0; a < 3; a++) plane.point[a] += t->cells[i].centroid[a] / t->n_cells;
  }
  double length = sqrt(0.2 * 0.2 + 0.97 * 0.97 + 0.1 * 0.1);
  for (int a = 0; a < 3; a++) plane.normal[a] /= length;
  status = lth_topology_cut(ctx, t, n, cells, 1, &plane, LTH_TAG_CUT, &done_cut);
  row->n_split = done_cut.n_split;
  lth_free(ctx, cells);
  return status;
}

/// All points embedded anew, each in a cell that the skin knows: from nothing (NULL rows), or with rows of before.
static LitheStatus embed(LitheCtx *ctx, const LthTopology *t, const LthSkin *skin,
                         LthEmbeddingRows **rows, double *time) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthEmbedding *e = NULL;
  LitheIndex *record = NULL, *place = NULL, *cell = NULL;
  LITHE_TRY_OR(done, lth_topology_mesh(ctx, t, 0, NULL, &mesh, &record, NULL));
  LITHE_TRY_OR(done, lth_dg_space_create(ctx, mesh, 1, NULL, &space));
  LTH_NEW_OR(done, ctx, place, t->n_cells);
  LTH_NEW_OR(done, ctx, cell, skin->soup->n_points);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) place[record[c]] = c;
  for (LitheIndex i = 0; i < skin->soup->n_points; i++)
    cell[i] = skin->cell[i] >= 0 ? place[skin->cell[i]] : -1;
  double start = lth_now();
  const LthSoup *soup = skin->soup;
  if (rows)
    LITHE_TRY_OR(done, lth_embedding_renew(ctx, space, soup->n_points, soup->points, cell,
                                           LTH_EMBED_MLS, LTH_SAMPLE_NODES, record, rows, &e));
  else
    LITHE_TRY_OR(done, lth_embedding_create(ctx, space, soup->n_points, soup->points, cell,
                                            LTH_EMBED_MLS, LTH_SAMPLE_NODES, &e));
  if (time) keep(time, lth_now() - start);
done:
  lth_embedding_destroy(ctx, &e);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
  lth_free(ctx, record);
  lth_free(ctx, place);
  lth_free(ctx, cell);
  return status;
}

static LitheStatus time_once(LitheCtx *ctx, const Shape *s, Row *row) {
  LitheStatus status = LITHE_OK;
  LthTopology *t = NULL;
  LthSkin *skin = NULL;
  LthEmbeddingRows *rows = NULL;
  LITHE_TRY_OR(done, lth_topology_create(ctx, s->mesh, &t));
  row->n_cells = t->n_live_cells;
  double at[5] = {lth_now()};
  LITHE_TRY_OR(done, begin(ctx, s, t, &skin));
  at[1] = lth_now();
  LITHE_TRY_OR(done, embed(ctx, t, skin, &rows, NULL));
  double before_cut = lth_now();
  LITHE_TRY_OR(done, cut(ctx, t, row));
  at[2] = lth_now();
  LITHE_TRY_OR(done, lth_skin_follow(ctx, skin, t));
  at[3] = lth_now();
  LITHE_TRY_OR(done, lth_skin_update(ctx, skin, t));
  at[4] = lth_now();
  double *to[4] = {&row->begin, &row->cut, &row->follow, &row->update};
  for (int i = 0; i < 4; i++) keep(to[i], at[i + 1] - (i == 1 ? before_cut : at[i]));
  row->n_new = skin->soup->n_points - s->soup->n_points;
  row->n_caps = skin->n_caps;
  LITHE_TRY_OR(done, embed(ctx, t, skin, NULL, &row->embed));
  LITHE_TRY_OR(done, embed(ctx, t, skin, &rows, &row->renew));
  row->n_kept = lth_embedding_rows_kept(rows);
done:
  lth_embedding_rows_destroy(ctx, &rows);
  lth_skin_destroy(ctx, &skin);
  lth_topology_destroy(ctx, &t);
  return status;
}

static LitheStatus time_all(LitheCtx *ctx, const char *file) {
  static const int sizes[] = {4, 8, 16, 24};
  LitheStatus status = LITHE_OK;
  Shape s = {0};
  LITHE_TRY_OR(done, lth_soup_read(ctx, file, &s.soup));
  LITHE_TRY_OR(done, lth_surface_from_soup(ctx, s.soup, file, NULL, &s.surface));
  printf(
      "%d polygons\nelements  split  new points   caps  begin [ms]  elements    follow    polygons "
      "     embed     renew    kept\n",
      s.soup->n_polys);
  for (int i = 0; i < 4; i++) {
    Row row = {0};
    LITHE_TRY_OR(done, slice(ctx, sizes[i], &s));
    for (int k = 0; k < RUNS; k++) LITHE_TRY_OR(done, time_once(ctx, &s, &row));
    printf("%8d %6d %11d %6d %11.2f %9.2f %9.2f %11.2f %10.2f %9.2f %7d\n", row.n_cells,
           row.n_split, row.n_new, row.n_caps, 1e3 * row.begin, 1e3 * row.cut, 1e3 * row.follow,
           1e3 * row.update, 1e3 * row.embed, 1e3 * row.renew, row.n_kept);
    lth_mesh_destroy(ctx, &s.mesh);
  }
done:
  lth_mesh_destroy(ctx, &s.mesh);
  lth_surface_destroy(ctx, &s.surface);
  lth_soup_destroy(ctx, &s.soup);
  return status;
}

int main(int argc, char **argv) {
  const char *file = "/usr/share/glmark2/models/bunny.obj";
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  for (int i = 1; i < argc; i++) {
    if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
      def.threads = atoi(argv[++i]);
    else
      file = argv[i];
  }
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  LitheStatus status = time_all(ctx, file);
  if (status) fprintf(stderr, "bench_skin: %s\n", lithe_ctx_message(ctx));
  lithe_ctx_destroy(&ctx);
  return status ? EXIT_FAILURE : EXIT_SUCCESS;
}
