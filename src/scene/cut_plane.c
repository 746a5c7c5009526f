/// Cuts by planes, and by the facets of a blade.
#include "scene/cut_priv.h"

#include "base/tensor.h"

#include <math.h>

#define NEAR 0.5 ///< of a cell's box: a plane that close to it may part it from a neighbour

/// Cells to be cut, with the plane at rest of each.
typedef struct Cells {
  LitheIndex n;
  LitheIndex *record;
  LthPlane *plane;
} Cells;

static void free_cells(LitheCtx *ctx, Cells *cells) {
  lth_free(ctx, cells->record);
  lth_free(ctx, cells->plane);
}

/// Is the middle of the part of the plane in a cell within the cut's shape?
static bool is_within(const LthCutting *c, LitheIndex cell) {
  double middle[3] = {0, 0, 0}, sum = 0;
  for (LitheIndex i = 0; i < c->section.n; i++) {
    const double *ends = c->section.ends + 6 * (LitheCount)i;
    double a[3], b[3];
    lth_cutting_place(c, cell, ends, a);
    lth_cutting_place(c, cell, ends + 3, b);
    double half = 0.5 * lth_v3_distance(a, b);
    lth_v3_axpy(half, a, middle);
    lth_v3_axpy(half, b, middle);
    sum += 2 * half;
  }
  if (!(sum > 0)) return false;
  for (int i = 0; i < 3; i++) middle[i] /= sum;
  return lth_shape_value(&c->cut->within, middle) <= 0;
}

/// Does a cut through a cell's part of the plane belong to it? NULL window: as `within` says.
static LitheStatus reaches(LitheCtx *ctx, LthCutting *c, LitheIndex cell, const LthPlane *plane,
                           const LthWindow *window, bool *yes) {
  *yes = !window && !c->cut->has_within;
  if (*yes) return LITHE_OK;
  LITHE_TRY(lth_topology_section(ctx, c->t, cell, plane, &c->section));
  if (c->section.n == 0) { // a face may lie in the plane, and the cell above
    LthPlane turned = *plane;
    for (int a = 0; a < 3; a++) turned.normal[a] = -turned.normal[a];
    LITHE_TRY(lth_topology_section(ctx, c->t, cell, &turned, &c->section));
  }
  *yes = window ? lth_cutting_meets(c, cell, window) : is_within(c, cell);
  return LITHE_OK;
}

static LitheStatus find_cells(LitheCtx *ctx, LthCutting *c, const LthPlane *plane,
                              const LthWindow *window, Cells *cells) {
  const LthTopology *t = c->t;
  bool is_bounded = window || c->cut->has_within, yes;
  LTH_NEW(ctx, cells->record, t->n_live_cells);
  LTH_NEW(ctx, cells->plane, t->n_live_cells);
  for (LitheIndex i = 0; i < t->n_cells; i++) {
    LthPlane *rest = cells->plane + cells->n;
    if (!t->cells[i].is_live || !lth_cutting_plane(c, plane, i, rest)) continue;
    if (!lth_plane_passes(t->cells + i, rest, is_bounded ? 1e-9 : NEAR)) continue;
    LITHE_TRY(reaches(ctx, c, i, rest, window, &yes));
    if (yes) cells->record[cells->n++] = i;
  }
  return LITHE_OK;
}

/// A plane, all of it or what the window or `within` leave.
static LitheStatus cut(LitheCtx *ctx, LthCutting *c, const LthPlane *plane, const LthWindow *window,
                       LitheIndex tag) {
  LitheStatus status = LITHE_OK;
  Cells cells = {0};
  LthCut done = {0};
  LITHE_TRY_OR(done, find_cells(ctx, c, plane, window, &cells));
  if (cells.n > 0)
    LITHE_TRY_OR(done, lth_topology_cut(ctx, c->t, cells.n, cells.record, c->x ? cells.n : 1,
                                        cells.plane, tag, &done));
  if (tag == -1) goto done;
  c->note->n_split += done.n_split;
  c->note->n_separated += done.n_separated;
  c->note->area += done.area;
done:
  free_cells(ctx, &cells);
  return status;
}

