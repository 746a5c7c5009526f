/// Writing a skin's polygons: corners as numbers of points and texture coordinates.
#include "mesh/skin_priv.h"

#define CONVEX 1e-9 ///< sine of a reflex angle below which a corner counts as straight

static LitheStatus add_corner(LitheCtx *ctx, SkinWork *w, LitheIndex number, LitheIndex uv) {
  LthSoup *out = &w->out;
  LTH_RESERVE(ctx, out->poly_point, w->out_point_cap, w->n_corners_out + 1);
  LTH_RESERVE(ctx, out->poly_uv, w->out_uv_cap, w->n_corners_out + 1);
  if (w->n_corners_out >= INT32_MAX - 1)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting a surface: more than 2^31 corners");
  out->poly_point[w->n_corners_out] = number;
  out->poly_uv[w->n_corners_out++] = uv;
  return LITHE_OK;
}

static LitheStatus end_polygon(LitheCtx *ctx, SkinWork *w, LitheIndex group, LitheIndex cell) {
  LthSoup *out = &w->out;
  LTH_RESERVE(ctx, w->poly_cell, w->poly_cell_cap, (LitheCount)out->n_polys + 1);
  LTH_RESERVE(ctx, out->poly_off, w->off_cap, (LitheCount)out->n_polys + 2);
  LTH_RESERVE(ctx, out->poly_group, w->group_cap, (LitheCount)out->n_polys + 1);
  out->poly_group[out->n_polys] = group;
  w->poly_cell[out->n_polys] = cell;
  out->poly_off[++out->n_polys] = (LitheIndex)w->n_corners_out;
  return LITHE_OK;
}

LitheStatus lth_skin_add_uv(LitheCtx *ctx, SkinWork *w, double u, double v, LitheIndex *uv) {
  LthSoup *out = &w->out;
  LTH_RESERVE(ctx, out->uvs, w->uv_cap, 2 * ((LitheCount)out->n_uvs + 1));
  out->uvs[2 * (LitheCount)out->n_uvs] = u;
  out->uvs[2 * (LitheCount)out->n_uvs + 1] = v;
  *uv = out->n_uvs++;
  return LITHE_OK;
}

// ------------------------------------------------------------------ texture

/// Where the corners of a polygon get their numbers and texture coordinates from.
typedef struct Source {
  LitheIndex poly; ///< polygon of the soup, -1: a cut
  LitheIndex group;
  LitheIndex cell;      ///< element at the polygon in hand
  const double *normal; ///< out of the body
  double t1[3], t2[3];  ///< of cuts: the plane's directions of texture
} Source;

/// Directions in a cut's plane that do not depend on the side it is seen from.
static void set_frame(Source *s) {
  double n[3];
  int largest = 0;
  for (int a = 1; a < 3; a++)
    if (fabs(s->normal[a]) > fabs(s->normal[largest])) largest = a;
  for (int a = 0; a < 3; a++) n[a] = s->normal[largest] < 0 ? -s->normal[a] : s->normal[a];
  lth_face_frame(n, s->t1, s->t2);
}

/// Triangles of the polygon in hand, as points of the soup.
static LitheStatus triangulate(LitheCtx *ctx, SkinWork *w, LitheIndex poly) {
  const LthSoup *s = w->skin->first;
  LitheIndex begin = s->poly_off[poly], n = s->poly_off[poly + 1] - begin;
  w->poly = poly;
  w->n_poly_tris = n - 2;
  LTH_RESERVE(ctx, w->poly_tri, w->poly_tri_cap, 3 * (LitheCount)w->n_poly_tris);
  LTH_RESERVE(ctx, w->poly_row, w->poly_row_cap, n);
  for (LitheIndex i = 0; i < n; i++) w->poly_row[i] = s->poly_point[begin + i];
  LITHE_TRY(lth_polygon_triangulate(ctx, &w->clip, s->points, n, w->poly_row, w->poly_tri));
  return LITHE_OK;
}

