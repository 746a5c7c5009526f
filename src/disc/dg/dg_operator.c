/// Building and freeing the operator; rotations; the pattern of its matrix.
#include "disc/dg/dg_priv.h"

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

static LitheStatus build_slopes(LitheCtx *ctx, LthDgOperator *op) {
  LitheIndex n = op->space->n_cells;
  LTH_NEW(ctx, op->slope_off, n + 1);
  for (LitheIndex c = 0; c < n; c++)
    op->slope_off[c + 1] =
        op->slope_off[c] + 3 * (LitheCount)lth_dg_funcs(op->space, c) * lth_dg_lower(op->space, c);
  LTH_NEW(ctx, op->slope, op->slope_off[n]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < n; c++) lth_dg_cell_slope(op, c);
  return LITHE_OK;
}

static LitheStatus build_cells(LitheCtx *ctx, LthDgOperator *op) {
  LitheIndex n = op->space->n_cells;
  LTH_NEW(ctx, op->cell_off, n + 1);
  LTH_NEW(ctx, op->cell_load, op->space->n_dofs);
  LTH_NEW(ctx, op->partial, n);
  for (LitheIndex c = 0; c < n; c++) {
    LitheCount nb = lth_dg_funcs(op->space, c);
    op->cell_off[c + 1] = op->cell_off[c] + 9 * nb * nb;
  }
  LTH_NEW(ctx, op->cell_data, op->cell_off[n]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < n; c++) lth_dg_cell_matrix(op, c);
  return LITHE_OK;
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
  LITHE_TRY_OR(done, build_slopes(ctx, op));
  LITHE_TRY_OR(done, lth_dg_build_faces(ctx, op));
  LITHE_TRY_OR(done, lth_dg_build_holds(ctx, op));
  LITHE_TRY_OR(done, build_cells(ctx, op));
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
  void *blocks[] = {op->lambda,    op->mu,           op->young,    op->rotation,  op->rest,
                    op->slope_off, op->slope,        op->cell_off, op->cell_data, op->cell_load,
                    op->faces,     op->own_face_off, op->side_off, op->sides,     op->face_data,
                    op->weak,      op->partial};
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
