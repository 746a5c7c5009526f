/// Create, check and free a polyhedral mesh.
#include "mesh/mesh.h"

#include "base/tensor.h"
#include "mesh/mesh_measure.h"

#include <float.h>
#include <string.h>

/// A cell's open area may be this share of its area: far above rounding, far below a missing face.
#define CLOSED_TOLERANCE 1e-9

void lth_mesh_destroy(LitheCtx *ctx, LthMesh **mesh) {
  if (!mesh || !*mesh) return;
  LthMesh *m = *mesh;
  for (LitheIndex g = 0; g < m->n_groups; g++) {
    lth_free(ctx, m->groups[g].name);
    lth_free(ctx, m->groups[g].member);
  }
  void *blocks[] = {m->points,
                    m->point_rank,
                    m->face_loop_off,
                    m->loop_off,
                    m->loop_point,
                    m->face_cell,
                    m->face_normal,
                    m->face_area,
                    m->face_centroid,
                    m->face_tag,
                    m->cell_face_off,
                    m->cell_face,
                    m->cell_volume,
                    m->cell_centroid,
                    m->cell_box,
                    m->groups,
                    m};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *mesh = NULL;
}

void lth_mesh_bounds(const LthMesh *mesh, double min[3], double max[3]) {
  for (int a = 0; a < 3; a++) min[a] = INFINITY, max[a] = -INFINITY;
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    for (int a = 0; a < 3; a++) {
      min[a] = fmin(min[a], mesh->cell_box[6 * (LitheCount)c + a]);
      max[a] = fmax(max[a], mesh->cell_box[6 * (LitheCount)c + 3 + a]);
    }
}

LthFaceView lth_mesh_face(const LthMesh *mesh, LitheIndex f) {
  LitheIndex first = mesh->face_loop_off[f];
  return (LthFaceView){mesh->points, mesh->loop_off + first, mesh->loop_point,
                       mesh->face_loop_off[f + 1] - first, mesh->face_normal + 3 * (LitheCount)f};
}

static LitheStatus copy_block(LitheCtx *ctx, void **to, const void *from, LitheCount n,
                              size_t size) {
  LITHE_TRY(lth_new_(ctx, to, n, size));
  if (n > 0) memcpy(*to, from, (size_t)n * size);
  return LITHE_OK;
}

#define COPY(to, from, n) LITHE_TRY(copy_block(ctx, (void **)&(to), (from), (n), sizeof *(to)))

/// Three numbers of every point and face, and six of every cell, are counted in a LitheIndex.
static LitheStatus check_sizes(LitheCtx *ctx, const LthMeshDef *def) {
  if (def->n_points <= INT32_MAX / 3 && def->n_faces <= INT32_MAX / 3 &&
      def->n_cells <= INT32_MAX / 6)
    return LITHE_OK;
  LITHE_FAIL(
      ctx, LITHE_UNSUPPORTED,
      "mesh: %d points, %d faces and %d cells are more than a mesh can hold; use larger cells",
      def->n_points, def->n_faces, def->n_cells);
}

static LitheStatus copy_lists(LitheCtx *ctx, const LthMeshDef *def, LthMesh *m) {
  LitheIndex n_loops = def->face_loop_off[def->n_faces];
  COPY(m->points, def->points, 3 * (LitheCount)def->n_points);
  COPY(m->face_loop_off, def->face_loop_off, def->n_faces + 1);
  COPY(m->loop_off, def->loop_off, n_loops + 1);
  COPY(m->loop_point, def->loop_point, def->loop_off[n_loops]);
  COPY(m->face_cell, def->face_cell, 2 * (LitheCount)def->n_faces);
  return LITHE_OK;
}

static LitheStatus copy_rest(LitheCtx *ctx, const LthMeshDef *def, LthMesh *m) {
  LTH_NEW(ctx, m->point_rank, def->n_points);
  LTH_NEW(ctx, m->face_tag, def->n_faces);
  for (LitheIndex i = 0; i < def->n_points; i++)
    m->point_rank[i] = def->point_rank ? def->point_rank[i] : 3;
  for (LitheIndex f = 0; f < def->n_faces; f++)
    m->face_tag[f] = def->face_tag ? def->face_tag[f] : -1;
  m->n_points = def->n_points;
  m->n_faces = def->n_faces;
  m->n_cells = def->n_cells;
  m->n_surface_points = def->n_surface_points;
  m->cell_size = def->cell_size;
  m->n_merged = def->n_merged;
  return LITHE_OK;
}

