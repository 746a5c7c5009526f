/// Volume fractions: which blocks are there, rows of blocks filled by a method, and what is cut kept.
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

#include <stdlib.h>

#define MARGIN 2          // cells: held sides may fill the first, whose neighbours are then needed
#define SUPER 8           ///< blocks along the boxes that are asked first
#define CELLS_MAX 1048576 ///< along an axis
#define SNAP 1e-12        ///< of a part: rounding of what is empty or full
#define PROGRESS_ROUNDS 32

/// What is kept of a row of blocks.
typedef struct Row {
  LitheIndex n, *at; ///< blocks that were filled                                       (n)
  uint16_t *cell;    ///< as LthFractions has it                          (n x block_cells)
  uint32_t *reach;   ///< neighbours that its cells touch, bits as LthSparseGrid numbers them (n)
  LitheCount *cut;   ///< first cut cell of a block in `part`                       (n + 1)
  double *part;
} Row;

typedef struct Builder {
  LitheCtx *ctx;
  const LthFractionFiller *filler;
  LthFractionFrame frame;
  LitheIndex n_rows;
  uint8_t *side;              ///< of each block                (n_block[0] n_block[1] n_block[2])
  Row *rows;                  ///< k fastest behind j            (n_block[1] n_block[2])
  LitheIndex low[3], high[3]; ///< first and last cells that hold something
} Builder;

static LitheIndex smaller(LitheIndex a, LitheIndex b) { return a < b ? a : b; }
static LitheIndex larger(LitheIndex a, LitheIndex b) { return a > b ? a : b; }

/// --- which blocks ---

static LitheStatus make_frame(LitheCtx *ctx, int dim, const double origin[3], const double h[3],
                              const LitheIndex n[3], LthFractionFrame *f) {
  double n_blocks = 1;
  f->dim = dim;
  f->side = dim == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D;
  f->n_parts = 1 << dim;
  f->block_cells = f->side * f->side * (dim == 3 ? f->side : 1);
  for (int a = 0; a < 3; a++) {
    f->n_block[a] = f->end_cell[a] = 1;
    if (a >= dim) continue;
    if (n[a] < 1 || n[a] > CELLS_MAX || !(h[a] > 0) || !isfinite(h[a] * n[a]))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "a grid of %d cells of %g m along %c: expected from 1 to %d of positive size",
                 n[a], h[a], "xyz"[a], CELLS_MAX);
    f->origin[a] = origin[a];
    f->h[a] = h[a];
    f->end_cell[a] = n[a];
    f->n_block[a] = lth_sparse_grid_blocks(dim, a, n[a]);
    n_blocks *= f->n_block[a] + 2;
  }
  if (n_blocks > INT32_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "a grid of %d x %d x %d cells is too large; give larger cells",
               n[0], n[1], n[2]);
  return LITHE_OK;
}

/// Does the grid that was asked for end within the blocks [at, at + size)?
static bool meets_end(const LthFractionFrame *f, const LitheIndex at[3], LitheIndex size) {
  for (int a = 0; a < f->dim; a++)
    if ((at[a] + size) * f->side > f->end_cell[a]) return true;
  return false;
}

