/// Skins: what they keep from one cut to the next.
#include "mesh/skin_priv.h"

static LitheStatus copy(LitheCtx *ctx, const void *from, LitheCount n, size_t size, void **to) {
  *to = NULL;
  if (!from) return LITHE_OK;
  LITHE_TRY(lth_new_(ctx, to, n, size));
  memcpy(*to, from, (size_t)n * size);
  return LITHE_OK;
}

static LitheStatus copy_soup(LitheCtx *ctx, const LthSoup *from, LthSoup **soup) {
  LitheCount n_corners = from->poly_off[from->n_polys];
  LTH_NEW(ctx, *soup, 1);
  LthSoup *s = *soup;
  s->n_points = from->n_points;
  s->n_polys = from->n_polys;
  s->n_uvs = from->n_uvs;
  LITHE_TRY(
      copy(ctx, from->points, 3 * (LitheCount)s->n_points, sizeof *s->points, (void **)&s->points));
  LITHE_TRY(copy(ctx, from->poly_off, (LitheCount)s->n_polys + 1, sizeof *s->poly_off,
                 (void **)&s->poly_off));
  LITHE_TRY(copy(ctx, from->poly_point, n_corners, sizeof *s->poly_point, (void **)&s->poly_point));
  LITHE_TRY(copy(ctx, from->uvs, 2 * (LitheCount)s->n_uvs, sizeof *s->uvs, (void **)&s->uvs));
  LITHE_TRY(copy(ctx, from->poly_uv, n_corners, sizeof *s->poly_uv, (void **)&s->poly_uv));
  LITHE_TRY(
      copy(ctx, from->poly_group, s->n_polys, sizeof *s->poly_group, (void **)&s->poly_group));
  LTH_NEW(ctx, s->group_names, from->n_groups);
  for (; s->n_groups < from->n_groups; s->n_groups++)
    LITHE_TRY(lth_copy_text(ctx, from->group_names[s->n_groups], s->group_names + s->n_groups));
  return LITHE_OK;
}

/// The soup as it is shown: with a group for cuts, behind those of the first one.
static LitheStatus add_groups(LitheCtx *ctx, const LthSoup *first, LthSoup *soup) {
  LitheIndex n = first->n_groups;
  for (LitheIndex i = 0; i < soup->n_groups; i++) lth_free(ctx, soup->group_names[i]);
  lth_free(ctx, soup->group_names);
  soup->group_names = NULL;
  soup->n_groups = 0;
  LTH_NEW(ctx, soup->group_names, (LitheCount)n + 2);
  for (; soup->n_groups < n; soup->n_groups++)
    LITHE_TRY(
        lth_copy_text(ctx, first->group_names[soup->n_groups], soup->group_names + soup->n_groups));
  if (n == 0) LITHE_TRY(lth_copy_text(ctx, "surface", soup->group_names + soup->n_groups++));
  LITHE_TRY(lth_copy_text(ctx, "cut", soup->group_names + soup->n_groups++));
  if (soup->poly_group) return LITHE_OK;
  LTH_NEW(ctx, soup->poly_group, soup->n_polys);
  return LITHE_OK;
}

static void turn(LitheIndex *corner, LitheIndex n) {
  for (LitheIndex i = 1, j = n - 1; i < j; i++, j--) {
    LitheIndex swap = corner[i];
    corner[i] = corner[j];
    corner[j] = swap;
  }
}

static void turn_outward(LthSoup *s, const bool *is_inward) {
  for (LitheIndex p = 0; is_inward && p < s->n_polys; p++) {
    LitheIndex begin = s->poly_off[p], n = s->poly_off[p + 1] - begin;
    if (!is_inward[p]) continue;
    turn(s->poly_point + begin, n);
    if (s->poly_uv) turn(s->poly_uv + begin, n);
  }
}

static void find_pieces(LthSkin *skin, const LthTopology *t) {
  for (LitheIndex f = 0; f < t->n_faces && f < skin->n_faces; f++)
    if (skin->face_facet[f] >= 0 && lth_skin_is_boundary(t->faces + f))
      skin->has_pieces[skin->face_facet[f]] = true;
}

