/// What the triangles of a surface give to the parts of a row of blocks. Along a line in the direction of x a solid is the
/// sum of all that begins where the line enters it, less all that begins where it leaves. So every triangle takes from and
/// gives to the parts that it meets and all behind them, on its own (docs/theory/fractions.md).
#pragma once

#include "geometry/fractions_fill.h"

enum {
  LTH_LEDGER_TOUCHED = 1, ///< a triangle meets the part
  LTH_LEDGER_MARKED = 2,  ///< one of those that were to be marked does
  LTH_LEDGER_TWICE = 4    ///< two of them do
};

typedef struct LthLedger {
  const LthFractionFrame *frame;
  const LthFractionRow *row;
  int samples;    ///< along a cell, 0: volumes
  double *part;   ///< to a part alone, borrowed         (n blocks x block_cells x n_parts)
  double *behind; ///< to a part and all behind it       (same; x fastest by parts, then y, z)
  double *carry;  ///< to all parts from a block on      (n x width^2)
  uint8_t *touch; ///< bits as above, as `behind`; NULL where nobody asks
  bool is_marked; ///< the triangle that is taken
  int width;      ///< parts along a block
  LitheIndex
      *of; ///< place in the row's list of the first block at or behind a block  (n_block[0] + 1)
  double low[3]; ///< corner of the row
} LthLedger;

/// An empty ledger; `part` is as row->part, zero.
LitheStatus lth_ledger_open(LitheCtx *ctx, const LthFractionFrame *frame, const LthFractionRow *row,
                            int samples, bool touches, double *part, LthLedger *ledger);
void lth_ledger_close(LitheCtx *ctx, LthLedger *ledger);

/// All triangles of a surface (and of the tree over it) whose boxes meet the row, whatever their x; `marked`
/// (n_tris) may be NULL.
void lth_ledger_take(LthLedger *ledger, const LthBvh *tree, const bool *marked);

/// Place of part (i, j, k) of block m of the row in `behind` and `touch`.
static inline LitheCount lth_ledger_place(const LthLedger *l, LitheIndex m, int i, int j, int k) {
  LitheCount w = l->width;
  return (((LitheCount)m * w + k) * w + j) * w + i;
}
