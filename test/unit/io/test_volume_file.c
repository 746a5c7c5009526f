/// Volume files: every type in both byte orders, places in space, compressed and detached data, and what is
/// wrong with broken ones.
#include "check.h"
#include "scratch_folder.h"

#include "base/tensor.h"
#include "io/file.h"
#include "io/nifti_write.h"
#include "io/volume_file.h"

#include <string.h>
#include <zlib.h>

/// Bytes being put together.
typedef struct Bytes {
  char at[8192];
  size_t n;
} Bytes;

static void put(Bytes *b, const void *data, size_t n) {
  assert_true(b->n + n <= sizeof b->at);
  memcpy(b->at + b->n, data, n);
  b->n += n;
}

/// A number of n bytes in either order at a place; this machine's order is little endian.
static void set(Bytes *b, size_t at, const void *value, size_t n, bool is_big) {
  for (size_t i = 0; i < n; i++) b->at[at + i] = ((const char *)value)[is_big ? n - 1 - i : i];
}

static void set_i16(Bytes *b, size_t at, int value, bool is_big) {
  int16_t v = (int16_t)value;
  set(b, at, &v, 2, is_big);
}
static void set_f32(Bytes *b, size_t at, double value, bool is_big) {
  float v = (float)value;
  set(b, at, &v, 4, is_big);
}

/// Header of a 3 x 2 x 2 volume of `type` (NIfTI's code) with `bytes` a value, room for its data.
static void nifti(Bytes *b, int type, size_t bytes, bool is_big) {
  memset(b, 0, sizeof *b);
  int32_t header = 348;
  set(b, 0, &header, 4, is_big);
  static const int dims[] = {3, 3, 2, 2};
  for (size_t i = 0; i < 4; i++) set_i16(b, 40 + 2 * i, dims[i], is_big);
  set_i16(b, 70, type, is_big);
  static const double sizes[] = {1, 2, 3, 4};
  for (size_t i = 0; i < 4; i++) set_f32(b, 76 + 4 * i, sizes[i], is_big);
  set_f32(b, 108, 352, is_big);
  memcpy(b->at + 344, "n+1", 4);
  b->n = 352 + 12 * bytes;
}

static LthVolume *parse(LitheCtx *ctx, const char *format, const Bytes *b) {
  LthVolume *v = NULL;
  CHECK_OK(ctx, lth_volume_parse(ctx, "test", format, b->at, b->n, &v));
  return v;
}

#define SET_ALL(type, sign)                                                                        \
  for (size_t p = 0; p < 12; p++) {                                                                \
    type value = (type)((sign) * (type)(7 * p + 1));                                               \
    set(&b, 352 + p * sizeof(type), &value, sizeof(type), is_big);                                 \
  }

static void nifti_reads_all_types_in_both_orders(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const struct {
    int code;
    size_t bytes;
    int sign;
  } types[] = {{256, 1, -1}, {2, 1, 1},     {4, 2, -1},   {512, 2, 1}, {8, 4, -1},
               {768, 4, 1},  {1024, 8, -1}, {1280, 8, 1}, {16, 4, -1}, {64, 8, -1}};
  for (int t = 0; t < 10; t++)
    for (int is_big = 0; is_big < 2; is_big++) {
      Bytes b;
      nifti(&b, types[t].code, types[t].bytes, is_big);
      int sign = types[t].sign;
      if (types[t].code == 256) SET_ALL(int8_t, sign)
      if (types[t].code == 2) SET_ALL(uint8_t, sign)
      if (types[t].code == 4) SET_ALL(int16_t, sign)
      if (types[t].code == 512) SET_ALL(uint16_t, sign)
      if (types[t].code == 8) SET_ALL(int32_t, sign)
      if (types[t].code == 768) SET_ALL(uint32_t, sign)
      if (types[t].code == 1024) SET_ALL(int64_t, sign)
      if (types[t].code == 1280) SET_ALL(uint64_t, sign)
      if (types[t].code == 16) SET_ALL(float, (float)sign)
      if (types[t].code == 64) SET_ALL(double, sign)
      set_f32(&b, 112, 0.5, is_big);
      set_f32(&b, 116, 10, is_big);
      LthVolume *v = parse(ctx, "nii", &b);
      assert_int_equal(v->n[0] * 100 + v->n[1] * 10 + v->n[2], 322);
      for (int p = 0; p < 12; p++)
        assert_true(v->values[p] == (float)(10 + 0.5 * sign * (7 * p + 1)));
      lth_volume_destroy(ctx, &v);
    }
  lithe_ctx_destroy(&ctx);
}