/// Sides of the blocks [at, at + size), all at once where they are on one.
static void find_side(Builder *b, const LitheIndex at[3], LitheIndex size) {
  const LthFractionFrame *f = &b->frame;
  double low[3], half[3], center[3];
  for (int a = 0; a < 3; a++)
    if (at[a] >= f->n_block[a]) return;
  lth_fraction_corner(f, at[0], at[1], at[2], low);
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * f->h[a] * f->side * size;
    center[a] = low[a] + half[a];
  }
  LthSide side = b->filler->side(b->filler->self, center, half);
  if (side == LTH_SIDE_INSIDE && meets_end(f, at, size)) side = LTH_SIDE_MIXED;
  if (side == LTH_SIDE_MIXED && size > 1) {
    for (int q = 0; q < f->n_parts; q++)
      find_side(b,
                (LitheIndex[3]){at[0] + (q & 1) * size / 2, at[1] + (q >> 1 & 1) * size / 2,
                                at[2] + (q >> 2) * size / 2},
                size / 2);
    return;
  }
  LitheIndex deep = f->dim == 3 ? size : 1;
  for (LitheIndex k = at[2]; k < smaller(at[2] + deep, f->n_block[2]); k++)
    for (LitheIndex j = at[1]; j < smaller(at[1] + size, f->n_block[1]); j++)
      for (LitheIndex i = at[0]; i < smaller(at[0] + size, f->n_block[0]); i++)
        b->side[i + (LitheCount)f->n_block[0] * (j + (LitheCount)f->n_block[1] * k)] =
            (uint8_t)side;
}

static void find_sides(Builder *b) {
  const LthFractionFrame *f = &b->frame;
  LitheIndex n[3], count = 1;
  for (int a = 0; a < 3; a++) n[a] = (f->n_block[a] + SUPER - 1) / SUPER, count *= n[a];
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(b->ctx))
  for (LitheIndex s = 0; s < count; s++) {
    LitheIndex at[3] = {SUPER * (s % n[0]), SUPER * (s / n[0] % n[1]), SUPER * (s / n[0] / n[1])};
    if (!lth_cancelled(b->ctx)) find_side(b, at, SUPER);
  }
}

/// --- a row of blocks ---

/// Empty what lies beyond the grid that was asked for.
static void cut_off(const LthFractionFrame *f, const LitheIndex block[3], double *part) {
  if (!meets_end(f, block, 1)) return;
  for (LitheIndex c = 0; c < f->block_cells; c++) {
    LitheIndex s = f->side;
    LitheIndex cell[3] = {block[0] * s + c % s, block[1] * s + c / s % s,
                          f->dim == 3 ? block[2] * s + c / (s * s) : 0};
    if (cell[0] >= f->end_cell[0] || cell[1] >= f->end_cell[1] || cell[2] >= f->end_cell[2])
      for (int q = 0; q < f->n_parts; q++) part[(LitheCount)c * f->n_parts + q] = 0;
  }
}

/// Parts within rounding of 0 and 1 are made so. Returns what the cell is.
static uint16_t settle_cell(double *part, int n_parts) {
  int empty = 0, full = 0;
  for (int q = 0; q < n_parts; q++) {
    if (!(part[q] > SNAP)) part[q] = 0;
    if (part[q] > 1 - SNAP) part[q] = 1;
    empty += part[q] == 0;
    full += part[q] == 1;
  }
  return empty == n_parts ? LTH_CELL_EMPTY : full == n_parts ? LTH_CELL_FULL : LTH_CELL_CUT;
}

/// Neighbours of a block within the margins of its place `c`, also itself.
static uint32_t touched(const LthFractionFrame *f, LitheIndex c) {
  LitheIndex s = f->side, at[3] = {c % s, c / s % s, c / (s * s)};
  int low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
  uint32_t bits = 0;
  for (int a = 0; a < f->dim; a++) low[a] = -(at[a] < MARGIN), high[a] = at[a] >= s - MARGIN;
  for (int dz = low[2]; dz <= high[2]; dz++)
    for (int dy = low[1]; dy <= high[1]; dy++)
      for (int dx = low[0]; dx <= high[0]; dx++)
        bits |= 1u << ((f->dim == 3 ? (dz + 1) * 9 : 0) + (dy + 1) * 3 + dx + 1);
  return bits;
}

