/// Building and freeing the operator; rotations; the pattern of its matrix.
#include "disc/dg/dg_store_priv.h"

#include "material/rotation.h"

/// Young's modulus, Poisson's ratio and the penalty's eta are positive and finite numbers in range.
static LitheStatus check_def(LitheCtx *ctx, const LthDgOperatorDef *def) {
  for (LitheIndex c = 0; c < def->space->n_cells; c++) {
    double E = def->young[c], nu = def->poisson[c];
    if (!(E > 0) || !isfinite(E))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "element %d: Young's modulus must be a positive number of Pa, got %g", c, E);
    if (!(nu > -1 && nu < 0.5))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "element %d: Poisson's ratio must lie between -1 and 0.5 (excluded), got %g", c,
                 nu);
  }
  if (def->penalty != LTH_PENALTY_AUTO && (!(def->eta > 0) || !isfinite(def->eta)))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "penalty: eta must be a positive number, got %g", def->eta);
  return LITHE_OK;
}

static LitheStatus copy_materials(LitheCtx *ctx, const LthDgOperatorDef *def, LthDgOperator *op) {
  LitheIndex n = def->space->n_cells;
  LTH_NEW(ctx, op->lambda, n);
  LTH_NEW(ctx, op->mu, n);
  LTH_NEW(ctx, op->young, n);
  for (LitheIndex c = 0; c < n; c++) {
    op->young[c] = def->young[c];
    lth_lame(def->young[c], def->poisson[c], &op->lambda[c], &op->mu[c]);
  }
  LTH_NEW(ctx, op->weak, def->n_weak);
  for (LitheIndex w = 0; w < def->n_weak; w++) op->weak[w] = def->weak[w];
  op->n_weak = def->n_weak;
  return LITHE_OK;
}

/// Places of slopes in one block.
static LitheStatus place_slopes(LitheCtx *ctx, LthDgOperator *op) {
  LitheIndex n = op->space->n_cells;
  LitheCount size = 0;
  for (LitheIndex c = 0; c < n; c++)
    size += 3 * (LitheCount)lth_dg_funcs(op->space, c) * lth_dg_lower(op->space, c);
  LTH_NEW(ctx, op->slope_block, size);
  double *next = op->slope_block;
  for (LitheIndex c = 0; c < n; c++) {
    op->slope[c] = next;
    next += 3 * lth_dg_funcs(op->space, c) * lth_dg_lower(op->space, c);
  }
  return LITHE_OK;
}

/// Places of the faces' tables in one block.
static LitheStatus place_faces(LitheCtx *ctx, LthDgOperator *op) {
  LitheCount size = 0;
  for (LitheIndex f = 0; f < op->n_faces; f++) size += lth_dg_face_doubles(op, &op->faces[f]);
  LTH_NEW(ctx, op->face_block, size);
  double *next = op->face_block;
  for (LitheIndex f = 0; f < op->n_faces; f++) {
    op->faces[f].table = next;
    next += lth_dg_face_doubles(op, &op->faces[f]);
  }
  return LITHE_OK;
}

/// Places of the elements' matrices in one block.
static LitheStatus place_cells(LitheCtx *ctx, LthDgOperator *op) {
  LitheIndex n = op->space->n_cells;
  LitheCount size = 0;
  for (LitheIndex c = 0; c < n; c++)
    size += 9 * (LitheCount)lth_dg_funcs(op->space, c) * lth_dg_funcs(op->space, c);
  LTH_NEW(ctx, op->cell_block, size);
  double *next = op->cell_block;
  for (LitheIndex c = 0; c < n; c++) {
    op->cell_data[c] = next;
    next += 9 * lth_dg_funcs(op->space, c) * lth_dg_funcs(op->space, c);
  }
  return LITHE_OK;
}

static void integrate_slopes(LitheCtx *ctx, LthDgOperator *op, const uint8_t *known) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < op->space->n_cells; c++)
    if (!known[c]) lth_dg_cell_slope(op, c);
}

static void integrate_faces(LitheCtx *ctx, LthDgOperator *op, const uint8_t *known) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex f = 0; f < op->n_faces; f++)
    if (!known[f]) lth_dg_integrate_face(op, &op->faces[f]);
}

static void integrate_cells(LitheCtx *ctx, LthDgOperator *op, const uint8_t *known) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < op->space->n_cells; c++)
    if (!known[c]) lth_dg_cell_matrix(op, c);
}

/// The same, its time counted apart from that of looking up what is known.
static void timed(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op,
                  const uint8_t *known,
                  void (*integral)(LitheCtx *, LthDgOperator *, const uint8_t *)) {
  double start = lth_processor_time();
  integral(ctx, op, known);
  if (records) records->store->count.seconds += lth_processor_time() - start;
}

