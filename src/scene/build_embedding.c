/// The surface that follows a body.
#include "scene/change.h"
#include "scene/cut_surface.h"

#include <math.h>
#include <string.h>

LitheStatus lth_surface_as_soup(LitheCtx *ctx, const LthSurface *surface, LthSoup **soup) {
  LTH_NEW(ctx, *soup, 1);
  LthSoup *s = *soup;
  s->n_points = surface->n_points;
  s->n_polys = surface->n_tris;
  LTH_NEW(ctx, s->points, 3 * (LitheCount)s->n_points);
  LTH_NEW(ctx, s->poly_off, (LitheCount)s->n_polys + 1);
  LTH_NEW(ctx, s->poly_point, 3 * (LitheCount)s->n_polys);
  memcpy(s->points, surface->points, sizeof *s->points * 3 * (size_t)s->n_points);
  memcpy(s->poly_point, surface->tris, sizeof *s->poly_point * 3 * (size_t)s->n_polys);
  for (LitheIndex i = 0; i <= s->n_polys; i++) s->poly_off[i] = 3 * i;
  return LITHE_OK;
}

LitheStatus lth_body_make_surface(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  double resolution = def->shape_resolution > 0 ? def->shape_resolution : body->cell_size / 4;
  if (body->surface) return LITHE_OK;
  return lth_shape_tessellate(ctx, &def->shape, resolution, &body->surface);
}

LitheStatus lth_body_choose_soup(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  if (body->soup) return LITHE_OK;
  body->soup = def->embed_soup ? def->embed_soup : def->soup;
  if (body->soup) return LITHE_OK;
  // where a box of elements is cut, its surface is theirs from the beginning
  bool is_boundary =
      !def->has_shape || (body->change && def->mesh_kind != LTH_MESH_SLICE && !body->surface);
  if (is_boundary) {
    LITHE_TRY(lth_mesh_boundary_soup(ctx, body->mesh, &body->own_soup));
    body->soup = body->own_soup;
    return LITHE_OK;
  }
  LITHE_TRY(lth_body_make_surface(ctx, body));
  LITHE_TRY(lth_surface_as_soup(ctx, body->surface, &body->own_soup));
  body->soup = body->own_soup;
  return LITHE_OK;
}

/// Cells of the soup's points where slicing knows them, else -1.
static LitheStatus known_cells(LitheCtx *ctx, const LthBody *body, LitheIndex *cells) {
  const LthSceneBody *def = body->def;
  LitheIndex *surface_cells = NULL;
  LitheIndex n_known = body->mesh ? body->mesh->n_surface_points : 0;
  const LitheIndex *map = def->surface ? def->surface->soup_point : NULL;
  bool is_sliced = n_known > 0 && lth_body_embeds_shape(body);
  const LthCutSurface *cut = body->change ? body->change->surface : NULL;
  if (cut && cut->is_cut) {
    memcpy(cells, cut->cell, sizeof *cells * (size_t)body->soup->n_points);
    return LITHE_OK;
  }
  for (LitheIndex i = 0; i < body->soup->n_points; i++) cells[i] = -1;
  if (!is_sliced) return LITHE_OK;
  LTH_NEW(ctx, surface_cells, n_known);
  LitheStatus status = lth_surface_point_cells(ctx, body->mesh, surface_cells);
  for (LitheIndex i = 0; status == LITHE_OK && i < body->soup->n_points; i++) {
    LitheIndex point = map ? map[i] : i;
    if (point >= 0 && point < n_known) cells[i] = surface_cells[point];
  }
  lth_free(ctx, surface_cells);
  return status;
}

/// A surface of its own that lies elsewhere is most likely in another unit or place: it would be carried
/// along by the nearest elements.
static void warn_of_far_points(LitheCtx *ctx, const LthBody *body) {
  const LthSoup *soup = body->def->embed_soup;
  const double margin = body->cell_size;
  LitheIndex n_far = 0;
  double farthest = 0;
  for (LitheIndex i = 0; soup && i < soup->n_points; i++) {
    double outside = 0;
    for (int a = 0; a < 3; a++) {
      double x = soup->points[3 * (LitheCount)i + a];
      outside = fmax(outside, fmax(body->box[a] - x, x - body->box[3 + a]));
    }
    n_far += outside > margin;
    farthest = fmax(farthest, outside);
  }
  if (n_far > 0)
    lth_warn(
        ctx,
        "%s.embed.surface: %d of %d points lie outside the body, up to %.3g m away, and follow "
        "its nearest elements: are unit, scale and place those of the shape?",
        body->def->path, n_far, soup->n_points, farthest);
}

LitheStatus lth_build_points(LitheCtx *ctx, const LthBody *body, LitheIndex n, const double *points,
                             const LitheIndex *cells, LthEmbedding **embedding) {
  // elements that fit together need no averages: points follow them directly
  if (!body->space)
    return lth_embedding_create_direct(ctx, body->disc, n, points, cells, embedding);
  return lth_embedding_create(ctx, body->space, n, points, cells, body->def->interpolation,
                              body->def->samples, embedding);
}

/// The points of the surface: those of a body whose elements change take rows over that stay the same.
static LitheStatus embed_points(LitheCtx *ctx, LthBody *body, const LitheIndex *cells) {
  const LthSoup *soup = body->soup;
  if (!body->space || !body->change)
    return lth_build_points(ctx, body, soup->n_points, soup->points, cells, &body->embedding);
  return lth_embedding_renew(ctx, body->space, soup->n_points, soup->points, cells,
                             body->def->interpolation, body->def->samples,
                             body->change->cell_record, &body->change->rows, &body->embedding);
}

static LitheStatus embed_surface(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LitheIndex *cells = NULL;
  LITHE_TRY(lth_body_choose_soup(ctx, body));
  if (!body->sim) warn_of_far_points(ctx, body);
  LTH_NEW_OR(done, ctx, cells, body->soup->n_points);
  LITHE_TRY_OR(done, known_cells(ctx, body, cells));
  LITHE_TRY_OR(done, embed_points(ctx, body, cells));
  LITHE_TRY_OR(done, lth_embedding_set_area(ctx, body->embedding, body->soup->n_polys,
                                            body->soup->poly_off, body->soup->poly_point));

done:
  lth_free(ctx, cells);
  return status;
}

LitheStatus lth_build_embedding(LitheCtx *ctx, LthBody *body) {
  return body->def->has_embed ? embed_surface(ctx, body) : LITHE_OK;
}
