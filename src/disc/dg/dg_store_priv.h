/// What spaces and operators see of a store: before they integrate they are lent rooms, which tell what is in them already;
/// after that what they wrote is kept.
#pragma once

#include "base/rooms.h"
#include "disc/dg/dg_priv.h"
#include "disc/dg/dg_store.h"

/// Doubles of a chunk of memory: more than any one table has.
#define LTH_DG_STORE_CHUNK ((LitheCount)1 << 16)

/// A room of doubles; size 0: none.
typedef struct LthDgRoom {
  LitheCount at, size;
} LthDgRoom;

/// A group of held pieces of an element.
typedef struct LthDgStoreGroup {
  LitheIndex constraint;
  uint64_t stamp;   ///< of the element
  LthDgRoom room;   ///< nb x nb, then rest (nb x 3)
  LthDgGroup group; ///< but for its places in an operator's tables
  bool is_seen;
} LthDgStoreGroup;

/// An element. Versions are numbers that were never given before.
typedef struct LthDgStoreCell {
  LthDgRoom basis;  ///< nb x nb, then mean gradients (nb x 3)
  uint64_t version; ///< of the basis, 0: none
  double center[3], axes[9], trace_constant;
  LthDgRoom slope;
  uint64_t slope_of; ///< version of the basis that it is of
  double lambda, mu;
  bool is_rigid;
  uint64_t stamp;    ///< of basis, material and holding: what faces see of the element
  uint64_t stamp_of; ///< version of the basis in it
  LthDgRoom matrix;  ///< 9 nb nb, then the load (nb x 3)
  uint64_t made_of;  ///< digest of what went into the matrix
  LthDgStoreGroup *groups;
  LitheCount groups_cap;
  LitheIndex n_groups;
  uint8_t degree;
} LthDgStoreCell;

/// An inner face between the elements with two stamps.
typedef struct LthDgStoreFace {
  LthDgRoom room;
  uint64_t stamp[2], version; ///< version 0: none
  LthDgFace face;             ///< its numbers in a mesh are not read
} LthDgStoreFace;

struct LthDgStore {
  LthDgStoreCell *cells; ///< by record
  LthDgStoreFace *faces;
  LitheCount cells_cap, faces_cap;
  LitheIndex n_cells, n_faces;
  LthRooms rooms;
  double **chunk;
  LitheCount n_chunks, chunk_cap;
  LthDgRoom *retired; ///< replaced, but for others to read until settled
  LitheCount n_retired, retired_cap;
  uint64_t last_version;
  LthDgStoreCount count;
};

/// Empty, as at first; everything is freed.
void lth_dg_store_clear(LitheCtx *ctx, LthDgStore *store);
/// Memory for rooms up to `end`.
LitheStatus lth_dg_store_grow(LitheCtx *ctx, LthDgStore *store, LitheCount end);

/// Lend places for the bases of all cells; those that are known are in the space at once.
LitheStatus lth_dg_store_lend_bases(LitheCtx *ctx, const LthDgRecords *records, LthDgSpace *space,
                                    uint8_t *is_known);
void lth_dg_store_keep_bases(const LthDgRecords *records, const LthDgSpace *space,
                             const uint8_t *is_known);

/// The same for op->slope; materials and holding of the cells are taken note of.
LitheStatus lth_dg_store_lend_slopes(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op,
                                     uint8_t *is_known);

/// The same for the tables of op->faces; known ones get normals, weights and penalties as they were.
LitheStatus lth_dg_store_lend_faces(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op,
                                    uint8_t *is_known);
void lth_dg_store_keep_faces(const LthDgRecords *records, const LthDgOperator *op,
                             const uint8_t *is_known);

/// The same for op->groups, once they are measured: a known one has the same plane and, to rounding, the same area (corners on
/// the edges of its pieces may have come and gone).
void lth_dg_store_lend_groups(const LthDgRecords *records, LthDgOperator *op, uint8_t *is_known);
LitheStatus lth_dg_store_keep_groups(LitheCtx *ctx, const LthDgRecords *records,
                                     const LthDgOperator *op, const uint8_t *is_known);

/// The same for op->cell_data and op->cell_load, once faces and holds are there. Cells of the rim count as known.
LitheStatus lth_dg_store_lend_cells(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op,
                                    uint8_t *is_known);
void lth_dg_store_keep_cells(const LthDgRecords *records, const LthDgOperator *op,
                             const uint8_t *is_known);

/// Digest of the own faces from f on to one neighbour: what the block of the pair is made of.
uint64_t lth_dg_store_pair_digest(const LthDgRecords *records, const LthDgOperator *op,
                                  LitheIndex f);
