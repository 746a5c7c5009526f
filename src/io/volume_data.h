/// What readers of volumes share: types of numbers, compressed data, files beside a header.
#pragma once

#include "geometry/volume.h"

typedef enum LthVoxelType {
  LTH_VOXEL_I8,
  LTH_VOXEL_U8,
  LTH_VOXEL_I16,
  LTH_VOXEL_U16,
  LTH_VOXEL_I32,
  LTH_VOXEL_U32,
  LTH_VOXEL_I64,
  LTH_VOXEL_U64,
  LTH_VOXEL_F32,
  LTH_VOXEL_F64,
  LTH_VOXEL_TYPES
} LthVoxelType;

typedef enum LthVoxelCoding { LTH_CODING_RAW, LTH_CODING_ZLIB, LTH_CODING_TEXT } LthVoxelCoding;

/// What a header says of the volume behind it.
typedef struct LthVolumeHeader {
  const char *name;    ///< for messages
  const char *path;    ///< of the header: what other files are relative to; NULL: none are opened
  double n[3];         ///< voxels, as read
  double to_world[12]; ///< [m]
  LthVoxelType type;
  bool is_big_endian;
  LthVoxelCoding coding; ///< zlib: also gzip
  double slope, offset;  ///< value = slope raw + offset
  size_t skip;           ///< bytes before the data, after decompression
  bool is_last;          ///< the data are the last bytes of the file, whatever is before them
  char data_file[1024];  ///< empty: the data are in the header's file
} LthVolumeHeader;

/// Bytes of one number.
size_t lth_voxel_bytes(LthVoxelType type);

/// Check what the header says, find the data (at `data`, `size` bytes, where data_file is empty), convert.
LitheStatus lth_volume_from_data(LitheCtx *ctx, const LthVolumeHeader *header, const char *data,
                                 size_t size, LthVolume **volume);

/// Decompress up to `want` bytes of gzip or zlib data into `out`; *got says how many came.
LitheStatus lth_inflate(LitheCtx *ctx, const char *name, const char *data, size_t size, char *out,
                        size_t want, size_t *got);

/// The readers; `data` has a 0 behind its end.
LitheStatus lth_nifti_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                            LthVolume **volume);
LitheStatus lth_nrrd_parse(LitheCtx *ctx, const char *name, const char *path, const char *data,
                           size_t size, LthVolume **volume);
LitheStatus lth_png_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                          LthVolume **volume);
LitheStatus lth_mhd_parse(LitheCtx *ctx, const char *name, const char *path, const char *data,
                          size_t size, LthVolume **volume);
