/// Displacement and pressure on a staggered grid, where lambda is large next to mu: what of it multigrid for displacements
/// bears stays with these, a pressure in every cell has the rest. docs/theory/staggered-mixed.md.
#pragma once

#include "disc/staggered/staggered_multigrid.h"

/// lambda = soft + rest, soft at most LTH_STIFFEST mu, rest infinite where nu = 0.5. With p = rest div u, over unknowns u of the body
/// and pressures p of cells:
///
///   [ A    B^T ] [ u ]   [ f ]      A = cm M + ck K(soft),  B = ck |cell| V div,
///   [ B   -C   ] [ p ] = [ g ]      C = ck |cell| V / rest                                    (1)
///
/// A vector of it is n_dofs displacements, then the pressures.
typedef struct LthMixed {
  LthStaggeredLevel level; ///< lambda, V and V / lambda of the whole; arrays are borrowed
  LthStaggeredLevel soft;  ///< the same, but for its own lambda
  LthStaggeredMultigrid *multigrid;
  int dim;
  LitheCount n_dofs;
  LitheIndex n_cells; ///< with a pressure
  LitheIndex *slot;   ///< of such a cell                                             (n_cells)
  LitheIndex
      *func; ///< of its low faces, then of the high one along each axis     ((dim + 1) x n_cells)
  LitheIndex *
      beside; ///< of a function: its cell, then that below along each axis; n_cells where there is none
              ///<                                                    ((dim + 1) x functions)
  uint8_t *state; ///< LthUnknownState of component a << 2 a                       (functions)
  double *volume; ///< V                                                          (n_cells + 1)
  double *
      rest; ///< V lambda less that of `soft` [Pa]; where nu = 0.5 of the assembled form's   (n_cells)
  double *compliance; ///< V over the rest of lambda [1/Pa], 0 where nu = 0.5          (n_cells)
  double *scale; ///< [Pa] constraint rows times this and over ck |cell| are pressures     (n_cells)
  double *push;  ///< scratch: V p                                               (n_cells + 1)
  double cm, ck;
} LthMixed;

static inline LitheCount lth_mixed_size(const LthMixed *m) { return m->n_dofs + m->n_cells; }

/// Both are borrowed for life: a level with compliance, and functions of its slots, NULL: the slots themselves.
LitheStatus lth_mixed_create(LitheCtx *ctx, const LthStaggeredLevel *level, const LitheIndex *func,
                             LitheCount n_dofs, LthMixed **mixed);
void lth_mixed_destroy(LitheCtx *ctx, LthMixed **mixed);
/// Make ready for cm M + ck K; allocates at the first call, and where cm turns from 0 to more.
LitheStatus lth_mixed_prepare(LitheCtx *ctx, LthMixed *m, double cm, double ck);
LitheCount lth_mixed_bytes(const LthMixed *m);

/// d = div u of the cells with a pressure.
void lth_mixed_divergence(const LthMixed *m, int threads, const double *u, double *d);
/// push = rest / V div u: the pressures that the rest of lambda makes of displacements.
void lth_mixed_follow(const LthMixed *m, int threads, const double *u);
/// f += c |cell| V div^T p at unknowns that are free, or (`held`) not dead. p may be `m->push`.
void lth_mixed_push(const LthMixed *m, int threads, double c, bool held, const double *p,
                    double *f);
/// y = (1) x, 0 at unknowns that are not free.
void lth_mixed_apply(const LthMixed *m, int threads, const double *x, double *y);
/// z = approximately the inverse of (1) on r, by one V-cycle; r is kept, `work` (n_dofs) is scratch.
LitheStatus lth_mixed_precondition(LitheCtx *ctx, LthMixed *m, const double *r, double *work,
                                   double *z);

/// When a solve ends: |r| <= tolerance size, of the momentum rows once every pressure is what the divergence makes it.
typedef struct LthMixedStop {
  double tolerance, size;
  LitheIndex max_iterations;
  double stiff; ///< lambda over mu that weighs the divergence where nu = 0.5
  bool start; ///< the displacements given are zero: multigrid for these alone makes the first guess
} LthMixedStop;

/// Directions and vectors of a solve.
typedef struct LthMixedKrylov LthMixedKrylov;
LitheStatus lth_mixed_krylov_create(LitheCtx *ctx, const LthMixed *m, LthMixedKrylov **krylov);
void lth_mixed_krylov_destroy(LitheCtx *ctx, LthMixedKrylov **krylov);
LitheCount lth_mixed_krylov_bytes(const LthMixedKrylov *krylov);
/// Unknowns and right-hand side of the next solve (lth_mixed_size()).
double *lth_mixed_krylov_x(LthMixedKrylov *krylov);
double *lth_mixed_krylov_b(LthMixedKrylov *krylov);
/// Solve from the x that stands there, with `extra` (may be NULL) on displacements; allocates at the first `extra` alone.
LitheStatus lth_mixed_krylov_solve(LitheCtx *ctx, LthMixedKrylov *krylov, LthMixed *m,
                                   const LthOperator *extra, const LthMixedStop *stop,
                                   LthSolveReport *report);