/// World place of a voxel.
static void check_place(const LthVolume *v, double i, double j, double k, double x, double y,
                        double z) {
  double want[3] = {x, y, z}, voxel[3], in[3] = {i, j, k};
  for (int a = 0; a < 3; a++)
    CHECK_NEAR(v->to_world[4 * a] * i + v->to_world[4 * a + 1] * j + v->to_world[4 * a + 2] * k +
                   v->to_world[4 * a + 3],
               want[a], 1e-8);
  lth_volume_locate(v, want, voxel);
  for (int a = 0; a < 3; a++) CHECK_NEAR(voxel[a], in[a], 1e-5);
}

static void nifti_places_by_sform_then_qform_then_sizes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  Bytes b;
  nifti(&b, 2, 1, false);
  LthVolume *v = parse(ctx, "nii", &b);
  check_place(v, 2, 1, 1, 0.004, 0.003, 0.004); // no unit: mm
  lth_volume_destroy(ctx, &v);

  // a quarter turn about z, third axis reversed, in um
  set_i16(&b, 252, 1, false);
  set_f32(&b, 264, sqrt(0.5), false);
  set_f32(&b, 76, -1, false);
  set_f32(&b, 268, 100, false);
  b.at[123] = 3;
  v = parse(ctx, "nii", &b);
  check_place(v, 2, 1, 1, 97e-6, 4e-6, -4e-6);
  lth_volume_destroy(ctx, &v);

  // sheared, in m
  set_i16(&b, 254, 1, false);
  static const double rows[12] = {1, 0.5, 0, 10, 0, 2, 0, 20, 0.25, 0, 3, 30};
  for (size_t i = 0; i < 12; i++) set_f32(&b, 280 + 4 * i, rows[i], false);
  b.at[123] = 1;
  v = parse(ctx, "nii", &b);
  check_place(v, 2, 1, 1, 12.5, 22, 33.5);
  lth_volume_destroy(ctx, &v);
  lithe_ctx_destroy(&ctx);
}

/// gzip (window 31) or zlib (15).
static void pack(const Bytes *in, Bytes *out, int window) {
  z_stream z = {0};
  assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY), Z_OK);
  z.next_in = (Bytef *)(uintptr_t)in->at, z.avail_in = (uInt)in->n;
  z.next_out = (Bytef *)out->at + out->n, z.avail_out = (uInt)(sizeof out->at - out->n);
  assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
  out->n = sizeof out->at - z.avail_out;
  deflateEnd(&z);
}

static void check_values(const LthVolume *v) {
  for (int p = 0; p < 12; p++) assert_true(v->values[p] == (float)(3 * p));
}

static void compressed_text_and_raw_data_are_the_same(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  Bytes b, values = {.n = 0}, packed = {.n = 0};
  nifti(&b, 4, 2, false);
  for (int16_t p = 0; p < 12; p++) {
    int16_t value = (int16_t)(3 * p);
    set(&b, 352 + 2 * (size_t)p, &value, 2, false);
    put(&values, &value, 2);
  }
  pack(&b, &packed, 31);
  static const char nrrd[] = "NRRD0004\n# a comment\ntype: short\ndimension: 3\nsizes: 3 2 2\n"
                             "endian: little\nspace directions: (1,0,0) (0.5,2,0) (0,0,3)\n"
                             "space origin: (10,20,30)\nkey:=value\n";
  static const char meta[] = "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\n"
                             "ElementType = MET_SHORT\nElementSpacing = 1 2 3\nOffset = 10 20 30\n"
                             "TransformMatrix = 0 1 0 -1 0 0 0 0 1\n";
  for (int kind = 0; kind < 6; kind++) {
    Bytes file = {.n = 0};
    static const char *const tails[] = {NULL,
                                        "encoding: raw\n\n",
                                        "encoding: gzip\n\n",
                                        "encoding: ascii\n\n",
                                        "ElementDataFile = LOCAL\n",
                                        "CompressedData = True\nElementDataFile = LOCAL\n"};
    if (kind == 0) file = packed;
    if (kind >= 1 && kind <= 3) put(&file, nrrd, strlen(nrrd));
    if (kind >= 4) put(&file, meta, strlen(meta));
    if (kind > 0) put(&file, tails[kind], strlen(tails[kind]));
    if (kind == 1 || kind == 4) put(&file, values.at, values.n);
    if (kind == 2) pack(&values, &file, 31);
    if (kind == 5) pack(&values, &file, 15);
    for (int p = 0; kind == 3 && p < 12; p++) {
      char text[16];
      put(&file, text, (size_t)snprintf(text, sizeof text, "%d%s", 3 * p, p % 3 == 2 ? "\n" : " "));
    }
    LthVolume *v = parse(ctx, kind == 0 ? "nii" : kind < 4 ? "nrrd" : "mhd", &file);
    check_values(v);
    if (kind >= 1 && kind <= 3) check_place(v, 2, 1, 1, 12.5e-3, 22e-3, 33e-3);
    if (kind >= 4) check_place(v, 2, 1, 1, 8e-3, 22e-3, 33e-3); // x turns to y, y to -x
    lth_volume_destroy(ctx, &v);
  }
  lithe_ctx_destroy(&ctx);
}