LitheStatus lth_cut_by_plane(LitheCtx *ctx, LthCutting *c) {
  return cut(ctx, c, &c->cut->plane, NULL, c->tag);
}

// --- blades ---

/// Corners of what an edge sweeps, and their plane.
static LthWindow facet_window(const LthSceneCut *cut, LitheIndex i, LthPlane *plane) {
  const double *p = cut->path[i], *q = cut->path[i + 1];
  double edge[3], far[2][3];
  lth_v3_add(q, cut->depth, far[0]);
  lth_v3_add(p, cut->depth, far[1]);
  lth_v3_sub(q, p, edge);
  lth_v3_copy(p, plane->point);
  lth_v3_cross(edge, cut->depth, plane->normal);
  lth_v3_normalize(plane->normal);
  return lth_window_make(4, (const double *const[]){p, q, far[0], far[1]});
}

/// The plane halfway between two edges in a bend, as far from both as one can be: next to an edge it would be taken for it, and the
/// edge would not end in the bend. False where the path goes straight on (or back).
static bool bend_plane(const LthSceneCut *cut, LitheIndex i, LthPlane *plane) {
  double a[3], b[3], turn[3], along[3];
  lth_v3_sub(cut->path[i], cut->path[i - 1], a);
  lth_v3_sub(cut->path[i + 1], cut->path[i], b);
  lth_v3_copy(cut->depth, along);
  lth_v3_normalize(along);
  lth_v3_axpy(-lth_v3_dot(along, a), along, a);
  lth_v3_axpy(-lth_v3_dot(along, b), along, b);
  lth_v3_normalize(a);
  lth_v3_normalize(b);
  lth_v3_cross(a, b, turn);
  lth_v3_copy(cut->path[i], plane->point);
  lth_v3_add(a, b, plane->normal);
  return lth_v3_norm(turn) > 1e-9 && lth_v3_normalize(plane->normal) > 1e-6;
}

/// A window that is next to a line: the bend's edge, as far as the blade reaches.
static LthWindow bend_window(const LthSceneCut *cut, LitheIndex i, const LthPlane *plane,
                             double width) {
  double corners[4][3], across[3];
  lth_v3_cross(plane->normal, cut->depth, across);
  lth_v3_normalize(across);
  for (int k = 0; k < 4; k++) {
    lth_v3_copy(cut->path[i], corners[k]);
    if (k == 1 || k == 2) lth_v3_add(corners[k], cut->depth, corners[k]);
    lth_v3_axpy((k >= 2 ? 1 : -1) * width, across, corners[k]);
  }
  return lth_window_make(4,
                         (const double *const[]){corners[0], corners[1], corners[2], corners[3]});
}

// Where the blade bends inside an element, each of its two facets takes the part of the element on its side of the bend:
// divided there, and put together again where the cut has left the parts joined.
LitheStatus lth_cut_by_blade(LitheCtx *ctx, LthCutting *c) {
  LitheStatus status = LITHE_OK;
  const LthSceneCut *blade = c->cut;
  LthCutRoots roots = {0};
  LthPlane plane;
  LITHE_TRY_OR(done, lth_cut_roots_begin(ctx, c->t, &roots));
  for (LitheIndex i = 1; i + 1 < blade->n_path; i++) {
    if (!bend_plane(blade, i, &plane)) continue;
    LthWindow window = bend_window(blade, i, &plane, 1e-3 * c->t->cell_size);
    LITHE_TRY_OR(done, cut(ctx, c, &plane, &window, -1));
  }
  bool is_divided = c->t->log.n_births > roots.n_births;
  for (LitheIndex i = 0; i + 1 < blade->n_path; i++) {
    LthWindow window = facet_window(blade, i, &plane);
    LITHE_TRY_OR(done, cut(ctx, c, &plane, &window, c->tag));
  }
  if (!is_divided) goto done;
  LITHE_TRY_OR(done, lth_cut_roots_follow(ctx, c->t, &roots));
  LITHE_TRY_OR(done, lth_cut_merge_roots(ctx, c, &roots, NULL, NULL));
done:
  lth_free(ctx, roots.root);
  return status;
}
