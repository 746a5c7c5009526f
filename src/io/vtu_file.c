/// VTK's unstructured grids: cells, polyhedra and labels.
#include "io/vtu_file.h"

#include "io/vtu_head.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define POLYHEDRON 42
#define VOXEL 11

/// What is known of a cell type: its dimension, its nodes (0: any), its corners where it can be a face, the kind
/// of element it is (LTH_ELEMENT_KINDS: none), and the corners of its base where it is a prism made a polyhedron.
typedef struct CellType {
  int type, dimension, n_nodes, n_corners;
  LthElementKind kind;
  int prism;
} CellType;

#define NONE LTH_ELEMENT_KINDS
static const CellType cell_types[] = {{1, 0, 1, 0, NONE, 0},
                                      {2, 0, 0, 0, NONE, 0},
                                      {3, 1, 2, 0, NONE, 0},
                                      {4, 1, 0, 0, NONE, 0},
                                      {5, 2, 3, 3, NONE, 0},
                                      {6, 2, 0, 0, NONE, 0},
                                      {7, 2, 0, 0, NONE, 0},
                                      {8, 2, 4, 4, NONE, 0},
                                      {9, 2, 4, 4, NONE, 0},
                                      {10, 3, 4, 0, LTH_TET4, 0},
                                      {VOXEL, 3, 8, 0, LTH_HEX8, 0},
                                      {12, 3, 8, 0, LTH_HEX8, 0},
                                      {13, 3, 6, 0, LTH_WEDGE6, 0},
                                      {14, 3, 5, 0, LTH_PYRAMID5, 0},
                                      {15, 3, 10, 0, NONE, 5},
                                      {16, 3, 12, 0, NONE, 6},
                                      {21, 1, 3, 0, NONE, 0},
                                      {22, 2, 6, 3, NONE, 0},
                                      {23, 2, 8, 4, NONE, 0},
                                      {24, 3, 10, 0, LTH_TET10, 0},
                                      {25, 3, 20, 0, LTH_HEX20, 0},
                                      {26, 3, 15, 0, LTH_WEDGE15, 0},
                                      {27, 3, 13, 0, LTH_PYRAMID13, 0},
                                      {28, 2, 9, 4, NONE, 0},
                                      {29, 3, 27, 0, LTH_HEX27, 0},
                                      {32, 3, 18, 0, LTH_WEDGE18, 0},
                                      {34, 2, 7, 3, NONE, 0},
                                      {POLYHEDRON, 3, 0, 0, LTH_POLYHEDRON, 0}};

static const CellType *find_type(int64_t type) {
  for (size_t i = 0; i < sizeof cell_types / sizeof cell_types[0]; i++)
    if (cell_types[i].type == type) return &cell_types[i];
  return NULL;
}

/// All that is read of a file.
typedef struct VtuReader {
  LthElementBuilder *b;
  LthVtuHead head;
  double *points, *displacement, *label;
  int64_t *connectivity, *offsets, *types, *faces, *face_offsets;
  LitheCount n_connectivity, n_faces;
  LitheIndex *same; ///< of lth_vtu_weld(), or NULL
  int64_t *scratch; ///< a cell being put together
  LitheCount cap_scratch;
} VtuReader;

static void free_reader(VtuReader *r) {
  LitheCtx *ctx = r->b->ctx;
  void *blocks[] = {r->points, r->displacement, r->label,        r->connectivity, r->offsets,
                    r->types,  r->faces,        r->face_offsets, r->same,         r->scratch};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_vtu_head_free(ctx, &r->head);
}

static LitheStatus missing(const VtuReader *r, const char *what) {
  LITHE_FAIL(r->b->ctx, LITHE_BAD_INPUT, "%s: it has no array %s", r->b->file, what);
}

static LitheStatus check_length(const VtuReader *r, const LthVtuSource *source, LitheCount n,
                                LitheCount want) {
  if (n == want) return LITHE_OK;
  return lth_vtu_array_fail(&r->head.coding, source, "it has %lld values, expected %lld",
                            (long long)n, (long long)want);
}

/// An integer array of section Cells of a known length (-1: any).
static LitheStatus read_cells_array(VtuReader *r, const char *name, LitheCount want,
                                    int64_t **values, LitheCount *n) {
  const LthVtuSource *source = lth_vtu_find(&r->head, LTH_VTU_CELLS, name);
  if (!source) return missing(r, name);
  LITHE_TRY(lth_vtu_read_integers(&r->head.coding, source, values, n));
  return want < 0 ? LITHE_OK : check_length(r, source, *n, want);
}

