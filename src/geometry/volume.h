/// Images in three dimensions: values on a lattice that lies anywhere in space, and the solids that they show
/// (docs/reference/images.md).
#pragma once

#include "base/ctx.h"

#define LTH_VOXELS_MAX 1073741824 ///< of one volume

/// Values at the centres of voxels; voxel (i, j, k) is number i + n[0] (j + n[1] k).
typedef struct LthVolume {
  LitheIndex n[3];
  double to_world[12]; ///< row-major 3x4: place of voxel centre (i, j, k) [m]
  double to_voxel[12]; ///< the way back
  double of_file[12];  ///< to_world as it was at first: that of its file
  float *values;       ///< (n[0] n[1] n[2])
} LthVolume;

/// A volume of zeros. LITHE_BAD_INPUT: a map without inverse, or too many voxels.
LitheStatus lth_volume_create(LitheCtx *ctx, const LitheIndex n[3], const double to_world[12],
                              LthVolume **volume);
void lth_volume_destroy(LitheCtx *ctx, LthVolume **volume);

/// Give it another place. LITHE_BAD_INPUT: a map without inverse.
LitheStatus lth_volume_place(LitheCtx *ctx, LthVolume *volume, const double to_world[12]);

static inline LitheCount lth_volume_size(const LthVolume *v) {
  return (LitheCount)v->n[0] * v->n[1] * v->n[2];
}
static inline LitheCount lth_volume_index(const LthVolume *v, LitheIndex i, LitheIndex j,
                                          LitheIndex k) {
  return i + (LitheCount)v->n[0] * (j + (LitheCount)v->n[1] * k);
}

/// Voxel coordinates of a place; whole numbers are centres.
void lth_volume_locate(const LthVolume *volume, const double x[3], double voxel[3]);

/// Trilinear; beyond the outermost centres the value of the nearest.
double lth_volume_value(const LthVolume *volume, const double x[3]);

/// The same of an array with the volume's voxels.
double lth_volume_sample(const LthVolume *volume, const float *values, const double x[3]);

/// Gaussian of standard deviation `sigma` [m], along the voxel axes, constant beyond the rim.
LitheStatus lth_volume_smooth(LitheCtx *ctx, const LthVolume *volume, double sigma, float *values);
