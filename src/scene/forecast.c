/// `lithe check`: what a run would need, from its mesh and the symbolic analysis of its matrix.
#include "la/engine.h"
#include "scene/report_grid.h"
#include "scene/scene_public.h"
#include "scene/schedule.h"
#include "scene/world.h"
#include "step/simulation.h"

#include <math.h>

// Rates of a core of 2020, to guess by: a forecast is good to a factor of three.
#define FACTOR_FLOPS 8e9    // sparse Cholesky [1/s]
#define SOLVE_BYTES 6e9     // triangular solves and products read the matrix [byte/s]
#define GRID_SECONDS 1.5e-6 // a matrix-free solve by multigrid, an unknown
// What it holds, in bytes: at every slot of its blocks; for values of rows with unknowns, and samples of rows that are cut; for
// functions, of which vectors have three values in the plane too, fewer vectors in static runs; parts of cut cells, those of
// blocks with held sides twice; figures of cells, after the solver is gone in static runs; coarser levels; and clusters with
// their levels, where features are thin.
#define GRID_SLOT 20.0
#define GRID_VALUE 34.0
#define GRID_SAMPLE 11.5 // a value of a sample, in both precisions
#define GRID_FUNCTION 500.0
#define GRID_FUNCTION_STATIC 230.0
#define GRID_CUT 70.0
#define GRID_CELL 80.0
#define GRID_CELL_STATIC 5.0
#define GRID_COARSER 1.2
#define GRID_CLUSTERS 105.0
#define GRID_OUTPUT 2.5e7 // buffers of files that are written, at most
#define GRID_OUTPUT_UNKNOWN 60.0
#define GRID_THIN 0.4       // share of cut cells from which a body is thin
#define MIXED_SECONDS 3e-6  // and that of the mixed form
#define MIXED_KEPT 10       // directions of its Krylov method ...
#define MIXED_TOUCH_KEPT 60 // ... and with contact
#define PROGRAM_BYTES 1.5e7
#define POINT_SECONDS 2e-7 // integration and output, per boundary corner and output time

/// Pattern of the system matrix, which the mesh and the degrees alone decide.
static LitheStatus make_pattern(LitheCtx *ctx, const LthBody *body, LthBlockMatrix **A) {
  LitheStatus status = LITHE_OK;
  const LthMesh *mesh = body->mesh;
  LitheIndex *func_off = NULL;
  uint8_t *degree = NULL;
  if (body->def->method_kind == LTH_METHOD_CG) return lth_cg_pattern_create(ctx, body->elements, A);
  LTH_NEW_OR(done, ctx, func_off, (LitheCount)mesh->n_cells + 1);
  LTH_NEW_OR(done, ctx, degree, mesh->n_cells);
  LITHE_TRY_OR(done, lth_build_degrees(ctx, body, degree));
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    func_off[c + 1] = func_off[c] + lth_monomials3(degree[c]);
  LITHE_TRY_OR(done, lth_dg_pattern_create(ctx, mesh, func_off, A));

done:
  lth_free(ctx, func_off);
  lth_free(ctx, degree);
  return status;
}

/// Cholesky factors of all bodies, or what takes their place.
typedef struct Factor {
  double bytes, flops;
  bool is_beaten;       ///< by multigrid: as asked, or as `auto` will choose
  double grid_unknowns; ///< solved without a matrix
  double grid_bytes;    ///< for that
  double mixed_bytes;   ///< what pressures take beside
  bool has_mesh;        ///< some body is not on a grid
} Factor;

/// Add a factor's bytes and flops by its symbolic analysis, which is left out where no factor is made.
static LitheStatus add_factor(LitheCtx *ctx, const LthScene *scene, const LthBlockMatrix *A,
                              Factor *f) {
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  double bytes = 0, flops = 0;
  bool chooses = scene->linear == LTH_LINEAR_AUTO && scene->time_kind != LTH_TIME_DYNAMIC;
  f->is_beaten |=
      scene->linear == LTH_LINEAR_MULTIGRID || (chooses && lth_step_foresees_levels(A, 0));
  if (!engine || f->is_beaten || scene->linear == LTH_LINEAR_PCG) return LITHE_OK;
  LitheStatus status = engine->analyse(ctx, A, &factor);
  if (status == LITHE_OK) engine->predict(factor, &bytes, &flops);
  f->bytes += bytes;
  f->flops += flops;
  f->is_beaten |= chooses && lth_step_prefers_levels(A, flops);
  engine->destroy(ctx, &factor);
  return status;
}

