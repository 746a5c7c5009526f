/// Contact points of staggered bodies: the boundary near every cell where the body ends.
#include "scene/staggered_body.h"

#include "base/tensor.h"

#include <string.h>

#define ALIKE 0.7  ///< cosine between normals of one smooth piece of boundary
#define FACING 0.3 ///< of a normal towards a side: less tells of another part of the boundary

/// The points of one cell. What its sides lose to their neighbours goes to the boundary point nearest to the cell's middle, but
/// where an edge of the shape passes: there each side of the cell has the point that it faces.
typedef struct CellNodes {
  const LthBody *body;
  double center[3];
  double lost[6]; ///< of the sides, low and high of each axis, what neighbours do not have [m^2]
  LthFoot foot;
  bool has_foot;
} CellNodes;

static void find_lost(const LthStaggeredBody *s, LitheCount slot, double lost[6]) {
  const LthSparseGrid *g = s->fractions->grid;
  const double size = lth_sparse_grid_cell_volume(g), own = (double)s->filled[slot];
  memset(lost, 0, 6 * sizeof *lost);
  for (int side = 0; side < 2 * g->dim; side++) {
    const int a = side / 2, step = side % 2 ? 1 : -1;
    const int d[3] = {a == 0 ? step : 0, a == 1 ? step : 0, a == 2 ? step : 0};
    LitheCount other = lth_sparse_grid_step(g, slot, d);
    lost[side] = fmax(0, own - (other >= 0 ? (double)s->filled[other] : 0)) * size / g->h[a];
  }
}

static bool find_foot(const LthBody *body, const double x[3], LthFoot *foot) {
  const LthStaggeredBody *s = body->staggered;
  return lth_shape_foot(&body->def->shape, x, s->h, foot) &&
         fabs(foot->distance) <= 1.5 * s->diagonal;
}

/// The boundary point that a side of the cell faces; returns its area: a plane of normal n and area A loses A |n_a| along axis a,
/// so that the sum of lost_a |n_a| is A. Where the foot's normal is of no use, at corners, n is that of what is lost.
static double find_side(const CellNodes *cell, int side, double all, LthFoot *foot) {
  const LthStaggeredBody *s = cell->body->staggered;
  const double turn = side % 2 ? 1 : -1, lost = cell->lost[side];
  double x[3];
  lth_v3_copy(cell->center, x);
  x[side / 2] += 0.5 * turn * s->fractions->grid->h[side / 2];
  if (!find_foot(cell->body, x, foot)) {
    if (!cell->has_foot) return 0;
    *foot = cell->foot;
  }
  const double facing = turn * foot->normal[side / 2];
  return lost * (facing > FACING ? facing : lost / all);
}

/// Put the points of a cell behind the n that there are.
static LitheIndex add_cell(CellNodes *cell, LitheIndex n, double *points, double *area) {
  LitheIndex middle = -1;
  double all = 0;
  for (int side = 0; side < 6; side++) all += cell->lost[side] * cell->lost[side];
  if (!(all > 0)) return n;
  cell->has_foot = find_foot(cell->body, cell->center, &cell->foot);
  for (int side = 0; side < 6; side++) {
    LthFoot foot;
    double share = cell->lost[side] > 0 ? find_side(cell, side, sqrt(all), &foot) : 0;
    if (!(share > 0)) continue;
    bool is_smooth = cell->has_foot && lth_v3_dot(foot.normal, cell->foot.normal) > ALIKE;
    LitheIndex to = is_smooth && middle >= 0 ? middle : n++;
    if (is_smooth) middle = to;
    lth_v3_copy(is_smooth ? cell->foot.point : foot.point, points + 3 * (LitheCount)to);
    area[to] += share;
  }
  return n;
}

/// Contact points of all cells, of which those where the body ends have some; their number is all that is wanted where
/// `points` is NULL.
static LitheIndex collect(const LthBody *body, double *points, double *area) {
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    CellNodes cell = {.body = body};
    find_lost(body->staggered, lth_staggered_of(body->disc)->cell_slot[c], cell.lost);
    if (points) {
      lth_body_cell_center(body, c, cell.center);
      n = add_cell(&cell, n, points, area);
    } else {
      for (int side = 0; side < 6; side++) n += cell.lost[side] > 0;
    }
  }
  return n;
}

LitheStatus lth_build_grid_nodes(LitheCtx *ctx, const LthBody *body, const LthEmbedding *surface,
                                 LthEmbedding **nodes) {
  LitheStatus status = LITHE_OK;
  LitheIndex more = surface ? surface->n_points : 0;
  LitheCount cap = (LitheCount)collect(body, NULL, NULL) + more;
  double *points = NULL, *area = NULL;
  LTH_NEW_OR(done, ctx, points, 3 * cap);
  LTH_NEW_OR(done, ctx, area, cap);
  LitheIndex n = collect(body, points, area);
  for (LitheIndex i = 0; surface && i < n; i++) area[i] *= 0.5; // each kind stands for half of it
  for (LitheIndex i = 0; i < more; i++, n++) {
    lth_v3_copy(surface->rest + 3 * (LitheCount)i, points + 3 * (LitheCount)n);
    area[n] = 0.5 * surface->area[i];
  }
  LITHE_TRY_OR(done, lth_embedding_create_direct(ctx, body->disc, n, points, NULL, nodes));
  (*nodes)->area = area;
  area = NULL;
done:
  lth_free(ctx, points);
  lth_free(ctx, area);
  return status;
}
