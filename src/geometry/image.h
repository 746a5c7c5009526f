/// The solid that a volume shows: voxels above a threshold or with given labels, smoothed, without islands.
#pragma once

#include "geometry/volume.h"

/// Immutable once built but for lth_image_drop(); safe to read from many threads.
typedef struct LthImage {
  const LthVolume *volume; ///< borrowed for life
  float *level;            ///< negative inside, at voxel centres          (of the volume)
  bool is_smoothed;        ///< else volume fractions take whole voxels
  double box[6];           ///< around all that is inside [m]
  LitheIndex n_islands;    ///< pieces connected over voxel faces
  LitheIndex *island;      ///< of each voxel, -1 outside; in the order of their first voxels
  LitheCount *island_size; ///< voxels                                   (n_islands)
} LthImage;

/// `labels` (n_labels), or NULL: what is above `threshold`. `width` of smoothing: two standard deviations
/// of a Gaussian [m]. LITHE_BAD_INPUT: nothing is selected; the message says which values there are.
LitheStatus lth_image_create(LitheCtx *ctx, const LthVolume *volume, double threshold,
                             const double *labels, LitheIndex n_labels, double width,
                             LthImage **image);
void lth_image_destroy(LitheCtx *ctx, LthImage **image);

/// Leave out the islands that are not kept (n_islands); the box stays.
void lth_image_drop(LthImage *image, const bool *keep);

/// Negative inside, in no unit of length; positive beyond the volume.
double lth_image_value(const LthImage *image, const double x[3]);

/// Value of the nearest voxel that is inside, among those around x; of the nearest of all where none is.
double lth_image_label(const LthImage *image, const double x[3]);