static LitheStatus read_points(VtuReader *r) {
  LitheCount n = 0;
  const LthVtuSource *source = lth_vtu_find(&r->head, LTH_VTU_POINTS, NULL);
  if (!source) return missing(r, "Points");
  LITHE_TRY(lth_vtu_read_doubles(&r->head.coding, source, &r->points, &n));
  LITHE_TRY(check_length(r, source, n, 3 * r->head.n_points));
  for (LitheCount i = 0; i < n; i++)
    if (!isfinite(r->points[i]))
      return lth_vtu_array_fail(&r->head.coding, source, "a coordinate of point %lld is %g",
                                (long long)(i / 3), r->points[i]);
  return LITHE_OK;
}

/// The array whose values name groups: the first of these that has one number for each cell.
static LitheStatus read_label(VtuReader *r) {
  static const char *const names[] = {"label",         "material",      "MaterialIds",
                                      "gmsh:physical", "CellEntityIds", "region"};
  for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
    const LthVtuSource *source = lth_vtu_find(&r->head, LTH_VTU_CELL_DATA, names[i]);
    LitheCount n = 0;
    if (!source || source->components != 1) continue;
    LITHE_TRY(lth_vtu_read_doubles(&r->head.coding, source, &r->label, &n));
    LITHE_TRY(check_length(r, source, n, r->head.n_cells));
    return LITHE_OK;
  }
  return LITHE_OK;
}

static LitheStatus bad_cell(const VtuReader *r, LitheCount cell, const char *what, int64_t value) {
  LITHE_FAIL(r->b->ctx, LITHE_BAD_INPUT, "%s: cell %lld %s %lld", r->b->file, (long long)cell, what,
             (long long)value);
}

/// Offsets ascend and every node is a point.
static LitheStatus check_cells(const VtuReader *r) {
  int64_t before = 0;
  for (LitheCount c = 0; c < r->head.n_cells; c++) {
    if (r->offsets[c] < before || r->offsets[c] > r->n_connectivity)
      return bad_cell(r, c, "ends in the connectivity at", r->offsets[c]);
    before = r->offsets[c];
  }
  for (LitheCount i = 0; i < r->n_connectivity; i++)
    if (r->connectivity[i] < 0 || r->connectivity[i] >= r->head.n_points)
      LITHE_FAIL(r->b->ctx, LITHE_BAD_INPUT, "%s: the connectivity names point %lld of %lld",
                 r->b->file, (long long)r->connectivity[i], (long long)r->head.n_points);
  return LITHE_OK;
}

static LitheStatus read_arrays(VtuReader *r) {
  LitheCount n_cells = r->head.n_cells, n = 0;
  bool has_polyhedra = false;
  LITHE_TRY(read_points(r));
  LITHE_TRY(read_cells_array(r, "connectivity", -1, &r->connectivity, &r->n_connectivity));
  LITHE_TRY(read_cells_array(r, "offsets", n_cells, &r->offsets, &n));
  LITHE_TRY(read_cells_array(r, "types", n_cells, &r->types, &n));
  LITHE_TRY(check_cells(r));
  for (LitheCount c = 0; c < n_cells; c++)
    has_polyhedra = has_polyhedra || r->types[c] == POLYHEDRON;
  if (has_polyhedra) {
    LITHE_TRY(read_cells_array(r, "faces", -1, &r->faces, &r->n_faces));
    LITHE_TRY(read_cells_array(r, "faceoffsets", n_cells, &r->face_offsets, &n));
  }
  return read_label(r);
}

/// Whether every point belongs to one cell only, of several: as in files of discontinuous fields.
static LitheStatus find_discontinuous(VtuReader *r, bool *is_discontinuous) {
  uint8_t *used = NULL;
  LTH_NEW(r->b->ctx, used, r->head.n_points);
  *is_discontinuous = r->head.n_cells > 1;
  for (LitheCount i = 0; i < r->n_connectivity; i++) {
    if (used[r->connectivity[i]]) *is_discontinuous = false;
    used[r->connectivity[i]] = 1;
  }
  lth_free(r->b->ctx, used);
  return LITHE_OK;
}

