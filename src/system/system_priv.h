/// Shared by the files of this room.
#pragma once

#include "system/system.h"

/// Free what lth_system_matrix_create() made for single bodies.
void lth_system_parts_free(LitheCtx *ctx, LthSystem *system);
