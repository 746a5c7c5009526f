/// From the bytes behind a header to values.
#include "io/volume_data.h"

#include "io/bytes.h"
#include "io/file.h"

#include <math.h>
#include <stdlib.h>
#include <zlib.h>

#define INFLATE_RATIO_MAX 1100.0 ///< deflate packs a byte into no less than about 1/1032

size_t lth_voxel_bytes(LthVoxelType type) {
  static const size_t bytes[LTH_VOXEL_TYPES] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return bytes[type];
}

static double raw_value(LthVoxelType type, const char *at, bool is_big) {
  switch (type) {
  case LTH_VOXEL_I8:
    return (int8_t)*at;
  case LTH_VOXEL_U8:
    return (uint8_t)*at;
  case LTH_VOXEL_I16:
    return (int16_t)lth_bytes_unsigned(at, 2, is_big);
  case LTH_VOXEL_U16:
    return (double)lth_bytes_unsigned(at, 2, is_big);
  case LTH_VOXEL_I32:
    return (int32_t)lth_bytes_u32(at, is_big);
  case LTH_VOXEL_U32:
    return lth_bytes_u32(at, is_big);
  case LTH_VOXEL_I64:
    return (double)(int64_t)lth_bytes_unsigned(at, 8, is_big);
  case LTH_VOXEL_U64:
    return (double)lth_bytes_unsigned(at, 8, is_big);
  case LTH_VOXEL_F32:
    return (double)lth_bytes_f32(at, is_big);
  case LTH_VOXEL_F64:
  case LTH_VOXEL_TYPES:
    break;
  }
  return lth_bytes_f64(at, is_big);
}

static void convert(LitheCtx *ctx, const LthVolumeHeader *h, const char *data, LthVolume *v) {
  LitheCount n = lth_volume_size(v);
  size_t bytes = lth_voxel_bytes(h->type);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) if (n > 100000)
  for (LitheCount p = 0; p < n; p++)
    v->values[p] =
        (float)(h->slope * raw_value(h->type, data + (size_t)p * bytes, h->is_big_endian) +
                h->offset);
}

LitheStatus lth_inflate(LitheCtx *ctx, const char *name, const char *data, size_t size, char *out,
                        size_t want, size_t *got) {
  z_stream z = {0};
  *got = 0;
  if (inflateInit2(&z, 15 + 32) != Z_OK)
    LITHE_FAIL(ctx, LITHE_NO_MEMORY, "%s: out of memory for decompressing", name);
  int code = Z_OK;
  size_t taken = 0;
  while (*got < want && code == Z_OK) {
    size_t room = want - *got, left = size - taken;
    z.next_in = (Bytef *)(uintptr_t)(data + taken);
    z.avail_in = (uInt)(left < (1u << 30) ? left : 1u << 30);
    z.next_out = (Bytef *)(out + *got);
    z.avail_out = (uInt)(room < (1u << 30) ? room : 1u << 30);
    uInt in = z.avail_in, before = z.avail_out;
    code = inflate(&z, Z_NO_FLUSH);
    taken += in - z.avail_in;
    *got += before - z.avail_out;
    if (in == z.avail_in && before == z.avail_out) break;
  }
  inflateEnd(&z);
  if (code == Z_MEM_ERROR)
    LITHE_FAIL(ctx, LITHE_NO_MEMORY, "%s: out of memory for decompressing", name);
  if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: its compressed data are damaged near byte %zu of them, after %zu bytes", name,
               taken, *got);
  if (*got < want && code != Z_STREAM_END)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: its compressed data end too early, after %zu bytes of what they hold: the file "
               "is cut short; get it anew",
               name, *got);
  return LITHE_OK;
}

static LitheStatus fail_short(LitheCtx *ctx, const LthVolumeHeader *h, double want, size_t got) {
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s: its data end too early, got %zu bytes; expected %.0f for %.0f x %.0f x %.0f "
             "voxels of %zu bytes",
             h->name, got, want, h->n[0], h->n[1], h->n[2], lth_voxel_bytes(h->type));
}

static LitheStatus check_header(LitheCtx *ctx, const LthVolumeHeader *h) {
  for (int i = 0; i < 3; i++)
    if (!(h->n[i] >= 1 && h->n[i] <= 100000) || h->n[i] != floor(h->n[i]))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "%s: %.17g voxels along axis %d, expected a whole number from 1 to 100000",
                 h->name, h->n[i], i + 1);
  if (h->n[0] * h->n[1] * h->n[2] > LTH_VOXELS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: %.0f x %.0f x %.0f voxels are more than can be used (%d)",
               h->name, h->n[0], h->n[1], h->n[2], LTH_VOXELS_MAX);
  for (int i = 0; i < 12; i++)
    if (!isfinite(h->to_world[i]))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "%s: its place in space has an entry that is no number (row %d, column %d)",
                 h->name, i / 4 + 1, i % 4 + 1);
  if (!isfinite(h->slope) || !isfinite(h->offset))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: the scale of its values is no number, got %g and %g",
               h->name, h->slope, h->offset);
  return LITHE_OK;
}

