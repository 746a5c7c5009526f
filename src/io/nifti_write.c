/// NIfTI-1 files written: a header of 348 bytes, four of flags, then float values.
#include "io/nifti_write.h"

#include "base/tensor.h"
#include "io/bytes.h"
#include "io/file.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

#define HEADER_BYTES 352
#define AXIS_MAX 32767
#define CHUNK 65536 // floats

/// The row-major lower triangle of a symmetric tensor among ours (xx yy zz yz zx xy).
static const int lower_triangle[6] = {0, 5, 1, 4, 3, 2};

static void put_small(int value, char *at) {
  at[0] = (char)(value & 0xff);
  at[1] = (char)(value >> 8 & 0xff);
}

/// Quaternion (b, c, d) of a rotation, by its largest part; a >= 0.
static void quaternion(const double R[9], double q[3]) {
  double trace[4] = {R[0] + R[4] + R[8], R[0], R[4], R[8]}, v[4];
  int k = 0;
  for (int i = 1; i < 4; i++)
    if (2 * trace[i] - trace[0] > (k == 0 ? trace[0] : 2 * trace[k] - trace[0])) k = i;
  if (k == 0) {
    v[0] = 1 + trace[0];
    v[1] = R[7] - R[5], v[2] = R[2] - R[6], v[3] = R[3] - R[1];
  } else {
    int i = k - 1, j = (i + 1) % 3, l = (i + 2) % 3;
    v[0] = R[3 * l + j] - R[3 * j + l];
    v[1 + i] = 1 + R[4 * i] - R[4 * j] - R[4 * l];
    v[1 + j] = R[3 * j + i] + R[3 * i + j];
    v[1 + l] = R[3 * l + i] + R[3 * i + l];
  }
  double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  for (int i = 0; i < 3; i++) q[i] = v[i + 1] / (v[0] < 0 ? -length : length);
}

/// The qform says no more than lengths and a rotation; without one where the axes are not at right angles.
static void put_rotation(const double A[12], char *h) {
  double R[9], q[3], size[3];
  for (int j = 0; j < 3; j++) {
    size[j] = sqrt(A[j] * A[j] + A[4 + j] * A[4 + j] + A[8 + j] * A[8 + j]);
    for (int i = 0; i < 3; i++) R[3 * i + j] = A[4 * i + j] / size[j];
    lth_bytes_put_f32((float)(1000 * size[j]), h + 80 + 4 * j);
  }
  double sign = lth_m3_det(R) < 0 ? -1 : 1;
  lth_bytes_put_f32((float)sign, h + 76);
  for (int i = 0; i < 3; i++) R[3 * i + 2] *= sign;
  for (int i = 0; i < 3; i++)
    for (int j = i + 1; j < 3; j++)
      if (fabs(R[i] * R[j] + R[3 + i] * R[3 + j] + R[6 + i] * R[6 + j]) > 1e-6) return;
  put_small(1, h + 252);
  quaternion(R, q);
  for (int i = 0; i < 3; i++) lth_bytes_put_f32((float)q[i], h + 256 + 4 * i);
  for (int i = 0; i < 3; i++) lth_bytes_put_f32((float)(1000 * A[4 * i + 3]), h + 268 + 4 * i);
}

static void make_header(const LitheIndex n[3], const double A[12], const LthNiftiField *field,
                        char h[HEADER_BYTES]) {
  memset(h, 0, HEADER_BYTES);
  lth_bytes_put_u32(348, h);
  put_small(field->components > 1 ? 5 : 3, h + 40);
  for (int a = 0; a < 7; a++) put_small(a < 3 ? n[a] : 1, h + 42 + 2 * a);
  put_small(field->components, h + 50);
  put_small(field->components == 3 ? 1007 : field->components == 6 ? 1005 : 0, h + 68);
  if (field->components == 6) lth_bytes_put_f32(3, h + 56); // rows of the matrix
  put_small(16, h + 70);                                    // float
  put_small(32, h + 72);
  lth_bytes_put_f32(HEADER_BYTES, h + 108);
  lth_bytes_put_f32(1, h + 112);
  h[123] = 2; // millimetres
  put_rotation(A, h);
  put_small(2, h + 254);
  for (int i = 0; i < 12; i++) lth_bytes_put_f32((float)(1000 * A[i]), h + 280 + 4 * i);
  strncpy(h + 328, field->name, 15);
  memcpy(h + 344, "n+1", 4);
}

