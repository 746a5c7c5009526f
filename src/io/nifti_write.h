/// NIfTI-1 files written: fields on the voxels of a scan, so that they lie over it.
#pragma once

#include "geometry/volume.h"

/// Values on voxels as floats, one volume a component.
typedef struct LthNiftiField {
  const char *name; ///< shown as the intent's name, 15 letters at most
  int components; ///< 1, 3: a vector, 6: a symmetric tensor xx yy zz yz zx xy (NIfTI's order in the file)
  const float
      *values; ///< component by component, x fastest             (components x n[0] n[1] n[2])
} LthNiftiField;

/// `to_world` (row-major 3x4) [m] is written in millimetres, as sform, and as qform where it turns without shear. Gzip-compressed
/// where the name ends in .gz. Atomic. LITHE_BAD_INPUT: more voxels along an axis than the format has (32767).
LitheStatus lth_nifti_write(LitheCtx *ctx, const char *path, const LitheIndex n[3],
                            const double to_world[12], const LthNiftiField *field);
