/// The connected parts of a body and the closed surfaces by which they touch each other: boundary faces of the mesh, those
/// of cuts among them, each on its own part.
#include "scene/body.h"
#include "scene/cracks.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "geometry/face_polygon.h"
#include "geometry/polygon.h"

#include <stdlib.h>
#include <string.h>

#define EDGE_CELLS 1.0   ///< longest edge of a triangle, in cells
#define THIN_CELLS 0.002 ///< least volume over area, in cells: thinner crumbs touch nothing
#define SHORT_CELLS                                                                                \
  0.05 ///< edges below are contracted: jumps between elements would turn such triangles over

/// Cells of a continuous discretisation hang together by the functions that they share.
static LitheStatus unite_by_functions(LitheCtx *ctx, const LthBody *body, LitheIndex *part,
                                      LitheIndex *n) {
  const LthDisc *disc = body->disc;
  LitheIndex *parent = NULL, *first = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, parent, disc->n_cells);
  LTH_NEW_OR(done, ctx, first, disc->n_funcs);
  lth_sets_reset(parent, disc->n_cells);
  for (LitheIndex c = 0; c < disc->n_cells; c++) {
    LitheIndex func[LTH_DISC_MAX_FUNCS];
    double phi[3 * LTH_DISC_MAX_FUNCS];
    int count = disc->table->eval(disc, c, body->mesh->cell_centroid + 3 * (size_t)c, func, phi);
    for (int k = 0; k < count; k++) {
      if (first[func[k]] > 0) lth_sets_unite(parent, first[func[k]] - 1, c);
      first[func[k]] = c + 1;
    }
  }
  *n = 0;
  for (LitheIndex c = 0; c < disc->n_cells; c++) {
    LitheIndex root = lth_sets_root(parent, c);
    part[c] = root == c ? (*n)++ : part[root];
  }
done:
  lth_free(ctx, parent);
  lth_free(ctx, first);
  return status;
}

/// Number of connected parts, and that of each cell of the mesh (n_cells).
static LitheStatus find_parts(LitheCtx *ctx, const LthBody *body, LitheIndex *part, LitheIndex *n) {
  return body->space ? lth_mesh_parts(ctx, body->mesh, part, n)
                     : unite_by_functions(ctx, body, part, n);
}

LitheStatus lth_body_count_parts(LitheCtx *ctx, LthBody *body) {
  LitheIndex *part = NULL;
  body->n_parts = 1;
  body->n_fronts = 0;
  if (!body->mesh) return LITHE_OK;
  if (body->space) LITHE_TRY(lth_cracks_count(ctx, body->mesh, &body->n_fronts));
  LTH_NEW(ctx, part, body->mesh->n_cells);
  LitheStatus status = find_parts(ctx, body, part, &body->n_parts);
  lth_free(ctx, part);
  return status;
}

/// A part's surface in the making.
typedef struct Making {
  LitheCtx *ctx;
  const LthBody *body;
  LitheIndex *part;            ///< of each cell                             (n_cells)
  LitheIndex *face_off, *face; ///< boundary faces of each part              (n + 1)
  LitheIndex *stands_for;      ///< mesh point that each one is contracted into (n_points)
  LthCracks cracks;
  LitheIndex *place, *placed; ///< of each place() on it, plus one; and which have one
  LthPolygonList polygons;    ///< of the face at hand
  LthPolygonWork work;
  LitheIndex *tris, *tri_face; ///< corners; face of the mesh that each is of
  double *points;
  LitheIndex n_tris, n_points;
  LitheCount placed_cap, tris_cap, tri_face_cap, points_cap;
} Making;

static void free_making(Making *m) {
  void *blocks[] = {m->part,   m->face_off, m->face,     m->place, m->stands_for,
                    m->placed, m->tris,     m->tri_face, m->points};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(m->ctx, blocks[i]);
  lth_cracks_free(m->ctx, &m->cracks);
  lth_polygon_list_free(m->ctx, &m->polygons);
  lth_polygon_work_free(m->ctx, &m->work);
}

