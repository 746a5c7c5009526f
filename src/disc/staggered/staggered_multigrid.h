/// Solves of (cm M + ck K) w = f on a staggered grid: conjugate gradients in double precision, a V-cycle in single
/// precision as preconditioner, full multigrid as start (docs/theory/staggered-multigrid.md).
#pragma once

#include "disc/staggered/staggered_level.h"
#include "la/krylov.h"

typedef struct LthStaggeredMultigrid LthStaggeredMultigrid;

typedef struct LthStaggeredMultigridDef {
  const LthStaggeredLevel *level; ///< arrays borrowed for life
  const LitheIndex
      *func; ///< function of a slot, -1: none; NULL: the slot itself. Borrowed for life (n_slots)
  LitheCount
      n_dofs; ///< 3 x functions: what vectors below are long; component a of function i at 3 i + a
  int degree; ///< steps of a smoother; 0: by Poisson's ratio
  LitheCount
      factored; ///< unknowns up to which the coarsest level has a Cholesky factor; 0: by dimension
} LthStaggeredMultigridDef;

/// Enough for lth_staggered_multigrid_apply().
LitheStatus lth_staggered_multigrid_create(LitheCtx *ctx, const LthStaggeredMultigridDef *def,
                                           LthStaggeredMultigrid **multigrid);
void lth_staggered_multigrid_destroy(LitheCtx *ctx, LthStaggeredMultigrid **multigrid);

/// y = (cm M + ck K) x: held unknowns of x count; y is 0 where not free, or (`held`) where dead. x may be y.
void lth_staggered_multigrid_apply(LthStaggeredMultigrid *multigrid, int threads, double cm,
                                   double ck, bool held, const double *x, double *y);

/// Levels and coefficients for cm M + ck K; allocates at the first call, where cm turns from 0 to more, and where
/// levels of clusters are made anew for other coefficients.
LitheStatus lth_staggered_multigrid_prepare(LitheCtx *ctx, LthStaggeredMultigrid *multigrid,
                                            double cm, double ck);

/// Free what prepare() has made: multigrid_apply() does without; the next prepare() makes it again.
void lth_staggered_multigrid_release(LitheCtx *ctx, LthStaggeredMultigrid *multigrid);

/// Solve from the w given until |r| <= tolerance |rhs|, with `extra` as LthDiscSolver.solve() has it. Where w = 0 and
/// extra is NULL, full multigrid makes the first guess. Allocates nothing but for the first `extra`.
LitheStatus lth_staggered_multigrid_solve(LitheCtx *ctx, LthStaggeredMultigrid *multigrid,
                                          const LthOperator *extra, const double *rhs, double *w,
                                          double tolerance, LitheIndex max_iterations,
                                          LthSolveReport *report);

/// z = one V-cycle on r from zero; w = one pass of full multigrid for rhs.
LitheStatus lth_staggered_multigrid_cycle(LitheCtx *ctx, LthStaggeredMultigrid *multigrid,
                                          const double *r, double *z);
LitheStatus lth_staggered_multigrid_full(LitheCtx *ctx, LthStaggeredMultigrid *multigrid,
                                         const double *rhs, double *w);

/// Seconds of one pass of full multigrid, on vectors that lie as solves have them, mean of `count`; after prepare(). `work`: of the pass, counted on the way, in applications of the operator: steps of smoothers and residuals
/// of all levels by their unknowns, transfers and the coarsest solve by the bytes that they touch (rigid clusters left out).
LitheStatus lth_staggered_multigrid_time_full(LitheCtx *ctx, LthStaggeredMultigrid *multigrid,
                                              const double *rhs, int count, double *seconds,
                                              double *work);
/// Seconds of one application of the operator, on vectors that lie as solves have them; after prepare().
double lth_staggered_multigrid_time_apply(LitheCtx *ctx, LthStaggeredMultigrid *multigrid);
/// Bytes that such an application cannot but move: places of x and y, samples of rows that differ, states and numbers of
/// rows in general blocks, each once.
LitheCount lth_staggered_multigrid_apply_bytes(const LthStaggeredMultigrid *multigrid);

LitheCount lth_staggered_multigrid_bytes(const LthStaggeredMultigrid *multigrid);
int lth_staggered_multigrid_levels(const LthStaggeredMultigrid *multigrid);
/// Unknowns that are free, on a level.
LitheCount lth_staggered_multigrid_unknowns(const LthStaggeredMultigrid *multigrid, int level);
