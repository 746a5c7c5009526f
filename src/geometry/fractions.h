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

/// Half width of the smooth profile [cells].
double lth_fraction_half_width(const LthFractionDef *def);

enum { LTH_CELL_EMPTY, LTH_CELL_FULL, LTH_CELL_CUT }; ///< LTH_CELL_CUT and above: cut

/// Part q of a cell is the quarter (eighth) towards the corner with bit a of q set where it is the high one
/// along axis a. Fractions of all control volumes - cells, and boxes around faces and edges - are means of
/// parts, so they are those of one solid. Only cut cells keep parts.
typedef struct LthFractions {
  LthSparseGrid *
      grid; ///< owned. Every cell that holds something is in a block, and so are all within two cells of it
  int n_parts;    ///< 4 or 8
  uint16_t *cell; ///< EMPTY, FULL, or CUT + place among the cut cells of its block      (n_slots)
  LitheCount *
      first; ///< where parts of a block's cut cells begin; behind the last: of how many cells there are (n_blocks + 1)
  double *part;  ///< in [0, 1], n_parts for each cut cell            (first[n_blocks] x n_parts)
  double volume; ///< of the shape, as the parts have it [m^3]
} LthFractions;

/// Fractions of a prepared shape (lth_shape_prepare()) on a grid of n cells from origin on; what lies beyond it is cut
/// off. The grid of the result has margins of two cells at least around all that is inside: its origin may
/// lie before `origin` by whole blocks. In 2D the shape is met at z = 0.
/// LITHE_BAD_INPUT: the shape lies beside the grid.
LitheStatus lth_fractions_create(LitheCtx *ctx, const LthShape *shape, int dim,
                                 const double origin[3], const double h[3], const LitheIndex n[3],
                                 const LthFractionDef *def, LthFractions **fractions);
void lth_fractions_destroy(LitheCtx *ctx, LthFractions **fractions);

/// Fraction of the part with low corner `low` and size `size` (2D: size[2] = 0); thread-safe.
typedef double (*LthPartFunction)(const void *self, const double low[3], const double size[3]);

/// Fractions as a function gives them, asked for every part of the grid.
LitheStatus lth_fractions_from(LitheCtx *ctx, int dim, const double origin[3], const double h[3],
                               const LitheIndex n[3], LthPartFunction part, const void *self,
                               LthFractions **fractions);

/// Fraction of part q of a slot's cell.
static inline double lth_fractions_part(const LthFractions *f, LitheCount slot, int q) {
  uint16_t cell = f->cell[slot];
  if (cell < LTH_CELL_CUT) return cell;
  return f->part[(f->first[slot / f->grid->block_cells] + cell - LTH_CELL_CUT) * f->n_parts + q];
}

/// Fraction of a slot's cell: the mean of its parts.
static inline double lth_fractions_cell(const LthFractions *f, LitheCount slot) {
  uint16_t cell = f->cell[slot];
  if (cell < LTH_CELL_CUT) return cell;
  double sum = 0;
  for (int q = 0; q < f->n_parts; q++) sum += lth_fractions_part(f, slot, q);
  return sum / f->n_parts;
}

/// Bytes that lth_fractions_create() will need at most for a shape with so much surface and so much inside
/// [m^2 and m^3; 2D: m and m^2].
LitheCount lth_fractions_forecast(int dim, const double h[3], const LitheIndex n[3], double area,
                                  double volume);