static LitheStatus list_faces(Making *m, LitheIndex n_parts) {
  const LthMesh *mesh = m->body->mesh;
  LTH_NEW(m->ctx, m->face_off, (LitheCount)n_parts + 2);
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    if (mesh->face_cell[2 * f + 1] < 0) m->face_off[m->part[mesh->face_cell[2 * f]] + 2]++;
  for (LitheIndex k = 0; k < n_parts; k++) m->face_off[k + 2] += m->face_off[k + 1];
  LTH_NEW(m->ctx, m->face, m->face_off[n_parts + 1]);
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    if (mesh->face_cell[2 * f + 1] < 0)
      m->face[m->face_off[m->part[mesh->face_cell[2 * f]] + 1]++] = f;
  return LITHE_OK;
}

/// A short edge of a boundary face.
typedef struct Short {
  LitheIndex from, to;
} Short;

static int compare_shorts(const void *a, const void *b) {
  const Short *p = a, *q = b;
  if (p->from != q->from) return p->from < q->from ? -1 : 1;
  return (p->to > q->to) - (p->to < q->to);
}

static double distance(const LthMesh *mesh, LitheIndex p, LitheIndex q) {
  return lth_v3_distance(mesh->points + 3 * (size_t)p, mesh->points + 3 * (size_t)q);
}

/// All short edges of the boundary, both ways, sorted.
static LitheStatus list_shorts(const Making *m, double shortest, Short **list, LitheCount *n) {
  const LthMesh *mesh = m->body->mesh;
  LitheCount cap = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    for (LitheIndex l = mesh->face_loop_off[f]; l < mesh->face_loop_off[f + 1]; l++)
      for (LitheIndex i = mesh->loop_off[l]; i < mesh->loop_off[l + 1]; i++) {
        LitheIndex p = mesh->loop_point[i];
        LitheIndex q = mesh->loop_point[i + 1 < mesh->loop_off[l + 1] ? i + 1 : mesh->loop_off[l]];
        if (!(distance(mesh, p, q) < shortest)) continue;
        LTH_RESERVE(m->ctx, *list, cap, *n + 2);
        (*list)[(*n)++] = (Short){p, q};
        (*list)[(*n)++] = (Short){q, p};
      }
  }
  if (*n > 0) qsort(*list, (size_t)*n, sizeof **list, compare_shorts);
  return LITHE_OK;
}

/// Contract short edges into one of their ends, for all parts at once: both sides of a cut stay face to face.
static LitheStatus contract(Making *m) {
  const LthMesh *mesh = m->body->mesh;
  const double shortest = SHORT_CELLS * m->body->cell_size;
  Short *list = NULL;
  LitheCount n = 0;
  LTH_NEW(m->ctx, m->stands_for, mesh->n_points);
  LitheStatus status = list_shorts(m, shortest, &list, &n);
  for (LitheIndex p = 0; p < mesh->n_points; p++) m->stands_for[p] = -1;
  for (LitheCount i = 0, end; status == LITHE_OK && i < n; i = end) {
    const LitheIndex p = list[i].from;
    LitheIndex *own = &m->stands_for[p];
    for (end = i; end < n && list[end].from == p;) end++;
    for (LitheCount k = i; *own < 0 && k < end; k++) {
      LitheIndex other = m->stands_for[list[k].to];
      if (other >= 0 && distance(mesh, p, other) < shortest) *own = other;
    }
    if (*own >= 0) continue;
    *own = p;
    for (LitheCount k = i; k < end; k++)
      if (m->stands_for[list[k].to] < 0) m->stands_for[list[k].to] = p;
  }
  for (LitheIndex p = 0; p < mesh->n_points; p++)
    if (m->stands_for[p] < 0) m->stands_for[p] = p;
  lth_free(m->ctx, list);
  return status;
}

