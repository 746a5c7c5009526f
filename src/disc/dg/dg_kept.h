/// Stiffness of a linear body whose elements change, in place by record of its topology: steps copy it instead of assembling it,
/// and a change writes rows of the elements alone whose integrals it made anew (docs/develop/topology.md, section 5).
#pragma once

#include "disc/dg/dg_store.h"
#include "la/block_matrix.h"

typedef struct LthDgKept LthDgKept;

LitheStatus lth_dg_kept_create(LitheCtx *ctx, LthDgKept **kept);
void lth_dg_kept_destroy(LitheCtx *ctx, LthDgKept **kept);

/// Become the stiffness of an operator that was made with these records; the log of the topology tells which are dead. Entries that
/// are made of what they were made of keep their bits and their places. `n_written` (may be NULL): blocks that are not.
LitheStatus lth_dg_kept_follow(LitheCtx *ctx, LthDgKept *kept, const LthTopology *topology,
                               const LthDgRecords *records, const LthDgOperator *op,
                               LitheCount *n_written);

/// Where the blocks of K, whose rows are the elements with these records, stand: `at` (K's blocks) for lth_dg_kept_copy().
void lth_dg_kept_find(const LthDgKept *kept, const LitheIndex *record, const LthBlockMatrix *K,
                      LitheCount *at);
/// K = the stiffness, to the bit what lth_dg_assemble() of the operator writes. Blocks lie at K->value_off.
void lth_dg_kept_copy(LitheCtx *ctx, const LthDgKept *kept, const LitheCount *at,
                      LthBlockMatrix *K);
