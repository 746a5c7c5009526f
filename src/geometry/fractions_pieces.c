/// Pieces: flood fill over shared faces, and what is left of the fractions without some of them.
#include "geometry/fractions_pieces.h"

#include "base/tensor.h"

static double cell_fraction(const LthFractions *f, LitheCount slot) {
  double sum = 0;
  for (int q = 0; q < f->n_parts; q++) sum += lth_fractions_part(f, slot, q);
  return sum / f->n_parts;
}

/// Is anything on either side of the face between two cells, along an axis, on both sides? `slot` is the lower.
static bool are_joined(const LthFractions *f, LitheCount slot, LitheCount next, int axis) {
  double below = 0, above = 0;
  for (int q = 0; q < f->n_parts; q++) {
    if (q >> axis & 1)
      below += lth_fractions_part(f, slot, q);
    else
      above += lth_fractions_part(f, next, q);
  }
  return below > 0 && above > 0;
}

typedef struct Flood {
  const LthFractions *fractions;
  LthPieces *pieces;
  LitheCount *stack, top, cap;
} Flood;

static LitheStatus visit(LitheCtx *ctx, Flood *d, LitheCount slot, LitheIndex piece) {
  d->pieces->piece[slot] = piece;
  LTH_RESERVE(ctx, d->stack, d->cap, d->top + 1);
  d->stack[d->top++] = slot;
  return LITHE_OK;
}

/// All cells that are joined to the first; `piece[slot]` is n where a cell is not in a piece yet.
static LitheStatus flood(LitheCtx *ctx, Flood *d, LitheCount first, LitheIndex piece) {
  const LthSparseGrid *g = d->fractions->grid;
  LitheIndex *of = d->pieces->piece;
  LITHE_TRY(visit(ctx, d, first, piece));
  while (d->top > 0) {
    LitheCount slot = d->stack[--d->top];
    for (int side = 0; side < 2 * g->dim; side++) {
      int step[3] = {0, 0, 0}, axis = side / 2;
      step[axis] = side % 2 ? 1 : -1;
      LitheCount next = lth_sparse_grid_step(g, slot, step);
      if (next < 0 || of[next] != INT32_MAX) continue;
      bool is_joined = side % 2 ? are_joined(d->fractions, slot, next, axis)
                                : are_joined(d->fractions, next, slot, axis);
      if (is_joined) LITHE_TRY(visit(ctx, d, next, piece));
    }
  }
  return LITHE_OK;
}

/// Cells, volume and box of each piece.
static void measure(const LthFractions *f, LthPieces *p) {
  const LthSparseGrid *g = f->grid;
  for (LitheIndex i = 0; i < p->n; i++)
    for (int a = 0; a < 3; a++) {
      p->box[6 * (size_t)i + (size_t)a] = INFINITY;
      p->box[6 * (size_t)i + 3 + (size_t)a] = -INFINITY;
    }
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    LitheIndex i = p->piece[slot], cell[3];
    if (i < 0) continue;
    double low[3], high[3], *box = p->box + 6 * (size_t)i;
    lth_sparse_grid_cell(g, slot, cell);
    lth_sparse_grid_place(g, cell, (double[3]){0, 0, 0}, low);
    lth_sparse_grid_place(g, cell, (double[3]){1, 1, 1}, high);
    for (int a = 0; a < 3; a++) {
      box[a] = fmin(box[a], low[a]);
      box[3 + a] = fmax(box[3 + a], high[a]);
    }
    p->cells[i]++;
    p->volume[i] += cell_fraction(f, slot) * lth_sparse_grid_cell_volume(g);
  }
}