/// Barycentric coordinates of x over a triangle, as seen along its normal; the least of them.
static double barycentric(const double *p[3], const double x[3], double b[3]) {
  double e[3], f[3], n[3], d[3], c[3];
  lth_v3_sub(p[1], p[0], e);
  lth_v3_sub(p[2], p[0], f);
  lth_v3_cross(e, f, n);
  double nn = lth_v3_dot(n, n);
  if (!(nn > 0)) return -INFINITY;
  lth_v3_sub(x, p[0], d);
  lth_v3_cross(d, f, c);
  b[1] = lth_v3_dot(c, n) / nn;
  lth_v3_cross(e, d, c);
  b[2] = lth_v3_dot(c, n) / nn;
  b[0] = 1 - b[1] - b[2];
  return fmin(b[0], fmin(b[1], b[2]));
}

/// Texture coordinate that a polygon has at one of its points.
static LitheIndex corner_uv(const LthSoup *s, LitheIndex poly, LitheIndex point) {
  LitheIndex k = s->poly_off[poly];
  while (s->poly_point[k] != point) k++;
  return s->poly_uv[k];
}

/// Linear over the triangle of the polygon that holds the place; -1 where that has no texture.
static LitheStatus interpolate_uv(LitheCtx *ctx, SkinWork *w, LitheIndex poly, const double x[3],
                                  LitheIndex *uv) {
  const LthSoup *s = w->skin->first;
  LitheIndex best[3] = {-1, -1, -1};
  double least = -INFINITY, weight[3] = {0, 0, 0}, value[2] = {0, 0};
  if (w->poly != poly) LITHE_TRY(triangulate(ctx, w, poly));
  for (LitheIndex t = 0; t < w->n_poly_tris; t++) {
    const double *p[3];
    double b[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) p[i] = s->points + 3 * (LitheCount)w->poly_tri[3 * t + i];
    double inside = barycentric(p, x, b);
    if (!(inside > least)) continue;
    least = inside;
    for (int i = 0; i < 3; i++)
      weight[i] = b[i], best[i] = corner_uv(s, poly, w->poly_tri[3 * t + i]);
  }
  *uv = -1;
  for (int i = 0; i < 3; i++) {
    if (best[i] < 0) return LITHE_OK;
    for (int a = 0; a < 2; a++) value[a] += weight[i] * s->uvs[2 * (LitheCount)best[i] + a];
  }
  return lth_skin_add_uv(ctx, w, value[0], value[1], uv);
}

// ------------------------------------------------------------------ polygons

/// A node as a corner: the polygon's own point and texture where it has that node already.
static LitheStatus write_corner(LitheCtx *ctx, SkinWork *w, const Source *source, LitheIndex node) {
  const LthSoup *s = w->skin->first;
  LitheIndex number = -1, uv = -1;
  const double *x = lth_skin_place(w, node);
  if (source->poly < 0) {
    LITHE_TRY(lth_skin_add_uv(ctx, w, lth_v3_dot(x, source->t1), lth_v3_dot(x, source->t2), &uv));
    LITHE_TRY(lth_skin_number(ctx, w, node, &number));
    return add_corner(ctx, w, number, uv);
  }
  LitheIndex own = -1, point = lth_skin_point(w, node);
  for (LitheIndex k = s->poly_off[source->poly]; k < s->poly_off[source->poly + 1]; k++) {
    LitheIndex p = s->poly_point[k];
    if (w->skin->point[p] != point) continue;
    own = k;
    if (w->node[p] == node) number = p;
  }
  if (number < 0) LITHE_TRY(lth_skin_number(ctx, w, node, &number));
  if (s->poly_uv && own >= 0) uv = s->poly_uv[own];
  if (s->poly_uv && own < 0) LITHE_TRY(interpolate_uv(ctx, w, source->poly, x, &uv));
  return add_corner(ctx, w, number, uv);
}