/// Number of a mesh point on the part at hand, as the cell of a face sees it: along a crack each side has a point of its own.
static LitheStatus place_point(Making *m, LitheIndex p, LitheIndex face, LitheIndex *number) {
  const LthMesh *mesh = m->body->mesh;
  LitheIndex at = m->stands_for[p];
  if (m->cracks.n_fronts > 0) at = lth_cracks_corner(&m->cracks, p, mesh->face_cell[2 * face]);
  if (m->place[at] == 0) {
    LTH_RESERVE(m->ctx, m->points, m->points_cap, 3 * ((LitheCount)m->n_points + 1));
    LTH_RESERVE(m->ctx, m->placed, m->placed_cap, (LitheCount)m->n_points + 1);
    memcpy(m->points + 3 * (size_t)m->n_points, mesh->points + 3 * (size_t)m->stands_for[p],
           3 * sizeof *m->points);
    m->placed[m->n_points] = at;
    m->place[at] = ++m->n_points;
  }
  *number = m->place[at] - 1;
  return LITHE_OK;
}

static LitheStatus add_polygon(Making *m, LitheIndex face, LitheIndex n, const LitheIndex *corner) {
  if (n < 3) return LITHE_OK;
  LTH_RESERVE(m->ctx, m->tris, m->tris_cap, 3 * ((LitheCount)m->n_tris + n));
  LTH_RESERVE(m->ctx, m->tri_face, m->tri_face_cap, (LitheCount)m->n_tris + n);
  LitheIndex *first = m->tris + 3 * (size_t)m->n_tris;
  LITHE_TRY(lth_polygon_triangulate(m->ctx, &m->work, m->body->mesh->points, n, corner, first));
  for (LitheIndex k = 0; k < n - 2; k++) {
    LitheIndex tri[3], at[3], *to = m->tris + 3 * (size_t)m->n_tris;
    for (int i = 0; i < 3; i++) tri[i] = first[3 * k + i], at[i] = m->stands_for[tri[i]];
    if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;
    for (int i = 0; i < 3; i++) LITHE_TRY(place_point(m, tri[i], face, &to[i]));
    m->tri_face[m->n_tris++] = face;
  }
  return LITHE_OK;
}

static LitheStatus add_face(Making *m, LitheIndex face) {
  LthFaceView view = lth_mesh_face(m->body->mesh, face);
  m->polygons.n = 0, m->polygons.n_polygons = 0;
  LITHE_TRY(lth_face_polygons(m->ctx, &view, &m->polygons));
  const LitheIndex *polygon = m->polygons.items;
  for (LitheIndex i = 0; i < m->polygons.n_polygons; i++, polygon += 1 + polygon[0])
    LITHE_TRY(add_polygon(m, face, polygon[0], polygon + 1));
  return LITHE_OK;
}

/// The surface of a part in triangles no larger than its cells; tri_poly is the face of the mesh.
static LitheStatus make_surface(Making *m, LitheIndex part, LthSurface *surface) {
  LitheIndex *shell = NULL;
  LthSurface *fine = NULL;
  m->n_tris = m->n_points = 0;
  for (LitheIndex i = m->face_off[part]; i < m->face_off[part + 1]; i++)
    LITHE_TRY(add_face(m, m->face[i]));
  for (LitheIndex i = 0; i < m->n_points; i++) m->place[m->placed[i]] = 0;
  LTH_NEW(m->ctx, shell, m->n_tris);
  LthSurface coarse = {.n_points = m->n_points,
                       .n_tris = m->n_tris,
                       .n_shells = 1,
                       .points = m->points,
                       .tris = m->tris,
                       .tri_shell = shell,
                       .tri_poly = m->tri_face};
  LitheStatus status = lth_surface_refine(m->ctx, &coarse, EDGE_CELLS * m->body->cell_size, &fine);
  lth_free(m->ctx, shell);
  LITHE_TRY(status);
  *surface = *fine;
  lth_free(m->ctx, fine);
  return LITHE_OK;
}

/// A point of the parts' surfaces and a cell that it bounds.
typedef struct Bound {
  LitheIndex point, cell;
} Bound;

