/// Growing a patch of triangles from the nearest one.
#include "mesh/surface_patch.h"

#include "base/tensor.h"

#include <string.h>

static bool bends(const LthBvh *bvh, LitheIndex t, LitheIndex u, double angle) {
  const double *n = bvh->tri_normal + 3 * (LitheCount)t, *m = bvh->tri_normal + 3 * (LitheCount)u;
  double cross[3];
  lth_v3_cross(n, m, cross);
  return atan2(lth_v3_norm(cross), lth_v3_dot(n, m)) > angle + 1e-9;
}

LitheStatus lth_surface_patch_grow(LitheCtx *ctx, const LthBvh *bvh, const double point[3],
                                   double angle, uint8_t *member) {
  LitheIndex n = bvh->surface->n_tris, depth = 0, *stack = NULL;
  LthBvhPoint nearest;
  memset(member, 0, (size_t)n);
  if (!lth_bvh_closest(bvh, point, INFINITY, NULL, NULL, &nearest)) return LITHE_OK;
  LTH_NEW(ctx, stack, n);
  member[nearest.tri] = 1;
  stack[depth++] = nearest.tri;
  while (depth > 0) {
    LitheIndex t = stack[--depth];
    for (int k = 0; k < 3; k++) {
      LitheIndex u = bvh->across[3 * (LitheCount)t + k];
      if (u < 0 || member[u] || bends(bvh, t, u, angle)) continue;
      member[u] = 1;
      stack[depth++] = u;
    }
  }
  lth_free(ctx, stack);
  return LITHE_OK;
}
