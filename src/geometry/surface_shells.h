/// Surfaces made of triangles that are closed by construction, and their connected shells.
#pragma once

#include "geometry/surface.h"

/// A surface that is its own soup: soup_point and tri_poly are the identity. Takes over both arrays
/// (n x 3 each), which are NULL afterwards; on failure what is left of them is the caller's.
LitheStatus lth_surface_from_triangles(LitheCtx *ctx, LitheIndex n_points, double **points,
                                       LitheIndex n_tris, LitheIndex **tris, LthSurface **surface);

/// Volume within each shell, negative of cavities [m^3]. (n_shells)
void lth_surface_shell_volumes(const LthSurface *surface, double *volume);

/// Leave out shells whose volume is below `smallest` [m^3] in size; the surface has to be its own soup.
LitheStatus lth_surface_drop_small(LitheCtx *ctx, LthSurface *surface, double smallest);