/// Numbers as text, one after the other.
static LitheStatus parse_text(LitheCtx *ctx, const LthVolumeHeader *h, const char *data,
                              size_t size, LthVolume *v) {
  const char *at = data, *end = data + size;
  LitheCount n = lth_volume_size(v);
  for (LitheCount p = 0; p < n; p++) {
    while (at < end && (*at == ' ' || *at == '\n' || *at == '\t' || *at == '\r' || *at == ','))
      at++;
    char word[64];
    size_t length = 0;
    while (at < end && length + 1 < sizeof word && *at > ' ' && *at != ',') word[length++] = *at++;
    word[length] = 0;
    char *stop = NULL;
    double value = strtod(word, &stop);
    if (length == 0 || *stop)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: number %lld of %lld is \"%s\", expected a number",
                 h->name, (long long)p + 1, (long long)n, word);
    v->values[p] = (float)(h->slope * value + h->offset);
  }
  return LITHE_OK;
}

static LitheStatus unpack(LitheCtx *ctx, const LthVolumeHeader *h, const char *data, size_t size,
                          LthVolume *v) {
  LitheStatus status = LITHE_OK;
  char *raw = NULL;
  size_t need = (size_t)lth_volume_size(v) * lth_voxel_bytes(h->type), got = 0;
  LTH_NEW_OR(done, ctx, raw, (LitheCount)(need + h->skip));
  LITHE_TRY_OR(done, lth_inflate(ctx, h->name, data, size, raw, need + h->skip, &got));
  if (got < need + h->skip)
    LITHE_TRY_OR(done, fail_short(ctx, h, (double)need, got > h->skip ? got - h->skip : 0));
  convert(ctx, h, raw + h->skip, v);
done:
  lth_free(ctx, raw);
  return status;
}

/// Does so much data fit into the bytes there are? Told before memory is taken for it.
static LitheStatus check_size(LitheCtx *ctx, const LthVolumeHeader *h, size_t size) {
  double n = h->n[0] * h->n[1] * h->n[2], need = n * (double)lth_voxel_bytes(h->type);
  double there = size > h->skip ? (double)(size - h->skip) : 0;
  if (h->coding == LTH_CODING_RAW && there < need) return fail_short(ctx, h, need, (size_t)there);
  if (h->coding == LTH_CODING_TEXT && (double)size + 1 < 2 * n)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: %zu bytes of text cannot hold %.0f numbers", h->name,
               size, n);
  if (h->coding == LTH_CODING_ZLIB &&
      need + (double)h->skip > INFLATE_RATIO_MAX * ((double)size + 64))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: %zu compressed bytes cannot hold %.0f x %.0f x %.0f voxels", h->name, size,
               h->n[0], h->n[1], h->n[2]);
  return LITHE_OK;
}

static LitheStatus from_bytes(LitheCtx *ctx, const LthVolumeHeader *h, const char *data,
                              size_t size, LthVolume *v) {
  size_t skip = h->skip;
  switch (h->coding) {
  case LTH_CODING_TEXT:
    return parse_text(ctx, h, data, size, v);
  case LTH_CODING_ZLIB:
    return unpack(ctx, h, data, size, v);
  case LTH_CODING_RAW:
    break;
  }
  if (h->is_last) skip = size - (size_t)lth_volume_size(v) * lth_voxel_bytes(h->type);
  convert(ctx, h, data + skip, v);
  return LITHE_OK;
}

/// Bytes of the file beside the header.
static LitheStatus read_beside(LitheCtx *ctx, const LthVolumeHeader *h, char **data, size_t *size) {
  LitheStatus status = LITHE_OK;
  char *folder = NULL, *path = NULL;
  if (!h->path)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: its data are in another file, \"%s\"", h->name,
               h->data_file);
  LITHE_TRY(lth_copy_text(ctx, h->path, &folder));
  char *slash = strrchr(folder, '/');
  if (slash)
    slash[slash == folder] = 0;
  else
    strcpy(folder, folder[0] ? "." : "");
  LITHE_TRY_OR(done, lth_path_join(ctx, folder, h->data_file, &path));
  LITHE_TRY_OR(done, lth_file_read(ctx, path, data, size));
done:
  lth_free(ctx, folder);
  lth_free(ctx, path);
  return status;
}

LitheStatus lth_volume_from_data(LitheCtx *ctx, const LthVolumeHeader *h, const char *data,
                                 size_t size, LthVolume **volume) {
  LitheStatus status = LITHE_OK;
  LthVolume *v = NULL;
  char *beside = NULL;
  *volume = NULL;
  LITHE_TRY(check_header(ctx, h));
  if (h->data_file[0]) {
    LITHE_TRY(read_beside(ctx, h, &beside, &size));
    data = beside;
  }
  LITHE_TRY_OR(done, check_size(ctx, h, size));
  LitheIndex n[3] = {(LitheIndex)h->n[0], (LitheIndex)h->n[1], (LitheIndex)h->n[2]};
  status = lth_volume_create(ctx, n, h->to_world, &v);
  if (status == LITHE_BAD_INPUT) {
    char why[400];
    snprintf(why, sizeof why, "%s", lithe_ctx_message(ctx));
    status = lth_fail(ctx, LITHE_BAD_INPUT, "%s: %s", h->name, why);
  }
  if (status != LITHE_OK) goto done;
  LITHE_TRY_OR(done, from_bytes(ctx, h, data, size, v));
  *volume = v;
  v = NULL;
done:
  lth_volume_destroy(ctx, &v);
  lth_free(ctx, beside);
  return status;
}
