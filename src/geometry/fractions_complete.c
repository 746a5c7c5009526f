/// Making parts of cells full: what cells are is decided anew, block by block, and their parts are laid out again.
#include "geometry/fractions_complete.h"

/// Old and new; `mask` has the chosen parts of every slot.
typedef struct Change {
  const LthFractions *old;
  uint8_t *mask;     // (n_slots)
  uint16_t *cell;    // (n_slots)
  LitheCount *first; // (n_blocks + 1)
  double *part;
} Change;

static double part_after(const Change *c, LitheCount slot, int q) {
  return c->mask[slot] >> q & 1 ? 1 : lth_fractions_part(c->old, slot, q);
}

static uint16_t kind_after(const Change *c, LitheCount slot) {
  bool any = false, all = true;
  for (int q = 0; q < c->old->n_parts; q++) {
    double v = part_after(c, slot, q);
    any = any || v > 0;
    all = all && v == 1;
  }
  return all ? LTH_CELL_FULL : any ? LTH_CELL_CUT : LTH_CELL_EMPTY;
}

/// Choose, and number the cut cells of each block.
static void choose_parts(LitheCtx *ctx, Change *c, LthPartChoice choose, const void *self) {
  const LthSparseGrid *g = c->old->grid;
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LitheCount slot = (LitheCount)block * g->block_cells, end = slot + g->block_cells;
    uint16_t n_cut = 0;
    for (; slot < end; slot++) {
      uint16_t kind = c->old->cell[slot];
      if (kind != LTH_CELL_FULL) c->mask[slot] = choose(self, slot);
      if (c->mask[slot] || kind >= LTH_CELL_CUT) kind = kind_after(c, slot);
      c->cell[slot] = kind == LTH_CELL_CUT ? (uint16_t)(LTH_CELL_CUT + n_cut++) : kind;
    }
    c->first[block + 1] = n_cut;
  }
}

static void copy_parts(LitheCtx *ctx, const Change *c) {
  const LthFractions *f = c->old;
  const LthSparseGrid *g = f->grid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++)
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      LitheCount slot = (LitheCount)block * g->block_cells + local;
      if (c->cell[slot] < LTH_CELL_CUT) continue;
      double *to = c->part + (c->first[block] + c->cell[slot] - LTH_CELL_CUT) * f->n_parts;
      for (int q = 0; q < f->n_parts; q++) to[q] = part_after(c, slot, q);
    }
}

LitheStatus lth_fractions_complete(LitheCtx *ctx, LthFractions *f, LthPartChoice choose,
                                   const void *self) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = f->grid;
  Change c = {.old = f};
  LTH_NEW_OR(done, ctx, c.mask, g->n_slots);
  LTH_NEW_OR(done, ctx, c.cell, g->n_slots);
  LTH_NEW_OR(done, ctx, c.first, (LitheCount)g->n_blocks + 1);
  choose_parts(ctx, &c, choose, self);
  for (LitheIndex b = 0; b < g->n_blocks; b++) c.first[b + 1] += c.first[b];
  LTH_NEW_OR(done, ctx, c.part, c.first[g->n_blocks] * f->n_parts);
  copy_parts(ctx, &c);
  lth_free(ctx, f->cell);
  lth_free(ctx, f->first);
  lth_free(ctx, f->part);
  f->cell = c.cell;
  f->first = c.first;
  f->part = c.part;
  c.cell = NULL;
  c.first = NULL;
  c.part = NULL;
done:
  lth_free(ctx, c.mask);
  lth_free(ctx, c.cell);
  lth_free(ctx, c.first);
  lth_free(ctx, c.part);
  return status;
}
