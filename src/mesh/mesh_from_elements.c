/// Elements of a file as polyhedra: faces matched by their corners, those that are not planar split.
#include "mesh/mesh_from_elements.h"

#include "base/tensor.h"

#include <string.h>

/// A face is planar where its corners leave its mean plane by less than this share of its size.
#define PLANAR 1e-10
/// The diagonal of a split quad is the one with less area; a share within which both count as equal.
#define SAME_AREA 1e-6

void lth_elements_as_mesh_free(LitheCtx *ctx, LthElementsAsMesh *w) {
  lth_element_sides_destroy(ctx, &w->sides);
  void *blocks[] = {w->node_point, w->points,    w->loop_off, w->loop_off_of,
                    w->loop_point, w->face_cell, w->face_side};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

/// Corner nodes become points, in the order of the nodes.
static LitheStatus number_points(LitheCtx *ctx, LthElementsAsMesh *w) {
  const LthElementMesh *m = w->elements;
  const LthElementSides *s = w->sides;
  LTH_NEW(ctx, w->node_point, m->n_nodes);
  for (LitheIndex i = 0; i < s->corner_off[s->n]; i++) w->node_point[s->corner[i]] = 1;
  for (LitheIndex i = 0; i < m->n_nodes; i++)
    w->node_point[i] = w->node_point[i] ? w->n_points++ : -1;
  LTH_RESERVE(ctx, w->points, w->cap_points, 3 * (LitheCount)w->n_points);
  for (LitheIndex i = 0; i < m->n_nodes; i++)
    if (w->node_point[i] >= 0)
      lth_v3_copy(m->nodes + 3 * (LitheCount)i, w->points + 3 * (LitheCount)w->node_point[i]);
  return LITHE_OK;
}

static LitheStatus add_face(LitheCtx *ctx, LthElementsAsMesh *w, LitheIndex side, LitheIndex n,
                            const LitheIndex *point) {
  LitheCount used = w->n_loop_points;
  if (w->n_faces >= INT32_MAX / 3 || used + n >= INT32_MAX)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "%s: it has more faces than a mesh can hold", w->file);
  LTH_RESERVE(ctx, w->face_cell, w->cap_cells, 2 * (LitheCount)w->n_faces + 2);
  LTH_RESERVE(ctx, w->face_side, w->cap_sides, w->n_faces + 1);
  LTH_RESERVE(ctx, w->loop_off, w->cap_off, w->n_faces + 2);
  LTH_RESERVE(ctx, w->loop_point, w->cap_loop, used + n);
  memcpy(w->loop_point + used, point, (size_t)n * sizeof *point);
  LitheIndex mate = w->sides->mate[side], f = w->n_faces++;
  w->n_loop_points += n;
  w->loop_off[f + 1] = (LitheIndex)w->n_loop_points;
  w->face_cell[2 * f] = w->sides->element[side];
  w->face_cell[2 * f + 1] = mate < 0 ? -1 : w->sides->element[mate];
  w->face_side[f] = side;
  return LITHE_OK;
}

/// Mean of a face's corners, and its unit normal there.
static void mean_plane(const double *points, const LitheIndex *v, LitheIndex n, double mean[3],
                       double normal[3]) {
  double a[3], b[3], cross[3];
  memset(mean, 0, 3 * sizeof *mean);
  memset(normal, 0, 3 * sizeof *normal);
  for (LitheIndex i = 0; i < n; i++) lth_v3_axpy(1.0 / n, points + 3 * (LitheCount)v[i], mean);
  for (LitheIndex i = 0; i < n; i++) {
    lth_v3_sub(points + 3 * (LitheCount)v[i], mean, a);
    lth_v3_sub(points + 3 * (LitheCount)v[i + 1 < n ? i + 1 : 0], mean, b);
    lth_v3_cross(a, b, cross);
    lth_v3_add(normal, cross, normal);
  }
  lth_v3_normalize(normal);
}

