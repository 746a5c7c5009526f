/// Point in polyhedron by solid angles; the nearest element beyond.
#include "embed/cell_search.h"

#include "base/tensor.h"
#include "embed/embedding.h"

#define INSIDE 0.5       ///< of the full angle
#define IN_PLANE 1e-10   ///< of a cell's size
#define ON_BOUNDARY 1e-9 ///< of a cell's size: nearer points count as inside

static const double *loop_point(const LthFaceView *v, LitheIndex i) {
  return v->points + 3 * (size_t)v->loop_point[i];
}

/// Solid angle of a face from a signed fan; holes run the other way and subtract themselves.
static double face_angle(const LthFaceView *v, const double x[3]) {
  double angle = 0;
  for (LitheIndex l = 0; l < v->n_loops; l++)
    for (LitheIndex i = v->loop_off[l] + 1; i + 1 < v->loop_off[l + 1]; i++)
      angle +=
          lth_solid_angle(loop_point(v, v->loop_off[l]), loop_point(v, i), loop_point(v, i + 1), x);
  return angle;
}

static double signed_area2(const double a[3], const double b[3], const double c[3],
                           const double normal[3]) {
  double e1[3], e2[3], n[3];
  lth_v3_sub(b, a, e1);
  lth_v3_sub(c, a, e2);
  lth_v3_cross(e1, e2, n);
  return lth_v3_dot(n, normal);
}

/// The same from a place in the face's plane, where rounding decides on which side of each triangle of the fan it is: one side for
/// all. So triangles that overlap outside a face that is not convex cancel each other, and the angle is 0 or half of all.
static double angle_in_plane(const LthFaceView *v, const double normal[3], const double x[3]) {
  double angle = 0;
  for (LitheIndex l = 0; l < v->n_loops; l++)
    for (LitheIndex i = v->loop_off[l] + 1; i + 1 < v->loop_off[l + 1]; i++) {
      const double *a = loop_point(v, v->loop_off[l]), *b = loop_point(v, i),
                   *c = loop_point(v, i + 1);
      double area = signed_area2(a, b, c, normal);
      angle += copysign(lth_solid_angle(a, b, c, x), area);
    }
  return angle;
}

double lth_cell_winding(const LthMesh *mesh, LitheIndex cell, const double x[3]) {
  double angle = 0, way[3];
  for (LitheIndex i = mesh->cell_face_off[cell]; i < mesh->cell_face_off[cell + 1]; i++) {
    const LitheIndex face = mesh->cell_face[i];
    const double *normal = mesh->face_normal + 3 * (size_t)face;
    LthFaceView v = lth_mesh_face(mesh, face);
    lth_v3_sub(loop_point(&v, v.loop_off[0]), x, way);
    bool is_in_plane = fabs(lth_v3_dot(way, normal)) < IN_PLANE * mesh->cell_size;
    angle += lth_mesh_side(mesh, face, cell) *
             (is_in_plane ? angle_in_plane(&v, normal, x) : face_angle(&v, x));
  }
  return angle / (4 * M_PI);
}

double lth_cell_distance2(const LthMesh *mesh, LitheIndex cell, const double x[3]) {
  double best = INFINITY;
  for (LitheIndex i = mesh->cell_face_off[cell]; i < mesh->cell_face_off[cell + 1]; i++) {
    LthFaceView v = lth_mesh_face(mesh, mesh->cell_face[i]);
    best = fmin(best, lth_face_distance2(&v, x));
  }
  return best;
}

/// What a search has found so far.
typedef struct Found {
  const LthMesh *mesh;
  const double *x;
  LitheIndex cell;
} Found;

static bool holds(const LthMesh *mesh, LitheIndex cell, const double x[3]) {
  if (lth_box_distance2(mesh->cell_box + 6 * (size_t)cell, x) > 0) return false;
  return lth_cell_winding(mesh, cell, x) > INSIDE;
}

