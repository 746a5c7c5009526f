/// Meshes of a whole box: hexahedra, or six tetrahedra to each of them (Kuhn's subdivision).
#include "base/hash.h"
#include "mesh/mesh.h"

#include <math.h>

double lth_grid_plane(const LthGrid *grid, int axis, LitheIndex k) {
  double lo = grid->min[axis], hi = grid->max[axis];
  LitheIndex n = grid->cells[axis];
  if (k <= 0) return lo;
  if (k >= n) return hi;
  return lo + (hi - lo) * ((double)k / (double)n);
}

/// Arrays of a definition while it is being filled.
typedef struct BoxDef {
  double *points;
  LitheIndex *face_loop_off, *loop_off, *loop_point, *face_cell;
  LitheIndex n_points, n_faces;
  int corners; ///< points of each face
} BoxDef;

static void free_box_def(LitheCtx *ctx, BoxDef *d) {
  lth_free(ctx, d->points);
  lth_free(ctx, d->face_loop_off);
  lth_free(ctx, d->loop_off);
  lth_free(ctx, d->loop_point);
  lth_free(ctx, d->face_cell);
}

static LitheStatus check_grid(LitheCtx *ctx, const LthGrid *grid, int per_cell) {
  LitheCount n = 1;
  for (int a = 0; a < 3; a++) {
    if (grid->cells[a] < 1 || !(grid->max[a] > grid->min[a]))
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "grid: axis %c runs from %g to %g in %d cells; expected min < max and at least 1 cell",
          "xyz"[a], grid -> min[a], grid -> max[a], grid -> cells[a]);
    n *= grid->cells[a] + 1;
    if (n > INT32_MAX / per_cell)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "grid: %d x %d x %d cells are more than a mesh can hold",
                 grid->cells[0], grid->cells[1], grid->cells[2]);
  }
  return LITHE_OK;
}

static LitheIndex grid_point(const LthGrid *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  return i + (g->cells[0] + 1) * (j + (g->cells[1] + 1) * k);
}

static LitheIndex grid_cell(const LthGrid *g, const LitheIndex at[3]) {
  for (int a = 0; a < 3; a++)
    if (at[a] < 0 || at[a] >= g->cells[a]) return -1;
  return at[0] + g->cells[0] * (at[1] + g->cells[1] * at[2]);
}

static LitheStatus make_points(LitheCtx *ctx, const LthGrid *g, BoxDef *d) {
  const LitheIndex *n = g->cells;
  d->n_points = (n[0] + 1) * (n[1] + 1) * (n[2] + 1);
  LTH_NEW(ctx, d->points, 3 * (LitheCount)d->n_points);
  double *x = d->points;
  for (LitheIndex k = 0; k <= n[2]; k++)
    for (LitheIndex j = 0; j <= n[1]; j++)
      for (LitheIndex i = 0; i <= n[0]; i++) {
        *x++ = lth_grid_plane(g, 0, i);
        *x++ = lth_grid_plane(g, 1, j);
        *x++ = lth_grid_plane(g, 2, k);
      }
  return LITHE_OK;
}

static LitheStatus make_faces(LitheCtx *ctx, BoxDef *d, LitheCount capacity, int corners) {
  d->corners = corners;
  LTH_NEW(ctx, d->face_loop_off, capacity + 1);
  LTH_NEW(ctx, d->loop_off, capacity + 1);
  LTH_NEW(ctx, d->loop_point, capacity * corners);
  LTH_NEW(ctx, d->face_cell, 2 * capacity);
  for (LitheCount f = 0; f <= capacity; f++) {
    d->face_loop_off[f] = (LitheIndex)f;
    d->loop_off[f] = (LitheIndex)(f * corners);
  }
  return LITHE_OK;
}

/// Append a face; `points` turn counter-clockwise seen from cell b.
static void add_face(BoxDef *d, const LitheIndex *points, LitheIndex a, LitheIndex b) {
  LitheIndex f = d->n_faces++;
  bool flip = a < 0 || (b >= 0 && b < a);
  for (int i = 0; i < d->corners; i++)
    d->loop_point[f * d->corners + i] = points[flip ? d->corners - 1 - i : i];
  d->face_cell[2 * f] = flip ? b : a;
  d->face_cell[2 * f + 1] = flip ? a : b;
}

/// The face across `axis` below cell `at`.
static void add_quad(const LthGrid *g, BoxDef *d, int axis, const LitheIndex at[3]) {
  LitheIndex corner[3] = {at[0], at[1], at[2]}, points[4];
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int i = 0; i < 4; i++) {
    corner[u] = at[u] + (i == 1 || i == 2);
    corner[v] = at[v] + (i >= 2);
    points[i] = grid_point(g, corner[0], corner[1], corner[2]);
  }
  LitheIndex below[3] = {at[0], at[1], at[2]};
  below[axis]--;
  add_face(d, points, grid_cell(g, below), grid_cell(g, at));
}

static LitheStatus add_quads(LitheCtx *ctx, const LthGrid *g, BoxDef *d) {
  const LitheIndex *n = g->cells;
  LitheCount n_faces = 0;
  for (int a = 0; a < 3; a++) n_faces += (LitheCount)(n[a] + 1) * n[(a + 1) % 3] * n[(a + 2) % 3];
  LITHE_TRY(make_faces(ctx, d, n_faces, 4));
  for (int a = 0; a < 3; a++) {
    LitheIndex at[3];
    for (at[2] = 0; at[2] < n[2] + (a == 2); at[2]++)
      for (at[1] = 0; at[1] < n[1] + (a == 1); at[1]++)
        for (at[0] = 0; at[0] < n[0] + (a == 0); at[0]++) add_quad(g, d, a, at);
  }
  return LITHE_OK;
}

