/// Fields of staggered bodies as files, for observe_fields.c: images of the grid, displaced voxels, volumes over a scan.
#pragma once

#include "scene/staggered_body.h"

/// Cells with material, and the state that is written. Values are computed as they are written: none is kept.
typedef struct LthGridFields LthGridFields;

LitheStatus lth_grid_fields_open(LitheCtx *ctx, LthGridFields **fields);
void lth_grid_fields_close(LitheCtx *ctx, LthGridFields **fields);

/// Files of the state that `body` is in, until its simulation is called again.
LitheStatus lth_grid_fields_begin(LitheCtx *ctx, LthGridFields *fields, const LthBody *body);

/// That state as .vti; as .vtu with displaced corners.
LitheStatus lth_grid_fields_image(LitheCtx *ctx, const LthGridFields *fields, const char *path);
LitheStatus lth_grid_fields_voxels(LitheCtx *ctx, LthGridFields *fields, const char *path);

/// It at the voxels of the scan that the body was made from, 0 outside of it. `what`: 0 displacement in
/// the scene's axes, 1 stress, 2 von Mises stress.
LitheStatus lth_grid_fields_volume(LitheCtx *ctx, const LthGridFields *fields, int what,
                                   const char *path);

#define LTH_GRID_VOLUMES 3
const char *lth_grid_fields_volume_name(int what);
