/// Polygon files as read, and the clean closed triangle surface that the rest of Lithe works on.
#pragma once

#include "base/ctx.h"

/// A polygon file as it was read: nothing welded, nothing dropped, order kept (output needs it).
typedef struct LthSoup {
  LitheIndex n_points, n_polys, n_uvs, n_groups;
  double *points;         ///< file coordinates, later scene [m]           (n_points x 3)
  LitheIndex *poly_off;   ///< start of each polygon in poly_point         (n_polys + 1)
  LitheIndex *poly_point; ///< its points, in file order                   (poly_off[n_polys])
  double *uvs;            ///< texture coordinates or NULL                 (n_uvs x 2)
  LitheIndex *poly_uv;    ///< texture coordinate of each corner, -1 none; NULL without uvs
  LitheIndex *poly_group; ///< group of each polygon, or NULL              (n_polys)
  char **group_names;     ///< (n_groups)
} LthSoup;

void lth_soup_destroy(LitheCtx *ctx, LthSoup **soup);

/// A closed, consistently oriented triangle surface: every directed edge has exactly one opposite.
/// Triangles are counter-clockwise seen from outside; cavities are inner shells with inward volume.
typedef struct LthSurface {
  LitheIndex n_points, n_tris, n_shells;
  double *points;        ///< [m]                                         (n_points x 3)
  LitheIndex *tris;      ///< points of each triangle                     (n_tris x 3)
  LitheIndex *tri_shell; ///< connected shell of each triangle            (n_tris)
  LitheIndex *tri_poly;  ///< polygon of the soup each triangle is from   (n_tris)
  LitheIndex n_soup_points;
  LitheIndex
      *soup_point; ///< point of this surface for each soup point, -1 if unused (n_soup_points)
} LthSurface;

void lth_surface_destroy(LitheCtx *ctx, LthSurface **surface);

/// Enclosed volume [m^3] and area [m^2], by sums about the box centre.
double lth_surface_volume(const LthSurface *surface);
double lth_surface_area(const LthSurface *surface);
void lth_surface_bounds(const LthSurface *surface, double min[3], double max[3]);

typedef enum LthDefectKind {
  LTH_DEFECT_OPEN_EDGE,    ///< an edge with one triangle
  LTH_DEFECT_NON_MANIFOLD, ///< an edge with more than two
  LTH_DEFECT_CROSSING,     ///< two triangles that cross or overlap
  LTH_DEFECT_UNORIENTABLE, ///< a shell that has no outside (Moebius)
  LTH_DEFECT_NESTING,      ///< shells inside each other in the wrong sense that cannot be repaired
  LTH_DEFECT_KINDS
} LthDefectKind;

/// Everything that is wrong with a surface, each with its place.
typedef struct LthDefects {
  LitheIndex n;                       ///< number of defects kept
  LitheIndex count[LTH_DEFECT_KINDS]; ///< number found, also of those not kept
  LthDefectKind *kind;                ///< (n)
  double *segment;                    ///< two end points of the bad edge or crossing  (n x 6)
  LitheCount cap, segment_cap;
  double size; ///< diagonal of the surface's box [m]
} LthDefects;

#define LTH_DEFECTS_KEPT 10000 ///< places kept of each kind

/// A few words for one defect of a kind, such as "open edge".
const char *lth_defect_text(LthDefectKind kind);

void lth_defects_free(LitheCtx *ctx, LthDefects *defects);

/// Weld points (equal or nearer than 1e-9 of the size), triangulate, drop what covers nothing, make
/// orientation agree, find shells and cavities, mend slight crossings (by less than 1e-3 of the size).
/// What was done is told by lth_warn(). A shell inside another must face the other way in the file, or
/// have mixed orientation, to be taken for a cavity. A surface that is open, crosses itself or is not a
/// manifold gives LITHE_BAD_INPUT, a message that counts and places the defects, and the list in
/// `defects` (may be NULL; else free it with lth_defects_free() whatever is returned).
/// `name` is used in messages. Nothing of the soup is kept. Same result for any number of threads.
LitheStatus lth_surface_from_soup(LitheCtx *ctx, const LthSoup *soup, const char *name,
                                  LthDefects *defects, LthSurface **surface);

/// Halve edges longer than `length` [m] until there are none: closed and flat where `surface` is, whose
/// points come first. Points of a soup are not known any more.
LitheStatus lth_surface_refine(LitheCtx *ctx, const LthSurface *surface, double length,
                               LthSurface **refined);

/// Triangulate the polygons of a soup without any repair (for drawing). (n_out x 3, caller frees)
LitheStatus lth_soup_triangulate(LitheCtx *ctx, const LthSoup *soup, LitheIndex *n_tris,
                                 LitheIndex **tris, LitheIndex **tri_poly);
