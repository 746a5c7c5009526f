/// NIfTI-1 files written: a header of 348 bytes, four of flags, then float values. Pieces of compressed ones are made side by side:
/// each ends at a whole byte and knows nothing of those before it, so that one behind the other they are one stream.
#include "io/nifti_write.h"

#include "base/tensor.h"
#include "io/bytes.h"
#include "io/file.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

#define HEADER_BYTES 352
#define AXIS_MAX 32767
#define PIECE 65536 // floats that are compressed together
#define GROUP 32    // pieces that are made side by side
#define LEVEL 1     // on floats, higher ones save some 3 % and take three times as long

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

/// Pieces in the making.
typedef struct Group {
  bool is_packed;
  LitheCount room; ///< of a packed piece
  unsigned char *plain, *packed;
  size_t size[GROUP], packed_size[GROUP];
  uLong crc[GROUP];
} Group;

/// Of all bytes so far.
typedef struct Sink {
  FILE *stream;
  uLong crc;
  uint64_t size;
  bool is_good;
} Sink;

/// Raw deflate up to a whole byte. False where zlib refuses.
static bool pack(const unsigned char *plain, size_t size, bool is_last, LitheCount room,
                 unsigned char *packed, size_t *packed_size) {
  z_stream z = {0};
  if (deflateInit2(&z, LEVEL, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK) return false;
  z.next_in = (Bytef *)(uintptr_t)plain;
  z.avail_in = (uInt)size;
  z.next_out = packed;
  z.avail_out = (uInt)room;
  int code = deflate(&z, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  *packed_size = (size_t)room - z.avail_out;
  bool is_done = code == (is_last ? Z_STREAM_END : Z_OK) && z.avail_in == 0 && z.avail_out > 0;
  deflateEnd(&z);
  return is_done;
}

/// Floats of the file from number `first` on, component by component.
static void fill(const LthNiftiField *field, LitheCount n, LitheCount first, LitheCount count,
                 unsigned char *to) {
  for (LitheCount i = first; i < first + count; i++, to += 4) {
    int k = (int)(i / n), from = field->components == 6 ? lower_triangle[k] : k;
    lth_bytes_put_f32(field->values[from * n + i % n], (char *)to);
  }
}

/// Pieces first ... first + count of the values (n voxels).
static bool make_pieces(LitheCtx *ctx, const LthNiftiField *field, LitheCount n, LitheCount first,
                        LitheCount count, Group *g) {
  LitheCount all = n * field->components;
  bool is_good = true;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(&& : is_good)
  for (LitheCount i = 0; i < count; i++) {
    LitheCount at = (first + i) * PIECE, floats = all - at < PIECE ? all - at : PIECE;
    unsigned char *plain = g->plain + i * 4 * PIECE;
    fill(field, n, at, floats, plain);
    g->size[i] = 4 * (size_t)floats;
    if (!g->is_packed) continue;
    g->crc[i] = crc32(0, plain, (uInt)g->size[i]);
    is_good = pack(plain, g->size[i], at + floats == all, g->room, g->packed + i * g->room,
                   &g->packed_size[i]) &&
              is_good;
  }
  return is_good;
}

static void put(Sink *s, const void *bytes, size_t n) {
  s->is_good = s->is_good && fwrite(bytes, 1, n, s->stream) == n;
}

static void put_pieces(Sink *s, const Group *g, LitheCount count) {
  for (LitheCount i = 0; i < count; i++) {
    if (!g->is_packed) {
      put(s, g->plain + i * 4 * PIECE, g->size[i]);
      continue;
    }
    put(s, g->packed + i * g->room, g->packed_size[i]);
    s->crc = crc32_combine(s->crc, g->crc[i], (z_off_t)g->size[i]);
    s->size += g->size[i];
  }
}

/// The header, with gzip's before it where the file is compressed.
static bool put_header(Sink *s, const char *header, Group *g) {
  static const unsigned char gzip[10] = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 4, 255};
  size_t packed_size;
  if (!g->is_packed) {
    put(s, header, HEADER_BYTES);
    return true;
  }
  put(s, gzip, sizeof gzip);
  s->crc = crc32(0, (const Bytef *)header, HEADER_BYTES);
  s->size = HEADER_BYTES;
  if (!pack((const unsigned char *)header, HEADER_BYTES, false, g->room, g->packed, &packed_size))
    return false;
  put(s, g->packed, packed_size);
  return true;
}

static void put_end(Sink *s, const Group *g) {
  char end[8];
  if (!g->is_packed) return;
  lth_bytes_put_u32((uint32_t)s->crc, end);
  lth_bytes_put_u32((uint32_t)s->size, end + 4);
  put(s, end, sizeof end);
}

static LitheStatus put_all(LitheCtx *ctx, Sink *s, const char *path, const char *header,
                           LitheCount n, const LthNiftiField *field, Group *g) {
  LitheCount n_pieces = (n * field->components + PIECE - 1) / PIECE;
  bool is_packed = put_header(s, header, g);
  for (LitheCount first = 0; is_packed && s->is_good && first < n_pieces; first += GROUP) {
    LitheCount count = n_pieces - first < GROUP ? n_pieces - first : GROUP;
    is_packed = make_pieces(ctx, field, n, first, count, g);
    put_pieces(s, g, count);
  }
  put_end(s, g);
  if (!is_packed) LITHE_FAIL(ctx, LITHE_NO_MEMORY, "%s: out of memory while compressing", path);
  if (!s->is_good) LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: cannot be written", path);
  return LITHE_OK;
}

static bool is_packed(const char *path) {
  size_t length = strlen(path);
  return length > 3 && strcmp(path + length - 3, ".gz") == 0;
}

static LitheStatus write_file(LitheCtx *ctx, const char *path, const char *header, LitheCount n,
                              const LthNiftiField *field, Group *g) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  Sink sink = {.stream = writer.stream, .is_good = true};
  LitheStatus status = put_all(ctx, &sink, path, header, n, field, g);
  if (status == LITHE_OK) return lth_file_commit(ctx, &writer);
  lth_file_abandon(ctx, &writer);
  return status;
}

LitheStatus lth_nifti_write(LitheCtx *ctx, const char *path, const LitheIndex n[3],
                            const double to_world[12], const LthNiftiField *field) {
  LitheStatus status = LITHE_OK;
  Group *g = NULL;
  char header[HEADER_BYTES];
  for (int a = 0; a < 3; a++)
    if (n[a] > AXIS_MAX)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: NIfTI-1 takes %d voxels along an axis, got %d", path,
                 AXIS_MAX, n[a]);
  make_header(n, to_world, field, header);
  LTH_NEW(ctx, g, 1);
  g->is_packed = is_packed(path);
  g->room = (LitheCount)compressBound(4 * PIECE) + 64;
  LTH_NEW_OR(done, ctx, g->plain, (LitheCount)GROUP * 4 * PIECE);
  if (g->is_packed) LTH_NEW_OR(done, ctx, g->packed, GROUP * g->room);
  status = write_file(ctx, path, header, (LitheCount)n[0] * n[1] * n[2], field, g);
done:
  lth_free(ctx, g->plain);
  lth_free(ctx, g->packed);
  lth_free(ctx, g);
  return status;
}
