/// Rigid clusters: a coarse space for levels that no coarser grid resolves (thin shells, combs, stiff inclusions).
/// Rigid motions of pieces of a box of four cells a side, split where stiffness jumps; above them the algebraic levels of
/// la/multilevel.h. Vanek, Mandel and Brezina 1996; docs/theory/staggered-multigrid.md, "Clusters".
#pragma once

#include "disc/staggered/staggered_fast.h"
#include "la/engine.h"
#include "la/multilevel.h"

#define LTH_CLUSTER_MODES 6 ///< translations, then rotations
#define LTH_CLUSTER_NONE UINT16_MAX

/// A motion q of cluster k moves its unknowns by b . (T q), b the row lth_cluster_row() and T the six by rank matrix that makes
/// the motions of a cluster orthonormal.
typedef struct LthStaggeredClusters {
  const LthFastLevel *level;
  LitheIndex n;      ///< clusters
  LitheIndex *first; ///< clusters of blocks before a block                      (n_blocks + 1)
  uint16_t *
      local; ///< cluster in its block, laid out as vectors; NONE: not free (level->n_rows x dim x side)
  double *centre;    ///< [m] from the grid's origin                             (n x 3)
  double *T;         ///< row-major                                               (n x 6 x 6)
  double *near;      ///< rigid motions of the body in orthonormal ones             (A->n x 6)
  LthBlockMatrix *A; ///< Galerkin matrix: a cluster a row
  const LthEngine *engine;
  LthFactor *factor; ///< of a small matrix, else NULL
  LthMultilevel *levels;
  double *motion;            ///< of clusters, before T                                   (n x 6)
  double *b, *x, *r, *z, *p; ///< (A->n)
  double
      *scratch; ///< blocks of the rows of one block of the grid             (threads x most x 36)
  LitheCount most;
  int threads;
} LthStaggeredClusters;

/// Clusters of the free unknowns of a level and the pattern of their matrix.
/// A matrix of at most `factored` unknowns has a Cholesky factor, a larger one algebraic levels.
LitheStatus lth_staggered_clusters_create(LitheCtx *ctx, const LthFastLevel *level,
                                          LitheCount factored, LthStaggeredClusters **clusters);
void lth_staggered_clusters_destroy(LitheCtx *ctx, LthStaggeredClusters **clusters);
/// Levels for (cm M + ck K) / unit, made anew by each call.
LitheStatus lth_staggered_clusters_set(LitheCtx *ctx, LthStaggeredClusters *clusters, double cm,
                                       double ck, double unit);
/// x += P (P^T A P)^-1 P^T y, the inverse by cycles of the algebraic levels; y is the level's residual.
LitheStatus lth_staggered_clusters_correct(LitheCtx *ctx, LthStaggeredClusters *clusters);
LitheCount lth_staggered_clusters_bytes(const LthStaggeredClusters *clusters);

// staggered_clusters_split.c

/// Clusters of the free unknowns: `first`, `local`, `n`.
LitheStatus lth_staggered_clusters_split(LitheCtx *ctx, LthStaggeredClusters *clusters);

// staggered_clusters_matrix.c

/// Pattern of the matrix over clusters, whose ranks are given (n).
LitheStatus lth_staggered_clusters_pattern(LitheCtx *ctx, LthStaggeredClusters *clusters,
                                           const int *rank);
/// Its values.
void lth_staggered_clusters_fill(LthStaggeredClusters *clusters, int threads, double cm, double ck,
                                 double unit);

/// Cluster of the unknown at component (at / block_cells) of cell (at mod block_cells) of a block, -1: none.
static inline LitheIndex lth_cluster_at(const LthStaggeredClusters *C, LitheIndex block,
                                        LitheCount at) {
  const LitheIndex n = C->level->grid->block_cells;
  const LitheCount slot = (LitheCount)block * n + at % n;
  uint16_t k = C->local[lth_fast_place(C->level, slot, (int)(at / n))];
  return k == LTH_CLUSTER_NONE ? -1 : C->first[block] + k;
}

/// Where the unknown of component a at a slot is, from the grid's origin.
static inline void lth_cluster_place(const LthSparseGrid *g, int a, LitheCount slot, double x[3]) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(g, slot, cell);
  for (int b = 0; b < 3; b++) x[b] = g->h[b] * (cell[b] + (b == a || b >= g->dim ? 0 : 0.5));
}

/// What component a at x moves by under unit motions about a centre: entries `index` alone differ from zero.
static inline void lth_cluster_row(double unit, int a, const double x[3], const double centre[3],
                                   int index[3], double value[3]) {
  int p = (a + 1) % 3, q = (a + 2) % 3;
  index[0] = a;
  index[1] = 3 + p;
  index[2] = 3 + q;
  value[0] = 1;
  value[1] = (x[q] - centre[q]) / unit;
  value[2] = -(x[p] - centre[p]) / unit;
}