/// The lowest cell that has each point in its boundary.
static LitheStatus find_cells(LitheCtx *ctx, LthSkin *skin, const LthTopology *t) {
  LitheIndex *cell = NULL;
  LTH_NEW(ctx, cell, t->n_points);
  for (LitheIndex f = 0; f < t->n_faces; f++) {
    if (!lth_skin_is_boundary(t->faces + f)) continue;
    LthFaceView view = lth_topology_face(t, f);
    LitheIndex c = t->faces[f].cell[0] + 1;
    for (LitheIndex k = 0; k < view.loop_off[view.n_loops]; k++) {
      LitheIndex *lowest = cell + view.loop_point[k];
      if (*lowest == 0 || c < *lowest) *lowest = c;
    }
  }
  for (LitheIndex i = 0; i < skin->soup->n_points; i++)
    skin->cell[i] = skin->point[i] >= 0 ? cell[skin->point[i]] - 1 : -1;
  lth_free(ctx, cell);
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, const LthSkinDef *def, LthSkin *skin) {
  const LthTopology *t = def->topology;
  LitheCount n = def->soup->n_points;
  skin->n_facets = def->n_facets;
  skin->n_faces = def->n_faces;
  LITHE_TRY(copy_soup(ctx, def->soup, &skin->first));
  LITHE_TRY(copy(ctx, def->facet_poly, def->n_facets, sizeof *skin->facet_poly,
                 (void **)&skin->facet_poly));
  LITHE_TRY(copy(ctx, def->face_facet, def->n_faces, sizeof *skin->face_facet,
                 (void **)&skin->face_facet));
  LTH_NEW(ctx, skin->has_pieces, skin->n_facets);
  find_pieces(skin, t);
  turn_outward(skin->first, def->is_inward);
  LITHE_TRY(copy_soup(ctx, skin->first, &skin->soup));
  LITHE_TRY(add_groups(ctx, skin->first, skin->soup));
  LITHE_TRY(copy(ctx, def->point, n, sizeof *skin->point, (void **)&skin->point));
  LTH_NEW(ctx, skin->cell, n);
  LTH_NEW(ctx, skin->place, 3 * n);
  skin->points_cap = skin->place_cap = 3 * n;
  skin->cell_cap = skin->point_cap = n;
  for (LitheIndex i = 0; i < n; i++)
    if (skin->point[i] >= 0)
      lth_v3_copy(t->points + 3 * (LitheCount)skin->point[i], skin->place + 3 * (LitheCount)i);
  return find_cells(ctx, skin, t);
}

LitheStatus lth_skin_create(LitheCtx *ctx, const LthSkinDef *def, LthSkin **skin) {
  *skin = NULL;
  LTH_NEW(ctx, *skin, 1);
  LitheStatus status = build(ctx, def, *skin);
  if (status != LITHE_OK) lth_skin_destroy(ctx, skin);
  return status;
}

void lth_skin_destroy(LitheCtx *ctx, LthSkin **skin) {
  if (!skin || !*skin) return;
  LthSkin *s = *skin;
  lth_soup_destroy(ctx, &s->soup);
  lth_soup_destroy(ctx, &s->first);
  lth_free(ctx, s->cell);
  lth_free(ctx, s->point);
  lth_free(ctx, s->place);
  lth_free(ctx, s->has_pieces);
  lth_free(ctx, s->facet_poly);
  lth_free(ctx, s->face_facet);
  lth_free(ctx, s);
  *skin = NULL;
}

// ------------------------------------------------------------------ following

/// New cells at every point that they have, in the order of their births.
typedef struct Births {
  LitheIndex *head, *tail; ///< of each point: first and last entry + 1  (t->n_points)
  LitheIndex *cell, *next; ///< of entries
  LitheCount n, cell_cap, next_cap;
} Births;

static LitheStatus list_births(LitheCtx *ctx, const LthTopology *t, Births *b) {
  LTH_NEW(ctx, b->head, t->n_points);
  LTH_NEW(ctx, b->tail, t->n_points);
  for (LitheIndex i = 0; i < t->log.n_births; i++) {
    LitheIndex cell = t->log.births[i].cell;
    if (!t->cells[cell].is_live) continue;
    for (LitheIndex k = 0; k < t->cells[cell].n_faces; k++) {
      LthFaceView f = lth_topology_face(t, lth_topology_cell_faces(t, cell)[k]);
      for (LitheIndex c = 0; c < f.loop_off[f.n_loops]; c++) {
        LitheIndex p = f.loop_point[c];
        if (b->tail[p] > 0 && b->cell[b->tail[p] - 1] == cell) continue;
        LTH_RESERVE(ctx, b->cell, b->cell_cap, b->n + 1);
        LTH_RESERVE(ctx, b->next, b->next_cap, b->n + 1);
        b->cell[b->n] = cell;
        b->next[b->n++] = 0;
        if (b->tail[p] > 0)
          b->next[b->tail[p] - 1] = (LitheIndex)b->n;
        else
          b->head[p] = (LitheIndex)b->n;
        b->tail[p] = (LitheIndex)b->n;
      }
    }
  }
  return LITHE_OK;
}