static LitheStatus check_faces(LitheCtx *ctx, const LthMesh *m) {
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    LitheIndex owner = m->face_cell[2 * f], other = m->face_cell[2 * f + 1];
    bool is_inner = other > owner && other < m->n_cells;
    if (owner < 0 || owner >= m->n_cells || !(is_inner || other == -1))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "mesh: face %d lies between cells %d and %d; expected owner < neighbour < %d, or "
                 "neighbour -1",
                 f, owner, other, m->n_cells);
    LitheIndex first = m->loop_off[m->face_loop_off[f]],
               last = m->loop_off[m->face_loop_off[f + 1]];
    if (last - first < 3)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "mesh: face %d has %d points, expected 3 or more", f,
                 last - first);
    for (LitheIndex i = first; i < last; i++)
      if (m->loop_point[i] < 0 || m->loop_point[i] >= m->n_points)
        LITHE_FAIL(ctx, LITHE_BAD_INPUT, "mesh: face %d names point %d of %d", f, m->loop_point[i],
                   m->n_points);
  }
  return LITHE_OK;
}

static LitheStatus list_cell_faces(LitheCtx *ctx, LthMesh *m) {
  LTH_NEW(ctx, m->cell_face_off, (LitheCount)m->n_cells + 2);
  LitheIndex *off = m->cell_face_off;
  for (LitheCount i = 0; i < 2 * (LitheCount)m->n_faces; i++)
    if (m->face_cell[i] >= 0) off[m->face_cell[i] + 2]++;
  for (LitheIndex c = 0; c < m->n_cells; c++) off[c + 2] += off[c + 1];
  LTH_NEW(ctx, m->cell_face, off[m->n_cells + 1]);
  for (LitheCount i = 0; i < 2 * (LitheCount)m->n_faces; i++)
    if (m->face_cell[i] >= 0) m->cell_face[off[m->face_cell[i] + 1]++] = (LitheIndex)(i / 2);
  return LITHE_OK;
}

static LitheStatus check_cell(LitheCtx *ctx, const LthMesh *m, LitheIndex c) {
  double area = 0, gap = lth_mesh_cell_gap(m, c, &area);
  // areas of needles are small beside the rounding of their length
  const double *box = m->cell_box + 6 * (LitheCount)c;
  double rounding = 64 * DBL_EPSILON * pow(lth_v3_distance(box, box + 3), 2);
  if (!(gap <= CLOSED_TOLERANCE * area + rounding))
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "mesh: cell %d of %d near (%g, %g, %g) is not closed: its %d faces leave %g m^2 open", c,
        m->n_cells, m->cell_centroid[3 * c], m->cell_centroid[3 * c + 1],
        m->cell_centroid[3 * c + 2], m->cell_face_off[c + 1] - m->cell_face_off[c], gap);
  if (!(m->cell_volume[c] > 0))
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "mesh: cell %d of %d near (%g, %g, %g) has a volume of %g m^3, expected more than 0: "
        "its faces may be turned inside out",
        c, m->n_cells, m->cell_centroid[3 * c], m->cell_centroid[3 * c + 1],
        m->cell_centroid[3 * c + 2], m->cell_volume[c]);
  return LITHE_OK;
}

/// With the lists of faces and points in place.
static LitheStatus build(LitheCtx *ctx, const LthMeshDef *def, LthMesh *m) {
  LITHE_TRY(copy_rest(ctx, def, m));
  LITHE_TRY(check_faces(ctx, m));
  LITHE_TRY(list_cell_faces(ctx, m));
  LITHE_TRY(lth_mesh_measure_faces(ctx, m));
  LITHE_TRY(lth_mesh_measure_cells(ctx, m));
  for (LitheIndex c = 0; c < m->n_cells; c++) LITHE_TRY(check_cell(ctx, m, c));
  return LITHE_OK;
}

LitheStatus lth_mesh_create(LitheCtx *ctx, const LthMeshDef *def, LthMesh **mesh) {
  *mesh = NULL;
  LthMesh *made = NULL;
  LTH_NEW(ctx, made, 1);
  LitheStatus status = check_sizes(ctx, def);
  if (status == LITHE_OK) status = copy_lists(ctx, def, made);
  if (status == LITHE_OK) status = build(ctx, def, made);
  if (status != LITHE_OK) lth_mesh_destroy(ctx, &made);
  *mesh = made;
  return status;
}

static void free_lists(LitheCtx *ctx, LthMeshLists *l) {
  void *blocks[] = {l->points, l->face_loop_off, l->loop_off, l->loop_point, l->face_cell};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *l = (LthMeshLists){0};
}

LitheStatus lth_mesh_create_of(LitheCtx *ctx, const LthMeshDef *def, LthMeshLists *lists,
                               LthMesh **mesh) {
  LthMesh *made = NULL;
  *mesh = NULL;
  LitheStatus status = lth_new_(ctx, (void **)&made, 1, sizeof *made);
  if (status != LITHE_OK) {
    free_lists(ctx, lists);
    return status;
  }
  made->points = lists->points;
  made->face_loop_off = lists->face_loop_off;
  made->loop_off = lists->loop_off;
  made->loop_point = lists->loop_point;
  made->face_cell = lists->face_cell;
  *lists = (LthMeshLists){0};
  status = check_sizes(ctx, def);
  if (status == LITHE_OK) status = build(ctx, def, made);
  if (status != LITHE_OK) lth_mesh_destroy(ctx, &made);
  *mesh = made;
  return status;
}