LitheStatus lth_pieces_create(LitheCtx *ctx, const LthFractions *f, double threshold,
                              LthPieces **pieces) {
  LitheStatus status = LITHE_OK;
  LitheCount n_slots = f->grid->n_slots;
  LthPieces *p = NULL;
  Flood d = {.fractions = f};
  *pieces = NULL;
  LTH_NEW_OR(done, ctx, p, 1);
  LTH_NEW_OR(done, ctx, p->piece, n_slots);
  d.pieces = p;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount slot = 0; slot < n_slots; slot++)
    p->piece[slot] = cell_fraction(f, slot) > threshold ? INT32_MAX : -1;
  for (LitheCount slot = 0; slot < n_slots; slot++)
    if (p->piece[slot] == INT32_MAX) LITHE_TRY_OR(done, flood(ctx, &d, slot, p->n++));
  LTH_NEW_OR(done, ctx, p->cells, p->n);
  LTH_NEW_OR(done, ctx, p->volume, p->n);
  LTH_NEW_OR(done, ctx, p->box, 6 * (LitheCount)p->n);
  measure(f, p);
  *pieces = p;
  p = NULL;
done:
  lth_free(ctx, d.stack);
  lth_pieces_destroy(ctx, &p);
  return status;
}

void lth_pieces_destroy(LitheCtx *ctx, LthPieces **pieces) {
  if (!pieces || !*pieces) return;
  lth_free(ctx, (*pieces)->piece);
  lth_free(ctx, (*pieces)->cells);
  lth_free(ctx, (*pieces)->volume);
  lth_free(ctx, (*pieces)->box);
  lth_free(ctx, *pieces);
  *pieces = NULL;
}

/// Does a cell stay: one of a kept piece, or a thin rest next to one?
static bool stays(const LthSparseGrid *g, const LthPieces *p, const bool *keep, LitheCount slot) {
  if (p->piece[slot] >= 0) return keep[p->piece[slot]];
  for (int q = 0; q < (g->dim == 3 ? 27 : 9); q++) {
    int step[3] = {q % 3 - 1, q / 3 % 3 - 1, g->dim == 3 ? q / 9 - 1 : 0};
    LitheCount next = lth_sparse_grid_step(g, slot, step);
    if (next >= 0 && p->piece[next] >= 0 && keep[p->piece[next]]) return true;
  }
  return false;
}

/// Empty cells of a block; its cut cells move together to the front of its parts. Returns the volume in cells that
/// is left.
static double thin_out(const LthPieces *p, const bool *keep, LthFractions *f, LitheIndex block,
                       LitheCount *n_cut) {
  const LthSparseGrid *g = f->grid;
  LitheCount first = (LitheCount)block * g->block_cells;
  double *to = f->part + f->first[block] * f->n_parts, sum = 0;
  *n_cut = 0;
  for (LitheCount slot = first; slot < first + g->block_cells; slot++) {
    uint16_t cell = f->cell[slot];
    if (cell == LTH_CELL_EMPTY) continue;
    if (!stays(g, p, keep, slot)) {
      f->cell[slot] = LTH_CELL_EMPTY;
      continue;
    }
    sum += cell_fraction(f, slot);
    if (cell < LTH_CELL_CUT) continue;
    memmove(to, f->part + (f->first[block] + cell - LTH_CELL_CUT) * f->n_parts,
            (size_t)f->n_parts * sizeof *to);
    to += f->n_parts;
    f->cell[slot] = (uint16_t)(LTH_CELL_CUT + (*n_cut)++);
  }
  return sum;
}

LitheStatus lth_pieces_keep(LitheCtx *ctx, const LthPieces *p, const bool *keep, LthFractions *f) {
  LitheStatus status = LITHE_OK;
  LitheIndex n_blocks = f->grid->n_blocks;
  LitheCount *n_cut = NULL, at = 0;
  double *sums = NULL;
  LTH_NEW_OR(done, ctx, n_cut, n_blocks);
  LTH_NEW_OR(done, ctx, sums, n_blocks);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < n_blocks; b++) sums[b] = thin_out(p, keep, f, b, &n_cut[b]);

  // blocks move together
  f->volume = 0;
  for (LitheIndex b = 0; b < n_blocks; b++) {
    memmove(f->part + at * f->n_parts, f->part + f->first[b] * f->n_parts,
            (size_t)(n_cut[b] * f->n_parts) * sizeof *f->part);
    f->first[b] = at;
    at += n_cut[b];
    f->volume += sums[b];
  }
  f->first[n_blocks] = at;
  f->volume *= lth_sparse_grid_cell_volume(f->grid);
done:
  lth_free(ctx, n_cut);
  lth_free(ctx, sums);
  return status;
}