/// What the cells of block m are; counts the cut ones.
static void settle_block(const LthFractionFrame *f, Row *row, LitheIndex m, double *part) {
  uint16_t *cell = row->cell + (LitheCount)m * f->block_cells;
  LitheCount n_cut = 0;
  for (LitheIndex c = 0; c < f->block_cells; c++) {
    cell[c] = settle_cell(part + (LitheCount)c * f->n_parts, f->n_parts);
    if (cell[c] == LTH_CELL_CUT) cell[c] = (uint16_t)(LTH_CELL_CUT + n_cut++);
    if (cell[c] != LTH_CELL_EMPTY) row->reach[m] |= touched(f, c);
  }
  row->cut[m + 1] = row->cut[m] + n_cut;
}

static LitheStatus keep_row(LitheCtx *ctx, const LthFractionFrame *f, Row *row,
                            const double *part) {
  LTH_NEW(ctx, row->part, row->cut[row->n] * f->n_parts);
  double *to = row->part;
  for (LitheCount c = 0; c < (LitheCount)row->n * f->block_cells; c++) {
    if (row->cell[c] < LTH_CELL_CUT) continue;
    memcpy(to, part + c * f->n_parts, (size_t)f->n_parts * sizeof *to);
    to += f->n_parts;
  }
  return LITHE_OK;
}

static LitheStatus list_row(const Builder *b, LitheIndex j, LitheIndex k, Row *row) {
  const LthFractionFrame *f = &b->frame;
  const uint8_t *side = b->side + (LitheCount)f->n_block[0] * (j + (LitheCount)f->n_block[1] * k);
  for (LitheIndex i = 0; i < f->n_block[0]; i++) row->n += side[i] == LTH_SIDE_MIXED;
  if (row->n == 0) return LITHE_OK;
  LTH_NEW(b->ctx, row->at, row->n);
  LTH_NEW(b->ctx, row->cell, (LitheCount)row->n * f->block_cells);
  LTH_NEW(b->ctx, row->reach, row->n);
  LTH_NEW(b->ctx, row->cut, (LitheCount)row->n + 1);
  for (LitheIndex i = 0, m = 0; i < f->n_block[0]; i++)
    if (side[i] == LTH_SIDE_MIXED) row->at[m++] = i;
  return LITHE_OK;
}

static LitheStatus fill_row(const Builder *b, LitheIndex r) {
  LitheStatus status = LITHE_OK;
  const LthFractionFrame *f = &b->frame;
  Row *row = &b->rows[r];
  LthFractionRow fill = {.j = r % f->n_block[1], .k = r / f->n_block[1]};
  LITHE_TRY_OR(done, list_row(b, fill.j, fill.k, row));
  if (row->n == 0) return LITHE_OK;
  fill.n = row->n;
  fill.at = row->at;
  LTH_NEW_OR(done, b->ctx, fill.part, (LitheCount)row->n * f->block_cells * f->n_parts);
  LITHE_TRY_OR(done, b->filler->fill(b->filler->self, b->ctx, f, &fill));
  for (LitheIndex m = 0; m < row->n; m++) {
    double *part = fill.part + (LitheCount)m * f->block_cells * f->n_parts;
    cut_off(f, (LitheIndex[3]){row->at[m], fill.j, fill.k}, part);
    settle_block(f, row, m, part);
  }
  LITHE_TRY_OR(done, keep_row(b->ctx, f, row, fill.part));
done:
  lth_free(b->ctx, fill.part);
  return status;
}

static LitheStatus fill_rows(Builder *b) {
  LitheStatus status = LITHE_OK, *statuses = NULL;
  LTH_NEW(b->ctx, statuses, b->n_rows);
  for (int round = 0; round < PROGRESS_ROUNDS && status == LITHE_OK; round++) {
    LitheIndex from = (LitheIndex)((LitheCount)b->n_rows * round / PROGRESS_ROUNDS),
               to = (LitheIndex)((LitheCount)b->n_rows * (round + 1) / PROGRESS_ROUNDS);
    lth_progress(b->ctx, "volume fractions", (double)round / PROGRESS_ROUNDS);
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(b->ctx))
    for (LitheIndex r = from; r < to; r++)
      statuses[r] = lth_cancelled(b->ctx) ? LITHE_INTERRUPTED : fill_row(b, r);
    for (LitheIndex r = from; r < to && status == LITHE_OK; r++) status = statuses[r];
  }
  lth_free(b->ctx, statuses);
  if (status == LITHE_INTERRUPTED)
    LITHE_FAIL(b->ctx, status, "interrupted while fractions are found");
  return status;
}

