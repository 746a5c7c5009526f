/// A yardstick for the staggered operator: the same stencil with one coefficient for all, in a full box without blocks,
/// boundaries or samples, as plain loops that the compiler makes vectors of.
#pragma once

#include "base/ctx.h"

#include <stddef.h>

typedef struct DenseStencil {
  int dim;
  LitheCount side;   ///< cells along an axis
  ptrdiff_t step[3]; ///< from a value to the next one along an axis
  LitheCount size;   ///< values of a component, with one cell around the box
  double *p, *q;
  double share; ///< unknowns that were asked for, of those in the box
} DenseStencil;

/// A box for so many unknowns, written by all threads.
LitheStatus dense_stencil_create(LitheCtx *ctx, int dim, LitheCount unknowns, DenseStencil *box);
/// One application on all threads.
void dense_stencil_apply(const LitheCtx *ctx, const DenseStencil *box);
void dense_stencil_free(LitheCtx *ctx, DenseStencil *box);
