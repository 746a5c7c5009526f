/// Coordinates of one cell in which it is about as large in one direction as in another: xi = axes (x - center).
#pragma once

#include "mesh/mesh.h"

/// Second moments of a cell in its frame differ by this factor at most, but for rounding.
#define LTH_DG_FRAME_BALANCE 16

/// Turn and stretch a frame until the cell has balanced second moments in it, centred at its centroid; `center` and
/// `axes` (row-major, [1/m]) are those to begin with. False where the cell has no volume in some direction.
bool lth_dg_frame_fit(const LthMesh *mesh, LitheIndex cell, double center[3], double axes[9]);

/// Moments of a cell in any frame up to degree p, lth_monomials3(p) [m^3].
void lth_dg_frame_moments(const LthMesh *mesh, LitheIndex cell, int p, const double center[3],
                          const double axes[9], double *moments);

/// Those of its boundary [m^2].
void lth_dg_frame_area_moments(const LthMesh *mesh, LitheIndex cell, int p, const double center[3],
                               const double axes[9], double *moments);
