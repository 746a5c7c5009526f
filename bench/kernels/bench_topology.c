/// A plane through a body of hexahedra, 1 000, 10 000 and 100 000 of them: time of splitting, of the bases, the face and
/// element matrices and the assembly (values alone) of what was touched and its neighbours, in all and for each element touched;
/// beside these a new matrix with its pattern, the start, and the mesh of all. One core.
/// `--csv` prints rows; `--degree K` takes functions of degree K; `--cells N` takes N^3 hexahedra alone.
#include "disc/dg/dg_operator.h"
#include "mesh/topology.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 5 };

typedef struct Row {
  LitheIndex n_cells, n_touched, n_ring;
  double create, cut, patch, space, matrices, pattern, assembly, whole; ///< [s]
} Row;

/// Keep the shortest time since `start`.
static void timed(double *best, double start) {
  double time = lth_now() - start;
  if (*best == 0 || time < *best) *best = time;
}

/// Bases, matrices and assembly of a few cells as a mesh of their own.
static LitheStatus time_patch(LitheCtx *ctx, const LthMesh *mesh, int degree, Row *row) {
  LitheStatus status = LITHE_OK;
  LthDgSpace *space = NULL;
  LthDgOperator *op = NULL;
  LthBlockMatrix *K = NULL;
  double *young = NULL, *poisson = NULL, *f0 = NULL, start = lth_now();
  LITHE_TRY_OR(done, lth_dg_space_create(ctx, mesh, degree, NULL, &space));
  timed(&row->space, start);
  LTH_NEW_OR(done, ctx, young, mesh->n_cells);
  LTH_NEW_OR(done, ctx, poisson, mesh->n_cells);
  LTH_NEW_OR(done, ctx, f0, space->n_dofs);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) young[c] = 1e5, poisson[c] = 0.3;
  LthDgOperatorDef def = {.space = space, .young = young, .poisson = poisson, .warped = true};
  start = lth_now();
  LITHE_TRY_OR(done, lth_dg_operator_create(ctx, &def, &op));
  timed(&row->matrices, start);
  start = lth_now();
  LITHE_TRY_OR(done, lth_dg_matrix_create(ctx, op, &K));
  lth_dg_assemble(op, 0, K, f0);
  timed(&row->pattern, start);
  start = lth_now();
  lth_dg_assemble(op, 0, K, f0);
  timed(&row->assembly, start);
done:
  lth_block_matrix_destroy(ctx, &K);
  lth_dg_operator_destroy(ctx, &op);
  lth_dg_space_destroy(ctx, &space);
  lth_free(ctx, young);
  lth_free(ctx, poisson);
  lth_free(ctx, f0);
  return status;
}

/// Cells whose box the plane crosses.
static LitheIndex crossed(const LthTopology *t, const LthPlane *plane, LitheIndex *cells) {
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < t->n_cells; c++) {
    const double *box = t->cells[c].box;
    double middle = 0, reach = 0;
    for (int a = 0; a < 3; a++) {
      middle += plane->normal[a] * (0.5 * (box[a] + box[3 + a]) - plane->point[a]);
      reach += 0.5 * fabs(plane->normal[a]) * (box[3 + a] - box[a]);
    }
    if (t->cells[c].is_live && fabs(middle) <= reach) cells[n++] = c;
  }
  return n;
}

/// Births that are alive, and then their neighbours.
static LitheIndex touched(const LthTopology *t, bool *is_listed, LitheIndex *cells,
                          LitheIndex *n_births) {
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < t->log.n_births; i++) {
    LitheIndex cell = t->log.births[i].cell;
    if (t->cells[cell].is_live) is_listed[cell] = true, cells[n++] = cell;
  }
  *n_births = n;
  for (LitheIndex i = 0; i < *n_births; i++)
    for (LitheIndex k = 0; k < t->cells[cells[i]].n_faces; k++) {
      const LthTopologyFace *f = t->faces + lth_topology_cell_faces(t, cells[i])[k];
      LitheIndex across = f->cell[f->cell[0] == cells[i]];
      if (across >= 0 && !is_listed[across]) is_listed[across] = true, cells[n++] = across;
    }
  return n;
}

