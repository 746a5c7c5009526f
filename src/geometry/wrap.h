/// Surfaces that are not the boundary of a solid, made ready to be wrapped: the closed surface where their
/// winding number is one half (docs/theory/winding.md).
#pragma once

#include "geometry/bvh.h"
#include "geometry/winding.h"
#include "geometry/wrap_rim.h"

/// Immutable once built; safe to read from many threads.
typedef struct LthWrap {
  LthSurface *raw; ///< welded triangles, oriented as far as they can be; open, crossing, anything
  LthBvh *bvh;     ///< over `raw`
  LthWinding *winding;
  LthRim *rim;
  bool *
      crosses; ///< does a triangle cross others, or touch them but for corners and edges in common?  (n_tris)
  double box[6]; ///< of `raw`: nothing beyond it is inside
  double size;   ///< diagonal of it [m]

  // what is wrong with it; crossings are what strict cleaning finds
  LitheIndex n_open_edges, n_holes; ///< holes: connected sets of open edges
  double largest_hole;              ///< diagonal of its box [m]
  LitheIndex n_crowded_edges;       ///< with more than two triangles
  LitheIndex n_repeated;            ///< triangles that are there more than once
  LitheIndex n_one_sided;           ///< shells without an outside
  LitheIndex n_turned_shells;       ///< closed shells that were inside out
} LthWrap;

/// Weld, triangulate, merge equal triangles (opposite ones cancel), make neighbours agree in orientation,
/// turn closed shells over that are inside out on their own. LITHE_BAD_INPUT: no triangles are left.
LitheStatus lth_wrap_create(LitheCtx *ctx, const LthSoup *soup, const char *name, LthWrap **wrap);
void lth_wrap_destroy(LitheCtx *ctx, LthWrap **wrap);

/// Is the winding number at x above one half, and x within the box?
bool lth_wrap_inside(const LthWrap *wrap, const double x[3]);

/// Distance to the nearest triangle [m], negative inside. Not continuous in holes.
double lth_wrap_value(const LthWrap *wrap, const double x[3]);

/// What is certainly inside and outside, for asking at millions of places.
typedef struct LthWrapMap {
  const LthWrap *wrap; ///< borrowed for life
  double origin[3], cell;
  LitheIndex n[3];
  uint8_t *state; ///< of each cell: LTH_WRAP_UNKNOWN, OUTSIDE, INSIDE    (n[0] n[1] n[2])
} LthWrapMap;

enum { LTH_WRAP_UNKNOWN, LTH_WRAP_OUTSIDE, LTH_WRAP_INSIDE };

/// Cells of about `cell` [m]. A cell is known where no triangle meets it, or is near a block of cells that
/// it is in, and the number at the middle of that is below 0.15 or above 0.85.
LitheStatus lth_wrap_map_create(LitheCtx *ctx, const LthWrap *wrap, double cell, LthWrapMap **map);
void lth_wrap_map_destroy(LitheCtx *ctx, LthWrapMap **map);

/// lth_wrap_inside() by the map.
bool lth_wrap_map_inside(const LthWrapMap *map, const double x[3]);

/// Where inside changes on the way from a to b, as a part of it: on the triangle that is met there, or by
/// bisection where it changes within a hole. `starts_inside` is the answer at a; that at b is the other.
double lth_wrap_map_crossing(const LthWrapMap *map, const double a[3], const double b[3],
                             bool starts_inside);
