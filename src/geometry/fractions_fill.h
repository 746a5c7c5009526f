/// How the parts of a row of blocks are found: what the methods of volume fractions have in common.
#pragma once

#include "geometry/fractions.h"
#include "geometry/shape_probe.h"

/// Where blocks, cells and parts lie.
typedef struct LthFractionFrame {
  int dim, side; ///< cells along a block
  int n_parts;   ///< of a cell
  LitheIndex block_cells;
  double origin[3]; ///< of block (0, 0, 0); 2D: z = 0
  double h[3];      ///< 2D: h[2] = 0
  LitheIndex n_block[3];
  LitheIndex first_cell[3], end_cell[3]; ///< cells of the grid that was asked for
} LthFractionFrame;

/// Blocks (at[m], j, k) of one row that the boundary may meet.
typedef struct LthFractionRow {
  LitheIndex j, k;
  LitheIndex n;         ///< blocks
  const LitheIndex *at; ///< rising                                                             (n)
  double *part;         ///< zero before it is filled           (n x block_cells x n_parts)
} LthFractionRow;

/// A method. Both functions are thread-safe.
typedef struct LthFractionFiller {
  const void *self;
  LthSide (*side)(const void *self, const double center[3], const double half[3]);
  LitheStatus (*fill)(const void *self, LitheCtx *ctx, const LthFractionFrame *frame,
                      const LthFractionRow *row);
} LthFractionFiller;

/// Low corner of a block.
static inline void lth_fraction_corner(const LthFractionFrame *f, LitheIndex i, LitheIndex j,
                                       LitheIndex k, double low[3]) {
  low[0] = f->origin[0] + f->h[0] * f->side * i;
  low[1] = f->origin[1] + f->h[1] * f->side * j;
  low[2] = f->dim == 3 ? f->origin[2] + f->h[2] * f->side * k : 0;
}

/// Place in a block's parts of part (i, j, k), counted in halves of cells from the block's low corner.
static inline LitheIndex lth_fraction_place(const LthFractionFrame *f, int i, int j, int k) {
  int cell = i / 2 + f->side * (j / 2 + f->side * (k / 2));
  return cell * f->n_parts + (i & 1) + 2 * (j & 1) + 4 * (k & 1);
}

/// Find which blocks are there, fill them, and keep what is cut.
LitheStatus lth_fractions_build(LitheCtx *ctx, const LthFractionFiller *filler, int dim,
                                const double origin[3], const double h[3], const LitheIndex n[3],
                                LthFractions **fractions);

/// LTH_FRACTIONS_SAMPLES by a probe.
typedef struct LthSampler {
  const LthProbe *probe;
  int samples; ///< along a cell, even
} LthSampler;
LthSide lth_fraction_sample_side(const void *sampler, const double center[3], const double half[3]);
LitheStatus lth_fraction_fill_samples(const void *sampler, LitheCtx *ctx,
                                      const LthFractionFrame *frame, const LthFractionRow *row);

/// LTH_FRACTIONS_SMOOTH by a probe.
typedef struct LthSmoother {
  const LthProbe *probe;
  double width; ///< of the profile's half [m]
  double step;  ///< of gradients [m]
  int dim;
} LthSmoother;
LthSmoother lth_fraction_smoother(const LthProbe *probe, const LthFractionDef *def, int dim,
                                  const double h[3]);
/// From 1 at s = -1 to 0 at s = 1.
double lth_fraction_profile(double s);
LthSide lth_fraction_smooth_side(const void *smoother, const double center[3],
                                 const double half[3]);
LitheStatus lth_fraction_fill_smooth(const void *smoother, LitheCtx *ctx,
                                     const LthFractionFrame *frame, const LthFractionRow *row);

/// The same for a probe that is one surface of triangles, closed or wrapped, in 3D.
LitheStatus lth_fraction_fill_near(const LthSmoother *smoother, LitheCtx *ctx,
                                   const LthFractionFrame *frame, const LthFractionRow *row);

/// LTH_FRACTIONS_EXACT in 2D.
LthFractionFiller lth_fraction_plane_filler(const LthProbe *probe);

/// LTH_FRACTIONS_EXACT in 3D by a probe, which is `self`.
LitheStatus lth_fraction_fill_exact(const void *probe, LitheCtx *ctx, const LthFractionFrame *frame,
                                    const LthFractionRow *row);

/// Parts inside a prepared triangle surface: to rounding, or `samples` along a cell > 0. `part` as row->part, zero.
LitheStatus lth_fraction_fill_surface(LitheCtx *ctx, const LthShape *shape, int samples,
                                      const LthFractionFrame *frame, const LthFractionRow *row,
                                      double *part);

/// The same of a probe's wrapped surface.
LitheStatus lth_fraction_fill_wrap(LitheCtx *ctx, const LthProbe *probe, int samples,
                                   const LthFractionFrame *frame, const LthFractionRow *row,
                                   double *part);

/// Value of a leaf box of `size` parts at `at` (counted in parts from the block's low corner).
typedef double (*LthFractionLeaf)(const void *self, const LthFractionFrame *frame,
                                  const double low[3], const int at[3]);

/// Fill a block (low corner `low`) by halving: boxes on one side at once, parts that are mixed by `leaf`. Sides are asked of
/// boxes of `asked` parts or more.
void lth_fraction_halve(const LthFractionFiller *filler, LthFractionLeaf leaf, int asked,
                        const LthFractionFrame *frame, const double low[3], double *part);