static bool is_planar(const LthElementsAsMesh *w, const LitheIndex *v, LitheIndex n) {
  double mean[3], normal[3], d[3], size = 0, off = 0, place = 0;
  if (n == 3) return true;
  mean_plane(w->points, v, n, mean, normal);
  for (LitheIndex i = 0; i < n; i++) {
    lth_v3_sub(w->points + 3 * (LitheCount)v[i], mean, d);
    size = fmax(size, lth_v3_norm(d));
    off = fmax(off, fabs(lth_v3_dot(d, normal)));
    place = fmax(place, lth_v3_norm(w->points + 3 * (LitheCount)v[i]));
  }
  return off <= PLANAR * size + 0x1p-48 * place + 4 * w->elements->rounding;
}

/// Area of the triangles 0 1 2 and 0 2 3 of a quad, starting at its corner k.
static double split_area(const double *points, const LitheIndex v[4], int k) {
  double sum = 0, a[3], b[3], cross[3];
  const double *o = points + 3 * (LitheCount)v[k];
  for (int i = 1; i <= 2; i++) {
    lth_v3_sub(points + 3 * (LitheCount)v[(k + i) % 4], o, a);
    lth_v3_sub(points + 3 * (LitheCount)v[(k + i + 1) % 4], o, b);
    lth_v3_cross(a, b, cross);
    sum += lth_v3_norm(cross) / 2;
  }
  return sum;
}

/// Corner that the diagonal of a quad starts at: that of the lowest number, or its neighbour where the other
/// diagonal gives a smaller area (as it does where the quad is not convex).
static int diagonal_of(const double *points, const LitheIndex v[4]) {
  int low = 0;
  for (int i = 1; i < 4; i++)
    if (v[i] < v[low]) low = i;
  int next = (low + 1) % 4;
  return split_area(points, v, next) < (1 - SAME_AREA) * split_area(points, v, low) ? next : low;
}

static LitheStatus split_quad(LitheCtx *ctx, LthElementsAsMesh *w, LitheIndex side,
                              const LitheIndex v[4]) {
  int k = diagonal_of(w->points, v);
  for (int i = 1; i <= 2; i++) {
    LitheIndex t[3] = {v[k], v[(k + i) % 4], v[(k + i + 1) % 4]};
    LITHE_TRY(add_face(ctx, w, side, 3, t));
  }
  return LITHE_OK;
}

/// Triangles about a new point in the middle: no corner of a larger polygon need see all the others.
static LitheStatus split_polygon(LitheCtx *ctx, LthElementsAsMesh *w, LitheIndex side,
                                 const LitheIndex *v, LitheIndex n) {
  double mean[3], normal[3];
  mean_plane(w->points, v, n, mean, normal);
  LTH_RESERVE(ctx, w->points, w->cap_points, 3 * ((LitheCount)w->n_points + 1));
  lth_v3_copy(mean, w->points + 3 * (LitheCount)w->n_points);
  LitheIndex middle = w->n_points++;
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex t[3] = {v[i], v[i + 1 < n ? i + 1 : 0], middle};
    LITHE_TRY(add_face(ctx, w, side, 3, t));
  }
  return LITHE_OK;
}

/// A face is made from the side that comes first; `v` has room for its points.
static LitheStatus make_face(LitheCtx *ctx, LthElementsAsMesh *w, LitheIndex side, LitheIndex *v) {
  const LthElementSides *s = w->sides;
  LitheIndex n = s->corner_off[side + 1] - s->corner_off[side];
  if (n == 0 || (s->mate[side] >= 0 && s->mate[side] < side)) return LITHE_OK;
  for (LitheIndex i = 0; i < n; i++) v[i] = w->node_point[s->corner[s->corner_off[side] + i]];
  if (is_planar(w, v, n)) return add_face(ctx, w, side, n, v);
  return n == 4 ? split_quad(ctx, w, side, v) : split_polygon(ctx, w, side, v, n);
}

