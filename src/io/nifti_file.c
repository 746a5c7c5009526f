/// NIfTI-1 files: a header of 348 bytes, then the values.
#include "io/bytes.h"
#include "io/volume_data.h"

#include <math.h>
#include <stdio.h>

#define HEADER_BYTES 348
#define FIRST_DATA 352 ///< four bytes of extension flags lie between

static double number(const char *data, size_t at, bool is_big) {
  return (double)lth_bytes_f32(data + at, is_big);
}

static int small(const char *data, size_t at, bool is_big) {
  return (int16_t)lth_bytes_unsigned(data + at, 2, is_big);
}

static LitheStatus find_type(LitheCtx *ctx, const char *name, int code, LthVoxelType *type) {
  static const int codes[LTH_VOXEL_TYPES] = {256, 2, 4, 512, 8, 768, 1024, 1280, 16, 64};
  for (int t = 0; t < LTH_VOXEL_TYPES; t++)
    if (codes[t] == code) {
      *type = (LthVoxelType)t;
      return LITHE_OK;
    }
  const char *what = code == 32 || code == 1792 || code == 2048 ? " (complex numbers)"
                     : code == 128 || code == 2304              ? " (colours)"
                     : code == 1536                             ? " (long double)"
                                                                : "";
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s: at byte 70: values of type %d%s are not read; expected integers or floats", name,
             code, what);
}

/// dim: 3, or more with further lengths of 1.
static LitheStatus read_dims(LitheCtx *ctx, const char *data, bool is_big, LthVolumeHeader *h) {
  int n_dims = small(data, 40, is_big);
  if (n_dims < 1 || n_dims > 7)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: at byte 40: %d dimensions, expected 3", h->name, n_dims);
  for (int i = 0; i < 3; i++) h->n[i] = i < n_dims ? small(data, 42 + 2 * (size_t)i, is_big) : 1;
  for (int i = 3; i < n_dims; i++) {
    int n = small(data, 42 + 2 * (size_t)i, is_big);
    if (n > 1)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "%s: at byte %d: it holds %d volumes along dimension %d, expected one", h->name,
                 42 + 2 * i, n, i + 1);
  }
  return LITHE_OK;
}

/// Rotation of the quaternion (a, b, c, d) with a >= 0, voxel sizes, third axis by qfac.
static void quaternion_map(const char *data, bool is_big, double A[12]) {
  double b = number(data, 256, is_big), c = number(data, 260, is_big),
         d = number(data, 264, is_big), a = sqrt(fmax(0, 1 - b * b - c * c - d * d));
  double length = sqrt(a * a + b * b + c * c + d * d);
  a /= length, b /= length, c /= length, d /= length;
  double R[9] = {
      a * a + b * b - c * c - d * d, 2 * (b * c - a * d),           2 * (b * d + a * c),
      2 * (b * c + a * d),           a * a + c * c - b * b - d * d, 2 * (c * d - a * b),
      2 * (b * d - a * c),           2 * (c * d + a * b),           a * a + d * d - b * b - c * c};
  for (int j = 0; j < 3; j++) {
    double size = fabs(number(data, 80 + 4 * (size_t)j, is_big));
    if (j == 2 && number(data, 76, is_big) < 0) size = -size;
    for (int i = 0; i < 3; i++) A[4 * i + j] = R[3 * i + j] * size;
  }
  for (size_t i = 0; i < 3; i++) A[4 * i + 3] = number(data, 268 + 4 * i, is_big);
}

/// sform, else qform, else voxel sizes alone; in the file's units.
static void read_place(const char *data, bool is_big, double A[12]) {
  memset(A, 0, 12 * sizeof *A);
  if (small(data, 254, is_big) > 0) {
    for (size_t i = 0; i < 12; i++) A[i] = number(data, 280 + 4 * i, is_big);
  } else if (small(data, 252, is_big) > 0) {
    quaternion_map(data, is_big, A);
  } else {
    for (size_t i = 0; i < 3; i++) {
      double size = fabs(number(data, 80 + 4 * i, is_big));
      A[5 * i] = size > 0 ? size : 1;
    }
  }
}

static LitheStatus read_header(LitheCtx *ctx, const char *data, LthVolumeHeader *h) {
  bool is_big = lth_bytes_u32(data, false) != HEADER_BYTES;
  if (is_big && lth_bytes_u32(data, true) != HEADER_BYTES) {
    bool is_two = lth_bytes_u32(data, false) == 540 || lth_bytes_u32(data, true) == 540;
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: at byte 0: %s", h->name,
               is_two ? "NIfTI-2 is not read, expected NIfTI-1"
                      : "no NIfTI-1 header, expected one of 348 bytes");
  }
  h->is_big_endian = is_big;
  if (memcmp(data + 344, "ni1", 4) == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: at byte 344: its values are in a file of their own (.img), expected one file",
               h->name);
  if (memcmp(data + 344, "n+1", 4) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: at byte 344: no NIfTI-1 file, expected \"n+1\"", h->name);
  LITHE_TRY(read_dims(ctx, data, is_big, h));
  LITHE_TRY(find_type(ctx, h->name, small(data, 70, is_big), &h->type));
  double offset = number(data, 108, is_big), slope = number(data, 112, is_big);
  if (!(offset >= 0 && offset <= 1e9))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: at byte 108: values begin at byte %g, expected %d or more", h->name, offset,
               FIRST_DATA);
  h->skip = offset > FIRST_DATA ? (size_t)offset : FIRST_DATA;
  h->slope = slope != 0 ? slope : 1;
  h->offset = slope != 0 ? number(data, 116, is_big) : 0;
  read_place(data, is_big, h->to_world);
  int unit = data[123] & 7;
  double factor = unit == 1 ? 1 : unit == 3 ? 1e-6 : 1e-3;
  for (int i = 0; i < 12; i++) h->to_world[i] *= factor;
  return LITHE_OK;
}

LitheStatus lth_nifti_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                            LthVolume **volume) {
  LthVolumeHeader h = {.name = name};
  char head[HEADER_BYTES];
  size_t got = size;
  bool is_packed = size >= 2 && (uint8_t)data[0] == 0x1f && (uint8_t)data[1] == 0x8b;
  *volume = NULL;
  if (is_packed) {
    LITHE_TRY(lth_inflate(ctx, name, data, size, head, HEADER_BYTES, &got));
    h.coding = LTH_CODING_ZLIB;
  }
  const char *ending = strrchr(name, '.');
  bool is_plain = size >= HEADER_BYTES && data[344] == 'n';
  if (!is_packed && !is_plain && ending && strcmp(ending, ".gz") == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: not compressed by gzip, which its name says; rename it or compress it", name);
  if (got < HEADER_BYTES)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: too short for a NIfTI-1 header, got %zu bytes; expected at least %d", name, got,
               HEADER_BYTES);
  if (!is_packed) memcpy(head, data, HEADER_BYTES);
  LITHE_TRY(read_header(ctx, head, &h));
  return lth_volume_from_data(ctx, &h, data, size, volume);
}
