/// The open solver, shared by staggered_multigrid.c, staggered_cycle.c and staggered_cg.c.
#pragma once

#include "disc/staggered/staggered_clusters.h"
#include "disc/staggered/staggered_coarsest.h"
#include "disc/staggered/staggered_fast.h"
#include "disc/staggered/staggered_multigrid.h"

struct LthStaggeredMultigrid {
  LthStaggeredMultigridDef def;
  LthStaggeredLevel fine;
  LthStaggeredHierarchy *hierarchy; ///< NULL before the first prepare()
  int n_levels;                     ///< 1 before that
  LthFastLevel level[LTH_STAGGERED_MAX_LEVELS];
  LthStaggeredCoarsest coarsest;
  LthStaggeredClusters *clusters; ///< below the coarsest level where that has no factor, else NULL
  double cm, ck, unit;
  int degree;
  LitheCount width; ///< values of a row of vectors: dim side
  double *p, *r;    ///< direction, residual: as vectors of level 0 lie    (n_rows x width)
  double *work;     ///< q = A p, and in the same place x and y of level 0 (n_rows x width)
  float *vectors[LTH_STAGGERED_MAX_LEVELS]; ///< b of level 0; x, y and b of the others
  double *sum;                              ///< one of each active block  (n_active)
  double work_done;          ///< by cycles and full multigrid so far, in applications of level 0
  double *extra_x, *extra_y; ///< of `extra`, or NULL                   (n_dofs)
};

/// x of level 0 from its b by one V-cycle from zero; product = b . x.
LitheStatus lth_staggered_cycle(LitheCtx *ctx, LthStaggeredMultigrid *M, double *product);
/// x of level 0 from its b: every level's start is the coarser one's solution.
LitheStatus lth_staggered_full(LitheCtx *ctx, LthStaggeredMultigrid *M);

/// Sum of M->sum in order.
double lth_staggered_sum(const LthStaggeredMultigrid *M);
/// Values of the finest rows from a vector of functions; all of them, or (`only_free`) 0 where not free.
void lth_staggered_scatter(const LthStaggeredMultigrid *M, int threads, bool only_free,
                           const double *x, double *rows);
/// The way back: y = rows at unknowns that are free, or (`held`) not dead; else y is 0.
void lth_staggered_gather(const LthStaggeredMultigrid *M, int threads, bool held,
                          const double *rows, double *y);
/// Whether a solve for uniform forces comes below a tolerance in less than `most` iterations; uses r and p.
LitheStatus lth_staggered_multigrid_trial(LitheCtx *ctx, LthStaggeredMultigrid *M, double tolerance,
                                          LitheIndex most, bool *reached);