/// Slopes, tables of faces, holds and matrices of cells: all that is not known.
static LitheStatus integrate(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = op->space->n_cells;
  uint8_t *known = NULL; // of cells and faces in turn
  LTH_NEW_OR(done, ctx, known, n > op->n_faces ? n : op->n_faces);
  LITHE_TRY_OR(done,
               records ? lth_dg_store_lend_slopes(ctx, records, op, known) : place_slopes(ctx, op));
  timed(ctx, records, op, known, integrate_slopes);
  memset(known, 0, (size_t)(n > op->n_faces ? n : op->n_faces));
  LITHE_TRY_OR(done,
               records ? lth_dg_store_lend_faces(ctx, records, op, known) : place_faces(ctx, op));
  timed(ctx, records, op, known, integrate_faces);
  if (records) lth_dg_store_keep_faces(records, op, known);
  LITHE_TRY_OR(done, lth_dg_build_holds(ctx, records, op));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < n; c++) lth_dg_cell_holds(op, c);
  memset(known, 0, (size_t)(n > op->n_faces ? n : op->n_faces));
  LITHE_TRY_OR(done,
               records ? lth_dg_store_lend_cells(ctx, records, op, known) : place_cells(ctx, op));
  timed(ctx, records, op, known, integrate_cells);
  if (records) lth_dg_store_keep_cells(records, op, known);
done:
  lth_free(ctx, known);
  return status;
}

LitheStatus lth_dg_operator_create(LitheCtx *ctx, const LthDgOperatorDef *def,
                                   LthDgOperator **out) {
  LitheStatus status = LITHE_OK;
  LthDgOperator *op = NULL;
  *out = NULL;
  LITHE_TRY(check_def(ctx, def));
  LTH_NEW(ctx, op, 1);
  op->ctx = ctx;
  op->space = def->space;
  op->flux = def->flux;
  op->kind = def->penalty;
  op->eta = def->eta;
  op->warped = def->warped;
  op->held = def->held;
  op->faces_only = def->faces_only;
  LITHE_TRY_OR(done, copy_materials(ctx, def, op));
  LTH_NEW_OR(done, ctx, op->rotation, 9 * (LitheCount)def->space->n_cells);
  LTH_NEW_OR(done, ctx, op->rest, def->space->n_dofs);
  lth_dg_reset_rotations(op);
  lth_dg_rest(def->space, op->rest);
  LTH_NEW_OR(done, ctx, op->slope, def->space->n_cells);
  LTH_NEW_OR(done, ctx, op->cell_data, def->space->n_cells);
  LTH_NEW_OR(done, ctx, op->cell_load, def->space->n_dofs);
  LTH_NEW_OR(done, ctx, op->partial, def->space->n_cells);
  LITHE_TRY_OR(done, lth_dg_list_faces(ctx, def->records, op));
  LITHE_TRY_OR(done, integrate(ctx, def->records, op));
  lth_dg_measure_penalty(op);
done:
  if (status != LITHE_OK) lth_dg_operator_destroy(ctx, &op);
  *out = op;
  return status;
}

void lth_dg_operator_destroy(LitheCtx *ctx, LthDgOperator **out) {
  LthDgOperator *op = *out;
  if (!op) return;
  lth_dg_free_holds(ctx, op);
  void *blocks[] = {op->lambda, op->mu,           op->young,     op->rotation,   op->rest,
                    op->slope,  op->slope_block,  op->cell_data, op->cell_block, op->cell_load,
                    op->faces,  op->own_face_off, op->side_off,  op->sides,      op->face_block,
                    op->weak,   op->partial};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, op);
  *out = NULL;
}

void lth_dg_reset_rotations(LthDgOperator *op) {
  for (LitheIndex c = 0; c < op->space->n_cells; c++)
    lth_m3_identity(op->rotation + 9 * (LitheCount)c);
}

/// Mean gradient F_ab = sum_j x_ja slope_b[j][0]: phi_l has no mean for l > 0.
static void mean_gradient(const LthDgOperator *op, LitheIndex cell, const double *x, double F[9]) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  const double *slope = lth_dg_slope(op, cell);
  const double *xc = x + 3 * (LitheCount)op->space->func_off[cell];
  memset(F, 0, 9 * sizeof *F);
  for (int j = 1; j < nb; j++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) F[3 * a + b] += xc[3 * j + a] * slope[(b * nb + j) * nl];
}

void lth_dg_update_rotations(LthDgOperator *op, const double *x) {
  if (!op->warped) return;
#pragma omp parallel for schedule(static) num_threads(lth_dg_threads(op))
  for (LitheIndex c = 0; c < op->space->n_cells; c++) {
    double F[9];
    mean_gradient(op, c, x, F);
    lth_rotation_nearest(F, op->rotation + 9 * (LitheCount)c);
  }
}

LitheStatus lth_dg_matrix_create(LitheCtx *ctx, const LthDgOperator *op, LthBlockMatrix **K) {
  return lth_dg_pattern_create(ctx, op->space->mesh, op->space->func_off, K);
}
