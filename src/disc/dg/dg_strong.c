/// Strong constraints: their coefficients are projections of prescribed places, by quadrature points that
/// are kept.
#include "disc/dg/dg_strong.h"

#include "base/tensor.h"

#include <string.h>

/// One prescribed cell: coefficient i = sum_q test[i][q] place(points[q]).
typedef struct StrongCell {
  LitheIndex cell, motion, n; ///< n quadrature points
  double *points;             ///< (n x 3)
  double *test;               ///< weight phi_i / |K|                       (funcs x n)
} StrongCell;

struct LthDgStrong {
  const LthDgSpace *space;
  LthStrongMotion *motions;
  uint8_t *held; ///< (n_dofs)
  StrongCell *cells;
  LitheIndex n;
};

void lth_dg_strong_destroy(LitheCtx *ctx, LthDgStrong **strong) {
  if (!*strong) return;
  for (LitheIndex i = 0; (*strong)->cells && i < (*strong)->n; i++) {
    lth_free(ctx, (*strong)->cells[i].points);
    lth_free(ctx, (*strong)->cells[i].test);
  }
  lth_free(ctx, (*strong)->cells);
  lth_free(ctx, (*strong)->held);
  lth_free(ctx, (*strong)->motions);
  lth_free(ctx, *strong);
  *strong = NULL;
}

const uint8_t *lth_dg_strong_held(const LthDgStrong *strong) { return strong->held; }

static void place_at(const LthStrongMotion *motion, const double x[3], double t, double place[3]) {
  for (int a = 0; a < 3; a++)
    place[a] = lth_value_at(motion->value + a, x, t) + (motion->is_position ? 0 : x[a]);
}

LitheStatus lth_dg_strong_prescribe(const void *self, double t, double *x) {
  const LthDgStrong *strong = self;
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    LitheIndex first = strong->space->func_off[cell->cell];
    int funcs = lth_dg_funcs(strong->space, cell->cell);
    memset(x + 3 * (LitheCount)first, 0, sizeof *x * 3 * (size_t)funcs);
    for (LitheIndex q = 0; q < cell->n; q++) {
      double place[3];
      place_at(strong->motions + cell->motion, cell->points + 3 * (LitheCount)q, t, place);
      for (int f = 0; f < funcs; f++)
        for (int a = 0; a < 3; a++)
          x[3 * (LitheCount)(first + f) + a] += cell->test[(LitheCount)f * cell->n + q] * place[a];
    }
  }
  return LITHE_OK;
}

void lth_dg_strong_add_reactions(const LthDgStrong *strong, const double *imbalance,
                                 double *reaction) {
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    // phi_0 = 1: its coefficient of a force is the whole force on the cell
    const double *force = imbalance + 3 * (LitheCount)strong->space->func_off[cell->cell];
    lth_v3_axpy(-1, force, reaction + 3 * (LitheCount)cell->motion);
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

static LitheStatus prepare_all(LitheCtx *ctx, const LitheIndex *motion_of, LthDgStrong *strong) {
  LitheIndex n = 0, n_cells = strong->space->n_cells;
  for (LitheIndex c = 0; c < n_cells; c++) n += motion_of[c] >= 0;
  LTH_NEW(ctx, strong->held, strong->space->n_dofs);
  LTH_NEW(ctx, strong->cells, n);
  for (LitheIndex c = 0; c < n_cells; c++) {
    if (motion_of[c] < 0) continue;
    StrongCell *cell = strong->cells + strong->n++;
    memset(strong->held + 3 * (LitheCount)strong->space->func_off[c], 1,
           3 * (size_t)lth_dg_funcs(strong->space, c));
    cell->cell = c;
    cell->motion = motion_of[c];
    LITHE_TRY(prepare_cell(ctx, strong->space, cell));
  }
  return LITHE_OK;
}

LitheStatus lth_dg_strong_create(LitheCtx *ctx, const LthDgSpace *space,
                                 const LitheIndex *motion_of, LitheIndex n_motions,
                                 const LthStrongMotion *motions, LthDgStrong **strong) {
  LitheStatus status = LITHE_OK;
  *strong = NULL;
  LTH_NEW(ctx, *strong, 1);
  (*strong)->space = space;
  LTH_NEW_OR(done, ctx, (*strong)->motions, n_motions);
  for (LitheIndex i = 0; i < n_motions; i++) (*strong)->motions[i] = motions[i];
  LITHE_TRY_OR(done, prepare_all(ctx, motion_of, *strong));
done:
  if (status != LITHE_OK) lth_dg_strong_destroy(ctx, strong);
  return status;
}
