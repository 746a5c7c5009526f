/// Cells around the points of a mesh, in parts that hang together there: the two sides of a cut share points, not more.
#pragma once

#include "mesh/mesh.h"

/// Two cells around a point are of one part if inner faces that have the point lead from one to the other through
/// cells around it. A point inside of a body has one part, one on a cut has a part on each side, and one at
/// the end of a cut has one again.
typedef struct LthAround {
  LitheCount *off;  ///< entries of a point                              (n_points + 1)
  LitheIndex *cell; ///< by part, then ascending; parts by their lowest cell
  LitheIndex *part; ///< 0, 1, ... of each entry
} LthAround;

LitheStatus lth_around_create(LitheCtx *ctx, const LthMesh *mesh, LthAround *around);
void lth_around_free(LitheCtx *ctx, LthAround *around);

/// End of the part of a point that begins at entry `first`.
static inline LitheCount lth_around_end(const LthAround *around, LitheIndex point,
                                        LitheCount first) {
  LitheCount end = first;
  while (end < around->off[point + 1] && around->part[end] == around->part[first]) end++;
  return end;
}

/// Part of a point that a cell around it belongs to; -1: the cell does not have the point.
static inline LitheIndex lth_around_part(const LthAround *around, LitheIndex point,
                                         LitheIndex cell) {
  for (LitheCount i = around->off[point]; i < around->off[point + 1]; i++)
    if (around->cell[i] == cell) return around->part[i];
  return -1;
}
