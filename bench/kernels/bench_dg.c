/// Kaufmann et al. 2009, Table 1: 10 x 10 x 10 hexahedra, BZ and IP, linear and quadratic; unknowns,
/// structural non-zeros and the time of every phase. Times are the best of several runs on all cores, the
/// factorisation's and the solves' of one. `--csv` prints rows; `--cells N` takes N^3 hexahedra.
#include "disc/dg/dg_load.h"
#include "disc/dg/dg_operator.h"
#include "la/engine.h"
#include "la/krylov.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 5 };

/// One row of the table, times in seconds.
typedef struct Row {
  LitheCount unknowns, nonzeros;
  double space, matrices, assembly, reassembly, analysis, factor, solve, cg;
  LitheIndex cg_iterations;
} Row;

/// Keep the shortest time since `start`.
static void timed(double *best, double start) {
  double time = lth_now() - start;
  if (*best == 0 || time < *best) *best = time;
}

/// Entries that are not zero whatever the mesh, both triangles: element blocks are dense; between
/// elements BZ couples equal components only, IP all but the two constants.
static LitheCount structural_nonzeros(const LthDgSpace *space, LthFlux flux) {
  LitheCount count = 0;
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    LitheCount nb = lth_dg_funcs(space, c);
    count += 9 * nb * nb;
  }
  for (LitheIndex f = 0; f < space->mesh->n_faces; f++) {
    if (space->mesh->face_cell[2 * f + 1] < 0) continue;
    LitheCount n0 = lth_dg_funcs(space, space->mesh->face_cell[2 * f]);
    LitheCount n1 = lth_dg_funcs(space, space->mesh->face_cell[2 * f + 1]);
    count += 2 * (flux == LTH_FLUX_BZ ? 3 * n0 * n1 : 9 * n0 * n1 - 6);
  }
  return count;
}

static LitheStatus time_solvers(LitheCtx *ctx, const LthBlockMatrix *K, const double *b, Row *row) {
  LitheStatus status = LITHE_OK;
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  LthCg *cg = NULL;
  LthBlockJacobi *jacobi = NULL;
  double *x = NULL, start = lth_now();
  LTH_NEW_OR(done, ctx, x, K->n);
  LITHE_TRY_OR(done, engine->analyse(ctx, K, &factor));
  timed(&row->analysis, start), start = lth_now();
  LITHE_TRY_OR(done, engine->factorize(ctx, factor, K));
  timed(&row->factor, start), start = lth_now();
  LITHE_TRY_OR(done, engine->solve(ctx, factor, b, x));
  timed(&row->solve, start);

  LITHE_TRY_OR(done, lth_cg_create(ctx, K->n, &cg));
  memset(x, 0, sizeof *x * (size_t)K->n);
  start = lth_now();
  LITHE_TRY_OR(done, lth_block_jacobi_create(ctx, K, &jacobi));
  LITHE_TRY_OR(done, lth_block_jacobi_update(ctx, jacobi, K, NULL));
  LthOperator A = lth_block_matrix_operator(K), M = lth_block_jacobi_operator(jacobi);
  row->cg_iterations = lth_cg_solve(cg, lth_threads(ctx), &A, &M, b, x, 1e-8, 10000).iterations;
  timed(&row->cg, start);
done:
  if (factor) engine->destroy(ctx, &factor);
  lth_cg_destroy(ctx, &cg);
  lth_block_jacobi_destroy(ctx, &jacobi);
  lth_free(ctx, x);
  return status;
}

/// Assembly at rest, and again with the rotations of a bent body.
static LitheStatus time_assembly(LitheCtx *ctx, LthDgOperator *op, const LthDgSpace *space,
                                 Row *row) {
  LitheStatus status = LITHE_OK;
  LthBlockMatrix *K = NULL;
  double *f0 = NULL, *x = NULL, *b = NULL, *one = NULL, start = lth_now();
  const double gravity[3] = {0, 0, -9.81};
  LITHE_TRY_OR(done, lth_dg_matrix_create(ctx, op, &K));
  LTH_NEW_OR(done, ctx, f0, K->n);
  lth_dg_assemble(op, 0, K, f0);
  timed(&row->assembly, start);
  LTH_NEW_OR(done, ctx, x, K->n);
  LTH_NEW_OR(done, ctx, b, K->n);
  LTH_NEW_OR(done, ctx, one, space->n_cells);
  for (LitheIndex c = 0; c < space->n_cells; c++) one[c] = 1;
  lth_dg_add_gravity(space, one, gravity, b);
  LITHE_TRY_OR(done, time_solvers(ctx, K, b, row));
  lth_dg_rest(space, x);
  for (LitheCount i = 0; i < K->n; i++) x[i] += 0.1 * sin((double)i);
  for (int run = 0; run < RUNS; run++) {
    start = lth_now();
    lth_dg_update_rotations(op, x);
    lth_dg_assemble(op, 0, K, f0);
    timed(&row->reassembly, start);
  }
done:
  lth_block_matrix_destroy(ctx, &K);
  lth_free(ctx, f0);
  lth_free(ctx, x);
  lth_free(ctx, b);
  lth_free(ctx, one);
  return status;
}

