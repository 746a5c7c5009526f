/// How much of every part of every cell of a grid is inside a shape (docs/theory/fractions.md).
/// Dolny 2025, section 4.1; one consistent set for all control volumes: docs/theory/fractions.md.
#pragma once

#include "geometry/shape.h"
#include "geometry/sparse_grid.h"

typedef enum LthFractionMethod {
  LTH_FRACTIONS_EXACT, ///< to rounding for polygons and closed triangle surfaces, else to a tolerance
  LTH_FRACTIONS_SAMPLES, ///< inside test on one lattice for all control volumes
  LTH_FRACTIONS_SMOOTH   ///< profile of the signed distance
} LthFractionMethod;

typedef struct LthFractionDef {
  LthFractionMethod method;
  int samples;       ///< along a cell, even
  double half_width; ///< of the smooth profile, in cells; 0: 1.2
} LthFractionDef;

/// Part q of a cell is the quarter (eighth) towards the corner with bit a of q set where it is the high one
/// along axis a. Fractions of all control volumes - cells, and boxes around faces and edges - are means of
/// parts (lth_fractions_cells() and so on), so they are those of one solid.
typedef struct LthFractions {
  LthSparseGrid *
      grid; ///< owned. Every cell that holds something is in a block, and so are all its neighbours
  int n_parts;         ///< 4 or 8
  LitheCount *first;   ///< first value of a block in `part`, -1: all of it is full     (n_blocks)
  double *part;        ///< in [0, 1], n_parts for each slot of blocks that are not full
  LitheCount n_values; ///< of `part`
  double volume;       ///< of the shape, as the parts have it [m^3]
} LthFractions;

/// Fractions of a prepared shape (lth_shape_prepare()) on a grid of n cells from origin on. The grid of the result
/// has margins of one cell at least around what the shape touches: its origin may lie before `origin` by whole cells.
/// LITHE_BAD_INPUT: the shape lies beside the grid.
LitheStatus lth_fractions_create(LitheCtx *ctx, const LthShape *shape, int dim,
                                 const double origin[3], const double h[3], const LitheIndex n[3],
                                 const LthFractionDef *def, LthFractions **fractions);
void lth_fractions_destroy(LitheCtx *ctx, LthFractions **fractions);

/// Fraction of part q of a slot's cell.
static inline double lth_fractions_part(const LthFractions *f, LitheCount slot, int q) {
  LitheCount first = f->first[slot / f->grid->block_cells];
  return first < 0 ? 1 : f->part[first + (slot % f->grid->block_cells) * f->n_parts + q];
}

/// Means over control volumes, for all slots: cells; h-boxes around low faces across an axis; and around low edges
/// along an axis (2D: axis 2, the low corner).                                             (n_slots)
void lth_fractions_cells(LitheCtx *ctx, const LthFractions *f, double *V);
void lth_fractions_faces(LitheCtx *ctx, const LthFractions *f, int axis, double *V);
void lth_fractions_edges(LitheCtx *ctx, const LthFractions *f, int axis, double *V);

/// Bytes that lth_fractions_create() will need at most for a shape with so much surface [m^2; 2D: m].
LitheCount lth_fractions_forecast(int dim, const double h[3], const LitheIndex n[3], double area);
