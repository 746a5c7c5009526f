/// Static solves: the unit cube of N^3 hexahedra (E = 1e5, nu, held below, under its own weight), or the sliced
/// bunny, interior penalty. Phases in seconds of the process (all its threads), memory of the preconditioner, iterations
/// to a relative residual of 1e-8 with the multilevel preconditioner, with block-Jacobi, and the sparse Cholesky.
/// Options: --cells N,N,.. --degree K,K,.. --nu NU --eta G (0: automatic penalty) --jump J --mesh FILE --threads N
/// --cholesky-up-to UNKNOWNS --jacobi-up-to UNKNOWNS --csv
#include "disc/dg/dg_load.h"
#include "disc/dg/dg_operator.h"
#include "io/surface_file.h"
#include "la/engine.h"
#include "la/multilevel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define TOLERANCE 1e-8
#define MAX_LIST 16

typedef struct Options {
  int cells[MAX_LIST], degree[MAX_LIST], n_cells, n_degrees, threads;
  double nu, eta, jump, cholesky_limit, jacobi_limit;
  const char *mesh;
  bool csv;
} Options;

/// One row of the table; times in seconds of the process.
typedef struct Row {
  LitheIndex elements;
  LitheCount unknowns;
  double matrices, assembly, setup, update, solve, megabytes, complexity, compliance;
  int levels;
  LthSolveReport report, jacobi_report;
  double jacobi, analysis, factor, backsolve;
  LitheCount coarsest;
} Row;

static double cpu(void) { return (double)clock() / CLOCKS_PER_SEC; }

static double since(double *start) {
  double now = cpu(), time = now - *start;
  *start = now;
  return time;
}

/// Everything of one problem.
typedef struct Problem {
  LthMesh *mesh;
  LthPatches *clamp;
  LthDgSpace *space;
  LthDgOperator *op;
  LthBlockMatrix *K;
  double *young, *poisson, *one, *x0, *b, *x, *f0;
} Problem;

static void free_problem(LitheCtx *ctx, Problem *p) {
  double *vectors[] = {p->young, p->poisson, p->one, p->x0, p->b, p->x, p->f0};
  for (int i = 0; i < 7; i++) lth_free(ctx, vectors[i]);
  lth_block_matrix_destroy(ctx, &p->K);
  lth_dg_operator_destroy(ctx, &p->op);
  lth_dg_space_destroy(ctx, &p->space);
  lth_patches_destroy(ctx, &p->clamp);
  lth_mesh_destroy(ctx, &p->mesh);
}

static LitheStatus slice_file(LitheCtx *ctx, const char *file, int n, LthMesh **mesh) {
  LitheStatus status = LITHE_OK;
  LthSoup *soup = NULL;
  LthSurface *surface = NULL;
  LthGrid grid;
  LITHE_TRY_OR(done, lth_soup_read(ctx, file, &soup));
  LITHE_TRY_OR(done, lth_surface_from_soup(ctx, soup, file, NULL, &surface));
  lth_surface_bounds(surface, grid.min, grid.max);
  double longest = 0;
  for (int a = 0; a < 3; a++) longest = fmax(longest, grid.max[a] - grid.min[a]);
  for (int a = 0; a < 3; a++) {
    grid.cells[a] = (LitheIndex)ceil(n * (grid.max[a] - grid.min[a]) / longest - 1e-9);
    double middle = 0.5 * (grid.min[a] + grid.max[a]), half = 0.5 * grid.cells[a] * longest / n;
    grid.min[a] = middle - half;
    grid.max[a] = middle + half;
  }
  LITHE_TRY_OR(done, lth_mesh_slice(ctx, surface, &grid, 1e-3, mesh));
done:
  lth_soup_destroy(ctx, &soup);
  lth_surface_destroy(ctx, &surface);
  return status;
}

static LitheStatus make_mesh(LitheCtx *ctx, const Options *o, int n, Problem *p) {
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  LthWhere below = {.kind = LTH_WHERE_PLANE, .normal = {0, 0, -1}};
  if (!o->mesh) {
    LITHE_TRY(lth_mesh_hexahedra(ctx, &grid, &p->mesh));
  } else {
    double min[3], max[3];
    LITHE_TRY(slice_file(ctx, o->mesh, n, &p->mesh));
    lth_mesh_bounds(p->mesh, min, max);
    below.normal[2] = 0;
    below.normal[1] = -1;
    below.point[1] = 0.9 * min[1] + 0.1 * max[1];
  }
  return lth_select_boundary(ctx, p->mesh, &below, &p->clamp);
}

