/// Multilevel preconditioner for matrices of elasticity: Galerkin levels of linear functions, then of rigid motions.
#pragma once

#include "la/krylov.h"

/// What the levels are made of (docs/theory/multigrid.md).
typedef struct LthMultilevelDef {
  const LthBlockMatrix *A; ///< symmetric positive definite, borrowed for life
  const double *one;       ///< coefficients of the function 1, borrowed for life       (n / 3)
  const double *near; ///< rigid motions by row, instead of `one` and `position`; not kept (n x 6)
  const double *position; ///< coefficients of the map x -> x, or of where bodies are; not kept (n)
  LitheIndex n_linear; ///< leading unknowns of a block row that span the linear functions; 0: all
  const LthBlockMatrix
      *touch; ///< what coarse levels know beside A: rows as A's, pattern and values of its own,
              ///< borrowed for life; or NULL
  bool
      once; ///< never updated, refreshed or strengthened: what only that would need is freed as levels are made
  LitheIndex
      least_rows; ///< of an aggregate on the mean, where the strong couplings alone make smaller ones; 0: any
} LthMultilevelDef;

typedef struct LthMultilevel LthMultilevel;

/// Build levels for A as it stands. Unknowns whose row of A holds nothing but the diagonal are taken as held.
/// LITHE_NOT_CONVERGED: a diagonal block or the coarsest matrix is not definite.
LitheStatus lth_multilevel_create(LitheCtx *ctx, const LthMultilevelDef *def, LthMultilevel **M);
void lth_multilevel_destroy(LitheCtx *ctx, LthMultilevel **M);

/// Take over A's new values and new places (position may be NULL, as it must where `near` was given: as before): aggregates and patterns stay,
/// nothing is allocated. `extra` (laid out as for lth_block_jacobi_update(), borrowed until the next update, or
/// NULL) is added to the diagonal blocks of A on the finest level. Held unknowns must be the same.
LitheStatus lth_multilevel_update(LitheCtx *ctx, LthMultilevel *M, const double *position,
                                  const double *extra);

/// The same for the finest level's diagonal blocks alone; coarser levels stay as they are, which costs iterations
/// where A has changed much.
LitheStatus lth_multilevel_refresh(LitheCtx *ctx, LthMultilevel *M, const double *extra);

/// The matrix proper is A + C, and not A + extra, which must nowhere be below it: residuals of the finest level are those of A + C from
/// now on. C.apply adds: y += C x; its `self` is borrowed. NULL: no more.
void lth_multilevel_add(LthMultilevel *M, const LthOperator *C);

/// Smooth by polynomials from now on, as lth_multilevel_solve() does by itself; and whether that is so.
void lth_multilevel_strengthen(LthMultilevel *M);
bool lth_multilevel_is_strong(const LthMultilevel *M);

/// The preconditioner: one symmetric V-cycle from zero. Symmetric positive definite; the same bits for any number
/// of threads; allocates nothing. Uses vectors of M: one application at a time.
LthOperator lth_multilevel_operator(const LthMultilevel *M);

/// As lth_cg_solve() with this preconditioner. Where the first iterations show that plain sweeps smooth too little
/// (nearly incompressible bodies), M turns to a polynomial smoother, and stays with it.
LthSolveReport lth_multilevel_solve(LthMultilevel *M, LthCg *cg, int threads, const LthOperator *A,
                                    const double *b, double *x, double tolerance,
                                    LitheIndex max_iterations);

/// Levels, the unknowns of each, and the values of all levels' matrices over those of A.
int lth_multilevel_levels(const LthMultilevel *M);
LitheCount lth_multilevel_unknowns(const LthMultilevel *M, int level);
double lth_multilevel_complexity(const LthMultilevel *M);

/// What an update costs for a matrix with A's pattern, in bytes that products would read in that time.
double lth_multilevel_update_cost(const LthBlockMatrix *A, LitheIndex n_linear);

/// Bytes that M holds, A not among them.
LitheCount lth_multilevel_bytes(const LthMultilevel *M);
