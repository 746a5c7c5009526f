/// Strong constraints: their coefficients are projections of prescribed places, by quadrature points that
/// are kept.
#include "disc/dg/dg_strong.h"

#include "base/tensor.h"

#include <string.h>

/// A cell with prescribed components: coefficient i of them = sum_q test[i][q] place(points[q]).
typedef struct StrongCell {
  LitheIndex cell, motion[3], n; ///< motion -1: free; n quadrature points
  double *points;                ///< (n x 3)
  double *test;                  ///< weight phi_i / |K|                    (funcs x n)
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

/// Place of component a.
static double place_at(const LthStrongMotion *motion, int a, const double x[3], double t) {
  double value = motion->factor * lth_value_at(motion->value + a, x, t);
  return value + (motion->is_position ? 0 : x[a]);
}

static void prescribe_component(const LthDgStrong *strong, const StrongCell *cell, int a, double t,
                                double *x) {
  const LthStrongMotion *motion = strong->motions + cell->motion[a];
  int funcs = lth_dg_funcs(strong->space, cell->cell);
  for (int f = 0; f < funcs; f++) x[3 * f + a] = 0;
  for (LitheIndex q = 0; q < cell->n; q++) {
    double place = place_at(motion, a, cell->points + 3 * (LitheCount)q, t);
    for (int f = 0; f < funcs; f++) x[3 * f + a] += cell->test[(LitheCount)f * cell->n + q] * place;
  }
}

LitheStatus lth_dg_strong_prescribe(const void *self, double t, double *x) {
  const LthDgStrong *strong = self;
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    double *first = x + 3 * (LitheCount)strong->space->func_off[cell->cell];
    for (int a = 0; a < 3; a++)
      if (cell->motion[a] >= 0) prescribe_component(strong, cell, a, t, first);
  }
  return LITHE_OK;
}

void lth_dg_strong_add_reactions(const LthDgStrong *strong, const double *imbalance,
                                 double *reaction) {
  for (LitheIndex i = 0; i < strong->n; i++) {
    const StrongCell *cell = strong->cells + i;
    // phi_0 = 1: its coefficient of a force is the whole force on the cell
    const double *force = imbalance + 3 * (LitheCount)strong->space->func_off[cell->cell];
    for (int a = 0; a < 3; a++)
      if (cell->motion[a] >= 0)
        reaction[3 * (LitheCount)strong->motions[cell->motion[a]].constraint + a] -= force[a];
  }
}

static LitheStatus prepare_cell(LitheCtx *ctx, const LthDgSpace *space, StrongCell *cell) {
  double phi[LTH_DG_MAX_FUNCS], *weights = NULL;
  int funcs = lth_dg_funcs(space, cell->cell);
  LITHE_TRY(lth_dg_cell_quadrature(ctx, space->mesh, cell->cell, 2 * space->degree[cell->cell] + 2,
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

static bool is_held(const LitheIndex *motion_of, LitheIndex cell) {
  const LitheIndex *m = motion_of + 3 * (LitheCount)cell;
  return m[0] >= 0 || m[1] >= 0 || m[2] >= 0;
}

static LitheStatus prepare_all(LitheCtx *ctx, const LitheIndex *motion_of, LthDgStrong *strong) {
  const LthDgSpace *space = strong->space;
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < space->n_cells; c++) n += is_held(motion_of, c);
  LTH_NEW(ctx, strong->held, space->n_dofs);
  LTH_NEW(ctx, strong->cells, n);
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    if (!is_held(motion_of, c)) continue;
    StrongCell *cell = strong->cells + strong->n++;
    cell->cell = c;
    memcpy(cell->motion, motion_of + 3 * (LitheCount)c, sizeof cell->motion);
    LitheCount first = 3 * (LitheCount)space->func_off[c],
               last = 3 * (LitheCount)space->func_off[c + 1];
    for (LitheCount i = first; i < last; i++) strong->held[i] = cell->motion[i % 3] >= 0;
    LITHE_TRY(prepare_cell(ctx, space, cell));
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
