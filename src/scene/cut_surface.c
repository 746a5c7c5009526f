/// Cut surfaces: what they begin with, and following a body's elements.
#include "scene/cut_surface.h"

#include "scene/change.h"

#include "base/tensor.h"

#include <string.h>

#define NUDGE                                                                                      \
  1e-3 ///< of the way to the middle of its cell: puts a point off the cuts that it lies on

// ------------------------------------------------------------------ beginning

/// What a skin begins with; the arrays are the caller's.
typedef struct Start {
  LthSkinDef def;
  LthSoup *soup; ///< NULL: the body's
  LitheIndex *point, *facet_poly, *face_facet;
  bool *is_inward;
} Start;

static void free_start(LitheCtx *ctx, Start *s) {
  lth_soup_destroy(ctx, &s->soup);
  lth_free(ctx, s->point);
  lth_free(ctx, s->facet_poly);
  lth_free(ctx, s->face_facet);
  lth_free(ctx, s->is_inward);
}

/// Does a triangle run against the polygon that it is a part of? 1, -1: with it, 0: not all its corners are the polygon's.
static int runs_against(const LthSurface *surface, LitheIndex tri, const LthSoup *soup,
                        LitheIndex poly) {
  LitheIndex at[3] = {-1, -1, -1}, begin = soup->poly_off[poly], end = soup->poly_off[poly + 1];
  for (int i = 0; i < 3; i++)
    for (LitheIndex k = begin; k < end; k++)
      if (surface->soup_point[soup->poly_point[k]] == surface->tris[3 * tri + i]) at[i] = k;
  if (at[0] < 0 || at[1] < 0 || at[2] < 0) return 0;
  int n_rising = (at[1] > at[0]) + (at[2] > at[1]) + (at[0] > at[2]);
  return n_rising == 2 ? -1 : 1;
}

/// Polygons that face inward; of those that do not say so themselves, as most of the others.
static LitheStatus find_inward(LitheCtx *ctx, const LthSurface *surface, const LthSoup *soup,
                               Start *s) {
  int8_t *turn = NULL;
  LitheIndex n_inward = 0, n_outward = 0;
  LTH_NEW(ctx, s->is_inward, soup->n_polys);
  LTH_NEW(ctx, turn, soup->n_polys);
  for (LitheIndex t = 0; t < surface->n_tris; t++) {
    LitheIndex poly = surface->tri_poly[t];
    if (turn[poly] == 0) turn[poly] = (int8_t)runs_against(surface, t, soup, poly);
  }
  for (LitheIndex p = 0; p < soup->n_polys; p++) n_inward += turn[p] > 0, n_outward += turn[p] < 0;
  for (LitheIndex p = 0; p < soup->n_polys; p++)
    s->is_inward[p] = turn[p] != 0 ? turn[p] > 0 : n_inward > n_outward;
  s->def.is_inward = s->is_inward;
  lth_free(ctx, turn);
  return LITHE_OK;
}

/// Triangles of a surface that a mesh was sliced from. `is_made`: the surface was made from the soup, else their points
/// and triangles are the same.
static LitheStatus start_sliced(LitheCtx *ctx, const LthMesh *mesh, const LthSurface *surface,
                                bool is_made, Start *s) {
  LitheIndex n = s->def.soup->n_points;
  if (is_made) LITHE_TRY(find_inward(ctx, surface, s->def.soup, s));
  LTH_NEW(ctx, s->point, n);
  LTH_NEW(ctx, s->facet_poly, surface->n_tris);
  LTH_NEW(ctx, s->face_facet, mesh->n_faces);
  for (LitheIndex i = 0; i < n; i++) s->point[i] = is_made ? surface->soup_point[i] : i;
  for (LitheIndex t = 0; t < surface->n_tris; t++)
    s->facet_poly[t] = is_made ? surface->tri_poly[t] : t;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) s->face_facet[f] = mesh->face_tag[f];
  s->def.n_facets = surface->n_tris;
  return LITHE_OK;
}

/// The boundary faces of a mesh, in the order of lth_mesh_boundary_soup().
static LitheStatus start_boundary(LitheCtx *ctx, const LthMesh *mesh, Start *s) {
  LitheIndex k = 0;
  LTH_NEW(ctx, s->point, s->def.soup->n_points);
  LTH_NEW(ctx, s->facet_poly, s->def.soup->n_polys);
  LTH_NEW(ctx, s->face_facet, mesh->n_faces);
  for (LitheIndex i = 0; i < s->def.soup->n_polys; i++) s->facet_poly[i] = i;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    s->face_facet[f] = mesh->face_cell[2 * f + 1] < 0 ? s->def.n_facets++ : -1;
    if (s->face_facet[f] < 0) continue;
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         i < mesh->loop_off[mesh->face_loop_off[f] + 1]; i++)
      s->point[s->def.soup->poly_point[k++]] = mesh->loop_point[i];
  }
  return LITHE_OK;
}