static int compare_bounds(const void *a, const void *b) {
  const Bound *p = a, *q = b;
  if (p->point != q->point) return p->point < q->point ? -1 : 1;
  return (p->cell > q->cell) - (p->cell < q->cell);
}

/// Points of all surfaces, and the cells that each of them bounds.
typedef struct Points {
  double *at;
  LitheIndex *cell_off, *cells, *first_cell;
} Points;

static LitheStatus list_bounds(LitheCtx *ctx, const LthBody *body, const LthBodyParts *parts,
                               Bound **bounds, LitheCount *n) {
  *n = 0;
  for (LitheIndex k = 0; k < parts->n; k++) *n += 3 * (LitheCount)parts->surface[k].n_tris;
  LTH_NEW(ctx, *bounds, *n);
  *n = 0;
  for (LitheIndex k = 0; k < parts->n; k++) {
    const LthSurface *s = &parts->surface[k];
    for (LitheIndex h = 0; h < 3 * s->n_tris; h++)
      (*bounds)[(*n)++] = (Bound){parts->first_point[k] + s->tris[h],
                                  body->mesh->face_cell[2 * s->tri_poly[h / 3]]};
  }
  if (*n > 0) qsort(*bounds, (size_t)*n, sizeof **bounds, compare_bounds);
  return LITHE_OK;
}

static LitheStatus gather_points(LitheCtx *ctx, const LthBody *body, const LthBodyParts *parts,
                                 Points *points) {
  LitheStatus status = LITHE_OK;
  const LitheIndex n = parts->first_point[parts->n];
  Bound *bounds = NULL;
  LitheCount n_bounds = 0;
  LitheIndex at = 0;
  LTH_NEW_OR(done, ctx, points->at, 3 * (LitheCount)n);
  LTH_NEW_OR(done, ctx, points->cell_off, (LitheCount)n + 1);
  LTH_NEW_OR(done, ctx, points->first_cell, n);
  for (LitheIndex k = 0; k < parts->n; k++)
    memcpy(points->at + 3 * (size_t)parts->first_point[k], parts->surface[k].points,
           sizeof *points->at * 3 * (size_t)parts->surface[k].n_points);
  LITHE_TRY_OR(done, list_bounds(ctx, body, parts, &bounds, &n_bounds));
  LTH_NEW_OR(done, ctx, points->cells, n_bounds);
  for (LitheCount i = 0; i < n_bounds; i++) {
    if (i > 0 && compare_bounds(&bounds[i - 1], &bounds[i]) == 0) continue;
    points->cells[at++] = bounds[i].cell;
    points->cell_off[bounds[i].point + 1] = at;
  }
  for (LitheIndex p = 0; p < n; p++) points->first_cell[p] = points->cells[points->cell_off[p]];
done:
  lth_free(ctx, bounds);
  return status;
}

/// Points follow the elements that they bound, of their own part alone.
static LitheStatus embed(LitheCtx *ctx, const LthBody *body, LthBodyParts *parts) {
  LitheStatus status = LITHE_OK;
  Points points = {0};
  const LitheIndex n = parts->first_point[parts->n];
  LITHE_TRY_OR(done, gather_points(ctx, body, parts, &points));
  status = body->space ? lth_embedding_create_average(ctx, body->disc, body->space, n, points.at,
                                                      points.cell_off, points.cells, &parts->points)
                       : lth_embedding_create_direct(ctx, body->disc, n, points.at,
                                                     points.first_cell, &parts->points);
done:
  lth_free(ctx, points.at);
  lth_free(ctx, points.cell_off);
  lth_free(ctx, points.cells);
  lth_free(ctx, points.first_cell);
  return status;
}

static void free_surface(LitheCtx *ctx, LthSurface *s) {
  void *blocks[] = {s->points, s->tris, s->tri_shell, s->tri_poly, s->soup_point};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  *s = (LthSurface){0};
}

