/// Volume fractions of control volumes: means of the parts they are made of (docs/theory/fractions.md).
#include "geometry/fractions.h"

/// One part of a control volume: in the cell at an offset of -1 or 0 along each axis.
typedef struct Piece {
  int step[3], part;
} Piece;

/// Parts of the h-box around what lies at the low end of a cell along the axes in `ends`, in its middle along
/// the others.
static int find_pieces(int dim, const bool ends[3], Piece *piece) {
  int n = 1 << dim;
  for (int q = 0; q < n; q++) {
    piece[q] = (Piece){.part = 0};
    for (int a = 0; a < dim; a++) {
      bool is_high = q >> a & 1;
      // before the end lies the high part of the previous cell
      if (ends[a] && !is_high) piece[q].step[a] = -1;
      if (ends[a] ? !is_high : is_high) piece[q].part |= 1 << a;
    }
  }
  return n;
}

/// Number of the neighbour block at an offset, as LthSparseGrid has it.
static int neighbor_at(const LthSparseGrid *g, const int d[3]) {
  return g->dim == 3 ? (d[2] + 1) * 9 + (d[1] + 1) * 3 + d[0] + 1 : (d[1] + 1) * 3 + d[0] + 1;
}

/// Slot of the cell at `step` from place `at` of a block, -1 where there is none.
static LitheCount step_slot(const LthSparseGrid *g, LitheIndex block, const int at[3],
                            const int step[3]) {
  int d[3] = {0, 0, 0}, to[3], side[3] = {g->side, g->side, g->dim == 3 ? g->side : 1};
  for (int a = 0; a < 3; a++) {
    to[a] = at[a] + step[a];
    if (to[a] < 0) to[a] += side[a], d[a] = -1;
  }
  LitheIndex b = g->neighbor[(LitheCount)block * g->n_neighbors + neighbor_at(g, d)];
  if (b < 0) return -1;
  return (LitheCount)b * g->block_cells + to[0] + side[0] * (to[1] + side[1] * to[2]);
}

static void find_means(LitheCtx *ctx, const LthFractions *f, const bool ends[3], double *V) {
  const LthSparseGrid *g = f->grid;
  Piece piece[8];
  int n = find_pieces(g->dim, ends, piece), s = g->side;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < g->n_blocks; b++)
    for (LitheIndex c = 0; c < g->block_cells; c++) {
      int at[3] = {c % s, c / s % s, c / (s * s)};
      double sum = 0;
      for (int q = 0; q < n; q++) {
        LitheCount slot = step_slot(g, b, at, piece[q].step);
        if (slot >= 0) sum += lth_fractions_part(f, slot, piece[q].part);
      }
      V[(LitheCount)b * g->block_cells + c] = sum / n;
    }
}

void lth_fractions_cells(LitheCtx *ctx, const LthFractions *f, double *V) {
  find_means(ctx, f, (bool[3]){false, false, false}, V);
}

void lth_fractions_faces(LitheCtx *ctx, const LthFractions *f, int axis, double *V) {
  find_means(ctx, f, (bool[3]){axis == 0, axis == 1, axis == 2}, V);
}

void lth_fractions_edges(LitheCtx *ctx, const LthFractions *f, int axis, double *V) {
  find_means(ctx, f, (bool[3]){axis != 0, axis != 1, axis != 2}, V);
}
