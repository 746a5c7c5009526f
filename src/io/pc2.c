/// PC2 point caches, as Blender's Mesh Cache modifier reads them.
///
/// Layout, little endian: "POINTCACHE2\0", int32 version 1, int32 points, float32 start, float32 sample
/// rate, int32 samples; then float32 x y z of every point, sample after sample. Start is 0 and the rate is
/// the time between samples in seconds; in the modifier's frame mode one sample is one frame.
#include "io/pc2.h"

#include "io/file.h"

#include "io/bytes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define HEADER_BYTES 32
#define SAMPLES_AT 28
#define BATCH_POINTS 4096

struct LthPc2 {
  FILE *stream;
  char *path;
  LitheIndex n_points;
  int32_t n_samples;
};

static off_t frame_end(const LthPc2 *pc2, int32_t samples) {
  return HEADER_BYTES + (off_t)12 * pc2->n_points * samples;
}

/// Take back a torn frame: the header still counts the whole ones only.
static LitheStatus fail_writing(LitheCtx *ctx, LthPc2 *pc2) {
  int reason = errno;
  bool is_whole = ftruncate(fileno(pc2->stream), frame_end(pc2, pc2->n_samples)) == 0;
  LITHE_FAIL(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s%s", pc2->path, strerror(reason),
             is_whole ? "" : " (bytes after the last whole frame remain)");
}

static void release(LitheCtx *ctx, LthPc2 **pc2) {
  if ((*pc2)->stream) fclose((*pc2)->stream);
  lth_free(ctx, (*pc2)->path);
  lth_free(ctx, *pc2);
  *pc2 = NULL;
}

/// `mode` of fopen(): "wb" for a new file, "r+b" for one that is there.
static LitheStatus create(LitheCtx *ctx, const char *path, LitheIndex n_points, const char *mode,
                          LthPc2 **pc2) {
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, *pc2, 1);
  (*pc2)->n_points = n_points;
  LITHE_TRY_OR(failed, lth_copy_text(ctx, path, &(*pc2)->path));
  LITHE_TRY_OR(failed, lth_stream_open(ctx, path, mode, &(*pc2)->stream));
  return LITHE_OK;
failed:
  release(ctx, pc2);
  return status;
}

LitheStatus lth_pc2_open(LitheCtx *ctx, const char *path, LitheIndex n_points, double dt,
                         LthPc2 **pc2) {
  char header[HEADER_BYTES] = "POINTCACHE2";
  lth_bytes_put_u32(1, header + 12);
  lth_bytes_put_u32((uint32_t)n_points, header + 16);
  lth_bytes_put_f32(0, header + 20);
  lth_bytes_put_f32((float)dt, header + 24);
  lth_bytes_put_u32(0, header + SAMPLES_AT);

  LITHE_TRY(create(ctx, path, n_points, "wb", pc2));
  if (fwrite(header, 1, HEADER_BYTES, (*pc2)->stream) == HEADER_BYTES &&
      fflush((*pc2)->stream) == 0)
    return LITHE_OK;
  lth_fail(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", path, strerror(errno));
  release(ctx, pc2);
  return LITHE_NO_SPACE;
}

LitheStatus lth_pc2_reopen(LitheCtx *ctx, const char *path, LitheIndex n_points, LthPc2 **pc2) {
  return create(ctx, path, n_points, "r+b", pc2);
}

static bool put_points(LthPc2 *pc2, const double *points) {
  char batch[12 * BATCH_POINTS];
  for (LitheIndex begin = 0; begin < pc2->n_points; begin += BATCH_POINTS) {
    LitheIndex n = pc2->n_points - begin < BATCH_POINTS ? pc2->n_points - begin : BATCH_POINTS;
    for (LitheIndex i = 0; i < 3 * n; i++)
      lth_bytes_put_f32((float)points[3 * (LitheCount)begin + i], batch + 4 * i);
    if (fwrite(batch, 12, (size_t)n, pc2->stream) != (size_t)n) return false;
  }
  return fflush(pc2->stream) == 0;
}

static bool put_count(LthPc2 *pc2, int32_t n_samples) {
  char bytes[4];
  lth_bytes_put_u32((uint32_t)n_samples, bytes);
  return fseeko(pc2->stream, SAMPLES_AT, SEEK_SET) == 0 && fwrite(bytes, 1, 4, pc2->stream) == 4 &&
         fflush(pc2->stream) == 0;
}

LitheStatus lth_pc2_append(LitheCtx *ctx, LthPc2 *pc2, const double *points) {
  // the points first, the count after them: at any moment the header tells whole frames only
  if (fseeko(pc2->stream, frame_end(pc2, pc2->n_samples), SEEK_SET) != 0 ||
      !put_points(pc2, points) || !put_count(pc2, pc2->n_samples + 1))
    return fail_writing(ctx, pc2);
  pc2->n_samples++;
  return LITHE_OK;
}

void lth_pc2_archive(LthPc2 *pc2, LthArchive *archive) {
  LTH_ARCHIVE(archive, pc2->n_samples);
  if (!archive->is_reading || archive->status != LITHE_OK) return;
  off_t end = frame_end(pc2, pc2->n_samples);
  if (fseeko(pc2->stream, 0, SEEK_END) != 0 || ftello(pc2->stream) < end)
    archive->status = lth_fail(archive->ctx, LITHE_BAD_INPUT,
                               "%s has become shorter since; run the scene anew", pc2->path);
  else if (!put_count(pc2, pc2->n_samples) || ftruncate(fileno(pc2->stream), end) != 0)
    archive->status = lth_fail(archive->ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", pc2->path,
                               strerror(errno));
}

LitheStatus lth_pc2_close(LitheCtx *ctx, LthPc2 **pc2) {
  if (!*pc2) return LITHE_OK;
  LitheStatus status = LITHE_OK;
  bool is_closed = fclose((*pc2)->stream) == 0;
  (*pc2)->stream = NULL;
  if (!is_closed)
    status =
        lth_fail(ctx, LITHE_NO_SPACE, "%s: cannot be written: %s", (*pc2)->path, strerror(errno));
  release(ctx, pc2);
  return status;
}