static void predict_cost(const LthScene *scene, double corners, const Factor *factor,
                         LitheForecast *f) {
  bool is_pcg = scene->linear == LTH_LINEAR_PCG, is_multigrid = factor->is_beaten;
  double bytes = factor->bytes, flops = factor->flops;
  double matrix = 8.0 * (double)f->nonzeros;
  double products = is_pcg ? 60 : 60 * 5.5;
  double one_solve = is_pcg || is_multigrid ? products * matrix / SOLVE_BYTES
                                            : flops / FACTOR_FLOPS + 2 * bytes / SOLVE_BYTES;
  // what touches changes its points within a step, and is not in any factor or coarse level
  if (scene->n_colliders > 0 || scene->n_bodies > 1) one_solve += 300 * matrix / SOLVE_BYTES;
  // a corotated equilibrium takes some ten solves
  if (scene->time_kind != LTH_TIME_DYNAMIC && factor->grid_unknowns == 0) one_solve *= 10;
  one_solve += factor->grid_unknowns * (factor->mixed_bytes > 0 ? MIXED_SECONDS : GRID_SECONDS);
  f->linear = is_pcg ? "pcg" : is_multigrid ? "multigrid" : "cholesky";
  f->memory = 3 * matrix +
              (is_pcg         ? 0
               : is_multigrid ? matrix
                              : 2 * bytes) +
              (factor->grid_unknowns > 0 ? 0 : 1000) * corners + factor->grid_bytes +
              factor->mixed_bytes + (factor->has_mesh || factor->bytes > 0 ? 5e7 : PROGRAM_BYTES);
  f->seconds = (double)f->steps * (one_solve + matrix / SOLVE_BYTES * 4) +
               corners * POINT_SECONDS * (20 + f->frames);
}

/// What pressures hold beside the displacement form (src/disc/staggered/staggered_mixed.h): vectors and directions of the Krylov method,
/// tables of faces and cells, and the state of cells of nu = 0.5.
static double mixed_bytes(const LthBody *body, const LthGridCount *count, bool touches) {
  const LthSparseGrid *g = body->staggered->fractions->grid;
  const double tables = 4 * (g->dim + 1), funcs = (double)count->funcs, cells = count->cells;
  const double vector = 40 + 16.0 * (touches ? MIXED_TOUCH_KEPT : MIXED_KEPT);
  return (3 * funcs + cells) * vector + funcs * (tables + 25) + cells * (tables + 56) +
         24 * (double)g->n_slots;
}

/// What a run with the displacement form holds.
static double grid_bytes(const LthStaggeredBody *s, const LthGridCount *count, bool is_static) {
  const LthSparseGrid *g = s->fractions->grid;
  const bool is_thin = count->cut > GRID_THIN * count->cells;
  const double samples = g->dim == 3 ? 9 : 6, row = g->side;
  const double solver = GRID_VALUE * g->dim * row * (double)count->rows +
                        GRID_SAMPLE * samples * row * (double)count->own_rows;
  return fmin(GRID_OUTPUT, GRID_OUTPUT_UNKNOWN * (double)count->unknowns) +
         GRID_SLOT * (double)g->n_slots + (is_thin ? 1 : GRID_COARSER) * solver +
         (is_static ? GRID_FUNCTION_STATIC : GRID_FUNCTION) * (double)count->funcs +
         GRID_CUT * count->cut + (is_static ? GRID_CELL_STATIC : GRID_CELL) * count->cells +
         (is_thin ? GRID_CLUSTERS * (double)count->unknowns : 0);
}

/// Whether the body has pressures, as far as it can be told without places.
static bool has_pressures(const LthBody *body) {
  const LthSceneBody *def = body->def;
  bool varies = false, stiff = false;
  for (LitheIndex i = 0; i < def->n_materials; i++) {
    const LthValue *nu = &def->materials[i].material.poisson;
    varies |= nu->eval != NULL;
    stiff |= 2 * nu->constant > LTH_STIFFEST * (1 - 2 * nu->constant);
  }
  if (varies ? def->formulation == LTH_FORMULATION_AUTO : !stiff) return false;
  return lth_body_formulation(body) == LTH_FORM_MIXED;
}