static bool visit_holding(void *self, LitheIndex cell) {
  Found *f = self;
  if ((f->cell < 0 || cell < f->cell) && holds(f->mesh, cell, f->x)) f->cell = cell;
  return true;
}

static double distance_to_cell(void *self, LitheIndex cell, const double x[3], double limit) {
  const Found *f = self;
  if (lth_box_distance2(f->mesh->cell_box + 6 * (size_t)cell, x) >= limit) return INFINITY;
  return lth_cell_distance2(f->mesh, cell, x);
}

static bool is_on_boundary(const LthMesh *mesh, double distance2) {
  double limit = ON_BOUNDARY * mesh->cell_size;
  return distance2 <= limit * limit;
}

LitheStatus lth_cell_search_create(LitheCtx *ctx, const LthMesh *mesh, LthCellSearch **search) {
  LitheStatus status = LITHE_OK;
  *search = NULL;
  LTH_NEW(ctx, *search, 1);
  (*search)->mesh = mesh;
  LITHE_TRY_OR(done, lth_bvh_create_boxes(ctx, mesh->n_cells, mesh->cell_box, &(*search)->bvh));
done:
  if (status != LITHE_OK) lth_cell_search_destroy(ctx, search);
  return status;
}

void lth_cell_search_destroy(LitheCtx *ctx, LthCellSearch **search) {
  if (!search || !*search) return;
  lth_bvh_destroy(ctx, &(*search)->bvh);
  lth_free(ctx, *search);
  *search = NULL;
}

LitheIndex lth_cell_search_find(const LthCellSearch *search, const double x[3], bool *inside) {
  Found f = {search->mesh, x, -1};
  lth_bvh_visit(search->bvh, x, 0, visit_holding, &f);
  bool is_inside = f.cell >= 0;
  if (!is_inside) {
    double distance2 = INFINITY;
    f.cell = lth_bvh_nearest(search->bvh, x, distance_to_cell, &f, &distance2);
    is_inside = is_on_boundary(search->mesh, distance2);
  }
  if (inside) *inside = is_inside;
  return f.cell;
}

LitheStatus lth_find_cell(LitheCtx *ctx, const LthMesh *mesh, const double x[3], LitheIndex *cell,
                          bool *inside) {
  *cell = -1;
  if (mesh->n_cells == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "a mesh without elements holds no points");
  for (LitheIndex c = 0; c < mesh->n_cells && *cell < 0; c++)
    if (holds(mesh, c, x)) *cell = c;
  if (inside) *inside = *cell >= 0;
  if (*cell >= 0) return LITHE_OK;

  double best = INFINITY;
  Found f = {mesh, x, -1};
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    double d2 = distance_to_cell(&f, c, x, best);
    if (d2 < best) best = d2, *cell = c;
  }
  if (*cell < 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "the point (%g, %g, %g) has no finite place", x[0], x[1],
               x[2]);
  if (inside) *inside = is_on_boundary(mesh, best);
  return LITHE_OK;
}

LitheStatus lth_surface_point_cells(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *cells) {
  (void)ctx;
  for (LitheIndex p = 0; p < mesh->n_surface_points; p++) cells[p] = -1;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex owner = mesh->face_cell[2 * (size_t)f];
    if (mesh->face_cell[2 * (size_t)f + 1] >= 0) continue;
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         i < mesh->loop_off[mesh->face_loop_off[f + 1]]; i++) {
      LitheIndex p = mesh->loop_point[i];
      if (p < mesh->n_surface_points && (cells[p] < 0 || owner < cells[p])) cells[p] = owner;
    }
  }
  return LITHE_OK;
}

LitheStatus lth_disc_find_cell(LitheCtx *ctx, const LthDisc *disc, const double x[3],
                               LitheIndex *cell, bool *inside) {
  if (!disc->table->find_cell) return lth_find_cell(ctx, disc->mesh, x, cell, inside);
  *cell = disc->table->find_cell(disc, x, inside);
  return LITHE_OK;
}
