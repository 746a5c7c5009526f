/// A plane through a body of hexahedra, 1 000, 10 000 and 100 000 of them: time of splitting (geometry), and of following it in
/// place (lth_dg_live_follow()): the touched elements and those around them as a mesh, integration, assembly; in all, and for
/// each element that the plane splits, as time of the processor, which other work on the machine does not stretch. Beside
/// these, in the same time, what the whole body costs from scratch: integration, assembly, and its mesh; and the pattern for solvers. One core,
/// best of nine.
/// `--csv` prints rows; `--degree K` takes functions of degree K; `--cells N` takes N^3 hexahedra alone.
#include "disc/dg/dg_live.h"
#include "mesh/topology.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { RUNS = 9 };

typedef struct Row {
  LitheIndex n_cells, n_split;
  LthDgLiveReport report;
  double cut, patch, integration, assembly, pattern; ///< [s]
  double all;                                        ///< cut to assembly, of the processor
  double whole_mesh, whole_integration, whole_assembly;
} Row;

/// Keep the shortest time.
static void keep(double *best, double time) {
  if (*best == 0 || time < *best) *best = time;
}

static double processor_time(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/// Bases, matrices and assembly of all elements, from scratch.
static LitheStatus time_whole(LitheCtx *ctx, const LthTopology *t, int degree, Row *row) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthDgSpace *space = NULL;
  LthDgOperator *op = NULL;
  LthBlockMatrix *K = NULL;
  double *young = NULL, *poisson = NULL, *f0 = NULL, start = processor_time();
  LITHE_TRY_OR(done, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  keep(&row->whole_mesh, processor_time() - start);
  LTH_NEW_OR(done, ctx, young, mesh->n_cells);
  LTH_NEW_OR(done, ctx, poisson, mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) young[c] = 1e5, poisson[c] = 0.3;
  start = processor_time();
  LITHE_TRY_OR(done, lth_dg_space_create(ctx, mesh, degree, NULL, &space));
  LthDgOperatorDef def = {.space = space, .young = young, .poisson = poisson};
  LITHE_TRY_OR(done, lth_dg_operator_create(ctx, &def, &op));
  keep(&row->whole_integration, processor_time() - start);
  LTH_NEW_OR(done, ctx, f0, space->n_dofs);
  start = processor_time();
  LITHE_TRY_OR(done, lth_dg_matrix_create(ctx, op, &K));
  lth_dg_assemble(op, 0, K, f0);
  keep(&row->whole_assembly, processor_time() - start);
done:
  lth_block_matrix_destroy(ctx, &K);
  lth_dg_operator_destroy(ctx, &op);
  lth_dg_space_destroy(ctx, &space);
  lth_mesh_destroy(ctx, &mesh);
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

/// One plane: what lies at it is not looked for in time, for that is asked of a tree or of the last cut.
static LitheStatus cut_and_follow(LitheCtx *ctx, LthTopology *t, LthDgLive *live,
                                  const LthPlane *plane, LitheIndex k, LitheIndex *cells,
                                  bool is_timed, Row *row) {
  LthCut cut;
  const LthBlockMatrix *A = NULL;
  LitheIndex n = crossed(t, plane, cells);
  double start = lth_now(), begin = processor_time();
  LITHE_TRY(lth_topology_cut(ctx, t, n, cells, 1, plane, LTH_TAG_CUT - k, &cut));
  double time = lth_now() - start;
  LITHE_TRY(lth_dg_live_follow(ctx, live, 0, &row->report));
  if (is_timed) keep(&row->all, processor_time() - begin);
  start = lth_now();
  LITHE_TRY(lth_dg_live_matrix(ctx, live, &A));
  if (is_timed) {
    keep(&row->pattern, lth_now() - start);
    keep(&row->cut, time);
    keep(&row->patch, row->report.patch);
    keep(&row->integration, row->report.integration);
    keep(&row->assembly, row->report.assembly);
    row->n_split = cut.n_split;
  }
  return lth_topology_forget(ctx, t);
}

static LitheStatus time_cut(LitheCtx *ctx, const LthMesh *mesh, int degree, bool with_whole,
                            Row *row) {
  LitheStatus status = LITHE_OK;
  LthTopology *t = NULL;
  LthDgLive *live = NULL;
  LitheIndex *cells = NULL;
  double *young = NULL, *poisson = NULL;
  // the first plane finds its memory, the second is timed
  const LthPlane planes[2] = {{{0.3012, 0.2979, 0.2031}, {0.02, 0.03, 1}},
                              {{0.5012, 0.4979, 0.5031}, {0.02, 0.03, 1}}};
  LTH_NEW_OR(done, ctx, cells, 4 * (LitheCount)mesh->n_cells);
  LTH_NEW_OR(done, ctx, young, mesh->n_cells);
  LTH_NEW_OR(done, ctx, poisson, mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) young[c] = 1e5, poisson[c] = 0.3;
  LITHE_TRY_OR(done, lth_topology_create(ctx, mesh, &t));
  LthDgLiveDef def = {.topology = t, .degree = degree, .young = young, .poisson = poisson};
  LITHE_TRY_OR(done, lth_dg_live_create(ctx, &def, 0, &live));
  for (int i = 0; i < 2; i++)
    LITHE_TRY_OR(done, cut_and_follow(ctx, t, live, planes + i, i, cells, i == 1, row));
  row->n_cells = mesh->n_cells;
  if (with_whole) LITHE_TRY_OR(done, time_whole(ctx, t, degree, row));
done:
  lth_dg_live_destroy(ctx, &live);
  lth_topology_destroy(ctx, &t);
  lth_free(ctx, cells);
  lth_free(ctx, young);
  lth_free(ctx, poisson);
  return status;
}

static LitheStatus time_body(LitheCtx *ctx, LitheIndex n, int degree, bool csv) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  Row r = {0};
  LITHE_TRY_OR(done, lth_mesh_hexahedra(ctx, &grid, &mesh));
  for (int run = 0; run < RUNS; run++) LITHE_TRY_OR(done, time_cut(ctx, mesh, degree, run < 2, &r));
  printf(csv ? "%d,%d,%d,%d,%d,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%.2f,%.2f,%.2f,%.2f,%.2f\n"
             : "%6d %8d %6d %6d %7d %5d %13.2f %8.2f %12.2f %9.2f %8.2f %9.1f %8.2f %12.1f %12.1f "
               "%10.1f\n",
         degree, r.n_cells, r.n_split, r.report.n_births, r.report.n_touched, r.report.n_rim,
         1e3 * r.cut, 1e3 * r.patch, 1e3 * r.integration, 1e3 * r.assembly, 1e3 * r.all,
         1e6 * r.all / r.n_split, 1e3 * r.pattern, 1e3 * r.whole_integration,
         1e3 * r.whole_assembly, 1e3 * r.whole_mesh);
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
  printf(csv ? "degree,elements,split,births,touched,around,geometry ms,patch ms,integration "
               "ms,assembly ms,sum processor ms,us a split element,pattern ms,whole integration "
               "ms,whole "
               "assembly ms,whole mesh ms\n"
             : "degree elements  split births touched  rim geometry [ms]    patch  integration  "
               "assembly      sum  us/split  pattern  whole: integr.  assembly       mesh\n");
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