/// A staggered body: matrix-free where it is linear and alone, else with a matrix of blocks, whose entries an unknown are those
/// of a cube of 20 cells a side and a disk of 80.
static void add_grid(const LthScene *scene, const LthBody *body, Factor *factor, LitheForecast *f) {
  const LthStaggeredBody *s = body->staggered;
  LthGridCount count = lth_count_grid(body);
  bool is_linear = body->def->materials[0].material.model == LTH_MATERIAL_LINEAR;
  bool is_free = is_linear && scene->n_bodies == 1 && !scene->export_path && !scene->condition &&
                 (scene->linear == LTH_LINEAR_AUTO || scene->linear == LTH_LINEAR_MULTIGRID);
  const bool is_solid = s->fractions->grid->dim == 3;
  const LitheCount row = is_linear ? (is_solid ? 40 : 31) : (is_solid ? 228 : 102);
  f->elements += count.cells;
  f->unknowns += count.unknowns;
  f->volume += s->volume;
  if (is_free) {
    factor->is_beaten = true;
    factor->grid_unknowns += (double)count.unknowns;
    factor->grid_bytes += grid_bytes(s, &count, scene->time_kind == LTH_TIME_STATIC);
    if (has_pressures(body))
      factor->mixed_bytes += mixed_bytes(body, &count, scene->n_colliders > 0);
    return;
  }
  f->nonzeros += row * count.unknowns;
  double n = (double)count.unknowns, dim = s->fractions->grid->dim;
  bool is_large = n > (dim == 3 ? 1e5 : 5e5);
  factor->is_beaten |= scene->linear == LTH_LINEAR_MULTIGRID || is_large;
  // nested dissection of a grid: fill n log n and n^(4/3), operations n^(3/2) and n^2
  factor->bytes += dim == 3 ? 8 * 8 * pow(n, 4. / 3) : 8 * 8 * n * log2(n + 2);
  factor->flops += dim == 3 ? 20 * n * n : 40 * pow(n, 1.5);
}

/// Add what one body needs: sizes to the forecast, and the cost of a factor of its matrix.
static LitheStatus add_body(LitheCtx *ctx, const LthScene *scene, const LthBody *body,
                            Factor *factor, LitheForecast *f) {
  LitheStatus status = LITHE_OK;
  const LthMesh *mesh = body->mesh;
  LthBlockMatrix *A = NULL;
  if (body->staggered) {
    add_grid(scene, body, factor, f);
    return LITHE_OK;
  }
  factor->has_mesh = true;
  LITHE_TRY_OR(done, make_pattern(ctx, body, &A));
  LITHE_TRY_OR(done, add_factor(ctx, scene, A, factor));
  f->elements += mesh->n_cells;
  f->unknowns += A->n;
  f->nonzeros += A->value_off[A->block_off[A->n_rows]];
  for (LitheIndex i = 0; i < mesh->n_faces; i++) f->inner_faces += mesh->face_cell[2 * i + 1] >= 0;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) f->volume += mesh->cell_volume[c];

done:
  lth_block_matrix_destroy(ctx, &A);
  return status;
}

static LitheStatus forecast_world(LitheCtx *ctx, const LthWorld *world, LitheForecast *f) {
  double corners = 0;
  Factor factor = {0};
  LthSchedule schedule = lth_schedule_make(world->scene);
  *f = (LitheForecast){.steps = lth_schedule_total(&schedule),
                       .frames = schedule.n_outputs + schedule.writes_start};
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthMesh *mesh = world->bodies[b]->mesh;
    LITHE_TRY(add_body(ctx, world->scene, world->bodies[b], &factor, f));
    corners += mesh ? mesh->loop_off[mesh->face_loop_off[mesh->n_faces]]
                    : 8.0 * lth_count_grid(world->bodies[b]).cells;
  }
  predict_cost(world->scene, corners, &factor, f);
  return LITHE_OK;
}

LitheStatus lithe_check(LitheCtx *ctx, const LitheScene *scene, LitheForecast *forecast) {
  LitheStatus status = LITHE_OK;
  LthWorld *world = NULL;
  LITHE_TRY_OR(done, lth_world_create_meshes(ctx, scene->scene, &world));
  LITHE_TRY_OR(done, forecast_world(ctx, world, forecast));
  LITHE_TRY_OR(done, lth_world_check(ctx, world));

done:
  lth_world_destroy(ctx, &world);
  return status;
}