/// --- all of it ---

/// Neighbours of blocks in use are wanted; `wanted` has one block more than the frame on every side.
static void want(Builder *b, uint8_t *wanted, const LitheIndex block[3], uint32_t reach) {
  const LthFractionFrame *f = &b->frame;
  int deep = f->dim == 3;
  for (int dz = -deep, bit = 0; dz <= deep; dz++)
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++, bit++) {
        if (!(reach >> bit & 1)) continue;
        LitheCount at =
            block[0] + dx + 1 +
            (LitheCount)(f->n_block[0] + 2) *
                (block[1] + dy + 1 + (LitheCount)(f->n_block[1] + 2) * (block[2] + dz + deep));
        wanted[at] = 1;
      }
}

/// First and last cells of a block that hold something; `cell` NULL: all.
static void note_extent(Builder *b, const LitheIndex block[3], const uint16_t *cell) {
  LitheIndex s = b->frame.side, deep = b->frame.dim == 3 ? s : 1;
  for (LitheIndex c = 0; c < b->frame.block_cells; c++) {
    LitheIndex at[3] = {block[0] * s + c % s, block[1] * s + c / s % s,
                        block[2] * deep + c / (s * s)};
    if (cell && cell[c] == LTH_CELL_EMPTY) continue;
    for (int a = 0; a < 3; a++) {
      b->low[a] = smaller(b->low[a], at[a]);
      b->high[a] = larger(b->high[a], at[a]);
    }
  }
}

static void want_blocks(Builder *b, uint8_t *wanted) {
  const LthFractionFrame *f = &b->frame;
  uint32_t all = f->dim == 3 ? (1u << 27) - 1 : (1u << 9) - 1;
  for (int a = 0; a < 3; a++) b->low[a] = INT32_MAX, b->high[a] = -1;
  for (LitheIndex r = 0; r < b->n_rows; r++) {
    const Row *row = &b->rows[r];
    for (LitheIndex i = 0, m = 0; i < f->n_block[0]; i++) {
      LitheIndex block[3] = {i, r % f->n_block[1], r / f->n_block[1]};
      uint8_t side = b->side[i + (LitheCount)f->n_block[0] * r];
      if (side == LTH_SIDE_MIXED) {
        want(b, wanted, block, row->reach[m]);
        if (row->reach[m]) note_extent(b, block, row->cell + (LitheCount)m * f->block_cells);
        m++;
      } else if (side == LTH_SIDE_INSIDE) {
        want(b, wanted, block, all);
        note_extent(b, block, NULL);
      }
    }
  }
}

/// The grid with its margins; *shift: blocks before the frame's first, along each axis.
static LitheStatus make_grid(Builder *b, const uint8_t *wanted, LitheIndex shift[3],
                             LthSparseGrid **grid) {
  const LthFractionFrame *f = &b->frame;
  uint8_t *used = NULL;
  double origin[3];
  LitheIndex n[3], blocks[3];
  for (int a = 0; a < 3; a++) {
    bool is_flat = a >= f->dim;
    shift[a] = !is_flat && b->low[a] < MARGIN;
    origin[a] = f->origin[a] - f->h[a] * f->side * shift[a];
    LitheIndex more = b->high[a] + MARGIN - (f->end_cell[a] - 1); // cells beyond the last
    n[a] = f->end_cell[a] + shift[a] * f->side + (is_flat || more < 0 ? 0 : more);
    blocks[a] = lth_sparse_grid_blocks(f->dim, a, n[a]);
  }
  LTH_NEW(b->ctx, used, (LitheCount)blocks[0] * blocks[1] * blocks[2]);
  for (LitheIndex k = 0; k < blocks[2]; k++)
    for (LitheIndex j = 0; j < blocks[1]; j++)
      for (LitheIndex i = 0; i < blocks[0]; i++) {
        LitheIndex from[3] = {i - shift[0] + 1, j - shift[1] + 1,
                              k - shift[2] + (f->dim == 3 ? 1 : 0)};
        used[i + (LitheCount)blocks[0] * (j + (LitheCount)blocks[1] * k)] =
            wanted[from[0] + (LitheCount)(f->n_block[0] + 2) *
                                 (from[1] + (LitheCount)(f->n_block[1] + 2) * from[2])];
      }
  LitheStatus status = lth_sparse_grid_create(b->ctx, f->dim, origin, f->h, n, used, grid);
  lth_free(b->ctx, used);
  return status;
}