/// A stream of bytes, compressed or not.
typedef struct Sink {
  FILE *stream;
  z_stream *zip; ///< NULL: plain
  unsigned char packed[CHUNK];
  bool is_good;
} Sink;

static void put_bytes(Sink *s, const void *bytes, size_t n, bool is_last) {
  if (!s->zip) {
    s->is_good = s->is_good && fwrite(bytes, 1, n, s->stream) == n;
    return;
  }
  s->zip->next_in = (Bytef *)(uintptr_t)bytes;
  s->zip->avail_in = (uInt)n;
  do {
    s->zip->next_out = s->packed;
    s->zip->avail_out = sizeof s->packed;
    if (deflate(s->zip, is_last ? Z_FINISH : Z_NO_FLUSH) == Z_STREAM_ERROR) s->is_good = false;
    size_t made = sizeof s->packed - s->zip->avail_out;
    s->is_good = s->is_good && fwrite(s->packed, 1, made, s->stream) == made;
  } while (s->is_good && s->zip->avail_out == 0);
}

static void put_values(Sink *s, LitheCount n, const LthNiftiField *field) {
  char chunk[4 * 4096];
  for (int k = 0; k < field->components; k++) {
    int from = field->components == 6 ? lower_triangle[k] : k;
    const float *values = field->values + from * n;
    for (LitheCount i = 0; i < n; i += 4096) {
      LitheCount m = n - i < 4096 ? n - i : 4096;
      for (LitheCount j = 0; j < m; j++) lth_bytes_put_f32(values[i + j], chunk + 4 * j);
      put_bytes(s, chunk, 4 * (size_t)m, k == field->components - 1 && i + m == n);
    }
  }
}

static LitheStatus put_all(LitheCtx *ctx, Sink *s, const char *path, const char *header,
                           LitheCount n, const LthNiftiField *field) {
  put_bytes(s, header, HEADER_BYTES, false);
  put_values(s, n, field);
  if (!s->is_good) LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: cannot be written", path);
  return LITHE_OK;
}

static bool is_packed(const char *path) {
  size_t length = strlen(path);
  return length > 3 && strcmp(path + length - 3, ".gz") == 0;
}

LitheStatus lth_nifti_write(LitheCtx *ctx, const char *path, const LitheIndex n[3],
                            const double to_world[12], const LthNiftiField *field) {
  LthFileWriter writer;
  Sink *sink = NULL;
  z_stream zip = {0};
  char header[HEADER_BYTES];
  for (int a = 0; a < 3; a++)
    if (n[a] > AXIS_MAX)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: NIfTI-1 takes %d voxels along an axis, got %d", path,
                 AXIS_MAX, n[a]);
  make_header(n, to_world, field, header);
  LTH_NEW(ctx, sink, 1);
  LitheStatus status = lth_file_open(ctx, path, &writer);
  if (status != LITHE_OK) {
    lth_free(ctx, sink);
    return status;
  }
  *sink = (Sink){.stream = writer.stream, .zip = is_packed(path) ? &zip : NULL, .is_good = true};
  // 16 + 15: a gzip header around a window of 32 KiB
  if (sink->zip && deflateInit2(&zip, 1, Z_DEFLATED, 16 + 15, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    status = lth_fail(ctx, LITHE_NO_MEMORY, "%s: out of memory while compressing", path);
  else
    status = put_all(ctx, sink, path, header, (LitheCount)n[0] * n[1] * n[2], field);
  if (sink->zip) deflateEnd(&zip);
  lth_free(ctx, sink);
  if (status == LITHE_OK) return lth_file_commit(ctx, &writer);
  lth_file_abandon(ctx, &writer);
  return status;
}
