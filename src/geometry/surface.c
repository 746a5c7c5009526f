/// The clean surface: made from a soup step by step, measured, freed.
#include "geometry/surface.h"

#include "base/tensor.h"
#include "geometry/surface_clean.h"

#define MENDED_PAIRS_MAX 100
#define MEND_ROUNDS_MAX 10

void lth_surface_destroy(LitheCtx *ctx, LthSurface **surface) {
  if (!surface || !*surface) return;
  lth_free(ctx, (*surface)->points);
  lth_free(ctx, (*surface)->tris);
  lth_free(ctx, (*surface)->tri_shell);
  lth_free(ctx, (*surface)->tri_poly);
  lth_free(ctx, (*surface)->soup_point);
  lth_free(ctx, *surface);
  *surface = NULL;
}

void lth_surface_bounds(const LthSurface *surface, double min[3], double max[3]) {
  for (int i = 0; i < 3; i++) min[i] = INFINITY, max[i] = -INFINITY;
  for (LitheIndex p = 0; p < surface->n_points; p++)
    for (int i = 0; i < 3; i++) {
      min[i] = fmin(min[i], surface->points[3 * (size_t)p + (size_t)i]);
      max[i] = fmax(max[i], surface->points[3 * (size_t)p + (size_t)i]);
    }
}

/// Twice the area vector of a triangle; `to` goes from `center` to its first corner.
static void area_vector(const LthSurface *surface, LitheIndex tri, const double center[3],
                        double cross[3], double to[3]) {
  const LitheIndex *t = surface->tris + 3 * (size_t)tri;
  const double *a = surface->points + 3 * (size_t)t[0], *b = surface->points + 3 * (size_t)t[1],
               *c = surface->points + 3 * (size_t)t[2];
  double e[3], f[3];
  lth_v3_sub(b, a, e);
  lth_v3_sub(c, a, f);
  lth_v3_sub(a, center, to);
  lth_v3_cross(e, f, cross);
}

double lth_surface_volume(const LthSurface *surface) {
  double min[3], max[3], center[3], cross[3], to[3], volume = 0;
  lth_surface_bounds(surface, min, max);
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (min[i] + max[i]);
  for (LitheIndex t = 0; t < surface->n_tris; t++) {
    area_vector(surface, t, center, cross, to);
    volume += lth_v3_dot(cross, to);
  }
  return volume / 6;
}

double lth_surface_area(const LthSurface *surface) {
  const double origin[3] = {0, 0, 0};
  double cross[3], to[3], area = 0;
  for (LitheIndex t = 0; t < surface->n_tris; t++) {
    area_vector(surface, t, origin, cross, to);
    area += lth_v3_norm(cross);
  }
  return area / 2;
}

// ------------------------------------------------------------------ cleaning

static void cleaner_free(LthCleaner *c) {
  LitheCtx *ctx = c->ctx;
  lth_free(ctx, c->points);
  lth_free(ctx, c->soup_point);
  lth_free(ctx, c->tris);
  lth_free(ctx, c->tri_poly);
  lth_free(ctx, c->tri_is_mixed);
  lth_free(ctx, c->tri_shell);
  lth_free(ctx, c->edge_off);
  lth_free(ctx, c->edge_half);
  lth_free(ctx, c->half_edge);
  lth_free(ctx, c->pair);
}

/// Weld, triangulate, drop what covers nothing, make orientation agree; bad edges become defects.
static LitheStatus make_manifold(LthCleaner *c) {
  LitheIndex n_turned = 0;
  LITHE_TRY(lth_clean_weld(c));
  LITHE_TRY(lth_clean_triangulate(c));
  LTH_NEW(c->ctx, c->tri_is_mixed, c->n_tris);
  LTH_NEW(c->ctx, c->tri_shell, c->n_tris);
  LITHE_TRY(lth_clean_reduce(c));
  LITHE_TRY(lth_clean_find_bad_edges(c));
  LITHE_TRY(lth_clean_orient(c));
  if (c->defects->n > 0) return LITHE_OK;

  LITHE_TRY(lth_clean_needles(c, &n_turned));
  if (n_turned == 0) return LITHE_OK;
  LITHE_TRY(lth_clean_reduce(c));
  LITHE_TRY(lth_clean_edges(c));
  LITHE_TRY(lth_clean_find_bad_edges(c));
  return lth_clean_orient(c);
}