static void write_file(const char *path, const char *data, size_t n) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(data, 1, n, file), n);
  fclose(file);
}

static void detached_data_are_found_beside_the_header(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char data[14] = {9, 9}, header[400], path[200];
  for (int p = 0; p < 12; p++) data[p + 2] = (char)(3 * p);
  snprintf(path, sizeof path, "%s/values.raw", folder);
  write_file(path, data, sizeof data);
  static const char *const texts[] = {
      "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nencoding: raw\nbyte skip: -1\n"
      "spacings: 1 1 1\ndata file: values.raw\n",
      "NDims = 3\nDimSize = 3 2 2\nHeaderSize = 2\nElementType = MET_UCHAR\n"
      "ElementDataFile = values.raw\n"};
  for (int k = 0; k < 2; k++) {
    snprintf(path, sizeof path, "%s/header.%s", folder, k ? "mhd" : "nhdr");
    snprintf(header, sizeof header, "%s", texts[k]);
    write_file(path, header, strlen(header));
    LthVolume *v = NULL;
    CHECK_OK(ctx, lth_volume_read(ctx, path, &v));
    check_values(v);
    lth_volume_destroy(ctx, &v);
    assert_int_equal(lth_volume_parse(ctx, "test", k ? "mhd" : "nrrd", header, strlen(header), &v),
                     LITHE_BAD_INPUT);
    assert_non_null(strstr(lithe_ctx_message(ctx), "values.raw"));
  }
  lithe_ctx_destroy(&ctx);
}

/// More than one group of pieces, the last one not full; the same bytes by any number of threads.
static void what_is_written_is_read_again(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  const LitheIndex n[3] = {171, 131, 101};
  const double to_world[12] = {0.001, 0, 0, 0.5, 0, 0.002, 0, -0.25, 0, 0, 0.001, 0};
  LitheCount count = (LitheCount)n[0] * n[1] * n[2];
  float *values = malloc((size_t)count * sizeof *values);
  uint64_t seed = 7;
  for (LitheCount i = 0; i < count; i++)
    values[i] = i % 3 ? 0 : (float)test_random(&seed); // most of a scan is nothing
  LthNiftiField field = {"pressure", 1, values};
  char *bytes[2], path[2][300];
  size_t size[2];
  for (int k = 0; k < 2; k++) {
    LthVolume *v = NULL;
    snprintf(path[k], sizeof path[k], "%s/p%d.nii.gz", folder, k);
    lth_set_threads(ctx, k ? 3 : 1);
    CHECK_OK(ctx, lth_nifti_write(ctx, path[k], n, to_world, &field));
    CHECK_OK(ctx, lth_volume_read(ctx, path[k], &v));
    assert_memory_equal(v->values, values, (size_t)count * sizeof *values);
    lth_volume_destroy(ctx, &v);
    CHECK_OK(ctx, lth_file_read(ctx, path[k], &bytes[k], &size[k]));
  }
  assert_int_equal(size[0], size[1]);
  assert_memory_equal(bytes[0], bytes[1], size[0]);
  gzFile again = gzopen(path[0], "rb"); // the whole stream with its checksum
  char part[4096];
  LitheCount there = 0;
  for (int got; (got = gzread(again, part, sizeof part)) > 0;) there += got;
  assert_int_equal(gzclose_r(again), Z_OK);
  assert_int_equal(there, 352 + 4 * count);
  for (int k = 0; k < 2; k++) lth_free(ctx, bytes[k]);
  free(values);
  lithe_ctx_destroy(&ctx);
}