static bool is_convex(const SkinWork *w, const double normal[3], LitheIndex n) {
  for (LitheIndex i = 0; i < n; i++) {
    const double *a = lth_skin_place(w, w->corner[i]),
                 *b = lth_skin_place(w, w->corner[(i + 1) % n]),
                 *c = lth_skin_place(w, w->corner[(i + 2) % n]);
    double e[3], f[3], cross[3];
    lth_v3_sub(b, a, e);
    lth_v3_sub(c, b, f);
    lth_v3_cross(e, f, cross);
    if (lth_v3_dot(cross, normal) < -CONVEX * lth_v3_norm(e) * lth_v3_norm(f)) return false;
  }
  return true;
}

/// The n nodes in w->corner as one polygon, or as triangles where it is not convex.
static LitheStatus write_loop(LitheCtx *ctx, SkinWork *w, const Source *source, LitheIndex n) {
  if (n < 3) return LITHE_OK; // both edges of such a loop are the same
  if (n == 3 || is_convex(w, source->normal, n)) {
    for (LitheIndex i = 0; i < n; i++) LITHE_TRY(write_corner(ctx, w, source, w->corner[i]));
    return end_polygon(ctx, w, source->group, source->cell);
  }
  LTH_RESERVE(ctx, w->clipped, w->clipped_cap, 4 * (LitheCount)n);
  LTH_RESERVE(ctx, w->corner_place, w->place_cap, 3 * (LitheCount)n);
  LitheIndex *row = w->clipped + 3 * (LitheCount)n;
  for (LitheIndex i = 0; i < n; i++) {
    lth_v3_copy(lth_skin_place(w, w->corner[i]), w->corner_place + 3 * i);
    row[i] = i;
  }
  LITHE_TRY(lth_polygon_triangulate(ctx, &w->clip, w->corner_place, n, row, w->clipped));
  for (LitheIndex i = 0; i < 3 * (n - 2); i++) w->clipped[i] = w->corner[w->clipped[i]];
  for (LitheIndex t = 0; t < n - 2; t++) {
    for (int i = 0; i < 3; i++) LITHE_TRY(write_corner(ctx, w, source, w->clipped[3 * t + i]));
    LITHE_TRY(end_polygon(ctx, w, source->group, source->cell));
  }
  return LITHE_OK;
}

/// A face of the topology with all its corners.
static LitheStatus write_face(LitheCtx *ctx, SkinWork *w, LitheIndex face, Source *source) {
  const LthTopologyFace *f = w->t->faces + face;
  LthFaceView view = lth_topology_face(w->t, face);
  source->normal = f->plane;
  source->cell = f->cell[0];
  if (source->poly < 0) set_frame(source);
  w->list.n = w->list.n_polygons = 0;
  LITHE_TRY(lth_face_polygons(ctx, &view, &w->list));
  for (LitheCount at = 0; at < w->list.n; at += w->list.items[at] + 1) {
    LitheIndex n = w->list.items[at];
    LTH_RESERVE(ctx, w->corner, w->corner_cap, n);
    for (LitheIndex i = 0; i < n; i++)
      w->corner[i] = lth_skin_node(w, w->list.items[at + 1 + i], f->cell[0]);
    LITHE_TRY(write_loop(ctx, w, source, n));
  }
  return LITHE_OK;
}

/// What is left of a facet: its outline without points that only the elements have, or its pieces.
static LitheStatus write_facet(LitheCtx *ctx, SkinWork *w, LitheIndex facet, Source *source) {
  bool is_simple = false;
  LitheIndex first = w->piece_off[facet];
  if (first == w->piece_off[facet + 1]) return LITHE_OK;
  for (LitheIndex i = first; w->in_parts[facet] && i < w->piece_off[facet + 1]; i++)
    LITHE_TRY(write_face(ctx, w, w->piece[i], source));
  if (w->in_parts[facet]) return LITHE_OK;
  source->normal = w->t->faces[w->piece[first]].plane;
  source->cell = w->t->faces[w->piece[first]].cell[0];
  LITHE_TRY(lth_skin_outline(ctx, w, facet, &is_simple));
  for (LitheIndex l = 0; l < w->n_loops; l++) {
    LitheIndex n = 0;
    LTH_RESERVE(ctx, w->corner, w->corner_cap, w->loop_off[l + 1] - w->loop_off[l]);
    for (LitheIndex k = w->loop_off[l]; k < w->loop_off[l + 1]; k++)
      if (w->is_kept[lth_skin_point(w, w->loop_node[k])]) w->corner[n++] = w->loop_node[k];
    LITHE_TRY(write_loop(ctx, w, source, n));
  }
  return LITHE_OK;
}