/// Take the points of a discontinuous field back to where they were at rest, where the file says by how much they
/// moved.
static LitheStatus undo_displacement(VtuReader *r, double *rounding) {
  LitheCount n = 0;
  const LthVtuSource *source = lth_vtu_find(&r->head, LTH_VTU_POINT_DATA, "displacement");
  if (!source || source->components != 3) return LITHE_OK;
  LITHE_TRY(lth_vtu_read_doubles(&r->head.coding, source, &r->displacement, &n));
  LITHE_TRY(check_length(r, source, n, 3 * r->head.n_points));
  for (LitheCount i = 0; i < n; i++) {
    r->points[i] -= r->displacement[i];
    if (!isfinite(r->points[i]))
      return lth_vtu_array_fail(&r->head.coding, source, "point %lld is moved by %g",
                                (long long)(i / 3), r->displacement[i]);
  }
  *rounding *= 2;
  return LITHE_OK;
}

/// Rounding of the coordinates, and which points are the same.
static LitheStatus weld_points(VtuReader *r) {
  bool is_discontinuous = false;
  double most = 0;
  const LthVtuSource *source = lth_vtu_find(&r->head, LTH_VTU_POINTS, NULL);
  double unit = source->type == LTH_VTU_FLOAT32 ? 0x1p-24 : 0x1p-53;
  for (LitheCount i = 0; i < 3 * r->head.n_points; i++) most = fmax(most, fabs(r->points[i]));
  double rounding = unit * most;
  LITHE_TRY(find_discontinuous(r, &is_discontinuous));
  if (is_discontinuous) {
    LITHE_TRY(undo_displacement(r, &rounding));
    LTH_NEW(r->b->ctx, r->same, r->head.n_points);
    if (rounding > 0)
      LITHE_TRY(
          lth_vtu_weld(r->b->ctx, (LitheIndex)r->head.n_points, r->points, 4 * rounding, r->same));
  }
  if (unit > 0x1p-40) r->b->rounding = rounding;
  for (LitheCount i = 0; i < r->head.n_points; i++)
    if (!r->same || r->same[i] == i) LITHE_TRY(lth_builder_node(r->b, i, r->points + 3 * i));
  return LITHE_OK;
}

static int64_t node_of(const VtuReader *r, int64_t point) {
  return r->same ? r->same[point] : point;
}

/// Append to the cell being put together.
static LitheStatus put(VtuReader *r, LitheCount *n, int64_t value) {
  LTH_RESERVE(r->b->ctx, r->scratch, r->cap_scratch, *n + 1);
  r->scratch[(*n)++] = value;
  return LITHE_OK;
}

/// Append a face; corners that became one point after the other are taken once, and a face of fewer than three
/// corners is none.
static LitheStatus put_face(VtuReader *r, LitheCount *n, const int64_t *point, LitheCount count) {
  LitheCount head = *n;
  LITHE_TRY(put(r, n, 0));
  for (LitheCount i = 0; i < count; i++) {
    int64_t node = node_of(r, point[i]);
    if (*n > head + 1 && r->scratch[*n - 1] == node) continue;
    LITHE_TRY(put(r, n, node));
  }
  while (*n > head + 2 && r->scratch[*n - 1] == r->scratch[head + 1]) --*n;
  r->scratch[head] = *n - head - 1;
  if (r->scratch[head] < 3)
    *n = head;
  else
    r->scratch[0]++;
  return LITHE_OK;
}

static LitheStatus add_polyhedron(VtuReader *r, LitheCount cell, LitheCount *from) {
  LitheCount n = 0, at = *from, end = r->face_offsets[cell];
  if (end < at + 1 || end > r->n_faces) return bad_cell(r, cell, "ends in the faces at", end);
  int64_t n_faces = r->faces[at++];
  LITHE_TRY(put(r, &n, 0));
  for (int64_t f = 0; f < n_faces; f++) {
    int64_t count = at < end ? r->faces[at++] : -1;
    if (count < 3 || count > end - at)
      return bad_cell(r, cell, "is a polyhedron with a face whose number of points is", count);
    for (int64_t i = 0; i < count; i++)
      if (r->faces[at + i] < 0 || r->faces[at + i] >= r->head.n_points)
        return bad_cell(r, cell, "is a polyhedron with a face that names point", r->faces[at + i]);
    LITHE_TRY(put_face(r, &n, r->faces + at, count));
    at += count;
  }
  *from = end;
  if (r->scratch[0] < 4)
    return bad_cell(r, cell, "is a polyhedron whose number of faces is", r->scratch[0]);
  return lth_builder_polyhedron(r->b, cell, 0, r->scratch, n);
}

