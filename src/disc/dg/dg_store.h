/// Integrals of a body whose elements change, by record of its topology: what a change did not touch stays where it
/// is, and the spaces and operators of before and after the change share it (docs/develop/topology.md, section 5).
#pragma once

#include "disc/dg/dg_operator.h"
#include "mesh/topology.h"

/// Bases, derivatives and matrices of elements, tables and penalties of faces. A basis is that of its record and degree for
/// as long as the record lives; a face's tables those of the bases at it; an element's matrix that of its faces, holds and
/// material: each is made anew where what it was made of has changed, and only there.
typedef struct LthDgStore LthDgStore;

/// The records of a mesh that lth_topology_mesh() made; borrowed for the call.
struct LthDgRecords {
  LthDgStore *store;
  const LitheIndex *cell, *face; ///< records of cells and faces (inner ones alone are read)
  const bool
      *is_rim; ///< cells of which not all faces are in the mesh: they get no matrix; NULL: none
};

LitheStatus lth_dg_store_create(LitheCtx *ctx, LthDgStore **store);
void lth_dg_store_destroy(LitheCtx *ctx, LthDgStore **store);

/// Forget the integrals of dead records in the topology's log, once a change has been followed and before
/// lth_topology_forget(). Spaces and operators of before the change can still be used.
LitheStatus lth_dg_store_forget(LitheCtx *ctx, LthDgStore *store, const LthTopology *topology);

/// Let the memory of what was forgotten or replaced be used again: spaces and operators of before must not be from here on.
LitheStatus lth_dg_store_settle(LitheCtx *ctx, LthDgStore *store);

/// All of it as bytes, so that another process goes on with the same bits; settled before.
void lth_dg_store_archive(LthDgStore *store, LthArchive *archive);

/// What was integrated since the store was made.
typedef struct LthDgStoreCount {
  LitheCount bases, faces, matrices;
  double seconds; ///< of the processor, for these
} LthDgStoreCount;

LthDgStoreCount lth_dg_store_count(const LthDgStore *store);
LitheCount lth_dg_store_bytes(const LthDgStore *store); ///< of integrals that are kept
