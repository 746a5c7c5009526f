/// The discontinuous Galerkin method as a discretisation among others.
#pragma once

#include "disc/dg/dg_kept.h"

/// What a DG body is seen through. `op` may be NULL while nothing but evaluation, rest positions and the
/// matrix pattern are asked for; `density` per cell [kg/m^3] while no mass or gravity is. All is borrowed
/// for life.
typedef struct LthDgDiscDef {
  const LthDgSpace *space;
  LthDgOperator *op;
  const double *density;
  const LthWeakConstraint *weak; ///< those of op
  LitheIndex n_weak;
  const LthDgKept
      *kept; ///< the stiffness of op, which is linear, or NULL: assembled anew every time
  const LitheIndex *cell_record; ///< of kept                                (n_cells)
} LthDgDiscDef;

LitheStatus lth_dg_disc_create(LitheCtx *ctx, const LthDgDiscDef *def, LthDisc **disc);
