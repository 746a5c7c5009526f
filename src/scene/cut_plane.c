/// Cuts by planes, whole or what a window leaves.
#include "scene/cut_priv.h"

#include "base/tensor.h"

#include <math.h>

#define ALIKE 1e-7 ///< of a cell's size: planes at rest that are so close in it are one

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

/// Are two planes as good as one in a cell?
static bool is_alike(const LthTopologyCell *cell, const LthPlane *a, const LthPlane *b) {
  double size = 0, apart = 0, turned = 0, middle[3];
  for (int i = 0; i < 3; i++) {
    const double side = cell->box[3 + i] - cell->box[i];
    middle[i] = cell->box[i] + 0.5 * side;
    apart += a->normal[i] * (middle[i] - a->point[i]) - b->normal[i] * (middle[i] - b->point[i]);
    turned += fabs(a->normal[i] - b->normal[i]) * side;
    size = fmax(size, side);
  }
  return fabs(apart) + 0.5 * turned <= ALIKE * size;
}

/// Give the cells around one its plane where their own are as good as that, and the cells around these. `place`: of records in the list, -1
/// where they are not in it or have their plane; `queue`: room for all.
static void spread_plane(const LthTopology *t, const Cells *cells, LitheIndex from,
                         LitheIndex *place, LitheIndex *queue) {
  LitheIndex n = 1;
  queue[0] = from;
  for (LitheIndex k = 0; k < n; k++) {
    const LitheIndex cell = cells->record[queue[k]];
    for (LitheIndex f = 0; f < t->cells[cell].n_faces; f++) {
      const LthTopologyFace *face = t->faces + lth_topology_cell_faces(t, cell)[f];
      const LitheIndex other = face->cell[face->cell[0] == cell];
      if (other < 0 || place[other] < 0) continue;
      const LitheIndex at = place[other];
      if (!is_alike(t->cells + other, cells->plane + from, cells->plane + at)) continue;
      cells->plane[at] = cells->plane[from];
      place[other] = -1;
      queue[n++] = at;
    }
  }
}

/// Where a body moves as one, each cell's own plane is that of its neighbours but for rounding, and faces a rounding wide would part them.
static LitheStatus share_planes(LitheCtx *ctx, const LthTopology *t, Cells *cells) {
  LitheStatus status = LITHE_OK;
  LitheIndex *place = NULL, *queue = NULL;
  LTH_NEW_OR(done, ctx, place, t->n_cells);
  LTH_NEW_OR(done, ctx, queue, cells->n);
  for (LitheIndex i = 0; i < t->n_cells; i++) place[i] = -1;
  for (LitheIndex i = 0; i < cells->n; i++) place[cells->record[i]] = i;
  for (LitheIndex i = 0; i < cells->n; i++) {
    if (place[cells->record[i]] < 0) continue;
    place[cells->record[i]] = -1;
    spread_plane(t, cells, i, place, queue);
  }
done:
  lth_free(ctx, place);
  lth_free(ctx, queue);
  return status;
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
                              const LthCutFacet *facet, Cells *cells) {
  const LthTopology *t = c->t;
  const LthWindow *window = facet ? &facet->window : NULL;
  bool is_bounded = window || c->cut->has_within, yes;
  LTH_NEW(ctx, cells->record, t->n_live_cells);
  LTH_NEW(ctx, cells->plane, t->n_live_cells);
  for (LitheIndex i = 0; i < t->n_cells; i++) {
    LthPlane *rest = cells->plane + cells->n;
    if (!t->cells[i].is_live || !lth_cutting_plane(c, plane, i, rest)) continue;
    if (!lth_plane_passes(t->cells + i, rest, is_bounded ? 1e-9 : LTH_CUT_NEAR)) continue;
    if (facet && c->x && lth_cut_is_beyond(c, i, facet)) continue;
    LITHE_TRY(reaches(ctx, c, i, rest, window, &yes));
    if (yes) cells->record[cells->n++] = i;
  }
  return LITHE_OK;
}

LitheStatus lth_cut_along(LitheCtx *ctx, LthCutting *c, const LthPlane *plane,
                          const LthCutFacet *facet, LitheIndex tag, LthCutSides *sides) {
  LitheStatus status = LITHE_OK;
  Cells cells = {0};
  LthCut done = {0};
  LITHE_TRY_OR(done, find_cells(ctx, c, plane, facet, &cells));
  if (c->x) LITHE_TRY_OR(done, share_planes(ctx, c->t, &cells));
  for (LitheIndex i = 0; i < cells.n && sides; i++) sides->of[cells.record[i]] = LTH_CUT_REACHED;
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
  return lth_cut_along(ctx, c, &c->cut->plane, NULL, c->tag, NULL);
}
