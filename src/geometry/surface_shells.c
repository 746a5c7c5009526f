/// Shells of a surface: numbered, measured, left out.
#include "geometry/surface_shells.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"

/// Number the connected shells in the order of their first triangles.
static LitheStatus number_shells(LitheCtx *ctx, LthSurface *s) {
  LitheIndex *parent = NULL, *shell = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, parent, s->n_points);
  LTH_NEW_OR(done, ctx, shell, s->n_points);
  lth_sets_reset(parent, s->n_points);
  for (LitheIndex p = 0; p < s->n_points; p++) shell[p] = -1;
  for (LitheIndex h = 0; h < 3 * s->n_tris; h++) {
    lth_sets_unite(parent, s->tris[h], s->tris[h / 3 * 3]);
  }
  s->n_shells = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    LitheIndex root = lth_sets_root(parent, s->tris[3 * (size_t)t]);
    if (shell[root] < 0) shell[root] = s->n_shells++;
    s->tri_shell[t] = shell[root];
  }
done:
  lth_free(ctx, parent);
  lth_free(ctx, shell);
  return status;
}

LitheStatus lth_surface_from_triangles(LitheCtx *ctx, LitheIndex n_points, double **points,
                                       LitheIndex n_tris, LitheIndex **tris, LthSurface **surface) {
  LitheStatus status = LITHE_OK;
  LthSurface *s = NULL;
  *surface = NULL;
  LTH_NEW_OR(done, ctx, s, 1);
  LTH_NEW_OR(done, ctx, s->tri_shell, n_tris);
  LTH_NEW_OR(done, ctx, s->tri_poly, n_tris);
  LTH_NEW_OR(done, ctx, s->soup_point, n_points);
  s->n_points = s->n_soup_points = n_points;
  s->n_tris = n_tris;
  s->points = *points, *points = NULL;
  s->tris = *tris, *tris = NULL;
  for (LitheIndex t = 0; t < n_tris; t++) s->tri_poly[t] = t;
  for (LitheIndex p = 0; p < n_points; p++) s->soup_point[p] = p;
  LITHE_TRY_OR(done, number_shells(ctx, s));
  *surface = s;
  s = NULL;
done:
  lth_surface_destroy(ctx, &s);
  return status;
}

void lth_surface_shell_volumes(const LthSurface *s, double *volume) {
  double min[3], max[3], center[3], a[3][3], cross[3];
  lth_surface_bounds(s, min, max);
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (min[i] + max[i]);
  for (LitheIndex shell = 0; shell < s->n_shells; shell++) volume[shell] = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    for (int k = 0; k < 3; k++)
      lth_v3_sub(s->points + 3 * (size_t)s->tris[3 * (size_t)t + (size_t)k], center, a[k]);
    lth_v3_cross(a[1], a[2], cross);
    volume[s->tri_shell[t]] += lth_v3_dot(a[0], cross) / 6;
  }
}

/// Keep the shells that have a new number, in order, and the points they use.
static void keep_shells(LthSurface *s, const LitheIndex *shell, LitheIndex *place) {
  LitheIndex n_tris = 0, n_points = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    if (shell[s->tri_shell[t]] < 0) continue;
    s->tri_shell[n_tris] = shell[s->tri_shell[t]];
    memmove(s->tris + 3 * (size_t)n_tris, s->tris + 3 * (size_t)t, 3 * sizeof *s->tris);
    n_tris++;
  }
  for (LitheIndex p = 0; p < s->n_points; p++) place[p] = -1;
  for (LitheIndex h = 0; h < 3 * n_tris; h++) place[s->tris[h]] = 0;
  for (LitheIndex p = 0; p < s->n_points; p++) {
    if (place[p] < 0) continue;
    memmove(s->points + 3 * (size_t)n_points, s->points + 3 * (size_t)p, 3 * sizeof *s->points);
    place[p] = n_points++;
  }
  for (LitheIndex h = 0; h < 3 * n_tris; h++) s->tris[h] = place[s->tris[h]];
  s->n_tris = n_tris;
  s->n_points = s->n_soup_points = n_points;
}

LitheStatus lth_surface_drop_small(LitheCtx *ctx, LthSurface *s, double smallest) {
  LitheStatus status = LITHE_OK;
  double *volume = NULL;
  LitheIndex *shell = NULL, *place = NULL, n = 0;
  LTH_NEW_OR(done, ctx, volume, s->n_shells);
  LTH_NEW_OR(done, ctx, shell, s->n_shells);
  LTH_NEW_OR(done, ctx, place, s->n_points);
  lth_surface_shell_volumes(s, volume);
  for (LitheIndex i = 0; i < s->n_shells; i++) shell[i] = fabs(volume[i]) < smallest ? -1 : n++;
  if (n < s->n_shells) keep_shells(s, shell, place);
  s->n_shells = n;
done:
  lth_free(ctx, volume);
  lth_free(ctx, shell);
  lth_free(ctx, place);
  return status;
}