static bool is_place(const LthTopology *t, LitheIndex p, const double place[3]) {
  return p >= 0 && p < t->n_points && t->point_use[p] > 0 &&
         memcmp(t->points + 3 * (LitheCount)p, place, 3 * sizeof *place) == 0;
}

/// The new cell whose middle is nearest to a place, among those that came from `old` if there are any.
static LitheIndex nearest_birth(const LthTopology *t, LitheIndex old, const double x[3]) {
  LitheIndex best = -1;
  double least = INFINITY;
  for (int any = 0; any < 2 && best < 0; any++)
    for (LitheIndex i = 0; i < t->log.n_births; i++) {
      LitheIndex c = t->log.births[i].cell;
      if (!t->cells[c].is_live || (!any && lth_topology_before(t, c) != old)) continue;
      double d = lth_v3_distance(t->cells[c].centroid, x);
      if (d < least) least = d, best = c;
    }
  return best;
}

/// What became of a dead cell, as seen from a point of it.
static LitheIndex descend(const LthTopology *t, const Births *b, LitheIndex old, LitheIndex point,
                          const double x[3]) {
  LitheIndex any = -1, now = lth_topology_now(t, old);
  if (now >= 0) return now;
  for (LitheIndex e = is_place(t, point, x) ? b->head[point] : 0; e > 0; e = b->next[e - 1]) {
    LitheIndex cell = b->cell[e - 1];
    if (lth_topology_before(t, cell) == old) return cell;
    if (any < 0) any = cell;
  }
  return any >= 0 ? any : nearest_birth(t, old, x);
}

LitheStatus lth_skin_follow(LitheCtx *ctx, LthSkin *skin, const LthTopology *t) {
  LitheStatus status = LITHE_OK;
  Births b = {0};
  LITHE_TRY_OR(done, list_births(ctx, t, &b));
  for (LitheIndex i = 0; i < skin->soup->n_points; i++) {
    LitheIndex c = skin->cell[i];
    if (c >= 0 && !t->cells[c].is_live)
      skin->cell[i] = descend(t, &b, c, skin->point[i], skin->place + 3 * (LitheCount)i);
  }
done:
  lth_free(ctx, b.head);
  lth_free(ctx, b.tail);
  lth_free(ctx, b.cell);
  lth_free(ctx, b.next);
  return status;
}

// ------------------------------------------------------------------ updating

static void free_work(LitheCtx *ctx, SkinWork *w) {
  void *blocks[] = {w->cut_point,    w->off,         w->cell,           w->part,
                    w->owner,        w->number,      w->node,           w->lowest,
                    w->is_kept,      w->piece_off,   w->piece,          w->facet_off,
                    w->facet,        w->in_parts,    w->edge,           w->loop_off,
                    w->loop_node,    w->is_used,     w->corner,         w->clipped,
                    w->corner_place, w->poly_row,    w->poly_tri,       w->out.uvs,
                    w->out.poly_off, w->out.poly_uv, w->out.poly_group, w->out.poly_point,
                    w->poly_cell};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_polygon_work_free(ctx, &w->clip);
  lth_polygon_list_free(ctx, &w->list);
}

/// Put the new polygons in the place of the old ones.
static void take_polygons(LthSoup *soup, LthSoup *out) {
  LthSoup old = *soup;
  soup->n_polys = out->n_polys;
  soup->n_uvs = out->n_uvs;
  soup->uvs = out->uvs, out->uvs = old.uvs;
  soup->poly_off = out->poly_off, out->poly_off = old.poly_off;
  soup->poly_point = out->poly_point, out->poly_point = old.poly_point;
  soup->poly_uv = out->poly_uv, out->poly_uv = old.poly_uv;
  soup->poly_group = out->poly_group, out->poly_group = old.poly_group;
}

LitheStatus lth_skin_update(LitheCtx *ctx, LthSkin *skin, const LthTopology *topology) {
  LitheStatus status = LITHE_OK;
  SkinWork w = {.skin = skin, .t = topology};
  LITHE_TRY_OR(done, lth_skin_find_sides(ctx, &w));
  LITHE_TRY_OR(done, lth_skin_find_facets(ctx, &w));
  LITHE_TRY_OR(done, lth_skin_write(ctx, &w));
  take_polygons(skin->soup, &w.out);
done:
  free_work(ctx, &w);
  return status;
}
