/// Drawings as SVG text: panels with places in metres, fills, lines, words, images.
#pragma once

#include "scene/arena.h"

/// Zero-initialise and set ctx. A failure (memory) is kept; lth_draw_end() tells.
typedef struct LthDrawing {
  LitheCtx *ctx;
  char *text;
  LitheCount n, cap;
  bool failed;
  double left, top, scale;  ///< of the panel [px], [px], [px/m]
  double corner[2], height; ///< low corner of the panel's places [m], its height [px]
} LthDrawing;

void lth_draw_begin(LthDrawing *drawing, double width, double height);
/// The text, copied into the arena; NULL where memory is out. Frees the drawing.
const char *lth_draw_end(LthDrawing *drawing, LthArena *arena);

/// Places from now on: box (min x, min y, max x, max y) [m] fills the panel's width from (left, top) [px]. Returns the
/// panel's height.
double lth_draw_panel(LthDrawing *drawing, const double box[4], double left, double top,
                      double width);

/// An area of one colour out of closed polygons of n places; their edges are drawn too, so that no gap is seen.
void lth_draw_area_begin(LthDrawing *drawing, const char *fill);
void lth_draw_area_add(LthDrawing *drawing, int n, const double *xy);
void lth_draw_area_end(LthDrawing *drawing);
void lth_draw_line(LthDrawing *drawing, const double from[2], const double to[2], double width,
                   const char *colour);
void lth_draw_dot(LthDrawing *drawing, const double at[2], double radius, const char *fill);
/// Words at a place of the page [px].
void lth_draw_words(LthDrawing *drawing, double x, double y, const char *words);

/// A colour bar of `height` [px] with its ends written beside it.
void lth_draw_bar(LthDrawing *drawing, double x, double y, double height, const char *title,
                  double low, double high);

/// A picture of w x h pixels over the panel's width, row 0 on top: (w x h x 3) bytes.
void lth_draw_pixels(LthDrawing *drawing, int w, int h, const uint8_t *rgb);

/// A colour for a value from 0 to 1 whose lightness rises all along: it can be read in grey.
#define LTH_COLOUR_MAX 8
const char *lth_colour(double value, char text[LTH_COLOUR_MAX]);
void lth_colour_bytes(double value, uint8_t rgb[3]);