static LitheStatus make_problem(LitheCtx *ctx, const Options *o, int n, int degree, Problem *p,
                                Row *row) {
  const double gravity[3] = {0, 0, -9.81};
  LITHE_TRY(make_mesh(ctx, o, n, p));
  LitheIndex n_cells = row->elements = p->mesh->n_cells;
  LTH_NEW(ctx, p->young, n_cells);
  LTH_NEW(ctx, p->poisson, n_cells);
  LTH_NEW(ctx, p->one, n_cells);
  for (LitheIndex c = 0; c < n_cells; c++) {
    const double *x = p->mesh->cell_centroid + 3 * c;
    bool hard = ((int)floor(4 * x[0]) + (int)floor(4 * x[1]) + (int)floor(4 * x[2])) % 2 == 0;
    p->young[c] = hard ? 1e5 * o->jump : 1e5;
    p->poisson[c] = o->nu;
    p->one[c] = 1;
  }
  double start = cpu();
  LITHE_TRY(lth_dg_space_create(ctx, p->mesh, degree, NULL, &p->space));
  LthWeakConstraint weak = {.patches = p->clamp, .fixed = {true, true, true}};
  LthDgOperatorDef def = {.space = p->space,
                          .young = p->young,
                          .poisson = p->poisson,
                          .penalty = o->eta > 0 ? LTH_PENALTY_ETA : LTH_PENALTY_AUTO,
                          .eta = o->eta,
                          .weak = &weak,
                          .n_weak = 1};
  LITHE_TRY(lth_dg_operator_create(ctx, &def, &p->op));
  row->matrices = since(&start);
  LITHE_TRY(lth_dg_matrix_create(ctx, p->op, &p->K));
  row->unknowns = p->K->n;
  LTH_NEW(ctx, p->f0, p->K->n);
  LTH_NEW(ctx, p->b, p->K->n);
  LTH_NEW(ctx, p->x, p->K->n);
  LTH_NEW(ctx, p->x0, p->K->n);
  lth_dg_assemble(p->op, 0, p->K, p->f0);
  row->assembly = since(&start);
  lth_dg_add_gravity(p->space, p->one, gravity, p->b);
  lth_dg_rest(p->space, p->x0);
  return LITHE_OK;
}

static double *ones(LitheCtx *ctx, const LthDgSpace *space) {
  double *one = lth_alloc(ctx, space->n_funcs, sizeof *one);
  for (LitheIndex c = 0; one && c < space->n_cells; c++) one[space->func_off[c]] = 1;
  return one;
}

static LitheStatus time_multilevel(LitheCtx *ctx, Problem *p, Row *row) {
  LitheStatus status = LITHE_OK;
  LthMultilevel *M = NULL;
  LthCg *cg = NULL;
  double *one = ones(ctx, p->space), start = cpu();
  LthMultilevelDef def = {.A = p->K, .one = one, .position = p->x0, .n_linear = 12};
  LITHE_TRY_OR(done, lth_multilevel_create(ctx, &def, &M));
  row->setup = since(&start);
  LITHE_TRY_OR(done, lth_multilevel_update(ctx, M, NULL, NULL));
  row->update = since(&start);
  LITHE_TRY_OR(done, lth_cg_create(ctx, p->K->n, &cg));
  LthOperator A = lth_block_matrix_operator(p->K);
  start = cpu();
  row->report = lth_multilevel_solve(M, cg, lth_threads(ctx), &A, p->b, p->x, TOLERANCE, 1000);
  row->solve = since(&start);
  row->compliance = lth_dot(1, p->K->n, p->b, p->x);
  row->megabytes = (double)lth_multilevel_bytes(M) / 1048576;
  row->levels = lth_multilevel_levels(M);
  row->coarsest = lth_multilevel_unknowns(M, row->levels - 1);
  row->complexity = lth_multilevel_complexity(M);
done:
  lth_free(ctx, one);
  lth_cg_destroy(ctx, &cg);
  lth_multilevel_destroy(ctx, &M);
  return status;
}

static LitheStatus time_jacobi(LitheCtx *ctx, Problem *p, Row *row) {
  LitheStatus status = LITHE_OK;
  LthBlockJacobi *J = NULL;
  LthCg *cg = NULL;
  memset(p->x, 0, sizeof *p->x * (size_t)p->K->n);
  double start = cpu();
  LITHE_TRY_OR(done, lth_block_jacobi_create(ctx, p->K, &J));
  LITHE_TRY_OR(done, lth_block_jacobi_update(ctx, J, p->K, NULL));
  LITHE_TRY_OR(done, lth_cg_create(ctx, p->K->n, &cg));
  LthOperator A = lth_block_matrix_operator(p->K), B = lth_block_jacobi_operator(J);
  row->jacobi_report = lth_cg_solve(cg, lth_threads(ctx), &A, &B, p->b, p->x, TOLERANCE, 20000);
  row->jacobi = since(&start);
done:
  lth_cg_destroy(ctx, &cg);
  lth_block_jacobi_destroy(ctx, &J);
  return status;
}

