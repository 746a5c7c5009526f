/// The part of a VTU file that stays the same while a body moves: which cells and faces there are.
#include "io/vtu_topology.h"

#include "geometry/face_polygon.h"

#include <string.h>

#define VTK_POLYHEDRON 42

/// Collect the distinct points of a cell in the order its faces name them; `seen` holds the last cell
/// that took a point. With `list` NULL only count.
static LitheIndex collect_points(const LthMesh *mesh, LitheIndex cell, LitheIndex *seen,
                                 LitheIndex *list) {
  LitheIndex n = 0;
  for (LitheIndex k = mesh->cell_face_off[cell]; k < mesh->cell_face_off[cell + 1]; k++) {
    LitheIndex f = mesh->cell_face[k];
    LitheIndex begin = mesh->loop_off[mesh->face_loop_off[f]];
    LitheIndex end = mesh->loop_off[mesh->face_loop_off[f + 1]];
    for (LitheIndex i = begin; i < end; i++) {
      LitheIndex p = mesh->loop_point[i];
      if (seen[p] == cell + 1) continue;
      seen[p] = cell + 1;
      if (list) list[n] = p;
      n++;
    }
  }
  return n;
}

LitheStatus lth_vtu_cell_points(LitheCtx *ctx, const LthMesh *mesh, LitheCount **cell_point_off,
                                LitheIndex **cell_mesh_point) {
  LitheStatus status = LITHE_OK;
  LitheIndex *seen = NULL;
  *cell_point_off = NULL;
  *cell_mesh_point = NULL;
  LTH_NEW_OR(failed, ctx, seen, mesh->n_points);
  LTH_NEW_OR(failed, ctx, *cell_point_off, mesh->n_cells + 1);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    (*cell_point_off)[c + 1] = (*cell_point_off)[c] + collect_points(mesh, c, seen, NULL);
  memset(seen, 0, sizeof *seen * (size_t)mesh->n_points);
  LTH_NEW_OR(failed, ctx, *cell_mesh_point, (*cell_point_off)[mesh->n_cells]);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    collect_points(mesh, c, seen, *cell_mesh_point + (*cell_point_off)[c]);
  lth_free(ctx, seen);
  return LITHE_OK;

failed:
  lth_free(ctx, seen);
  lth_free(ctx, *cell_point_off);
  lth_free(ctx, *cell_mesh_point);
  *cell_point_off = NULL;
  *cell_mesh_point = NULL;
  return status;
}

/// The plain arrays before compression, as VTK names them.
typedef struct Arrays {
  int64_t *connectivity, *offsets, *faces, *faceoffsets;
  unsigned char *types;
  LitheCount n_faces, cap_faces;
} Arrays;

static void free_arrays(LitheCtx *ctx, Arrays *a) {
  lth_free(ctx, a->connectivity);
  lth_free(ctx, a->offsets);
  lth_free(ctx, a->faces);
  lth_free(ctx, a->faceoffsets);
  lth_free(ctx, a->types);
}

/// Faces of one cell: their number, then each as its number of points and the rows of its points, seen
/// counter-clockwise from outside the cell. `row` maps mesh points to the cell's rows.
static LitheStatus append_cell(LitheCtx *ctx, const LthMesh *mesh, LitheIndex cell,
                               const LitheCount *row, LthPolygonList *polygons, Arrays *a) {
  LitheCount head = a->n_faces;
  LTH_RESERVE(ctx, a->faces, a->cap_faces, head + 1);
  a->n_faces++;
  int64_t n_polygons = 0;
  for (LitheIndex k = mesh->cell_face_off[cell]; k < mesh->cell_face_off[cell + 1]; k++) {
    LitheIndex f = mesh->cell_face[k];
    bool is_owner = mesh->face_cell[2 * f] == cell;
    LthFaceView face = lth_mesh_face(mesh, f);
    polygons->n = 0;
    polygons->n_polygons = 0;
    LITHE_TRY(lth_face_polygons(ctx, &face, polygons));
    LTH_RESERVE(ctx, a->faces, a->cap_faces, a->n_faces + polygons->n);
    n_polygons += polygons->n_polygons;
    for (LitheCount i = 0; i < polygons->n;) {
      LitheIndex n = polygons->items[i++];
      a->faces[a->n_faces++] = n;
      for (LitheIndex j = 0; j < n; j++)
        a->faces[a->n_faces++] = row[polygons->items[i + (is_owner ? j : n - 1 - j)]];
      i += n;
    }
  }
  a->faces[head] = n_polygons;
  a->faceoffsets[cell] = a->n_faces;
  return LITHE_OK;
}

static LitheStatus fill_arrays(LitheCtx *ctx, const LthVtu *vtu, Arrays *a) {
  LitheStatus status = LITHE_OK;
  const LthMesh *mesh = vtu->mesh;
  LitheCount *row = NULL;
  LthPolygonList polygons = {0};
  LTH_NEW_OR(done, ctx, row, mesh->n_points);
  LTH_NEW_OR(done, ctx, a->connectivity, vtu->n_points);
  LTH_NEW_OR(done, ctx, a->offsets, mesh->n_cells);
  LTH_NEW_OR(done, ctx, a->faceoffsets, mesh->n_cells);
  LTH_NEW_OR(done, ctx, a->types, mesh->n_cells);
  for (LitheIndex i = 0; i < vtu->n_points; i++) a->connectivity[i] = i;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    a->offsets[c] = vtu->cell_point_off[c + 1];
    a->types[c] = VTK_POLYHEDRON;
    for (LitheCount i = vtu->cell_point_off[c]; i < vtu->cell_point_off[c + 1]; i++)
      row[vtu->cell_mesh_point[i]] = i;
    LITHE_TRY_OR(done, append_cell(ctx, mesh, c, row, &polygons, a));
  }

done:
  lth_free(ctx, row);
  lth_polygon_list_free(ctx, &polygons);
  return status;
}

LitheStatus lth_vtu_topology_create(LitheCtx *ctx, const LthVtu *vtu, LthVtuTopology **topology) {
  LitheStatus status = LITHE_OK;
  Arrays a = {0};
  LitheCount n_cells = vtu->mesh->n_cells;
  LTH_NEW(ctx, *topology, 1);
  LITHE_TRY_OR(done, fill_arrays(ctx, vtu, &a));
  const struct {
    const void *data;
    LitheCount bytes;
  } source[LTH_VTU_TOPOLOGY_ARRAYS] = {{a.connectivity, 8 * (LitheCount)vtu->n_points},
                                       {a.offsets, 8 * n_cells},
                                       {a.types, n_cells},
                                       {a.faces, 8 * a.n_faces},
                                       {a.faceoffsets, 8 * n_cells}};
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++)
    LITHE_TRY_OR(
        done, lth_vtu_block_encode(ctx, source[i].data, source[i].bytes, &(*topology)->block[i]));

done:
  free_arrays(ctx, &a);
  if (status != LITHE_OK) lth_vtu_topology_destroy(ctx, topology);
  return status;
}

void lth_vtu_topology_destroy(LitheCtx *ctx, LthVtuTopology **topology) {
  if (!*topology) return;
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++) lth_vtu_block_free(ctx, &(*topology)->block[i]);
  lth_free(ctx, *topology);
  *topology = NULL;
}
