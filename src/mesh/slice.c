/// Exact slicing of a closed surface by a regular grid into polyhedra (Kaufmann, Martin, Botsch and
/// Gross 2009, section 9.2), as algebra of chains: see slice.h.
#include "mesh/slice.h"

#include <float.h>
#include <math.h>
#include <string.h>

/// A point this close to a plane, in units of the rounding of the largest coordinate, is on it.
#define REACH_ULPS 32

static LitheStatus check_request(LitheCtx *ctx, const LthSurface *surface, const LthGrid *grid,
                                 double sliver) {
  if (surface->n_tris < 4)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "slicing: the surface has %d triangles; expected a closed one with 4 or more",
               surface->n_tris);
  if (!(sliver >= 0 && sliver <= 1))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "slicing: sliver is %g, expected a share of a cell from 0 to 1", sliver);
  for (int a = 0; a < 3; a++)
    if (grid->cells[a] < 1 || !(grid->max[a] > grid->min[a]) ||
        !isfinite(grid->max[a] - grid->min[a]))
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "slicing: the grid's axis %c runs from %g to %g in %d cells; expected min < max and "
          "at least 1 cell",
          "xyz"[a], grid -> min[a], grid -> max[a], grid -> cells[a]);
  for (LitheCount i = 0; i < 3 * (LitheCount)surface->n_points; i++)
    if (!isfinite(surface->points[i]))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "slicing: point %lld of the surface is not finite",
                 (long long)(i / 3));
  return LITHE_OK;
}

static LitheStatus make_planes(Slicer *s, const LthGrid *grid, int axis) {
  LitheIndex n = grid->cells[axis];
  LTH_NEW(s->ctx, s->plane[axis], (LitheCount)n + 1);
  for (LitheIndex k = 0; k <= n; k++) s->plane[axis][k] = lth_grid_plane(grid, axis, k);
  if (!((grid->max[axis] - grid->min[axis]) / n > 4 * s->reach))
    LITHE_FAIL(
        s->ctx, LITHE_BAD_INPUT,
        "slicing: %d cells from %g to %g along %c are finer than rounding; use fewer cells or "
        "move the body to the origin",
        n, grid->min[axis], grid->max[axis], "xyz"[axis]);
  return LITHE_OK;
}

/// The surface's triangles as pieces, and room for about as many again.
static LitheStatus add_triangles(Slicer *s) {
  const LthSurface *surface = s->surface;
  s->n_points = surface->n_points;
  LTH_RESERVE(s->ctx, s->point, s->point_cap, 3 * s->n_points);
  memcpy(s->point, surface->points, 3 * (size_t)s->n_points * sizeof *s->point);
  for (LitheIndex t = 0; t < surface->n_tris; t++) {
    const LitheIndex *tri = surface->tris + 3 * (LitheCount)t;
    SlicePiece piece = {.tag = t, .axis = SLICE_BOUNDARY};
    LITHE_TRY(lth_slice_add_piece(s->ctx, &s->pieces, &piece));
    for (int i = 0; i < 3; i++)
      LITHE_TRY(lth_slice_add_edge(s->ctx, &s->pieces, tri[i], tri[(i + 1) % 3]));
  }
  return LITHE_OK;
}

static LitheStatus start(Slicer *s, const LthGrid *grid) {
  for (LitheCount i = 0; i < 3 * (LitheCount)s->surface->n_points; i++)
    s->rounding = fmax(s->rounding, DBL_EPSILON * fabs(s->surface->points[i]));
  for (int a = 0; a < 3; a++)
    s->rounding = fmax(s->rounding, DBL_EPSILON * fmax(fabs(grid->min[a]), fabs(grid->max[a])));
  s->reach = REACH_ULPS * s->rounding;
  s->cell_volume = 1;
  for (int a = 0; a < 3; a++) {
    s->cells[a] = grid->cells[a];
    s->cell_volume *= (grid->max[a] - grid->min[a]) / grid->cells[a];
    LITHE_TRY(make_planes(s, grid, a));
  }
  return add_triangles(s);
}

static void finish(Slicer *s) {
  for (int a = 0; a < 3; a++) lth_free(s->ctx, s->plane[a]);
  lth_free(s->ctx, s->point);
  lth_slice_free_pieces(s->ctx, &s->pieces);
  lth_slice_free_parts(s->ctx, &s->parts);
  lth_free(s->ctx, s->elements.of);
  lth_free(s->ctx, s->elements.group);
  lth_free(s->ctx, s->elements.volume);
  lth_free(s->ctx, s->elements.area);
}

/// Stop between two steps where the user asked for it.
static LitheStatus report(Slicer *s, double fraction) {
  if (lth_cancelled(s->ctx)) LITHE_FAIL(s->ctx, LITHE_INTERRUPTED, "interrupted");
  lth_progress(s->ctx, "building elements", fraction);
  return LITHE_OK;
}

static LitheStatus slice(Slicer *s, const LthGrid *grid, double sliver, LthMesh **mesh) {
  LITHE_TRY(start(s, grid));
  for (int axis = 0; axis < 3; axis++) LITHE_TRY(lth_slice_pass(s, axis));
  LITHE_TRY(report(s, 0));
  LITHE_TRY(lth_slice_weld(s));
  LITHE_TRY(report(s, 0.2));
  LITHE_TRY(lth_slice_make_parts(s));
  LITHE_TRY(report(s, 0.4));
  LITHE_TRY(lth_slice_make_elements(s));
  LITHE_TRY(report(s, 0.6));
  LITHE_TRY(lth_slice_merge(s, sliver));
  LITHE_TRY(report(s, 0.8));
  LITHE_TRY(lth_slice_make_mesh(s, mesh));
  return report(s, 1);
}

LitheStatus lth_mesh_slice(LitheCtx *ctx, const LthSurface *surface, const LthGrid *grid,
                           double sliver, LthMesh **mesh) {
  *mesh = NULL;
  LITHE_TRY(check_request(ctx, surface, grid, sliver));
  Slicer s = {.ctx = ctx, .surface = surface};
  LitheStatus status = slice(&s, grid, sliver, mesh);
  if (status != LITHE_OK) lth_mesh_destroy(ctx, mesh);
  finish(&s);
  return status;
}
