/// Contact points of staggered bodies: the boundary near every cell where the body ends.
#include "scene/staggered_body.h"

#include "base/tensor.h"

/// What the body has of the boundary around a cell, as a vector: the sum over the cell's faces of how much less of it the
/// neighbour holds. Over all cells the lengths sum up to the area of the boundary, exactly so for planes along
/// or diagonal to the axes.
static double boundary_of(const LthStaggeredBody *s, LitheCount slot) {
  const LthSparseGrid *g = s->fractions->grid;
  double size = lth_sparse_grid_cell_volume(g), sum = 0, own = (double)s->filled[slot];
  for (int a = 0; a < g->dim; a++) {
    double part = 0;
    for (int side = -1; side <= 1; side += 2) {
      const int d[3] = {a == 0 ? side : 0, a == 1 ? side : 0, a == 2 ? side : 0};
      LitheCount other = lth_sparse_grid_step(g, slot, d);
      double less = own - (other >= 0 ? (double)s->filled[other] : 0);
      part += fmax(less, 0) * size / g->h[a];
    }
    sum += part * part;
  }
  return sqrt(sum);
}

static LitheIndex collect(const LthBody *body, double *points, double *area) {
  const LthStaggeredBody *s = body->staggered;
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    LthFoot foot;
    double center[3];
    double share = boundary_of(s, lth_staggered_of(body->disc)->cell_slot[c]);
    if (!(share > 0)) continue;
    lth_body_cell_center(body, c, center);
    if (!lth_shape_foot(&body->def->shape, center, s->h, &foot)) continue;
    if (fabs(foot.distance) > 1.5 * s->diagonal) continue;
    lth_v3_copy(foot.point, points + 3 * (LitheCount)n);
    area[n++] = share;
  }
  return n;
}

LitheStatus lth_build_grid_nodes(LitheCtx *ctx, const LthBody *body, const LthEmbedding *surface,
                                 LthEmbedding **nodes) {
  LitheStatus status = LITHE_OK;
  LitheIndex more = surface ? surface->n_points : 0;
  LitheCount cap = (LitheCount)body->disc->n_cells + more;
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
