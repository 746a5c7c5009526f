/// Stiffness of a linear body whose elements change, in place by record of its topology: after a change only births, changed
/// elements and the neighbours of births are integrated and assembled (docs/develop/topology.md, section 5).
#pragma once

#include "disc/dg/dg_store.h"
#include "la/block_matrix.h"

/// What the body is. Arrays are by the cells of the mesh that the topology began with, parts of which all elements are.
typedef struct LthDgLiveDef {
  LthTopology *topology;         ///< borrowed for life; scratch of it is written
  int degree;                    ///< of all elements
  const uint8_t *cell_degree;    ///< or by cell; borrowed for life; NULL
  const double *young, *poisson; ///< borrowed for life
  LthFlux flux;
  LthPenaltyKind penalty;
  double eta;
  /// Weak constraints on some elements of the body as a mesh, of whose boundary faces those count that have no cell beyond
  /// in the topology either; valid until the next call. NULL: there are none.
  LitheStatus (*constrain)(LitheCtx *ctx, void *self, const LthMesh *mesh,
                           const LitheIndex *face_record, const LthWeakConstraint **weak,
                           LitheIndex *n_weak);
  void *constrain_self;
} LthDgLiveDef;

typedef struct LthDgLive LthDgLive;

/// Integrate and assemble all elements; constraint values of time t.
LitheStatus lth_dg_live_create(LitheCtx *ctx, const LthDgLiveDef *def, double t, LthDgLive **live);
void lth_dg_live_destroy(LitheCtx *ctx, LthDgLive **live);

/// What following a change took.
typedef struct LthDgLiveReport {
  LitheIndex n_births, n_touched,
      n_rim; ///< elements: born, with a new row or block, and around these
  LitheCount n_bases, n_faces, n_matrices;
  LitheCount n_blocks;                 ///< written
  double patch, integration, assembly; ///< [s]
} LthDgLiveReport;

/// Follow what the topology's log says; lth_topology_forget() comes next. Untouched entries keep their bits and their
/// places, and their loads are those of the time when they were written. Where it fails nothing but destroying is allowed.
/// `report` may be NULL.
LitheStatus lth_dg_live_follow(LitheCtx *ctx, LthDgLive *live, double t, LthDgLiveReport *report);

/// Unknowns of an element: 3 (func + i) + a, with a number of its own for its life. Numbers between are free.
LitheIndex lth_dg_live_func(const LthDgLive *live, LitheIndex record);
LitheIndex lth_dg_live_n_funcs(const LthDgLive *live); ///< beyond the highest number

/// The block of two elements, row-major; NULL where they share no face. Valid until the next change.
const double *lth_dg_live_block(const LthDgLive *live, LitheIndex row, LitheIndex col);
/// f0, by unknowns of the body.
const double *lth_dg_live_load(const LthDgLive *live);

/// The same matrix for solvers: a row for each element in order of records, whose values stay where they are. Valid, and
/// owned by `live`, until the next change; its pattern_revision changes when the pattern does.
LitheStatus lth_dg_live_matrix(LitheCtx *ctx, LthDgLive *live, const LthBlockMatrix **matrix);
const LthDgStore *lth_dg_live_store(const LthDgLive *live);
