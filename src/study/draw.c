/// Drawings as SVG text: panels with places in metres, fills, lines, words, images.
#include "study/draw.h"

#include "io/xml_tag.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

static bool reserve(LthDrawing *d, LitheCount more) {
  if (d->failed) return false;
  d->failed = lth_reserve_(d->ctx, (void **)&d->text, &d->cap, d->n + more + 1, 1) != LITHE_OK;
  return !d->failed;
}

static void put(LthDrawing *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(LthDrawing *d, const char *format, ...) {
  va_list args, again;
  va_start(args, format);
  va_copy(again, args);
  int length = vsnprintf(NULL, 0, format, args);
  va_end(args);
  if (length > 0 && reserve(d, length)) {
    vsnprintf(d->text + d->n, (size_t)length + 1, format, again);
    d->n += length;
  }
  va_end(again);
}

void lth_draw_begin(LthDrawing *d, double width, double height) {
  put(d,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.6g %.6g\" width=\"%.6g\" "
      "height=\"%.6g\" font-family=\"Helvetica,Arial,sans-serif\" font-size=\"13\">"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
      width, height, width, height);
}

const char *lth_draw_end(LthDrawing *d, LthArena *arena) {
  put(d, "</svg>");
  const char *text = d->failed ? NULL : lth_arena_text(arena, d->text, (size_t)d->n);
  arena->failed = arena->failed || d->failed;
  lth_free(d->ctx, d->text);
  *d = (LthDrawing){.ctx = d->ctx};
  return text;
}

double lth_draw_panel(LthDrawing *d, const double box[4], double left, double top, double width) {
  d->left = left;
  d->top = top;
  d->scale = width / (box[2] - box[0]);
  d->corner[0] = box[0];
  d->corner[1] = box[1];
  d->height = d->scale * (box[3] - box[1]);
  return d->height;
}

static double page_x(const LthDrawing *d, const double at[2]) {
  return d->left + d->scale * (at[0] - d->corner[0]);
}
static double page_y(const LthDrawing *d, const double at[2]) {
  return d->top + d->height - d->scale * (at[1] - d->corner[1]);
}

void lth_draw_area_begin(LthDrawing *d, const char *fill) {
  put(d, "<path transform=\"scale(.1)\" fill=\"%s\" stroke=\"%s\" stroke-width=\"3\" d=\"", fill,
      fill);
}

/// In whole tenths of a pixel, each corner by its way from the one before: thousands of cells have to stay a small file.
void lth_draw_area_add(LthDrawing *d, int n, const double *xy) {
  long before[2] = {0, 0};
  for (int i = 0; i < n; i++) {
    const double *at = xy + 2 * (size_t)i;
    long x = lround(10 * page_x(d, at)), y = lround(10 * page_y(d, at));
    put(d, i == 0 ? "M%ld %ld" : i == 1 ? "l%ld %ld" : " %ld %ld", x - before[0], y - before[1]);
    before[0] = x;
    before[1] = y;
  }
  put(d, "z");
}

void lth_draw_area_end(LthDrawing *d) { put(d, "\"/>\n"); }

void lth_draw_line(LthDrawing *d, const double from[2], const double to[2], double width,
                   const char *colour) {
  put(d, "<path d=\"M%.2f %.2fL%.2f %.2f\" stroke=\"%s\" stroke-width=\"%.3g\"/>\n",
      page_x(d, from), page_y(d, from), page_x(d, to), page_y(d, to), colour, width);
}

void lth_draw_dot(LthDrawing *d, const double at[2], double radius, const char *fill) {
  put(d,
      "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%.3g\" fill=\"%s\" stroke=\"#000000\" "
      "stroke-width=\".5\"/>\n",
      page_x(d, at), page_y(d, at), radius, fill);
}

void lth_draw_words(LthDrawing *d, double x, double y, const char *words) {
  put(d, "<text x=\"%.6g\" y=\"%.6g\">", x, y);
  for (; *words; words++) {
    const char *entity = lth_xml_entity(*words);
    put(d, entity ? "%s" : "%.1s", entity ? entity : words);
  }
  put(d, "</text>\n");
}

/// From nearly black over red-violet and orange to pale yellow: every channel a quadratic, lightness rising.
void lth_colour_bytes(double value, uint8_t rgb[3]) {
  double s = value > 0 ? (value < 1 ? value : 1) : 0;
  double red = 0.05 + 1.75 * s - 0.82 * s * s, green = 0.03 + 0.1 * s + 0.84 * s * s,
         blue = 0.15 + 1.5 * s * (1 - s) * (1 - s) + 0.45 * s * s * s;
  double c[3] = {red, green, blue};
  for (int i = 0; i < 3; i++) rgb[i] = (uint8_t)(255 * fmin(fmax(c[i], 0), 1) + 0.5);
}

const char *lth_colour(double value, char text[LTH_COLOUR_MAX]) {
  uint8_t rgb[3];
  lth_colour_bytes(value, rgb);
  snprintf(text, LTH_COLOUR_MAX, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text;
}

void lth_draw_bar(LthDrawing *d, double x, double y, double height, const char *title, double low,
                  double high) {
  char colour[LTH_COLOUR_MAX], words[40];
  for (int i = 0; i < 64; i++)
    put(d, "<rect x=\"%.6g\" y=\"%.2f\" width=\"14\" height=\"%.2f\" fill=\"%s\"/>\n", x,
        y + height * (63 - i) / 64, height / 64 + 0.3, lth_colour((i + 0.5) / 64, colour));
  snprintf(words, sizeof words, "%.3g", high);
  lth_draw_words(d, x + 18, y + 11, words);
  snprintf(words, sizeof words, "%.3g", low);
  lth_draw_words(d, x + 18, y + height, words);
  lth_draw_words(d, x, y - 6, title);
}

// --- a PNG file in memory, as text ---

static void put_base64(LthDrawing *d, const uint8_t *bytes, LitheCount n) {
  static const char letter[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (!reserve(d, (n + 2) / 3 * 4)) return;
  for (LitheCount i = 0; i < n; i += 3) {
    uint32_t three = (uint32_t)bytes[i] << 16 | (i + 1 < n ? (uint32_t)bytes[i + 1] << 8 : 0) |
                     (i + 2 < n ? bytes[i + 2] : 0);
    for (int k = 0; k < 4; k++)
      d->text[d->n++] = i + k <= n ? letter[three >> (18 - 6 * k) & 63] : '=';
  }
  d->text[d->n] = 0;
}

static uint8_t *put_word(uint8_t *at, uint32_t word) {
  for (int k = 0; k < 4; k++) *at++ = (uint8_t)(word >> (24 - 8 * k));
  return at;
}

/// Length, name, data and check sum of a chunk whose data stand at `at` + 8 already.
static uint8_t *end_chunk(uint8_t *at, const char name[4], uint32_t length) {
  put_word(at, length);
  memcpy(at + 4, name, 4);
  uint32_t sum = (uint32_t)crc32(0, at + 4, length + 4);
  return put_word(at + 8 + length, sum);
}

/// Rows with a filter byte of 0 in front, compressed between the chunks that PNG wants.
static LitheStatus make_png(LitheCtx *ctx, int w, int h, const uint8_t *rgb, uint8_t **png,
                            LitheCount *size) {
  static const uint8_t signature[8] = {137, 'P', 'N', 'G', 13, 10, 26, 10};
  size_t row = 3 * (size_t)w, raw_size = (row + 1) * (size_t)h;
  uLongf packed = compressBound((uLong)raw_size);
  uint8_t *raw;
  *png = NULL;
  LTH_NEW(ctx, raw, (LitheCount)raw_size);
  for (int j = 0; j < h; j++) memcpy(raw + (row + 1) * (size_t)j + 1, rgb + row * (size_t)j, row);
  LitheStatus status = lth_new_(ctx, (void **)png, (LitheCount)packed + 80, 1);
  if (status == LITHE_OK) {
    uint8_t *at = *png;
    memcpy(at, signature, 8);
    at += 8;
    put_word(put_word(at + 8, (uint32_t)w), (uint32_t)h);
    memcpy(at + 16, (const uint8_t[]){8, 2, 0, 0, 0}, 5); // 8 bits of three colours
    at = end_chunk(at, "IHDR", 13);
    compress2(at + 8, &packed, raw, (uLong)raw_size, 9);
    at = end_chunk(at, "IDAT", (uint32_t)packed);
    at = end_chunk(at, "IEND", 0);
    *size = at - *png;
  }
  lth_free(ctx, raw);
  return status;
}

void lth_draw_pixels(LthDrawing *d, int w, int h, const uint8_t *rgb) {
  uint8_t *png = NULL;
  LitheCount size = 0;
  double width = d->height * w / h;
  d->failed = d->failed || make_png(d->ctx, w, h, rgb, &png, &size) != LITHE_OK;
  put(d,
      "<image x=\"%.6g\" y=\"%.6g\" width=\"%.6g\" height=\"%.6g\" "
      "style=\"image-rendering:pixelated\" href=\"data:image/png;base64,",
      d->left, d->top, width, d->height);
  if (png) put_base64(d, png, size);
  put(d, "\"/>\n");
  lth_free(d->ctx, png);
}