/// A prism over a polygon of k corners.
static LitheStatus add_prism(VtuReader *r, LitheCount cell, const int64_t *point, int k) {
  LitheCount n = 0;
  LITHE_TRY(put(r, &n, 0));
  LITHE_TRY(put_face(r, &n, point, k));
  LITHE_TRY(put_face(r, &n, point + k, k));
  for (int i = 0; i < k; i++) {
    int64_t quad[4] = {point[i], point[(i + 1) % k], point[k + (i + 1) % k], point[k + i]};
    LITHE_TRY(put_face(r, &n, quad, 4));
  }
  if (r->scratch[0] < 4)
    return bad_cell(r, cell, "is a prism whose number of faces is", r->scratch[0]);
  // the two ends run alike, so one of them is turned when the element is taken
  return lth_builder_polyhedron(r->b, cell, 0, r->scratch, n);
}

static LitheStatus add_solid(VtuReader *r, LitheCount cell, const CellType *type,
                             const int64_t *point) {
  static const int voxel[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  int64_t node[LTH_ELEMENT_MAX_NODES];
  for (int i = 0; i < type->n_nodes; i++)
    node[i] = node_of(r, point[type->type == VOXEL ? voxel[i] : i]);
  return lth_builder_element(r->b, type->kind, false, cell, 0, node);
}

/// Cells go into the group of their label; triangles and quads of the boundary as faces.
static LitheStatus add_label(VtuReader *r, LitheCount cell, const CellType *type,
                             const int64_t *point) {
  char name[24];
  LitheIndex group = 0;
  double value = r->label ? r->label[cell] : NAN;
  if (!(fabs(value) < INT32_MAX && value == floor(value))) return LITHE_OK;
  if (type->dimension < 2 || (type->dimension == 2 && type->n_corners == 0)) return LITHE_OK;
  snprintf(name, sizeof name, "%d", (int)value);
  LITHE_TRY(lth_builder_group(r->b, type->dimension == 3 ? LTH_GROUP_ELEMENTS : LTH_GROUP_FACES,
                              (LthWord){name, strlen(name)}, (LitheIndex)value, false, &group));
  if (type->dimension == 3) return lth_builder_member(r->b, group, cell);
  int64_t corner[4];
  for (int i = 0; i < type->n_corners; i++) corner[i] = node_of(r, point[i]);
  return lth_builder_face_of_corners(r->b, group, type->n_corners, corner);
}

static LitheStatus add_cell(VtuReader *r, LitheCount cell, LitheCount *from) {
  LitheCount begin = cell == 0 ? 0 : r->offsets[cell - 1], n = r->offsets[cell] - begin;
  const int64_t *point = r->connectivity + begin;
  const CellType *type = find_type(r->types[cell]);
  if (!type) return bad_cell(r, cell, "is of a type that is not read here:", r->types[cell]);
  if (type->n_nodes > 0 && n != type->n_nodes)
    return bad_cell(r, cell, "is of a type that does not go with its number of points,", n);
  if (type->type == POLYHEDRON)
    LITHE_TRY(add_polyhedron(r, cell, from));
  else if (type->prism > 0)
    LITHE_TRY(add_prism(r, cell, point, type->prism));
  else if (type->dimension == 3)
    LITHE_TRY(add_solid(r, cell, type, point));
  return add_label(r, cell, type, point);
}

LitheStatus lth_vtu_parse(LthElementBuilder *b, const char *data, size_t size) {
  VtuReader r = {.b = b};
  LitheStatus status = LITHE_OK;
  LitheCount from = 0;
  b->may_mirror = true;
  LITHE_TRY_OR(done, lth_vtu_head_parse(b->ctx, b->file, data, size, &r.head));
  LITHE_TRY_OR(done, read_arrays(&r));
  LITHE_TRY_OR(done, weld_points(&r));
  for (LitheCount c = 0; c < r.head.n_cells; c++) LITHE_TRY_OR(done, add_cell(&r, c, &from));
done:
  free_reader(&r);
  return status;
}
