/// The Poisson equation on the unit square by squares of side 1/n: continuous bilinear functions, or
/// discontinuous polynomials with the fluxes of Babuska-Zlamal and of interior penalty.
/// Kaufmann et al. 2009, section 3, eqs (2), (12), (14).
#pragma once

#include "base/ctx.h"

typedef enum LthPoissonMethod { LTH_POISSON_CG, LTH_POISSON_BZ, LTH_POISSON_IP } LthPoissonMethod;

/// -Laplace u = source inside, u = value on the whole boundary.
typedef struct LthPoissonProblem {
  double (*value)(const double x[2]);  ///< also the exact solution
  double (*source)(const double x[2]); ///< minus its Laplacian
} LthPoissonProblem;

typedef struct LthPoissonDef {
  LthPoissonMethod method;
  int degree; ///< 1 or 2; of CG always bilinear
  int cells;  ///< along a side
  double eta; ///< penalty eta / |e| on every edge, boundary included (not used by CG)
  bool
      is_monomial; ///< condition number in the monomials of x and y themselves, not of the cells' own coordinates
  bool wants_matrix; ///< eigenvalues as well: dense, some thousand unknowns at most
} LthPoissonDef;

typedef struct LthPoissonResult {
  int unknowns;
  double l2;                ///< ||u_h - u||
  double laplace;           ///< ||Laplace u_h + source||, element by element
  double smallest, largest; ///< eigenvalues of the matrix; NaN where they were not asked for
} LthPoissonResult;

/// The solution does not depend on the basis: it is always computed in the cells' own coordinates. CG takes problems
/// with value 0 on the boundary alone.
LitheStatus lth_poisson_solve(LitheCtx *ctx, const LthPoissonProblem *problem,
                              const LthPoissonDef *def, LthPoissonResult *result);

static inline double lth_poisson_condition(const LthPoissonResult *r) {
  return r->largest / r->smallest;
}