static LitheStatus time_cut(LitheCtx *ctx, const LthMesh *mesh, int degree, bool with_whole,
                            Row *row) {
  LitheStatus status = LITHE_OK;
  LthTopology *t = NULL;
  LthMesh *patch = NULL, *whole = NULL;
  LitheIndex *cells = NULL, n_births = 0;
  bool *is_listed = NULL;
  double start = lth_now();
  // the first plane finds its memory, the second is timed
  const LthPlane planes[2] = {{{0.3012, 0.2979, 0.2031}, {0.02, 0.03, 1}},
                              {{0.5012, 0.4979, 0.5031}, {0.02, 0.03, 1}}};
  LthCut cut;
  LITHE_TRY_OR(done, lth_topology_create(ctx, mesh, &t));
  timed(&row->create, start);
  LTH_NEW_OR(done, ctx, cells, 4 * (LitheCount)mesh->n_cells);
  LTH_NEW_OR(done, ctx, is_listed, 4 * (LitheCount)mesh->n_cells);
  for (int i = 0; i < 2; i++) {
    LITHE_TRY_OR(done, lth_topology_forget(ctx, t));
    LitheIndex n = crossed(t, planes + i, cells);
    start = lth_now();
    LITHE_TRY_OR(done, lth_topology_cut(ctx, t, n, cells, 1, planes + i, LTH_TAG_CUT - i, &cut));
    if (i == 1) timed(&row->cut, start);
  }
  start = lth_now();
  LitheIndex n_patch = touched(t, is_listed, cells, &n_births);
  LITHE_TRY_OR(done, lth_topology_mesh(ctx, t, n_patch, cells, &patch, NULL, NULL));
  timed(&row->patch, start);
  LITHE_TRY_OR(done, time_patch(ctx, patch, degree, row));
  row->n_cells = mesh->n_cells;
  row->n_touched = n_births;
  row->n_ring = n_patch - n_births;
  if (!with_whole) goto done;
  start = lth_now();
  LITHE_TRY_OR(done, lth_topology_mesh(ctx, t, 0, NULL, &whole, NULL, NULL));
  timed(&row->whole, start);
done:
  lth_topology_destroy(ctx, &t);
  lth_mesh_destroy(ctx, &patch);
  lth_mesh_destroy(ctx, &whole);
  lth_free(ctx, cells);
  lth_free(ctx, is_listed);
  return status;
}

static LitheStatus time_body(LitheCtx *ctx, LitheIndex n, int degree, bool csv) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  Row r = {0};
  LITHE_TRY_OR(done, lth_mesh_hexahedra(ctx, &grid, &mesh));
  for (int run = 0; run < RUNS; run++)
    LITHE_TRY_OR(done, time_cut(ctx, mesh, degree, run == 0, &r));
  double total = r.cut + r.patch + r.space + r.matrices + r.assembly;
  printf(csv ? "%d,%d,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.2f,%.2f,%.2f,%.2f\n"
             : "%8d %8d %6d %9.2f %8.2f %8.2f %9.2f %9.2f %8.2f %11.1f %8.1f %11.1f %11.1f\n",
         r.n_cells, r.n_touched, r.n_ring, 1e3 * r.cut, 1e3 * r.patch, 1e3 * r.space,
         1e3 * r.matrices, 1e3 * r.assembly, 1e3 * total, 1e6 * total / r.n_touched,
         1e3 * r.pattern, 1e3 * r.create, 1e3 * r.whole);
done:
  lth_mesh_destroy(ctx, &mesh);
  return status;
}

int main(int argc, char **argv) {
  LitheIndex only = 0;
  int degree = 1;
  bool csv = false;
  for (int i = 1; i < argc; i++) {
    csv = csv || strcmp(argv[i], "--csv") == 0;
    if (strcmp(argv[i], "--cells") == 0 && i + 1 < argc) only = (LitheIndex)atoi(argv[++i]);
    if (strcmp(argv[i], "--degree") == 0 && i + 1 < argc) degree = atoi(argv[++i]);
  }
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  printf(csv ? "elements,touched,ring,cut ms,patch ms,bases ms,matrices ms,assembly ms,sum ms,us a "
               "touched element,"
               "start ms,whole mesh ms\n"
             : "elements  touched   ring  cut [ms]    patch    bases  matrices  assembly      sum  "
               "us/touched  pattern"
               "  start [ms]  whole mesh\n");
  static const LitheIndex sizes[] = {10, 22, 46};
  LitheStatus status = LITHE_OK;
  if (only > 0)
    status = time_body(ctx, only, degree, csv);
  else
    for (int i = 0; i < 3 && status == LITHE_OK; i++)
      status = time_body(ctx, sizes[i], degree, csv);
  if (status) fprintf(stderr, "bench_topology: %s\n", lithe_ctx_message(ctx));
  lithe_ctx_destroy(&ctx);
  return lithe_status_exit(status);
}
