/// What is told of staggered bodies before they are run.
#include "scene/report_grid.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "disc/staggered/staggered_hierarchy.h"
#include "io/grid_cells.h"

#define THIN 0.002 // share of cells that corners and slivers of a cut boundary may have

static bool is_filled(const LthStaggeredBody *s, LitheCount slot) {
  return slot >= 0 && s->filled[slot] > 0;
}

static LitheCount slot_below(const LthSparseGrid *g, LitheCount slot, int a) {
  int step[3] = {0};
  step[a] = -1;
  return lth_sparse_grid_step(g, slot, step);
}

static bool is_full(const LthStaggeredBody *s, LitheCount slot) {
  return slot >= 0 && s->filled[slot] >= 1;
}

/// Count what stands at a slot; whether that is anything, and whether all is full around it.
static void count_slot(const LthStaggeredBody *s, LitheCount slot, LthGridCount *count, bool *any,
                       bool *full) {
  const LthSparseGrid *g = s->fractions->grid;
  LitheCount unknowns = 0;
  count->cells += is_filled(s, slot);
  count->cut += is_filled(s, slot) && s->filled[slot] < 1;
  *full &= is_full(s, slot);
  for (int a = 0; a < g->dim; a++) {
    const LitheCount below = slot_below(g, slot, a);
    unknowns += is_filled(s, slot) || is_filled(s, below);
    *full &= is_full(s, below);
  }
  count->unknowns += unknowns;
  count->funcs += unknowns > 0;
  *any |= unknowns > 0;
}

LthGridCount lth_count_grid(const LthBody *body) {
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  LthGridCount count = {0};
  for (LitheCount first = 0; first < g->n_slots; first += g->side) {
    bool any = false, full = true;
    for (LitheCount slot = first; slot < first + g->side; slot++)
      count_slot(s, slot, &count, &any, &full);
    count.rows += any;
    count.own_rows += any && !full;
  }
  return count;
}

/// Pieces of cells that have faces in common.
static LitheStatus count_pieces(LitheCtx *ctx, const LthBody *body, LitheIndex *n) {
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  LitheIndex *set = NULL;
  if (g->n_slots > INT32_MAX)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "a grid of %lld cells is too large to count its pieces",
               (long long)g->n_slots);
  LTH_NEW(ctx, set, g->n_slots);
  lth_sets_reset(set, (LitheIndex)g->n_slots);
  for (LitheCount slot = 0; slot < g->n_slots; slot++)
    for (int a = 0; is_filled(s, slot) && a < g->dim; a++) {
      LitheCount below = slot_below(g, slot, a);
      if (is_filled(s, below)) lth_sets_unite(set, (LitheIndex)slot, (LitheIndex)below);
    }
  for (LitheCount slot = 0; slot < g->n_slots; slot++)
    *n += is_filled(s, slot) && lth_sets_root(set, (LitheIndex)slot) == slot;
  lth_free(ctx, set);
  return LITHE_OK;
}

/// Features of less than three cells: a run leaves out what hangs on by less than two, and tells so once it is built.
static LitheStatus warn_of_thin(LitheCtx *ctx, const LthBody *body) {
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  static const double middle[3] = {0.5, 0.5, 0.5};
  double share = 0, x[3];
  LitheCount where = -1;
  LitheIndex cell[3];
  LITHE_TRY(lth_staggered_thin_share(ctx, g, s->filled, &share, &where));
  if (where < 0 || share <= THIN) return LITHE_OK;
  lth_sparse_grid_cell(g, where, cell);
  lth_sparse_grid_place(g, cell, middle, x);
  lth_warn(ctx,
           "body %s: %.2g %% of its cells are in features thinner than three cells, for example at "
           "(%g, %g, %g): "
           "their stress is rough, and a run leaves out what hangs on by less than two; take "
           "smaller cells",
           body->def->name, 100 * share, x[0], x[1], x[2]);
  return LITHE_OK;
}

LitheStatus lth_report_grid(LitheCtx *ctx, const LthBody *body, LitheMeshReport *r) {
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  double cell = lth_sparse_grid_cell_volume(g);
  LthGridCount count = lth_count_grid(body);
  double least = 1, most = 0;
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    if (!is_filled(s, slot)) continue;
    least = fmin(least, (double)s->filled[slot]);
    most = fmax(most, (double)s->filled[slot]);
  }
  r->min_volume = r->elements == 0 ? least * cell : fmin(r->min_volume, least * cell);
  r->max_volume = fmax(r->max_volume, most * cell);
  r->elements += count.cells;
  r->full_cells += count.cells - count.cut;
  r->cut_cells += count.cut;
  r->volume += s->volume;
  for (int a = 0; a < g->dim; a++)
    for (int b = 0; b < g->dim; b++) r->max_aspect = fmax(r->max_aspect, g->h[a] / g->h[b]);
  LITHE_TRY(warn_of_thin(ctx, body));
  return count_pieces(ctx, body, &r->components);
}

static LitheStatus list_cells(LitheCtx *ctx, const LthStaggeredBody *s, LitheIndex n,
                              LitheIndex **cell, LitheCount **slot_of, double **fraction) {
  LitheCount n_slots = s->fractions->grid->n_slots;
  LitheIndex k = 0;
  LTH_NEW(ctx, *cell, n_slots);
  LTH_NEW(ctx, *slot_of, n);
  LTH_NEW(ctx, *fraction, n);
  for (LitheCount slot = 0; slot < n_slots; slot++) {
    (*cell)[slot] = -1;
    if (!is_filled(s, slot)) continue;
    (*slot_of)[k] = slot;
    (*fraction)[k] = (double)s->filled[slot];
    (*cell)[slot] = k++;
  }
  return LITHE_OK;
}

LitheStatus lth_write_fractions(LitheCtx *ctx, const LthBody *body, const char *path) {
  LitheStatus status = LITHE_OK;
  const LthStaggeredBody *s = body->staggered;
  LitheIndex *cell = NULL, n = lth_count_grid(body).cells;
  LitheCount *slot_of = NULL;
  double *fraction = NULL;
  LITHE_TRY_OR(done, list_cells(ctx, s, n, &cell, &slot_of, &fraction));
  const LthVtuArray array = lth_vtk_array("fraction", 1, fraction);
  LthGridCells cells = {.grid = s->fractions->grid,
                        .n_cells = n,
                        .cell = cell,
                        .cell_slot = slot_of,
                        .arrays = &array,
                        .n_arrays = 1};
  status = lth_grid_image_write(ctx, path, &cells);

done:
  lth_free(ctx, cell);
  lth_free(ctx, slot_of);
  lth_free(ctx, fraction);
  return status;
}