/// Cracks, and room for the points of a part.
static LitheStatus find_cracks(Making *m) {
  const LthMesh *mesh = m->body->mesh;
  if (m->body->n_fronts > 0) LITHE_TRY(lth_cracks_find(m->ctx, mesh, m->stands_for, &m->cracks));
  bool any = m->cracks.n_fronts > 0;
  LTH_NEW(m->ctx, m->place, any ? m->cracks.n_corners : mesh->n_points);
  return LITHE_OK;
}

static LitheStatus make_parts(Making *m, LthBodyParts *parts) {
  LTH_NEW(m->ctx, m->part, m->body->mesh->n_cells);
  LITHE_TRY(find_parts(m->ctx, m->body, m->part, &parts->n));
  LITHE_TRY(list_faces(m, parts->n));
  LITHE_TRY(contract(m));
  LITHE_TRY(find_cracks(m));
  if (m->cracks.n_fronts > 0) LTH_NEW(m->ctx, parts->cracks, parts->n);
  LTH_NEW(m->ctx, parts->surface, parts->n);
  LTH_NEW(m->ctx, parts->first_point, (LitheCount)parts->n + 1);
  const LitheIndex n = parts->n;
  parts->n = 0; // crumbs have no sides to be touched on
  for (LitheIndex k = 0; k < n; k++) {
    LitheIndex *at = &parts->n;
    LITHE_TRY(make_surface(m, k, &parts->surface[*at]));
    const LthSurface *made = &parts->surface[*at];
    if (lth_surface_volume(made) <= THIN_CELLS * m->body->cell_size * lth_surface_area(made)) {
      free_surface(m->ctx, &parts->surface[*at]);
      continue;
    }
    if (parts->cracks)
      LITHE_TRY(lth_cracks_find_sides(m->ctx, &m->cracks, made, &parts->cracks[*at]));
    parts->first_point[*at + 1] = parts->first_point[*at] + parts->surface[*at].n_points;
    ++*at;
  }
  return embed(m->ctx, m->body, parts);
}

/// A body without a mesh is one part with the surface that others touch.
static LitheStatus take_surface(LitheCtx *ctx, LthBody *body, LthBodyParts *parts) {
  LthSurface *fine = NULL;
  LitheIndex *cells = NULL;
  if (!body->touch) LITHE_TRY(lth_build_touch(ctx, body));
  LTH_NEW(ctx, parts->surface, 1);
  LTH_NEW(ctx, parts->first_point, 2);
  LITHE_TRY(lth_surface_refine(ctx, body->touch, EDGE_CELLS * body->cell_size, &fine));
  parts->n = 1;
  parts->surface[0] = *fine;
  lth_free(ctx, fine);
  const LthSurface *s = &parts->surface[0];
  parts->first_point[1] = s->n_points;
  LTH_NEW(ctx, cells, s->n_points);
  for (LitheIndex i = 0; i < s->n_points; i++) cells[i] = -1;
  LitheStatus status = lth_build_points(ctx, body, s->n_points, s->points, cells, &parts->points);
  lth_free(ctx, cells);
  return status;
}

LitheStatus lth_build_parts(LitheCtx *ctx, LthBody *body) {
  Making making = {.ctx = ctx, .body = body};
  if (body->parts) return LITHE_OK;
  LTH_NEW(ctx, body->parts, 1);
  if (!body->mesh) return take_surface(ctx, body, body->parts);
  LitheStatus status = make_parts(&making, body->parts);
  free_making(&making);
  return status;
}

void lth_body_parts_destroy(LitheCtx *ctx, LthBodyParts **parts) {
  LthBodyParts *p = *parts;
  if (!p) return;
  for (LitheIndex k = 0; p->surface && k < p->n; k++) free_surface(ctx, &p->surface[k]);
  for (LitheIndex k = 0; p->cracks && k < p->n; k++) lth_crack_sides_free(ctx, &p->cracks[k]);
  lth_free(ctx, p->cracks);
  lth_free(ctx, p->surface);
  lth_free(ctx, p->first_point);
  lth_embedding_destroy(ctx, &p->points);
  lth_free(ctx, p);
  *parts = NULL;
}