static LitheStatus make_faces(LitheCtx *ctx, LthElementsAsMesh *w) {
  LitheStatus status = LITHE_OK;
  const LthElementSides *s = w->sides;
  LitheIndex *v = NULL, most = 0;
  for (LitheIndex f = 0; f < s->n; f++)
    if (s->corner_off[f + 1] - s->corner_off[f] > most)
      most = s->corner_off[f + 1] - s->corner_off[f];
  LTH_NEW_OR(done, ctx, v, most);
  LTH_RESERVE_OR(done, ctx, w->loop_off, w->cap_off, 1);
  for (LitheIndex f = 0; f < s->n; f++) LITHE_TRY_OR(done, make_face(ctx, w, f, v));
  LTH_NEW_OR(done, ctx, w->loop_off_of, (LitheCount)w->n_faces + 1);
  for (LitheIndex f = 0; f <= w->n_faces; f++) w->loop_off_of[f] = f;
done:
  lth_free(ctx, v);
  return status;
}

/// Edge of a cube as large as the mean element.
static double typical_size(const LthElementsAsMesh *w) {
  double low[3], high[3], volume = 0;
  for (int a = 0; a < 3; a++) low[a] = INFINITY, high[a] = -INFINITY;
  for (LitheIndex i = 0; i < w->n_points; i++)
    for (int a = 0; a < 3; a++) {
      low[a] = fmin(low[a], w->points[3 * (LitheCount)i + a]);
      high[a] = fmax(high[a], w->points[3 * (LitheCount)i + a]);
    }
  // sum over the boundary of (x - low) . n dA / 3
  for (LitheIndex f = 0; f < w->n_faces; f++) {
    if (w->face_cell[2 * f + 1] >= 0) continue;
    double a[3], b[3], c[3], cross[3];
    const LitheIndex *v = w->loop_point + w->loop_off[f];
    lth_v3_sub(w->points + 3 * (LitheCount)v[0], low, a);
    for (LitheIndex i = 1; i + 1 < w->loop_off[f + 1] - w->loop_off[f]; i++) {
      lth_v3_sub(w->points + 3 * (LitheCount)v[i], low, b);
      lth_v3_sub(w->points + 3 * (LitheCount)v[i + 1], low, c);
      lth_v3_cross(b, c, cross);
      volume += lth_v3_dot(a, cross) / 6;
    }
  }
  return cbrt(volume / w->elements->n_elements);
}

static LitheStatus create(LitheCtx *ctx, LthElementsAsMesh *w, LthMesh **mesh) {
  LITHE_TRY(lth_element_sides_list(ctx, w->elements, &w->sides));
  LITHE_TRY(lth_element_sides_match(ctx, w->elements, w->file, w->sides));
  LITHE_TRY(number_points(ctx, w));
  LITHE_TRY(make_faces(ctx, w));
  LthMeshDef def = {.n_points = w->n_points,
                    .n_faces = w->n_faces,
                    .n_cells = w->elements->n_elements,
                    .points = w->points,
                    .face_loop_off = w->loop_off_of,
                    .loop_off = w->loop_off,
                    .loop_point = w->loop_point,
                    .face_cell = w->face_cell,
                    .cell_size = typical_size(w)};
  LITHE_TRY(lth_mesh_create(ctx, &def, mesh));
  LITHE_TRY(lth_mesh_groups_from_elements(ctx, w, *mesh));
  return lth_mesh_warn_overlaps(ctx, w, *mesh);
}

LitheStatus lth_mesh_from_elements(LitheCtx *ctx, const LthElementMesh *elements, const char *file,
                                   LthMesh **mesh) {
  LthElementsAsMesh w = {.elements = elements, .file = file};
  *mesh = NULL;
  LitheStatus status = create(ctx, &w, mesh);
  if (status != LITHE_OK) lth_mesh_destroy(ctx, mesh);
  lth_elements_as_mesh_free(ctx, &w);
  return status;
}