/// Whether the surface of a polygon has points beside its own corners now, or cuts at them, or is gone.
static bool has_changed(const SkinWork *w, LitheIndex poly) {
  LitheIndex begin = w->facet_off[poly], end = w->facet_off[poly + 1];
  for (LitheIndex i = begin; i < end; i++) {
    LitheIndex k = w->facet[i];
    if (w->skin->has_pieces[k] && w->piece_off[k] == w->piece_off[k + 1]) return true;
    for (LitheIndex j = w->piece_off[k]; j < w->piece_off[k + 1]; j++) {
      LthFaceView f = lth_topology_face(w->t, w->piece[j]);
      for (LitheIndex c = 0; c < f.loop_off[f.n_loops]; c++) {
        LitheIndex p = f.loop_point[c];
        bool is_first = w->number[p] >= 0 && w->number[p] < w->skin->first->n_points;
        if (w->cut_point[p] > 0 || (w->is_kept[p] && !is_first)) return true;
      }
    }
  }
  return false;
}

static LitheStatus copy_polygon(LitheCtx *ctx, SkinWork *w, LitheIndex poly, LitheIndex group) {
  const LthSoup *s = w->skin->first;
  for (LitheIndex k = s->poly_off[poly]; k < s->poly_off[poly + 1]; k++)
    LITHE_TRY(add_corner(ctx, w, s->poly_point[k], s->poly_uv ? s->poly_uv[k] : -1));
  return end_polygon(ctx, w, group, -1);
}

static LitheStatus begin_out(LitheCtx *ctx, SkinWork *w) {
  const LthSoup *s = w->skin->first;
  LTH_RESERVE(ctx, w->out.poly_off, w->off_cap, (LitheCount)s->n_polys + 1);
  LTH_RESERVE(ctx, w->out.uvs, w->uv_cap, 2 * ((LitheCount)s->n_uvs + 1));
  w->out.poly_off[0] = 0;
  w->out.n_uvs = s->n_uvs;
  if (s->n_uvs > 0) memcpy(w->out.uvs, s->uvs, 2 * sizeof *s->uvs * (size_t)s->n_uvs);
  w->poly = -1;
  return LITHE_OK;
}

LitheStatus lth_skin_write(LitheCtx *ctx, SkinWork *w) {
  const LthSoup *s = w->skin->first;
  LitheIndex cut_group = w->skin->soup->n_groups - 1;
  LITHE_TRY(begin_out(ctx, w));
  for (LitheIndex p = 0; p < s->n_polys; p++) {
    Source source = {.poly = p, .group = s->poly_group ? s->poly_group[p] : 0};
    if (!has_changed(w, p)) {
      LITHE_TRY(copy_polygon(ctx, w, p, source.group));
      continue;
    }
    for (LitheIndex i = w->facet_off[p]; i < w->facet_off[p + 1]; i++)
      LITHE_TRY(write_facet(ctx, w, w->facet[i], &source));
  }
  LitheIndex n_outer = w->out.n_polys;
  for (LitheIndex f = 0; f < w->t->n_faces; f++) {
    Source source = {.poly = -1, .group = cut_group};
    const LthTopologyFace *face = w->t->faces + f;
    if (lth_skin_is_boundary(face) && face->tag <= LTH_TAG_CUT)
      LITHE_TRY(write_face(ctx, w, f, &source));
  }
  w->skin->n_caps = w->out.n_polys - n_outer;
  return lth_skin_part_edges(ctx, w);
}
