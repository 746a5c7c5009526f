/// Images from files: NIfTI-1 (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mhd, .mha), and in two dimensions PNG.
#pragma once

#include "geometry/volume.h"

/// Read a volume by the ending of its name. Places are in metres; lengths are millimetres where the file
/// does not say. A PNG is one layer of pixels of 1 mm, its lower left corner at the origin, y upwards. LITHE_BAD_INPUT: broken, truncated or of a kind that is not read; the message names the file
/// and the place in it.
LitheStatus lth_volume_read(LitheCtx *ctx, const char *path, LthVolume **volume);

/// The same from bytes in memory; `format` is "nii", "nrrd", "mhd" or "png". Data in files of their own are not
/// opened: LITHE_BAD_INPUT.
LitheStatus lth_volume_parse(LitheCtx *ctx, const char *name, const char *format, const char *data,
                             size_t size, LthVolume **volume);
