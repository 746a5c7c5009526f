/// Which features of a level are thinner than three cells: what no box of three cells a side fits into.
#include "disc/staggered/staggered_hierarchy.h"

#include <string.h>

/// out = least (or greatest) of `in` over the cells up to `reach` away along an axis.
static void extreme_along(LitheCtx *ctx, const LthSparseGrid *g, int axis, int reach, bool least,
                          const uint8_t *in, uint8_t *out) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < g->n_slots; s++) {
    LitheIndex c[3];
    lth_sparse_grid_cell(g, s, c);
    uint8_t value = in[s];
    for (int d = -reach; d <= reach; d++) {
      LitheCount to = lth_sparse_grid_along(g, c, axis, d);
      uint8_t there = to < 0 ? 0 : in[to];
      if (least ? there < value : there > value) value = there;
    }
    out[s] = value;
  }
}

/// Solid cells that are far from any 3-box of solid cells, over all solid cells. A cell may be two away from the
/// box's centre and one more, so that rounded and slanting boundaries do not count.
LitheStatus lth_staggered_thin_share(LitheCtx *ctx, const LthSparseGrid *g, const float *solid,
                                     double *share, LitheCount *where) {
  LitheStatus status = LITHE_OK;
  uint8_t *a = NULL, *b = NULL;
  LTH_NEW_OR(done, ctx, a, g->n_slots);
  LTH_NEW_OR(done, ctx, b, g->n_slots);
  for (LitheCount s = 0; s < g->n_slots; s++) a[s] = solid[s] >= 0.5F;
  for (int phase = 0; phase < 2; phase++)
    for (int axis = 0; axis < g->dim; axis++) {
      extreme_along(ctx, g, axis, phase ? 2 : 1, phase == 0, a, b);
      uint8_t *swap = a;
      a = b;
      b = swap;
    }
  LitheCount n = 0, thin = 0, first = -1;
  for (LitheCount s = 0; s < g->n_slots; s++) {
    const bool is_solid = solid[s] >= 0.5F, is_thin = is_solid && !a[s];
    if (is_thin && first < 0) first = s;
    n += is_solid;
    thin += is_thin;
  }
  if (where) *where = first;
  *share = n ? (double)thin / (double)n : 1;
done:
  lth_free(ctx, a);
  lth_free(ctx, b);
  return status;
}
