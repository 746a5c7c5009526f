/// What the files of the cuts share.
///   cut.c        when they are due, slivers, what is told
///   cut_cells.c  cells near a plane, places of the moment, windows in planes, parts of cells
///   cut_plane.c  plane cuts
///   cut_blade.c  blades: facets, bends, and what lies on two sides of them
///   cut_carve.c  cuts by another solid
///   cut_crumbs.c pieces that are taken away
#pragma once

#include "mesh/topology_section.h"
#include "scene/cut.h"

/// Of a body's volume: less than that is nothing.
#define LTH_CRUMB_VOLUME 1e-12

/// A cut of one body in progress.
typedef struct LthCutting {
  LthBody *body;
  LthTopology *t;
  const LthSceneCut *cut;
  const double *x; ///< positions of the moment; NULL: places are those at rest
  LitheIndex tag;
  LthChangeNote *note;
  LthSection section; ///< scratch
} LthCutting;

/// A plane as a cell sees it at rest; false where the cell is too flat to have one.
bool lth_cutting_plane(const LthCutting *c, const LthPlane *plane, LitheIndex cell, LthPlane *rest);

/// Where a place at rest of a cell is.
void lth_cutting_place(const LthCutting *c, LitheIndex cell, const double rest[3], double at[3]);

/// Does a plane pass a cell's box, made larger by a part of itself?
bool lth_plane_passes(const LthTopologyCell *cell, const LthPlane *plane, double margin);

/// A convex polygon in a plane, by its corners.
typedef struct LthWindow {
  int n;
  double corner[4][2], origin[3], axis[2][3];
} LthWindow;

LthWindow lth_window_make(int n, const double *const corners[]);

/// Has the part of the plane in a cell, as c->section has it at rest, more than corners and edges in common with a window?
bool lth_cutting_meets(const LthCutting *c, LitheIndex cell, const LthWindow *window);

/// Cells that came of one: numbers of `roots` for all records, -1: of none.
typedef struct LthCutRoots {
  LitheIndex n, n_births;
  LitheIndex *root;
  LitheCount cap;
} LthCutRoots;

/// Every live cell of now is its own root.
LitheStatus lth_cut_roots_begin(LitheCtx *ctx, const LthTopology *t, LthCutRoots *roots);
/// Give births the roots of their parents.
LitheStatus lth_cut_roots_follow(LitheCtx *ctx, const LthTopology *t, LthCutRoots *roots);

/// Merge cells of one root again where nothing parts them and `side` (by record, may be NULL) is the same.
LitheStatus lth_cut_merge_roots(LitheCtx *ctx, LthCutting *c, LthCutRoots *roots, int8_t **side,
                                LitheCount *side_cap);

#define LTH_CUT_NEAR 0.5 ///< of a cell's box: a plane that close to it may part it from a neighbour
#define LTH_CUT_REACHED 2 ///< times the side of a cell that a facet has reached

/// A facet of a blade, of the moment.
typedef struct LthCutFacet {
  LthPlane plane;
  LthWindow window;
  LthPlane
      bend[2]; ///< in its first and in its last edge: it lies above the one and below the other
  bool has_bend[2];
} LthCutFacet;

/// Sides of cells by record: -1, 1 near a facet that passes them by, twice that where it has reached them, else 0.
typedef struct LthCutSides {
  int8_t *of;
  LitheIndex n, n_births;
  LitheCount cap;
} LthCutSides;

/// Cut by a plane, all of it, or what the facet's window or `within` leave. `sides` (may be NULL, of all cells) become LTH_CUT_REACHED
/// for the cells that were taken. tag -1 divides only, and is not counted.
LitheStatus lth_cut_along(LitheCtx *ctx, LthCutting *c, const LthPlane *plane,
                          const LthCutFacet *facet, LitheIndex tag, LthCutSides *sides);

/// Does a whole cell lie beyond one of a facet's bends, so that the facet cannot be in it?
bool lth_cut_is_beyond(const LthCutting *c, LitheIndex cell, const LthCutFacet *facet);

LitheStatus lth_cut_by_plane(LitheCtx *ctx, LthCutting *c);
LitheStatus lth_cut_by_blade(LitheCtx *ctx, LthCutting *c);
/// Take away crumbs that changes since the log began have left, and merge elements that are as thin. What was merged and taken
/// away is added to `*n_merged` and `*n_removed`.
LitheStatus lth_cut_clear_crumbs(LitheCtx *ctx, LthBody *body, LitheIndex *n_merged,
                                 LitheIndex *n_removed);
/// Where nothing would be left of the body, nothing changes, and the note says so; before the run LITHE_BAD_INPUT.
LitheStatus lth_cut_by_carving(LitheCtx *ctx, LthCutting *c);