static void expect_error(LitheCtx *ctx, const char *format, const char *data, size_t n,
                         const char *says) {
  LthVolume *v = NULL;
  assert_int_equal(lth_volume_parse(ctx, "test", format, data, n, &v), LITHE_BAD_INPUT);
  assert_null(v);
  if (!strstr(lithe_ctx_message(ctx), says))
    fail_msg("\"%s\" does not say \"%s\"", lithe_ctx_message(ctx), says);
  assert_int_equal(strncmp(lithe_ctx_message(ctx), "test:", 5), 0);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
}

static void broken_headers_and_short_data_are_told(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  Bytes b;
  nifti(&b, 16, 4, false);
  for (size_t n = 0; n < b.n; n += 25)
    expect_error(ctx, "nii", b.at, n, n < 348 ? "too short for a NIfTI-1 header" : "too early");
  b.at[0] = 12;
  expect_error(ctx, "nii", b.at, b.n, "no NIfTI-1 header");
  nifti(&b, 128, 4, false);
  expect_error(ctx, "nii", b.at, b.n, "at byte 70: values of type 128 (colours)");
  nifti(&b, 16, 4, false);
  set_i16(&b, 42, -3, false);
  expect_error(ctx, "nii", b.at, b.n, "-3 voxels along axis 1");
  set_i16(&b, 42, 30000, false), set_i16(&b, 44, 30000, false), set_i16(&b, 46, 30000, false);
  expect_error(ctx, "nii", b.at, b.n, "more than can be used");
  nifti(&b, 16, 4, false);
  set_i16(&b, 40, 4, false), set_i16(&b, 48, 5, false);
  expect_error(ctx, "nii", b.at, b.n, "5 volumes");
  nifti(&b, 16, 4, false);
  set_i16(&b, 254, 1, false);
  expect_error(ctx, "nii", b.at, b.n, "do not span space");
  Bytes packed = {.n = 0};
  nifti(&b, 16, 4, false);
  pack(&b, &packed, 31);
  expect_error(ctx, "nii", packed.at, packed.n / 2, "");
  packed.at[30] ^= 0x55;
  expect_error(ctx, "nii", packed.at, packed.n, "");

#define NRRD_ERROR(text, says) expect_error(ctx, "nrrd", text, sizeof text - 1, says)
  NRRD_ERROR("P5 3 3", "no NRRD file");
  NRRD_ERROR("NRRD0004\ntype: block\n\n", ":2: values of type \"block\"");
  NRRD_ERROR("NRRD0004\ntype: uchar\nsizes: 3 2 2\nencoding: bzip2\n\n", ":4: the encoding");
  NRRD_ERROR("NRRD0004\ntype: uchar\ndimension: 2\n\n", ":3: 2 dimensions");
  NRRD_ERROR("NRRD0004\ntype: short\nsizes: 3 2 2\nencoding: raw\n\n", "without the field endian");
  NRRD_ERROR("NRRD0004\ntype: uchar\nsizes: 3 2 2\nencoding: raw\n\n12345", "got 5 bytes");
  NRRD_ERROR("NRRD0004\ntype: uchar\nsizes: 1 1 3\nencoding: ascii\n\n1 two 3", "\"two\"");
  NRRD_ERROR("NRRD0004\nnonsense\n\n", ":2: no field");
#define META_ERROR(text, says) expect_error(ctx, "mhd", text, sizeof text - 1, says)
  META_ERROR("NDims = 3\nDimSize = 2 2\n", ":2: DimSize");
  META_ERROR("NDims = 3\nDimSize = 2 2 2\n", "without ElementDataFile");
  META_ERROR("DimSize = 2 2 2\nElementDataFile = LOCAL\n", "without ElementType");
  META_ERROR("DimSize = 2 2 2\nElementType = MET_UCHAR_ARRAY\n", ":2: values of type");
  META_ERROR("DimSize = 9 9 9\nElementType = MET_DOUBLE\nCompressedData = True\n"
             "ElementDataFile = LOCAL\nx",
             "");
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nifti_reads_all_types_in_both_orders),
      cmocka_unit_test(nifti_places_by_sform_then_qform_then_sizes),
      cmocka_unit_test(compressed_text_and_raw_data_are_the_same),
      cmocka_unit_test(detached_data_are_found_beside_the_header),
      cmocka_unit_test(what_is_written_is_read_again),
      cmocka_unit_test(broken_headers_and_short_data_are_told),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
