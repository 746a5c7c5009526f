/// Reading and writing polygon files: .obj, .stl, .ply, .off.
#pragma once

#include "geometry/surface.h"

/// Read by the file's ending (and, for .stl, its contents). LITHE_BAD_INPUT names file, line or byte
/// offset, what was found and what was expected. Every index, count and number is checked.
LitheStatus lth_soup_read(LitheCtx *ctx, const char *path, LthSoup **soup);

/// The same from memory; `format` is "obj", "stl", "ply" or "off". `name` is used in messages.
LitheStatus lth_soup_parse(LitheCtx *ctx, const char *name, const char *format, const void *data,
                           size_t size, LthSoup **soup);

/// Write polygons with other points (n_points x 3; NULL: the soup's own). Atomic: a temporary file that
/// is renamed. OBJ (text, ten digits) keeps polygons, texture coordinates and groups; PLY (binary, float
/// coordinates) keeps polygons; STL (binary, float) has triangles. LITHE_NO_SPACE: cannot write.
LitheStatus lth_soup_write_obj(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points);
LitheStatus lth_soup_write_ply(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points);
LitheStatus lth_soup_write_stl(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points);

/// Write defects as coloured line segments that any PLY viewer shows.
LitheStatus lth_defects_write_ply(LitheCtx *ctx, const char *path, const LthDefects *defects);
