/// Generalised winding number of triangles that need not be closed, oriented or apart.
/// Jacobson, Kavan and Sorkine 2013; far triangles together as in Barill et al. 2018
/// (docs/theory/winding.md).
#pragma once

#include "base/ctx.h"

/// Immutable once built; safe to read from many threads. Its own copy of the triangles.
typedef struct LthWinding LthWinding;

/// Triangles `tris` (n_tris x 3) of `points` [m], counter-clockwise seen from outside. Nothing is kept of
/// either.
LitheStatus lth_winding_create(LitheCtx *ctx, LitheIndex n_tris, const double *points,
                               const LitheIndex *tris, LthWinding **winding);
void lth_winding_destroy(LitheCtx *ctx, LthWinding **winding);

/// How often the triangles go around x: 1 inside a closed surface, 0 outside, in between where they are
/// open. A group of triangles within radius r of its centre is taken together where that is farther than
/// `opening` r away, opening > 1; the larger, the more exact. *bound (may be NULL) is then a bound on the
/// error of doing so (winding.md, equation 5).
double lth_winding_number(const LthWinding *winding, const double x[3], double opening,
                          double *bound);

/// The same as the sum over all triangles.
double lth_winding_direct(const LthWinding *winding, const double x[3]);

/// Is the number above one half? Groups are opened until the bound decides, or is below 1e-3.
bool lth_winding_inside(const LthWinding *winding, const double x[3]);

/// For many places in one box: far triangles as a polynomial over it, near ones as they are.
#define LTH_WINDING_NEAR 2048
#define LTH_WINDING_NEAR_ERROR 4e-3 ///< of its numbers, as measured: winding.md, section 5
typedef struct LthWindingNear {
  const LthWinding *winding; ///< borrowed
  double center[3], half[3];
  double far[27]; ///< winding numbers of far triangles at 3 places along each axis
  int n;          ///< leaves that are near
  LitheIndex leaf[LTH_WINDING_NEAR]; ///< (n)
} LthWindingNear;

/// From a larger box that this one is in, or NULL. False where too many triangles are near.
bool lth_winding_near(const LthWinding *winding, const LthWindingNear *larger,
                      const double center[3], const double half[3], LthWindingNear *near);

/// The number at x in the box.
double lth_winding_near_number(const LthWindingNear *near, const double x[3]);
