/// Polygon soups: freeing, triangulating.
#include "geometry/polygon.h"
#include "geometry/surface.h"

void lth_soup_destroy(LitheCtx *ctx, LthSoup **soup) {
  if (!soup || !*soup) return;
  LthSoup *s = *soup;
  if (s->group_names)
    for (LitheIndex i = 0; i < s->n_groups; i++) lth_free(ctx, s->group_names[i]);
  lth_free(ctx, s->group_names);
  lth_free(ctx, s->points);
  lth_free(ctx, s->poly_off);
  lth_free(ctx, s->poly_point);
  lth_free(ctx, s->uvs);
  lth_free(ctx, s->poly_uv);
  lth_free(ctx, s->poly_group);
  lth_free(ctx, s);
  *soup = NULL;
}

static LitheStatus count_triangles(LitheCtx *ctx, const LthSoup *soup, LitheCount *n) {
  *n = 0;
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    LitheIndex corners = soup->poly_off[p + 1] - soup->poly_off[p];
    if (corners > LTH_POLYGON_MAX)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "polygon %d has %d corners, at most %d can be triangulated",
                 p, corners, LTH_POLYGON_MAX);
    if (corners >= 3) *n += corners - 2;
  }
  if (3 * *n > INT32_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%lld triangles are more than can be used", (long long)*n);
  return LITHE_OK;
}

LitheStatus lth_soup_triangulate(LitheCtx *ctx, const LthSoup *soup, LitheIndex *n_tris,
                                 LitheIndex **tris, LitheIndex **tri_poly) {
  LitheStatus status = LITHE_OK;
  LthPolygonWork work = {0};
  LitheCount n = 0, t = 0;
  *n_tris = 0;
  *tris = *tri_poly = NULL;
  LITHE_TRY(count_triangles(ctx, soup, &n));
  LTH_NEW_OR(done, ctx, *tris, 3 * n);
  LTH_NEW_OR(done, ctx, *tri_poly, n);
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    LitheIndex corners = soup->poly_off[p + 1] - soup->poly_off[p];
    if (corners < 3) continue;
    LITHE_TRY_OR(done,
                 lth_polygon_triangulate(ctx, &work, soup->points, corners,
                                         soup->poly_point + soup->poly_off[p], *tris + 3 * t));
    for (LitheIndex i = 0; i < corners - 2; i++) (*tri_poly)[t++] = p;
  }
  *n_tris = (LitheIndex)n;
done:
  lth_polygon_work_free(ctx, &work);
  if (status != LITHE_OK) {
    lth_free(ctx, *tris);
    lth_free(ctx, *tri_poly);
    *tris = *tri_poly = NULL;
  }
  return status;
}
