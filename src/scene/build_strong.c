/// Strong constraints: whole elements that move as prescribed. Their coefficients are the projection of
/// the prescribed field, by quadrature points that are kept.
#include "scene/body.h"

#include "base/tensor.h"

#include <string.h>

/// One prescribed cell: coefficient i = sum_q test[i][q] field(points[q]).
typedef struct StrongCell {
  LitheIndex cell, n; ///< n quadrature points
  const LthSceneConstraint *constraint;
  double *points; ///< (n x 3)
  double *test;   ///< weight phi_i / |K|                       (funcs x n)
} StrongCell;

struct LthStrong {
  const LthDgSpace *space;
  uint8_t *is_strong; ///< (n_cells)
  StrongCell *cells;
  LitheIndex n;
};

void lth_strong_destroy(LitheCtx *ctx, LthStrong **strong) {
  if (!*strong) return;
  for (LitheIndex i = 0; (*strong)->cells && i < (*strong)->n; i++) {
    lth_free(ctx, (*strong)->cells[i].points);
    lth_free(ctx, (*strong)->cells[i].test);
  }
  lth_free(ctx, (*strong)->cells);
  lth_free(ctx, (*strong)->is_strong);
  lth_free(ctx, *strong);
  *strong = NULL;
}

const uint8_t *lth_strong_cells(const LthStrong *strong) { return strong->is_strong; }

static void prescribed_place(const LthSceneConstraint *c, const double x[3], double t,
                             double place[3]) {
  for (int a = 0; a < 3; a++)
    place[a] = lth_value_at(c->value + a, x, t) + (c->is_position ? 0 : x[a]);
}

LitheStatus lth_strong_prescribe(const void *self, double t, double *x) {
  const LthStrong *strong = self;
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    LitheIndex first = strong->space->func_off[cell->cell];
    int funcs = lth_dg_funcs(strong->space, cell->cell);
    memset(x + 3 * (LitheCount)first, 0, sizeof *x * 3 * (size_t)funcs);
    for (LitheIndex q = 0; q < cell->n; q++) {
      double place[3];
      prescribed_place(cell->constraint, cell->points + 3 * (LitheCount)q, t, place);
      for (int f = 0; f < funcs; f++)
        for (int a = 0; a < 3; a++)
          x[3 * (LitheCount)(first + f) + a] += cell->test[(LitheCount)f * cell->n + q] * place[a];
    }
  }
  return LITHE_OK;
}

void lth_strong_add_reactions(const LthStrong *strong, const LthSceneConstraint *constraints,
                              const double *imbalance, double *reaction) {
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    // phi_0 = 1: its coefficient of a force is the whole force on the cell
    const double *force = imbalance + 3 * (LitheCount)strong->space->func_off[cell->cell];
    lth_v3_axpy(-1, force, reaction + 3 * (cell->constraint - constraints));
  }
}

static LitheStatus prepare_cell(LitheCtx *ctx, const LthDgSpace *space, StrongCell *cell) {
  double phi[LTH_DG_MAX_FUNCS], *weights = NULL;
  int funcs = lth_dg_funcs(space, cell->cell);
  LITHE_TRY(lth_dg_cell_quadrature(ctx, space->mesh, cell->cell, 2 * space->degree[cell->cell],
                                   &cell->n, &cell->points, &weights));
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, cell->test, (LitheCount)funcs * cell->n);
  for (LitheIndex q = 0; q < cell->n; q++) {
    lth_dg_eval(space, cell->cell, cell->points + 3 * (LitheCount)q, phi);
    for (int f = 0; f < funcs; f++)
      cell->test[(LitheCount)f * cell->n + q] =
          weights[q] * phi[f] / space->mesh->cell_volume[cell->cell];
  }

done:
  lth_free(ctx, weights);
  return status;
}

/// Mark the cells of constraint i with i + 1 where no earlier constraint has them.
static LitheStatus mark(LitheCtx *ctx, const LthBody *body, LitheIndex i,
                        LitheIndex *constraint_of) {
  LitheStatus status = LITHE_OK;
  const LthSceneConstraint *c = body->def->constraints + i;
  uint8_t *chosen = NULL;
  bool any = false;
  if (c->normal_only || !(c->fixed[0] && c->fixed[1] && c->fixed[2]))
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "%s: strong and interior constraints hold all three components; for `null` "
               "components and rollers use `enforce: weak` without `interior`",
               c->place);
  LTH_NEW_OR(done, ctx, chosen, body->mesh->n_cells);
  LITHE_TRY_OR(done, lth_select_cells(ctx, body->mesh, &c->where, chosen));
  for (LitheIndex k = 0; k < body->mesh->n_cells; k++) {
    any = any || chosen[k];
    if (chosen[k] && constraint_of[k] == 0) constraint_of[k] = i + 1;
  }
  if (!any)
    status =
        lth_fail(ctx, LITHE_BAD_INPUT,
                 "%s.where: selects no element; the body reaches from (%g, %g, %g) to (%g, %g, %g)",
                 c->place, body->box[0], body->box[1], body->box[2], body->box[3], body->box[4],
                 body->box[5]);

done:
  lth_free(ctx, chosen);
  return status;
}

static LitheStatus collect(LitheCtx *ctx, const LthBody *body, const LitheIndex *constraint_of,
                           LthStrong *strong) {
  LitheIndex n = 0, n_cells = body->mesh->n_cells;
  for (LitheIndex k = 0; k < n_cells; k++) n += constraint_of[k] > 0;
  LTH_NEW(ctx, strong->is_strong, n_cells);
  LTH_NEW(ctx, strong->cells, n);
  strong->space = body->space;
  for (LitheIndex k = 0; k < n_cells; k++) {
    if (constraint_of[k] == 0) continue;
    StrongCell *cell = strong->cells + strong->n++;
    strong->is_strong[k] = 1;
    cell->cell = k;
    cell->constraint = body->def->constraints + constraint_of[k] - 1;
    LITHE_TRY(prepare_cell(ctx, body->space, cell));
  }
  return LITHE_OK;
}

LitheStatus lth_strong_create(LitheCtx *ctx, const LthBody *body, LthStrong **strong) {
  LitheStatus status = LITHE_OK;
  LitheIndex *constraint_of = NULL;
  LTH_NEW(ctx, *strong, 1);
  LTH_NEW_OR(done, ctx, constraint_of, body->mesh->n_cells);
  for (LitheIndex i = 0; i < body->def->n_constraints; i++)
    if (body->def->constraints[i].strong || body->def->constraints[i].interior)
      LITHE_TRY_OR(done, mark(ctx, body, i, constraint_of));
  LITHE_TRY_OR(done, collect(ctx, body, constraint_of, *strong));

done:
  lth_free(ctx, constraint_of);
  if (status != LITHE_OK) lth_strong_destroy(ctx, strong);
  return status;
}
