/// Reading VTK's unstructured grids (`.vtu`) as meshes.
#pragma once

#include "io/element_builder.h"
#include "io/vtu_array.h"

/// Enter the contents of a `.vtu` file into a builder.
LitheStatus lth_vtu_parse(LthElementBuilder *b, const char *data, size_t size);

/// Where the points of cells were written once for each cell (as Lithe's own fields are): `same[i]` becomes the
/// first point within `tolerance` of point i, for n points x (n x 3).
LitheStatus lth_vtu_weld(LitheCtx *ctx, LitheIndex n, const double *x, double tolerance,
                         LitheIndex *same);