static LitheStatus create_skin(LitheCtx *ctx, const LthTopology *t, const LthMesh *mesh, Start *s,
                               LthSkin **skin) {
  s->def.topology = t;
  s->def.n_faces = mesh->n_faces;
  s->def.point = s->point;
  s->def.facet_poly = s->facet_poly;
  s->def.face_facet = s->face_facet;
  return lth_skin_create(ctx, &s->def, skin);
}

/// Is the body's boundary cut from the triangles of its surface?
static bool is_sliced(const LthBody *body) {
  const LthMesh *mesh = body->mesh;
  return body->surface && mesh->n_surface_points > 0 &&
         mesh->n_surface_points == body->surface->n_points;
}

/// A soup of the body's own boundary behind the points of one that it cannot be made from.
static LitheStatus replace_soup(LitheCtx *ctx, const LthBody *body, Start *s) {
  LthSoup *boundary = NULL;
  LitheStatus status = LITHE_OK;
  LitheIndex n = body->soup->n_points;
  if (is_sliced(body))
    LITHE_TRY_OR(done, lth_surface_as_soup(ctx, body->surface, &boundary));
  else
    LITHE_TRY_OR(done, lth_mesh_boundary_soup(ctx, body->mesh, &boundary));
  s->def.soup = boundary;
  if (is_sliced(body))
    LITHE_TRY_OR(done, start_sliced(ctx, body->mesh, body->surface, false, s));
  else
    LITHE_TRY_OR(done, start_boundary(ctx, body->mesh, s));
  LTH_NEW_OR(done, ctx, s->soup, 1);
  LthSoup *both = s->soup;
  LitheCount n_corners = boundary->poly_off[boundary->n_polys];
  LitheIndex *point = NULL;
  both->n_points = n + boundary->n_points;
  both->n_polys = boundary->n_polys;
  both->poly_off = boundary->poly_off, boundary->poly_off = NULL;
  both->poly_point = boundary->poly_point, boundary->poly_point = NULL;
  LTH_NEW_OR(done, ctx, both->points, 3 * (LitheCount)both->n_points);
  memcpy(both->points, body->soup->points, 3 * sizeof *both->points * (size_t)n);
  memcpy(both->points + 3 * (LitheCount)n, boundary->points,
         3 * sizeof *both->points * (size_t)boundary->n_points);
  for (LitheCount i = 0; i < n_corners; i++) both->poly_point[i] += n;
  LTH_NEW_OR(done, ctx, point, both->n_points);
  for (LitheIndex i = 0; i < both->n_points; i++) point[i] = i < n ? -1 : s->point[i - n];
  lth_free(ctx, s->point);
  s->point = point;
  s->def.soup = both;
done:
  lth_soup_destroy(ctx, &boundary);
  return status;
}

/// The skin of the body's own elements.
static LitheStatus begin_own(LitheCtx *ctx, LthBody *body, bool replaces, LthSkin **skin) {
  const LthSurface *file = body->def->surface;
  LitheStatus status = LITHE_OK;
  Start s = {.def = {.soup = body->soup}};
  if (replaces)
    LITHE_TRY_OR(done, replace_soup(ctx, body, &s));
  else if (!is_sliced(body))
    LITHE_TRY_OR(done, start_boundary(ctx, body->mesh, &s));
  else
    LITHE_TRY_OR(done,
                 start_sliced(ctx, body->mesh, file ? file : body->surface, file != NULL, &s));
  status = create_skin(ctx, body->change->topology, body->mesh, &s, skin);
done:
  free_start(ctx, &s);
  return status;
}

/// A grid with cells like those of the body, over its box.
static LitheStatus grid_of_body(LitheCtx *ctx, const LthBody *body, LthGrid *grid) {
  const double *box = body->box;
  if (body->def->has_shape) return lth_build_grid(ctx, body->def, box, box + 3, grid);
  for (int a = 0; a < 3; a++) {
    double n = floor((box[3 + a] - box[a]) / body->cell_size + 0.5);
    grid->min[a] = box[a];
    grid->max[a] = box[3 + a];
    grid->cells[a] = n < 1 ? 1 : n > 400 ? 400 : (LitheIndex)n;
  }
  return LITHE_OK;
}