/// Row and place in it (-1: not filled) of a block of the grid; its side.
static LthSide find_block(const Builder *b, const LthSparseGrid *g, LitheIndex block,
                          const LitheIndex shift[3], LitheIndex *row, LitheIndex *m) {
  const LthFractionFrame *f = &b->frame;
  LitheIndex at[3];
  *m = -1;
  for (int a = 0; a < 3; a++) {
    at[a] = g->place[3 * (LitheCount)block + a] - shift[a];
    if (at[a] < 0 || at[a] >= f->n_block[a]) return LTH_SIDE_OUTSIDE;
  }
  *row = at[1] + f->n_block[1] * at[2];
  LthSide side = b->side[at[0] + (LitheCount)f->n_block[0] * *row];
  if (side != LTH_SIDE_MIXED) return side;
  const Row *r = &b->rows[*row];
  for (LitheIndex low = 0, high = r->n; *m < 0;) {
    LitheIndex middle = (low + high) / 2;
    if (r->at[middle] == at[0]) *m = middle;
    if (r->at[middle] < at[0])
      low = middle + 1;
    else
      high = middle;
  }
  return side;
}

/// Cells and parts of a block; returns its volume in parts.
static double take_block(const Builder *b, LthFractions *f, LitheIndex block,
                         const LitheIndex shift[3]) {
  LitheIndex row = 0, m, n = f->grid->block_cells;
  uint16_t *cell = f->cell + (LitheCount)block * n;
  LthSide side = find_block(b, f->grid, block, shift, &row, &m);
  double sum = 0;
  if (m >= 0) {
    const Row *r = &b->rows[row];
    LitheCount count = (r->cut[m + 1] - r->cut[m]) * f->n_parts;
    double *part = f->part + f->first[block] * f->n_parts;
    memcpy(cell, r->cell + (LitheCount)m * n, (size_t)n * sizeof *cell);
    if (count > 0) memcpy(part, r->part + r->cut[m] * f->n_parts, (size_t)count * sizeof *part);
    for (LitheCount i = 0; i < count; i++) sum += part[i];
  }
  for (LitheIndex c = 0; c < n; c++) {
    if (side == LTH_SIDE_INSIDE) cell[c] = LTH_CELL_FULL;
    sum += cell[c] == LTH_CELL_FULL ? f->n_parts : 0;
  }
  return sum;
}

static LitheStatus take_blocks(const Builder *b, LthFractions *f, const LitheIndex shift[3]) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = f->grid;
  double *sums = NULL;
  LTH_NEW_OR(done, b->ctx, f->cell, g->n_slots);
  LTH_NEW_OR(done, b->ctx, f->first, (LitheCount)g->n_blocks + 1);
  LTH_NEW_OR(done, b->ctx, sums, g->n_blocks);
  for (LitheIndex block = 0, row = 0, m; block < g->n_blocks; block++) {
    find_block(b, g, block, shift, &row, &m);
    f->first[block + 1] =
        f->first[block] + (m < 0 ? 0 : b->rows[row].cut[m + 1] - b->rows[row].cut[m]);
  }
  LTH_NEW_OR(done, b->ctx, f->part, f->first[g->n_blocks] * f->n_parts);
