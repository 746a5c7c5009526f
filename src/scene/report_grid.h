/// What `lithe mesh` and `lithe check` tell of staggered bodies: from their fractions, before anything else is built.
#pragma once

#include "lithe/run.h"
#include "scene/staggered_body.h"

/// Add a body's cells, pieces and volume to the report.
LitheStatus lth_report_grid(LitheCtx *ctx, const LthBody *body, LitheMeshReport *report);

/// Write fractions as .vti.
LitheStatus lth_write_fractions(LitheCtx *ctx, const LthBody *body, const char *path);

/// Cells with material, and unknowns that touch them.
typedef struct LthGridCount {
  LitheIndex cells, cut;
  LitheCount unknowns, funcs; ///< funcs: slots that have some
  LitheCount rows,
      own_rows; ///< rows of slots with unknowns; those of them that are not full all around
} LthGridCount;

LthGridCount lth_count_grid(const LthBody *body);
