/// Building small soups for tests, polygon by polygon.
#pragma once

#include "check.h"
#include "geometry/surface.h"

#include <string.h>

/// Enough room for every test's soup.
#define MAKER_POINTS 8000
#define MAKER_CORNERS 48000

/// Zero-initialise; `soup` may be handed to the library after soup_finish().
typedef struct SoupMaker {
  LthSoup soup;
  double points[3 * MAKER_POINTS];
  LitheIndex poly_off[MAKER_CORNERS], poly_point[MAKER_CORNERS];
} SoupMaker;

static inline LitheIndex soup_point(SoupMaker *m, double x, double y, double z) {
  double *at = m->points + 3 * m->soup.n_points;
  at[0] = x, at[1] = y, at[2] = z;
  return m->soup.n_points++;
}

static inline void soup_polygon(SoupMaker *m, int n_corners, const LitheIndex *points) {
  LitheIndex first = m->poly_off[m->soup.n_polys];
  for (int i = 0; i < n_corners; i++) m->poly_point[first + i] = points[i];
  m->poly_off[++m->soup.n_polys] = first + n_corners;
}

static inline void soup_triangle(SoupMaker *m, LitheIndex a, LitheIndex b, LitheIndex c) {
  soup_polygon(m, 3, (LitheIndex[]){a, b, c});
}

/// Point the soup at its arrays; call after the last change of place.
static inline LthSoup *soup_finish(SoupMaker *m) {
  m->soup.points = m->points;
  m->soup.poly_off = m->poly_off;
  m->soup.poly_point = m->poly_point;
  return &m->soup;
}

/// Six quads with outward normals (inward with `inside_out`); returns the number of the first point,
/// point i + 2 j + 4 k being at (low or high x, y, z).
static inline LitheIndex soup_box(SoupMaker *m, const double low[3], const double high[3],
                                  bool inside_out) {
  static const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  LitheIndex first = m->soup.n_points;
  for (int i = 0; i < 8; i++)
    soup_point(m, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
  for (int q = 0; q < 6; q++) {
    LitheIndex p[4];
    for (int k = 0; k < 4; k++) p[k] = first + quads[q][inside_out ? 3 - k : k];
    soup_polygon(m, 4, p);
  }
  return first;
}

/// The cube of side `side` with its lowest corner at (x, y, z).
static inline LitheIndex soup_cube(SoupMaker *m, double x, double y, double z, double side) {
  return soup_box(m, (double[]){x, y, z}, (double[]){x + side, y + side, z + side}, false);
}

/// The same cube as the boundary of a cavity.
static inline LitheIndex soup_cavity(SoupMaker *m, double x, double y, double z, double side) {
  return soup_box(m, (double[]){x, y, z}, (double[]){x + side, y + side, z + side}, true);
}