static LitheStatus create_from(LitheCtx *ctx, const LthGrid *g, const BoxDef *d, int per_cell,
                               LthMesh **mesh) {
  double size = 1;
  for (int a = 0; a < 3; a++) size *= (g->max[a] - g->min[a]) / g->cells[a];
  LthMeshDef def = {.n_points = d->n_points,
                    .n_faces = d->n_faces,
                    .n_cells = per_cell * g->cells[0] * g->cells[1] * g->cells[2],
                    .points = d->points,
                    .face_loop_off = d->face_loop_off,
                    .loop_off = d->loop_off,
                    .loop_point = d->loop_point,
                    .face_cell = d->face_cell,
                    .cell_size = cbrt(size)};
  return lth_mesh_create(ctx, &def, mesh);
}

LitheStatus lth_mesh_hexahedra(LitheCtx *ctx, const LthGrid *grid, LthMesh **mesh) {
  BoxDef d = {0};
  *mesh = NULL;
  LITHE_TRY(check_grid(ctx, grid, 12));
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, make_points(ctx, grid, &d));
  LITHE_TRY_OR(done, add_quads(ctx, grid, &d));
  LITHE_TRY_OR(done, create_from(ctx, grid, &d, 1, mesh));
done:
  free_box_def(ctx, &d);
  return status;
}

/// Enter a triangle of tetrahedron `cell`, outward: a new face, or the second side of a known one.
static LitheStatus add_triangle(LitheCtx *ctx, LthHash *known, BoxDef *d, const LitheIndex p[3],
                                LitheIndex cell) {
  LitheIndex s[3] = {p[0], p[1], p[2]};
  for (int i = 0; i < 3; i++)
    for (int j = i + 1; j < 3; j++)
      if (s[j] < s[i]) {
        LitheIndex swap = s[i];
        s[i] = s[j], s[j] = swap;
      }
  LitheIndex f = 0;
  LITHE_TRY(lth_hash_insert(ctx, known, lth_hash_pair(s[0], s[1]), (uint64_t)s[2], d->n_faces, &f));
  if (f < d->n_faces)
    d->face_cell[2 * f + 1] = cell;
  else
    add_face(d, p, cell, -1);
  return LITHE_OK;
}

/// The tetrahedron whose edges go along the axes in the order `path` from the low to the high corner.
static LitheStatus add_tetrahedron(LitheCtx *ctx, const LthGrid *g, LthHash *known, BoxDef *d,
                                   const LitheIndex at[3], const int path[3], bool is_odd,
                                   LitheIndex cell) {
  static const int faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  LitheIndex corner[3] = {at[0], at[1], at[2]}, v[4];
  v[0] = grid_point(g, corner[0], corner[1], corner[2]);
  for (int i = 0; i < 3; i++) {
    corner[path[i]]++;
    v[i + 1] = grid_point(g, corner[0], corner[1], corner[2]);
  }
  for (int i = 0; i < 4; i++) {
    const int *t = faces[i];
    LitheIndex p[3] = {v[t[0]], v[t[is_odd ? 2 : 1]], v[t[is_odd ? 1 : 2]]};
    LITHE_TRY(add_triangle(ctx, known, d, p, cell));
  }
  return LITHE_OK;
}

static LitheStatus add_tetrahedra(LitheCtx *ctx, const LthGrid *g, LthHash *known, BoxDef *d) {
  static const int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0}, {1, 0, 2}, {2, 0, 1}, {2, 1, 0}};
  const LitheIndex *n = g->cells;
  LitheCount n_cells = (LitheCount)n[0] * n[1] * n[2];
  LitheCount n_outer =
      4 * ((LitheCount)n[0] * n[1] + (LitheCount)n[1] * n[2] + (LitheCount)n[2] * n[0]);
  LITHE_TRY(make_faces(ctx, d, (24 * n_cells + n_outer) / 2, 3));
  LITHE_TRY(lth_hash_reserve(ctx, known, (24 * n_cells + n_outer) / 2));
  LitheIndex at[3], cell = 0;
  for (at[2] = 0; at[2] < n[2]; at[2]++)
    for (at[1] = 0; at[1] < n[1]; at[1]++)
      for (at[0] = 0; at[0] < n[0]; at[0]++)
        for (int t = 0; t < 6; t++)
          LITHE_TRY(add_tetrahedron(ctx, g, known, d, at, paths[t], t % 2 == 1, cell++));
  return LITHE_OK;
}

LitheStatus lth_mesh_tetrahedra(LitheCtx *ctx, const LthGrid *grid, LthMesh **mesh) {
  BoxDef d = {0};
  LthHash known = {0};
  *mesh = NULL;
  LITHE_TRY(check_grid(ctx, grid, 48));
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, make_points(ctx, grid, &d));
  LITHE_TRY_OR(done, add_tetrahedra(ctx, grid, &known, &d));
  LITHE_TRY_OR(done, create_from(ctx, grid, &d, 6, mesh));
done:
  lth_hash_free(ctx, &known);
  free_box_def(ctx, &d);
  return status;
}