static LitheStatus time_cholesky(LitheCtx *ctx, Problem *p, Row *row) {
  LitheStatus status = LITHE_OK;
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  if (!engine) return LITHE_OK;
  double start = cpu();
  LITHE_TRY_OR(done, engine->analyse(ctx, p->K, &factor));
  row->analysis = since(&start);
  LITHE_TRY_OR(done, engine->factorize(ctx, factor, p->K));
  row->factor = since(&start);
  LITHE_TRY_OR(done, engine->solve(ctx, factor, p->b, p->x));
  row->backsolve = since(&start);
done:
  if (factor) engine->destroy(ctx, &factor);
  return status;
}

static void print_row(const Options *o, int n, int degree, const Row *r) {
  const char *format =
      o->csv
          ? "%d,%d,%d,%lld,%.4f,%.4f,%.4f,%.4f,%.4f,%d,%.3g,%.1f,%d,%lld,%.3f,%.9g,%.4f,%d,%.4f,%."
            "4f,%.4f\n"
          : "%3d P%d %8d %8lld  %8.3f %8.3f  %8.3f %8.3f %8.3f %4d %8.1e %7.1f %2d %5lld %6.3f "
            "%.9g  %8.3f %5d  %7.3f %8.3f %7.3f\n";
  printf(format, n, degree, (int)r->elements, (long long)r->unknowns, r->matrices, r->assembly,
         r->setup, r->update, r->solve, (int)r->report.iterations, r->report.residual, r->megabytes,
         r->levels, (long long)r->coarsest, r->complexity, r->compliance, r->jacobi,
         (int)r->jacobi_report.iterations, r->analysis, r->factor, r->backsolve);
  fflush(stdout);
}

static LitheStatus run(LitheCtx *ctx, const Options *o, int n, int degree) {
  LitheStatus status = LITHE_OK;
  Problem p = {0};
  Row row = {0};
  LITHE_TRY_OR(done, make_problem(ctx, o, n, degree, &p, &row));
  LITHE_TRY_OR(done, time_multilevel(ctx, &p, &row));
  if ((double)p.K->n <= o->jacobi_limit) LITHE_TRY_OR(done, time_jacobi(ctx, &p, &row));
  if ((double)p.K->n <= o->cholesky_limit) LITHE_TRY_OR(done, time_cholesky(ctx, &p, &row));
  print_row(o, n, degree, &row);
done:
  free_problem(ctx, &p);
  return status;
}

static int read_list(const char *text, int *list) {
  int n = 0;
  char *end = NULL;
  for (; n < MAX_LIST && *text; text = *end ? end + 1 : end)
    list[n++] = (int)strtol(text, &end, 10);
  return n;
}

static Options read_options(int argc, char **argv) {
  Options o = {.cells = {10, 20},
               .degree = {1, 2},
               .n_cells = 2,
               .n_degrees = 2,
               .nu = 0.3,
               .jump = 1,
               .cholesky_limit = 40000,
               .jacobi_limit = 40000};
  for (int i = 1; i < argc; i++) {
    const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
    if (strcmp(name, "--csv") == 0) {
      o.csv = true;
      continue;
    }
    if (strcmp(name, "--cells") == 0) o.n_cells = read_list(value, o.cells);
    if (strcmp(name, "--degree") == 0) o.n_degrees = read_list(value, o.degree);
    if (strcmp(name, "--threads") == 0) o.threads = atoi(value);
    if (strcmp(name, "--nu") == 0) o.nu = atof(value);
    if (strcmp(name, "--eta") == 0) o.eta = atof(value);
    if (strcmp(name, "--jump") == 0) o.jump = atof(value);
    if (strcmp(name, "--mesh") == 0) o.mesh = value;
    if (strcmp(name, "--cholesky-up-to") == 0) o.cholesky_limit = atof(value);
    if (strcmp(name, "--jacobi-up-to") == 0) o.jacobi_limit = atof(value);
    i++;
  }
  return o;
}

int main(int argc, char **argv) {
  Options o = read_options(argc, argv);
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = o.threads;
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  LitheStatus status = LITHE_OK;
  printf(o.csv ? "cells,degree,elements,unknowns,matrices s,assembly s,setup s,update s,solve "
                 "s,iterations,residual,MiB,levels,coarsest,complexity,b.u,jacobi s,jacobi "
                 "iterations,analysis s,factor s,backsolve s\n"
               : "  N     elements unknowns  matrices assembly     setup   update    solve   it "
                 "residual    "
                 "MiB lv coars  compl b.u  bl-Jacobi    it  analyse   factor   solve [s]\n");
  for (int d = 0; !status && d < o.n_degrees; d++)
    for (int c = 0; !status && c < o.n_cells; c++) status = run(ctx, &o, o.cells[c], o.degree[d]);
  if (status) fprintf(stderr, "bench_static: %s\n", lithe_ctx_message(ctx));
  lithe_ctx_destroy(&ctx);
  return lithe_status_exit(status);
}
