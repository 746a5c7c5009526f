/// PNG files by libpng: what is grey or coloured becomes one value a pixel, y upwards.
#include "io/volume_data.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#define CHUNK_MAX 8000000 ///< bytes of a chunk of text or palette
#define SIDE_MAX 100000   ///< pixels along a side

/// A file while it is read: all that must be freed, whatever libpng makes of it.
typedef struct PngFile {
  LitheCtx *ctx;
  const char *data;
  size_t size, at;
  png_structp png;
  png_infop info;
  png_bytep bytes; ///< of all rows
  png_bytepp rows;
  char message[120]; ///< of libpng
  bool is_out_of_memory;
} PngFile;

/// --- what libpng calls ---

static void take_bytes(png_structp png, png_bytep to, size_t n) {
  PngFile *f = png_get_io_ptr(png);
  if (n > f->size - f->at) png_error(png, "the file ends too early");
  memcpy(to, f->data + f->at, n);
  f->at += n;
}

static png_voidp take_memory(png_structp png, png_alloc_size_t size) {
  PngFile *f = png_get_mem_ptr(png);
  void *memory = lth_alloc(f->ctx, (LitheCount)size, 1);
  if (!memory) f->is_out_of_memory = true;
  return memory;
}

static void free_memory(png_structp png, png_voidp memory) {
  PngFile *f = png_get_mem_ptr(png);
  lth_free(f->ctx, memory);
}

static void keep_error(png_structp png, png_const_charp text) {
  PngFile *f = png_get_error_ptr(png);
  snprintf(f->message, sizeof f->message, "%s", text);
  png_longjmp(png, 1);
}

static void pass_over(png_structp png, png_const_charp text) { (void)png, (void)text; }

/// --- reading; libpng leaves these functions by longjmp ---

/// Everything to grey, colours or either with alpha, of 8 or 16 bits.
static void read_header(PngFile *f) {
  png_structp png = f->png;
  png_set_user_limits(png, SIDE_MAX, SIDE_MAX);
  png_set_chunk_malloc_max(png, CHUNK_MAX);
  png_set_read_fn(png, f, take_bytes);
  png_read_info(png, f->info);
  png_set_expand(png); // palettes, few bits, transparent colours
  png_set_interlace_handling(png);
  png_read_update_info(png, f->info);
}

static void read_pixels(PngFile *f) {
  png_read_image(f->png, f->rows);
  png_read_end(f->png, NULL);
}

/// Run one of the two; false where libpng gave up.
static bool succeeds(PngFile *f, void (*read)(PngFile *)) {
  if (setjmp(png_jmpbuf(f->png))) return false;
  read(f);
  return true;
}

static LitheStatus fail(PngFile *f, const char *name) {
  if (f->is_out_of_memory)
    LITHE_FAIL(f->ctx, LITHE_NO_MEMORY, "out of memory while reading %s", name);
  LITHE_FAIL(f->ctx, LITHE_BAD_INPUT, "%s: at byte %zu: no PNG image that can be read: %s", name,
             f->at, f->message[0] ? f->message : "it is broken");
}

static LitheStatus make_rows(PngFile *f, const char *name) {
  png_uint_32 height = png_get_image_height(f->png, f->info),
              width = png_get_image_width(f->png, f->info);
  size_t row = png_get_rowbytes(f->png, f->info);
  // deflate packs a thousand bytes into one at most
  double packed = (double)height * width * png_get_bit_depth(f->png, f->info) / 64 / 8;
  if (packed > 1100.0 * (double)f->size)
    LITHE_FAIL(f->ctx, LITHE_BAD_INPUT,
               "%s: its header promises %u x %u pixels, more than a file of %zu bytes can hold",
               name, width, height, f->size);
  LTH_NEW(f->ctx, f->bytes, (LitheCount)height * (LitheCount)row);
  LTH_NEW(f->ctx, f->rows, height);
  for (png_uint_32 j = 0; j < height; j++) f->rows[j] = f->bytes + (size_t)j * row;
  return LITHE_OK;
}

/// --- values ---

/// Luminance (ITU-R BT.709 weights on the values as stored) over black, as a whole number; up to 255 or 65535.
static float grey(const png_byte *pixel, int channels, int bytes) {
  double c[4] = {0};
  for (int i = 0; i < channels; i++)
    c[i] = bytes == 2 ? pixel[2 * i] * 256 + pixel[2 * i + 1] : pixel[i];
  double value = c[0], full = bytes == 2 ? 65535 : 255;
  if (channels >= 3) value += 0.7152 * (c[1] - c[0]) + 0.0722 * (c[2] - c[0]);
  if (channels == 2) value *= c[1] / full;
  if (channels == 4) value *= c[3] / full;
  return (float)floor(value + 0.5);
}

static LitheStatus convert(PngFile *f, LthVolume **volume) {
  const LitheIndex n[3] = {(LitheIndex)png_get_image_width(f->png, f->info),
                           (LitheIndex)png_get_image_height(f->png, f->info), 1};
  const double to_world[12] = {1e-3, 0, 0, 0.5e-3, 0, 1e-3, 0, 0.5e-3, 0, 0, 1, 0};
  int channels = png_get_channels(f->png, f->info);
  int bytes = png_get_bit_depth(f->png, f->info) == 16 ? 2 : 1;
  LITHE_TRY(lth_volume_create(f->ctx, n, to_world, volume));
  for (LitheIndex j = 0; j < n[1]; j++)
    for (LitheIndex i = 0; i < n[0]; i++)
      (*volume)->values[lth_volume_index(*volume, i, j, 0)] =
          grey(f->rows[n[1] - 1 - j] + (size_t)i * (size_t)(channels * bytes), channels, bytes);
  return LITHE_OK;
}

LitheStatus lth_png_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                          LthVolume **volume) {
  LitheStatus status = LITHE_OK;
  PngFile f = {.ctx = ctx, .data = data, .size = size};
  *volume = NULL;
  f.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &f, keep_error, pass_over, &f,
                                   take_memory, free_memory);
  if (f.png) f.info = png_create_info_struct(f.png);
  if (!f.info) {
    status = lth_fail(ctx, LITHE_NO_MEMORY, "out of memory while reading %s", name);
    goto done;
  }
  if (!succeeds(&f, read_header)) {
    status = fail(&f, name);
    goto done;
  }
  LITHE_TRY_OR(done, make_rows(&f, name));
  if (!succeeds(&f, read_pixels)) {
    status = fail(&f, name);
    goto done;
  }
  status = convert(&f, volume);
done:
  png_destroy_read_struct(f.png ? &f.png : NULL, f.info ? &f.info : NULL, NULL);
  lth_free(ctx, f.bytes);
  lth_free(ctx, f.rows);
  return status;
}