/// The inside of a closed surface as elements of its own.
static LitheStatus begin_solid(LitheCtx *ctx, LthBody *body, const LthSurface *surface) {
  LthCutSurface *c = body->change->surface;
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LthGrid grid;
  Start s = {.def = {.soup = body->soup}};
  LITHE_TRY_OR(done, grid_of_body(ctx, body, &grid));
  LITHE_TRY_OR(done, lth_mesh_slice(ctx, surface, &grid, 0, &mesh));
  LITHE_TRY_OR(done, lth_topology_create(ctx, mesh, &c->solid));
  LITHE_TRY_OR(done, start_sliced(ctx, mesh, surface, true, &s));
  status = create_skin(ctx, c->solid, mesh, &s, &c->skin);
done:
  lth_mesh_destroy(ctx, &mesh);
  free_start(ctx, &s);
  return status;
}

/// A surface with a place of its own: cut where it is closed, else the body's own boundary takes its place.
static LitheStatus begin_other(LitheCtx *ctx, LthBody *body) {
  LthCutSurface *c = body->change->surface;
  LthSurface *closed = NULL;
  LitheStatus status = lth_surface_from_soup(ctx, body->soup, body->def->name, NULL, &closed);
  if (status == LITHE_OK) status = begin_solid(ctx, body, closed);
  lth_surface_destroy(ctx, &closed);
  if (status != LITHE_BAD_INPUT) return status;
  lth_warn(ctx,
           "%s.embed: its surface is not closed, so that a cut has no inside to show: from the "
           "first cut on the boundary of the body is written in its place",
           body->def->path);
  lth_topology_destroy(ctx, &c->solid);
  lth_skin_destroy(ctx, &c->skin);
  return begin_own(ctx, body, true, &c->skin);
}

LitheStatus lth_cut_surface_begin(LitheCtx *ctx, LthBody *body) {
  if (!body->def->has_embed) return LITHE_OK;
  LITHE_TRY(lth_body_choose_soup(ctx, body));
  LTH_NEW(ctx, body->change->surface, 1);
  bool is_own = body->soup == body->own_soup || (lth_body_embeds_shape(body) && is_sliced(body));
  return is_own ? begin_own(ctx, body, false, &body->change->surface->skin)
                : begin_other(ctx, body);
}

void lth_cut_surface_end(LitheCtx *ctx, LthCutSurface **surface) {
  LthCutSurface *c = *surface;
  if (!c) return;
  lth_skin_destroy(ctx, &c->skin);
  lth_topology_destroy(ctx, &c->solid);
  lth_free(ctx, c->cell);
  lth_free(ctx, c->home);
  lth_free(ctx, c);
  *surface = NULL;
}

// ------------------------------------------------------------------ following

/// Cells of the mesh for all points.
static LitheStatus number_cells(LitheCtx *ctx, const LthBody *body, LitheIndex n_cells,
                                const LitheIndex *cell_record) {
  LthCutSurface *c = body->change->surface;
  const LitheIndex *record = c->solid ? c->home : c->skin->cell;
  LitheIndex n = c->skin->soup->n_points, n_records = body->change->topology->n_cells;
  LitheIndex *place = NULL;
  LTH_RESERVE(ctx, c->cell, c->cap_cell, n);
  LTH_NEW(ctx, place, n_records);
  for (LitheIndex i = 0; i < n_records; i++) place[i] = -1;
  for (LitheIndex i = 0; i < n_cells; i++) place[cell_record[i]] = i;
  for (LitheIndex i = 0; i < n; i++) c->cell[i] = record[i] >= 0 ? place[record[i]] : -1;
  lth_free(ctx, place);
  return LITHE_OK;
}

LitheStatus lth_cut_surface_follow(LitheCtx *ctx, LthBody *body, const LthMesh *mesh,
                                   const LitheIndex *cell_record) {
  LthBodyChange *change = body->change;
  LthCutSurface *c = change->surface;
  if (!c) return LITHE_OK;
  bool is_cut_now = change->n_cuts > c->n_cuts;
  if (c->solid) {
    LITHE_TRY(lth_cut_solid_follow(ctx, body, mesh, cell_record));
  } else {
    LITHE_TRY(lth_skin_follow(ctx, c->skin, change->topology));
    if (is_cut_now) LITHE_TRY(lth_skin_update(ctx, c->skin, change->topology));
  }
  LITHE_TRY(number_cells(ctx, body, mesh->n_cells, cell_record));
  c->is_cut = c->is_cut || is_cut_now;
  c->has_changed = c->has_changed || (is_cut_now && body->sim);
  if (c->is_cut) body->soup = c->skin->soup;
  c->n_cuts = change->n_cuts;
  return LITHE_OK;
}

