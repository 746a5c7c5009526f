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
