/// Fields of staggered bodies as files, for observe_fields.c: images of the grid, displaced voxels, volumes over a scan.
#pragma once

#include "scene/staggered_body.h"

/// Samples of the present state, one a cell with material.
typedef struct LthGridFields LthGridFields;

LitheStatus lth_grid_fields_open(LitheCtx *ctx, const LthBody *body, LthGridFields **fields);
void lth_grid_fields_close(LitheCtx *ctx, LthGridFields **fields);

void lth_grid_fields_sample(LitheCtx *ctx, LthGridFields *fields, const LthBody *body);

/// What was sampled last as .vti; as .vtu with displaced corners, which `body` still has to be at.
LitheStatus lth_grid_fields_image(LitheCtx *ctx, const LthGridFields *fields, const LthBody *body,
                                  const char *path);
LitheStatus lth_grid_fields_voxels(LitheCtx *ctx, LthGridFields *fields, const LthBody *body,
                                   const char *path);

/// The sampled state at the voxels of the scan that the body was made from, 0 outside of it. `what`: 0 displacement in
/// the scene's axes, 1 stress, 2 von Mises stress.
LitheStatus lth_grid_fields_volume(LitheCtx *ctx, const LthGridFields *fields, const LthBody *body,
                                   int what, const char *path);

#define LTH_GRID_VOLUMES 3
const char *lth_grid_fields_volume_name(int what);