// ------------------------------------------------------------------ archive

static LitheStatus make_room(LitheCtx *ctx, LthCutSurface *c, LitheCount n) {
  LthSkin *s = c->skin;
  LTH_RESERVE(ctx, s->soup->points, s->points_cap, 3 * n);
  LTH_RESERVE(ctx, s->place, s->place_cap, 3 * n);
  LTH_RESERVE(ctx, s->cell, s->cell_cap, n);
  LTH_RESERVE(ctx, s->point, s->point_cap, n);
  if (c->solid) LTH_RESERVE(ctx, c->home, c->cap_home, n);
  return LITHE_OK;
}

static void walk_skin(LthCutSurface *c, LthArchive *a) {
  LthSkin *s = c->skin;
  LitheCount n = s->soup->n_points;
  lth_archive_count(a, &n);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room(a->ctx, c, n);
  if (a->status != LITHE_OK) return;
  s->soup->n_points = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(a, s->soup->points, 3 * n);
  LTH_ARCHIVE_ARRAY(a, s->place, 3 * n);
  LTH_ARCHIVE_ARRAY(a, s->cell, n);
  LTH_ARCHIVE_ARRAY(a, s->point, n);
}

static void walk_solid(LthCutSurface *c, LthArchive *a) {
  lth_topology_archive(c->solid, a);
  if (a->status != LITHE_OK) return;
  LTH_ARCHIVE(a, c->n_home);
  LTH_ARCHIVE_ARRAY(a, c->home, c->n_home);
}

/// Polygons as the cuts left them: elements may have been divided since, which they do not show.
static LitheStatus make_polygons(LitheCtx *ctx, LthSoup *soup, const LitheCount n[3], bool has_uv) {
  void *blocks[] = {soup->poly_off, soup->poly_point, soup->poly_group, soup->poly_uv, soup->uvs};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  soup->poly_off = soup->poly_point = soup->poly_group = soup->poly_uv = NULL;
  soup->uvs = NULL;
  LTH_NEW(ctx, soup->poly_off, n[0] + 1);
  LTH_NEW(ctx, soup->poly_point, n[1]);
  LTH_NEW(ctx, soup->poly_group, n[0]);
  if (has_uv) LTH_NEW(ctx, soup->poly_uv, n[1]);
  if (has_uv) LTH_NEW(ctx, soup->uvs, 2 * n[2]);
  soup->n_polys = (LitheIndex)n[0], soup->n_uvs = (LitheIndex)n[2];
  return LITHE_OK;
}

static void walk_polygons(LthSkin *skin, LthArchive *a) {
  LthSoup *soup = skin->soup;
  LitheCount n[3] = {soup->n_polys, a->is_reading ? 0 : soup->poly_off[soup->n_polys], soup->n_uvs};
  bool has_uv = soup->poly_uv != NULL;
  for (int i = 0; i < 3; i++) lth_archive_count(a, n + i);
  LTH_ARCHIVE(a, has_uv);
  LTH_ARCHIVE(a, skin->n_caps);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_polygons(a->ctx, soup, n, has_uv);
  if (a->status != LITHE_OK) return;
  LTH_ARCHIVE_ARRAY(a, soup->poly_off, n[0] + 1);
  LTH_ARCHIVE_ARRAY(a, soup->poly_point, n[1]);
  LTH_ARCHIVE_ARRAY(a, soup->poly_group, n[0]);
  if (has_uv) LTH_ARCHIVE_ARRAY(a, soup->poly_uv, n[1]);
  if (has_uv) LTH_ARCHIVE_ARRAY(a, soup->uvs, 2 * n[2]);
}

static LitheStatus restore(LitheCtx *ctx, LthBody *body) {
  LthCutSurface *c = body->change->surface;
  if (c->is_cut) body->soup = c->skin->soup;
  if (c->solid && c->n_home < c->skin->soup->n_points) return LITHE_OK; // nothing was ever followed
  return number_cells(ctx, body, body->mesh->n_cells, body->change->cell_record);
}

void lth_cut_surface_archive(LthBody *body, LthArchive *a) {
  LthCutSurface *c = body->change->surface;
  if (!c) return;
  lth_archive_mark(a, "cut surface");
  LTH_ARCHIVE(a, c->is_cut);
  LTH_ARCHIVE(a, c->has_changed);
  LTH_ARCHIVE(a, c->n_cuts);
  walk_skin(c, a);
  if (c->is_cut && a->status == LITHE_OK) walk_polygons(c->skin, a);
  if (c->solid) walk_solid(c, a);
  if (a->status == LITHE_OK && a->is_reading) a->status = restore(a->ctx, body);
}
