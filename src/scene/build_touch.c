/// The closed surface by which bodies touch each other: that of the shape, in pieces no larger than its cells.
#include "scene/body.h"

#include <string.h>

#define EDGE_CELLS                                                                                 \
  1.5 ///< longest edge, in cells: beyond, a bent body would have a straight surface

/// The outer faces of a mesh as polygons. `place` (n_points, zero): of each mesh point among theirs, plus one.
static LitheStatus soup_of_boundary(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *place,
                                    LthSoup **soup) {
  LTH_NEW(ctx, *soup, 1);
  LthSoup *s = *soup;
  LitheIndex n_corners = mesh->loop_off[mesh->face_loop_off[mesh->n_faces]];
  LTH_NEW(ctx, s->points, 3 * (LitheCount)mesh->n_points);
  LTH_NEW(ctx, s->poly_off, (LitheCount)mesh->n_faces + 1);
  LTH_NEW(ctx, s->poly_point, n_corners);
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex loop = mesh->face_loop_off[f], at = s->poly_off[s->n_polys];
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    for (LitheIndex k = mesh->loop_off[loop]; k < mesh->loop_off[loop + 1]; k++) {
      LitheIndex p = mesh->loop_point[k];
      if (place[p] == 0) {
        memcpy(s->points + 3 * (size_t)s->n_points, mesh->points + 3 * (size_t)p,
               3 * sizeof *s->points);
        place[p] = ++s->n_points;
      }
      s->poly_point[at++] = place[p] - 1;
    }
    s->poly_off[++s->n_polys] = at;
  }
  return LITHE_OK;
}

static LitheStatus surface_of_mesh(LitheCtx *ctx, const LthBody *body, LthSurface **surface) {
  LthSoup *soup = NULL;
  LitheIndex *place = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, place, body->mesh->n_points);
  LITHE_TRY_OR(done, soup_of_boundary(ctx, body->mesh, place, &soup));
  LITHE_TRY_OR(done, lth_surface_from_soup(ctx, soup, body->def->name, NULL, surface));
done:
  lth_free(ctx, place);
  lth_soup_destroy(ctx, &soup);
  return status;
}

/// Soup point of each point of the surface, where the embedded surface is this one.
static void map_to_soup(const LthBody *body, LitheIndex *point) {
  const LthSurface *shape = body->def->surface;
  for (LitheIndex i = 0; i < body->touch->n_points; i++) point[i] = i;
  if (!body->def->soup || !shape) return;
  for (LitheIndex i = shape->n_soup_points - 1; i >= 0; i--)
    if (shape->soup_point[i] >= 0) point[shape->soup_point[i]] = i;
}

/// Cells of the points that slicing knows, -1 for others.
static LitheStatus known_cells(LitheCtx *ctx, const LthBody *body, LitheIndex *cells) {
  LitheIndex n_known = body->mesh ? body->mesh->n_surface_points : 0;
  for (LitheIndex i = 0; i < body->touch->n_points; i++) cells[i] = -1;
  if (n_known == 0 || !body->surface || n_known != body->surface->n_points) return LITHE_OK;
  return lth_surface_point_cells(ctx, body->mesh, cells);
}

static LitheStatus embed_touch(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  const LthSurface *s = body->touch;
  LitheIndex *cells = NULL, *off = NULL;
  LTH_NEW_OR(done, ctx, cells, s->n_points);
  LTH_NEW_OR(done, ctx, off, (LitheCount)s->n_tris + 1);
  LITHE_TRY_OR(done, known_cells(ctx, body, cells));
  LITHE_TRY_OR(done,
               lth_build_points(ctx, body, s->n_points, s->points, cells, &body->touch_embedding));
  for (LitheIndex i = 0; i <= s->n_tris; i++) off[i] = 3 * i;
  LITHE_TRY_OR(done, lth_embedding_set_area(ctx, body->touch_embedding, s->n_tris, off, s->tris));
  for (LitheIndex i = 0; i < s->n_points; i++) body->touch_point[i] = i;
done:
  lth_free(ctx, cells);
  lth_free(ctx, off);
  return status;
}

LitheStatus lth_build_touch(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LthSurface *made = NULL;
  if (body->touch) return LITHE_OK; // for another body
  if (body->staggered) LITHE_TRY(lth_body_make_surface(ctx, body));
  const LthSurface *from = body->surface;
  if (!from) {
    LITHE_TRY(surface_of_mesh(ctx, body, &made));
    from = made;
  }
  LITHE_TRY_OR(done, lth_surface_refine(ctx, from, EDGE_CELLS * body->cell_size, &body->touch));
  LTH_NEW_OR(done, ctx, body->touch_point, body->touch->n_points);
  bool is_embedded = body->embedding && body->surface && lth_body_embeds_shape(body);
  if (is_embedded && body->touch->n_points == from->n_points)
    map_to_soup(body, body->touch_point);
  else
    status = embed_touch(ctx, body);
done:
  lth_surface_destroy(ctx, &made);
  return status;
}

const LthEmbedding *lth_body_touch_points(const LthBody *body) {
  return body->touch_embedding ? body->touch_embedding : body->embedding;
}