static LitheStatus time_method(LitheCtx *ctx, const LthMesh *mesh, const LthPatches *clamp,
                               LthFlux flux, int degree, Row *row) {
  LitheStatus status = LITHE_OK;
  LthDgSpace *space = NULL;
  LthDgOperator *op = NULL;
  double *young = NULL, *poisson = NULL;
  LthWeakConstraint weak = {.patches = clamp, .fixed = {true, true, true}};
  LTH_NEW_OR(done, ctx, young, mesh->n_cells);
  LTH_NEW_OR(done, ctx, poisson, mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) young[c] = 1e5, poisson[c] = 0.3;
  for (int run = 0; run < RUNS; run++) {
    lth_dg_operator_destroy(ctx, &op);
    lth_dg_space_destroy(ctx, &space);
    double start = lth_now();
    LITHE_TRY_OR(done, lth_dg_space_create(ctx, mesh, degree, NULL, &space));
    timed(&row->space, start);
    LthDgOperatorDef def = {.space = space,
                            .young = young,
                            .poisson = poisson,
                            .flux = flux,
                            .warped = true,
                            .weak = &weak,
                            .n_weak = 1};
    start = lth_now();
    LITHE_TRY_OR(done, lth_dg_operator_create(ctx, &def, &op));
    timed(&row->matrices, start);
  }
  row->unknowns = space->n_dofs;
  row->nonzeros = structural_nonzeros(space, flux);
  LITHE_TRY_OR(done, time_assembly(ctx, op, space, row));
done:
  lth_dg_operator_destroy(ctx, &op);
  lth_dg_space_destroy(ctx, &space);
  lth_free(ctx, young);
  lth_free(ctx, poisson);
  return status;
}

static void print_row(bool csv, LthFlux flux, int degree, const Row *r) {
  double percent = 100 * (double)r->nonzeros / ((double)r->unknowns * (double)r->unknowns);
  const char *format =
      csv ? "%s,%d,%lld,%.4f,%.3f,%.3f,%.3f,%.3f,%.2f,%.2f,%.2f,%.2f,%d\n"
          : "%s P%d %8lld %8.4f %8.2f %9.2f %9.2f %11.2f %9.1f %9.1f %7.2f %9.1f %5d\n";
  printf(format, flux == LTH_FLUX_IP ? "IP" : "BZ", degree, (long long)r->unknowns, percent,
         1e3 * r->space, 1e3 * r->matrices, 1e3 * r->assembly, 1e3 * r->reassembly,
         1e3 * r->analysis, 1e3 * r->factor, 1e3 * r->solve, 1e3 * r->cg, r->cg_iterations);
}

static LitheStatus table(LitheCtx *ctx, LitheIndex n, bool csv) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthPatches *clamp = NULL;
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  LthWhere down = {.kind = LTH_WHERE_NORMAL, .normal = {0, 0, -1}, .angle = 0.1};
  LITHE_TRY_OR(done, lth_mesh_hexahedra(ctx, &grid, &mesh));
  LITHE_TRY_OR(done, lth_select_boundary(ctx, mesh, &down, &clamp));
  printf(
      csv ? "flux,degree,unknowns,structural %%,space ms,matrices ms,assembly ms,reassembly ms,"
            "analysis ms,factor ms,solve ms,cg ms,cg iterations\n"
          : "       DOFs   nnz [%%]  moments  matrices  assembly  re-assembly  analysis    factor  "
            " solve   CG 1e-8    it   [ms]\n");
  for (int flux = 0; flux < 2; flux++)
    for (int degree = 1; degree <= 2; degree++) {
      Row row = {0};
      LthFlux f = flux ? LTH_FLUX_IP : LTH_FLUX_BZ;
      LITHE_TRY_OR(done, time_method(ctx, mesh, clamp, f, degree, &row));
      print_row(csv, f, degree, &row);
    }
done:
  lth_patches_destroy(ctx, &clamp);
  lth_mesh_destroy(ctx, &mesh);
  return status;
}

int main(int argc, char **argv) {
  LitheIndex n = 10;
  bool csv = false;
  for (int i = 1; i < argc; i++) {
    csv = csv || strcmp(argv[i], "--csv") == 0;
    if (strcmp(argv[i], "--cells") == 0 && i + 1 < argc) n = (LitheIndex)atoi(argv[++i]);
  }
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  LitheStatus status = n > 0 ? table(ctx, n, csv) : LITHE_BAD_INPUT;
  if (status) fprintf(stderr, "bench_dg: %s\n", lithe_ctx_message(ctx));
  lithe_ctx_destroy(&ctx);
  return lithe_status_exit(status);
}
