/// A matrix by record: rows with room at their end, values that stay where they are.
#pragma once

#include "disc/dg/dg_live.h"
#include "disc/dg/dg_store_priv.h"

/// A block of a row.
typedef struct LthDgLiveBlock {
  LitheIndex col; ///< record
  LitheIndex size;
  LitheCount at; ///< into values
  uint64_t made_of;
  uint32_t seen;
  bool is_stale; ///< has to be written
} LthDgLiveBlock;

/// A row of the matrix.
typedef struct LthDgLiveRow {
  LitheCount first; ///< into blocks
  LitheIndex n, room;
  LitheIndex func, nb; ///< nb 0: a free record
} LthDgLiveRow;

typedef struct LthDgLiveRows {
  LthDgLiveRow *rows; ///< by record
  LitheIndex n_rows;
  LitheCount rows_cap;
  LthDgLiveBlock *blocks;
  double *values, *load;
  LitheCount blocks_cap, values_cap, load_cap;
  LthRooms block_rooms, value_rooms, func_rooms;
  uint64_t revision; ///< of the pattern
} LthDgLiveRows;

void lth_dg_live_rows_free(LitheCtx *ctx, LthDgLiveRows *m);

/// The row of a record with nb functions: the one it has, or a new one with a diagonal block.
LitheStatus lth_dg_live_rows_open(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex record,
                                  LitheIndex nb);
/// Free the row of a record, if it has one. Blocks of its column in other rows are not looked for.
LitheStatus lth_dg_live_rows_close(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex record);

/// A block of a row, NULL: there is none.
LthDgLiveBlock *lth_dg_live_rows_find(const LthDgLiveRows *m, LitheIndex row, LitheIndex col);
/// Add a block of two open rows that is not there.
LitheStatus lth_dg_live_rows_add(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, LitheIndex col);
/// A block of two open rows, of the size that their functions ask for now: the one that is there, or a stale one.
LitheStatus lth_dg_live_rows_fit(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, LitheIndex col);
/// See to it that a pair of cells with open rows has its two blocks, which are `seen` then, and stale where what they are made of
/// has changed. `face`: the first that the two share.
LitheStatus lth_dg_live_rows_place(LitheCtx *ctx, LthDgLiveRows *m, const LthDgRecords *records,
                                   const LthDgOperator *op, LitheIndex face, uint32_t seen);
/// First own face of a cell with another neighbour than the given one.
LitheIndex lth_dg_next_pair(const LthDgOperator *op, LitheIndex face);
/// Take blocks that were not seen out of a row; the diagonal stays.
LitheStatus lth_dg_live_rows_drop(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, uint32_t seen);
/// Memory for all blocks that were added.
LitheStatus lth_dg_live_rows_grow(LitheCtx *ctx, LthDgLiveRows *m);

/// The rows as a block matrix with these values.
LitheStatus lth_dg_live_rows_matrix(LitheCtx *ctx, const LthDgLiveRows *m, LthBlockMatrix **matrix);