#pragma omp parallel for schedule(static) num_threads(lth_threads(b->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++)
    sums[block] = take_block(b, f, block, shift);
  for (LitheIndex block = 0; block < g->n_blocks; block++) f->volume += sums[block];
  f->volume *= lth_sparse_grid_cell_volume(g) / f->n_parts;
done:
  lth_free(b->ctx, sums);
  return status;
}

static LitheStatus fail_empty(const Builder *b) {
  const LthFractionFrame *f = &b->frame;
  double end[3];
  for (int a = 0; a < 3; a++) end[a] = f->origin[a] + f->h[a] * f->end_cell[a];
  LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
             "nothing of the shape was found in the grid from (%g, %g, %g) to (%g, %g, %g) m: it "
             "lies beside it, is thinner than cells can show, or is an expression that is nowhere "
             "negative",
             f->origin[0], f->origin[1], f->origin[2], end[0], end[1], end[2]);
}

static LitheStatus finish(Builder *b, LthFractions *f) {
  const LthFractionFrame *frame = &b->frame;
  LitheStatus status = LITHE_OK;
  uint8_t *wanted = NULL;
  LitheIndex shift[3];
  LTH_NEW_OR(done, b->ctx, wanted,
             (LitheCount)(frame->n_block[0] + 2) * (frame->n_block[1] + 2) *
                 (frame->dim == 3 ? frame->n_block[2] + 2 : 1));
  want_blocks(b, wanted);
  if (b->high[0] < 0) LITHE_TRY_OR(done, fail_empty(b));
  LITHE_TRY_OR(done, make_grid(b, wanted, shift, &f->grid));
  LITHE_TRY_OR(done, take_blocks(b, f, shift));
done:
  lth_free(b->ctx, wanted);
  return status;
}

static void release(Builder *b) {
  for (LitheIndex r = 0; b->rows && r < b->n_rows; r++) {
    Row *row = &b->rows[r];
    void *blocks[] = {row->at, row->cell, row->reach, row->cut, row->part};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(b->ctx, blocks[i]);
  }
  lth_free(b->ctx, b->rows);
  lth_free(b->ctx, b->side);
}

LitheStatus lth_fractions_build(LitheCtx *ctx, const LthFractionFiller *filler, int dim,
                                const double origin[3], const double h[3], const LitheIndex n[3],
                                LthFractions **fractions) {
  LitheStatus status = LITHE_OK;
  Builder b = {.ctx = ctx, .filler = filler};
  *fractions = NULL;
  LITHE_TRY_OR(done, make_frame(ctx, dim, origin, h, n, &b.frame));
  b.n_rows = b.frame.n_block[1] * b.frame.n_block[2];
  LTH_NEW_OR(done, ctx, *fractions, 1);
  (*fractions)->n_parts = b.frame.n_parts;
  LTH_NEW_OR(done, ctx, b.side, (LitheCount)b.frame.n_block[0] * b.n_rows);
  LTH_NEW_OR(done, ctx, b.rows, b.n_rows);
  find_sides(&b);
  LITHE_TRY_OR(done, fill_rows(&b));
  LITHE_TRY_OR(done, finish(&b, *fractions));
done:
  release(&b);
  if (status != LITHE_OK) lth_fractions_destroy(ctx, fractions);
  return status;
}

void lth_fractions_destroy(LitheCtx *ctx, LthFractions **fractions) {
  if (!fractions || !*fractions) return;
  lth_sparse_grid_destroy(ctx, &(*fractions)->grid);
  lth_free(ctx, (*fractions)->cell);
  lth_free(ctx, (*fractions)->first);
  lth_free(ctx, (*fractions)->part);
  lth_free(ctx, *fractions);
  *fractions = NULL;
}