/// Crossings, and in a surface without defects the nesting of its shells. *n_changes counts what was mended.
static LitheStatus look_inside(LthCleaner *c, LitheIndex *n_changes, double *moved) {
  LitheStatus status = LITHE_OK;
  LthBvh *bvh = NULL;
  double *boxes = NULL;
  bool was_manifold = c->defects->n == 0;
  *n_changes = 0;
  LTH_NEW_OR(done, c->ctx, boxes, 6 * (LitheCount)c->n_tris);
  for (LitheIndex t = 0; t < c->n_tris; t++)
    lth_clean_box(c, c->tris + 3 * (size_t)t, boxes + 6 * (size_t)t);
  LITHE_TRY_OR(done, lth_bvh_create_boxes(c->ctx, c->n_tris, boxes, &bvh));
  LITHE_TRY_OR(done, lth_clean_find_crossings(c, boxes, bvh));
  if (c->defects->n == 0)
    LITHE_TRY_OR(done, lth_clean_nest(c, bvh));
  else if (was_manifold && c->n_pairs <= MENDED_PAIRS_MAX)
    LITHE_TRY_OR(done, lth_clean_mend(c, bvh, n_changes, moved));
done:
  lth_bvh_destroy(c->ctx, &bvh);
  lth_free(c->ctx, boxes);
  return status;
}

/// Look for crossings and mend slight ones until there is none or nothing helps.
static LitheStatus find_inside(LthCleaner *c) {
  LitheIndex n_changes = 0, n_all = 0, n_first = 0;
  double moved = 0;
  for (int round = 0; round < MEND_ROUNDS_MAX; round++) {
    if (n_changes) lth_defects_free(c->ctx, c->defects);
    LITHE_TRY(look_inside(c, &n_changes, &moved));
    if (round == 0) n_first = c->n_pairs;
    n_all += n_changes;
    if (n_changes == 0) break;
  }
  if (n_all && c->defects->n == 0)
    lth_warn(c->ctx,
             "%s: %d pairs of triangles that crossed slightly mended by turning edges or removing "
             "points at %d places; the surface moved by at most %.2g %% of its size",
             c->name, n_first, n_all, 100 * moved / c->size);
  return LITHE_OK;
}

/// Leave out points that no triangle uses and hand the arrays over.
static LitheStatus take_surface(LthCleaner *c, LthSurface **surface) {
  LthSurface *s = NULL;
  LitheIndex *place = NULL; // new number + 1 of each welded point
  LTH_NEW(c->ctx, place, c->n_points);
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, c->ctx, s, 1);
  for (LitheIndex i = 0; i < 3 * c->n_tris; i++) place[c->tris[i]] = 1;
  for (LitheIndex p = 0; p < c->n_points; p++) {
    if (!place[p]) continue;
    lth_v3_copy(lth_clean_point(c, p), c->points + 3 * (size_t)s->n_points);
    place[p] = ++s->n_points;
  }
  for (LitheIndex i = 0; i < 3 * c->n_tris; i++) c->tris[i] = place[c->tris[i]] - 1;
  for (LitheIndex i = 0; i < c->soup->n_points; i++)
    if (c->soup_point[i] >= 0) c->soup_point[i] = place[c->soup_point[i]] - 1;

  s->n_tris = c->n_tris;
  s->n_shells = c->n_shells;
  s->n_soup_points = c->soup->n_points;
  s->points = c->points, c->points = NULL;
  s->tris = c->tris, c->tris = NULL;
  s->tri_shell = c->tri_shell, c->tri_shell = NULL;
  s->tri_poly = c->tri_poly, c->tri_poly = NULL;
  s->soup_point = c->soup_point, c->soup_point = NULL;
  *surface = s;
done:
  lth_free(c->ctx, place);
  return status;
}

LitheStatus lth_surface_from_soup(LitheCtx *ctx, const LthSoup *soup, const char *name,
                                  LthDefects *defects, LthSurface **surface) {
  LitheStatus status = LITHE_OK;
  LthDefects own = {0};
  LthCleaner c = {.ctx = ctx, .name = name, .soup = soup, .defects = defects ? defects : &own};
  *surface = NULL;
  *c.defects = (LthDefects){0};
  LITHE_TRY_OR(done, make_manifold(&c));
  LITHE_TRY_OR(done, find_inside(&c));
  c.defects->size = c.size;
  LITHE_TRY_OR(done, lth_defects_check(ctx, c.defects, name));
  LITHE_TRY_OR(done, take_surface(&c, surface));
done:
  cleaner_free(&c);
  lth_defects_free(ctx, &own);
  return status;
}
