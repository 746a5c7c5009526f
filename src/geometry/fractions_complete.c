/// Giving parts of cells other fractions: what cells are is decided anew, block by block. Parts of blocks in which some differ
/// stand behind all that were there, which remain for the fractions as they were.
#include "geometry/fractions_complete.h"

#include <string.h>

/// Old and new.
typedef struct Change {
  const LthFractions *old;
  LthPartChange change;
  const void *self;
  uint16_t *cell;    // (n_slots)
  LitheCount *first; // (n_blocks + 1)
  double *part;
  double *sum;      // of parts, per block
  uint8_t *differs; // some part of a block does                     (n_blocks)
} Change;

/// Parts of a slot's cell after the change.
static void parts_after(const Change *c, LitheCount slot, double part[8]) {
  for (int q = 0; q < c->old->n_parts; q++) part[q] = lth_fractions_part(c->old, slot, q);
  if (c->old->cell[slot] != LTH_CELL_FULL) c->change(c->self, slot, part);
}

static uint16_t kind_after(const Change *c, LitheCount slot, double *sum, uint8_t *differs) {
  bool any = false, all = true;
  double part[8];
  parts_after(c, slot, part);
  for (int q = 0; q < c->old->n_parts; q++) {
    *sum += part[q];
    any = any || part[q] > 0;
    all = all && part[q] == 1;
    *differs |= part[q] != lth_fractions_part(c->old, slot, q);
  }
  return all ? LTH_CELL_FULL : any ? LTH_CELL_CUT : LTH_CELL_EMPTY;
}

/// What cells are, and how many of each block are cut.
static void classify(LitheCtx *ctx, Change *c) {
  const LthSparseGrid *g = c->old->grid;
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LitheCount slot = (LitheCount)block * g->block_cells, end = slot + g->block_cells;
    uint16_t n_cut = 0;
    for (; slot < end; slot++) {
      uint16_t kind = kind_after(c, slot, &c->sum[block], &c->differs[block]);
      c->cell[slot] = kind == LTH_CELL_CUT ? (uint16_t)(LTH_CELL_CUT + n_cut++) : kind;
    }
    c->first[block + 1] = n_cut;
  }
}

static void copy_parts(LitheCtx *ctx, const Change *c) {
  const LthFractions *f = c->old;
  const LthSparseGrid *g = f->grid;
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++)
    for (LitheIndex local = 0; c->differs[block] && local < g->block_cells; local++) {
      LitheCount slot = (LitheCount)block * g->block_cells + local;
      double part[8];
      if (c->cell[slot] < LTH_CELL_CUT) continue;
      parts_after(c, slot, part);
      memcpy(c->part + (c->first[block] + c->cell[slot] - LTH_CELL_CUT) * f->n_parts, part,
             (size_t)f->n_parts * sizeof *part);
    }
}

/// Where parts of blocks begin, and room for those that differ behind the others. `first` has counts of cut cells, one
/// block further on, before.
static LitheStatus lay_out(LitheCtx *ctx, Change *c) {
  const LthFractions *f = c->old;
  const LitheIndex n = f->grid->n_blocks;
  LitheCount end = f->first[n];
  for (LitheIndex b = 0; b < n; b++) {
    const LitheCount n_cut = c->first[b + 1];
    c->first[b] = c->differs[b] ? end : f->first[b];
    end += c->differs[b] ? n_cut : 0;
  }
  c->first[n] = end;
  LTH_NEW(ctx, c->part, end * f->n_parts);
  memcpy(c->part, f->part, sizeof *f->part * (size_t)(f->first[n] * f->n_parts));
  return LITHE_OK;
}

/// Put the new parts in place of the old ones, which `before` gets.
static void exchange(LitheCtx *ctx, LthFractions *f, Change *c, LthFractions *before) {
  lth_free(ctx, f->part);
  f->part = c->part;
  *before = *f;
  f->cell = c->cell;
  f->first = c->first;
  c->cell = NULL;
  c->first = NULL;
  c->part = NULL;
}

LitheStatus lth_fractions_change(LitheCtx *ctx, LthFractions *f, LthPartChange change,
                                 const void *self, LthFractions *before) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = f->grid;
  Change c = {.old = f, .change = change, .self = self};
  double sum = 0;
  LTH_NEW_OR(done, ctx, c.cell, g->n_slots);
  LTH_NEW_OR(done, ctx, c.first, (LitheCount)g->n_blocks + 1);
  LTH_NEW_OR(done, ctx, c.sum, g->n_blocks);
  LTH_NEW_OR(done, ctx, c.differs, g->n_blocks);
  classify(ctx, &c);
  for (LitheIndex b = 0; b < g->n_blocks; b++) sum += c.sum[b];
  LITHE_TRY_OR(done, lay_out(ctx, &c));
  copy_parts(ctx, &c);
  exchange(ctx, f, &c, before);
  f->volume = sum * lth_sparse_grid_cell_volume(g) / f->n_parts;
done:
  lth_free(ctx, c.cell);
  lth_free(ctx, c.first);
  lth_free(ctx, c.part);
  lth_free(ctx, c.sum);
  lth_free(ctx, c.differs);
  return status;
}

// --- parts that become full ---

typedef struct Filling {
  const LthFractions *fractions;
  uint8_t *mask; ///< chosen parts of every slot (n_slots)
} Filling;

static void fill_parts(const void *filling, LitheCount slot, double *part) {
  const Filling *f = filling;
  for (int q = 0; q < f->fractions->n_parts; q++)
    if (f->mask[slot] >> q & 1) part[q] = 1;
}

LitheStatus lth_fractions_complete(LitheCtx *ctx, LthFractions *f, LthPartChoice choose,
                                   const void *self, LthFractions *before) {
  LitheStatus status = LITHE_OK;
  Filling filling = {.fractions = f};
  LitheCount n = f->grid->n_slots;
  double volume = f->volume;
  LTH_NEW_OR(done, ctx, filling.mask, n);
#pragma omp parallel for schedule(dynamic, 2048) num_threads(lth_threads(ctx))
  for (LitheCount slot = 0; slot < n; slot++)
    if (f->cell[slot] != LTH_CELL_FULL) filling.mask[slot] = choose(self, slot);
  LITHE_TRY_OR(done, lth_fractions_change(ctx, f, fill_parts, &filling, before));
  f->volume = volume;
done:
  lth_free(ctx, filling.mask);
  return status;
}

void lth_fractions_forget(LitheCtx *ctx, LthFractions *before) {
  lth_free(ctx, before->cell);
  lth_free(ctx, before->first);
  *before = (LthFractions){0};
}
