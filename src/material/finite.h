/// Solids of large deformation at a point, plane strain and 3D: energy, stress and tangent of corotated and stable
/// neo-Hookean ones. docs/theory/staggered-finite.md, section 1.
#pragma once

#include "material/material.h"

/// The energy density is
///   W(F) = psi(F) + lambda/2 v(F)^2
/// with psi that of nu = 0, and v a measure of volume, apart, so that v may be a mean over places:
///   corotated     psi = mu |F - R|^2, R the rotation nearest to F;          v = tr R^T F - dim
///   neo-Hookean   psi = mu/2 (|F|^2 - dim) - mu (J - 1) + mu/2 (J - 1)^2;   v = J - 1
/// Both have P = 0 and Lame's lambda, mu at every rotation F, and are finite and smooth where F is inverted (corotated:
/// but where R is not unique). F, P and G are row-major (dim x dim).
typedef struct LthFinite {
  LthMaterialModel model; ///< corotated or neo-Hookean
  int dim;                ///< 2 (plane strain) or 3
  double mu;              ///< [Pa]
  /// Shears that cost nothing: 1 yz, 2 zx, 4 xy (in the frame at rest). Where there are such, with l_a the lengths of the
  /// columns f_a of F, psi = mu sum_a (l_a - 1)^2 + mu/2 sum over the other shears of (f_a . f_b)^2, and v is
  /// sum_a (l_a - 1) or the product of the l_a less 1: the same for small strains at any rotation.
  unsigned loose;
} LthFinite;

/// psi [J/m^3] and v.
double lth_finite_energy(const LthFinite *m, const double *F, double *v);

/// P = d psi / dF [Pa], v and G = dv / dF.
void lth_finite_stress(const LthFinite *m, const double *F, double *v, double *P, double *G);

/// H = d2 (psi + p v) / dF2 at fixed p = lambda v [Pa], row-major (dim^2 x dim^2); `definite`: its negative eigenvalues
/// replaced by zero. What is left of d2 W, lambda G G^T, has none.
void lth_finite_tangent(const LthFinite *m, const double *F, double p, bool definite, double *H);
