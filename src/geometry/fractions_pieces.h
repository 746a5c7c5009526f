/// Connected pieces of a solid on a grid: islands that something holds, or nothing.
#pragma once

#include "geometry/fractions.h"

/// Cells with more than a threshold of their volume inside, joined over the faces they share. Immutable once built.
typedef struct LthPieces {
  LitheIndex n;      ///< pieces, in the order of their first slots
  LitheIndex *piece; ///< of each slot, -1: no more than the threshold                   (n_slots)
  LitheCount *cells; ///< cells of a piece                                               (n)
  double *volume;    ///< of a piece, as its parts have it [m^3]                         (n)
  double *box;       ///< around its cells: min, max [m]                                 (n x 6)
} LthPieces;

/// `threshold` in [0, 1). Faces count whose own box, half of each cell, holds something.
LitheStatus lth_pieces_create(LitheCtx *ctx, const LthFractions *fractions, double threshold,
                              LthPieces **pieces);
void lth_pieces_destroy(LitheCtx *ctx, LthPieces **pieces);

/// Empty all cells but those of pieces that are kept (n), and those with less than the threshold next to them, over a face,
/// edge or corner; `volume` becomes that of what is left, `pieces` stay as they were.
LitheStatus lth_pieces_keep(LitheCtx *ctx, const LthPieces *pieces, const bool *keep,
                            LthFractions *fractions);
