/// Cells of a topology as an immutable mesh.
#include "mesh/topology_priv.h"

/// A mesh in the making.
typedef struct Packing {
  LthTopology *t;
  LitheIndex n_cells, n_faces, n_points;
  LitheIndex *cell_of,
      *point_of; ///< of records: number in the mesh + 1, 0: none; of the topology's scratch
  LitheIndex *cell_record, *face_record, *point_record;
  LitheIndex *face_loop_off, *loop_off, *loop_point, *face_cell, *face_tag;
  double *points;
  uint8_t *rank;
  LitheCount face_cap, face_loop_cap, loop_off_cap, loop_point_cap, face_cell_cap, face_tag_cap,
      point_cap;
  LitheIndex n_loops, n_corners;
} Packing;

static LitheStatus list_cells(LitheCtx *ctx, Packing *p, LitheIndex n, const LitheIndex *cells) {
  const LthTopology *t = p->t;
  LTH_NEW(ctx, p->cell_record, cells ? n : t->n_live_cells);
  LTH_RESERVE(ctx, t->work->mesh_cell, t->work->mesh_cell_cap, t->n_cells);
  p->cell_of = t->work->mesh_cell;
  for (LitheIndex i = 0; i < (cells ? n : t->n_cells); i++) {
    LitheIndex cell = cells ? cells[i] : i;
    if (!t->cells[cell].is_live || p->cell_of[cell] > 0) continue;
    p->cell_record[p->n_cells++] = cell;
    p->cell_of[cell] = p->n_cells;
  }
  return LITHE_OK;
}

static LitheStatus add_point(LitheCtx *ctx, Packing *p, LitheIndex point) {
  LTH_RESERVE(ctx, p->point_record, p->point_cap, (LitheCount)p->n_points + 1);
  p->point_record[p->n_points++] = point;
  p->point_of[point] = p->n_points;
  return LITHE_OK;
}

static LitheStatus add_face(LitheCtx *ctx, Packing *p, LitheIndex face) {
  const LthTopologyFace *f = p->t->faces + face;
  LitheIndex a = p->cell_of[f->cell[0]] - 1, b = f->cell[1] >= 0 ? p->cell_of[f->cell[1]] - 1 : -1;
  bool is_turned = a < 0 || (b >= 0 && b < a);
  LthFaceView view = lth_topology_face(p->t, face);
  LTH_RESERVE(ctx, p->face_record, p->face_cap, (LitheCount)p->n_faces + 1);
  LTH_RESERVE(ctx, p->face_cell, p->face_cell_cap, 2 * ((LitheCount)p->n_faces + 1));
  LTH_RESERVE(ctx, p->face_tag, p->face_tag_cap, (LitheCount)p->n_faces + 1);
  LTH_RESERVE(ctx, p->face_loop_off, p->face_loop_cap, (LitheCount)p->n_faces + 2);
  LTH_RESERVE(ctx, p->loop_off, p->loop_off_cap, (LitheCount)p->n_loops + view.n_loops + 1);
  LTH_RESERVE(ctx, p->loop_point, p->loop_point_cap, (LitheCount)p->n_corners + f->n_corners);
  for (LitheIndex l = 0; l < view.n_loops; l++) {
    LitheIndex first = view.loop_off[l], size = view.loop_off[l + 1] - first;
    for (LitheIndex i = 0; i < size; i++) {
      LitheIndex point = view.loop_point[first + (is_turned && i > 0 ? size - i : i)];
      if (p->point_of[point] == 0) LITHE_TRY(add_point(ctx, p, point));
      p->loop_point[p->n_corners++] = p->point_of[point] - 1;
    }
    p->loop_off[++p->n_loops] = p->n_corners;
  }
  p->face_record[p->n_faces] = face;
  p->face_cell[2 * p->n_faces] = is_turned ? b : a;
  p->face_cell[2 * p->n_faces + 1] = is_turned ? a : b;
  p->face_tag[p->n_faces] = f->tag;
  p->face_loop_off[++p->n_faces] = p->n_loops;
  return LITHE_OK;
}

/// Room for all of it: lists that grow are copied.
static LitheStatus make_room(LitheCtx *ctx, Packing *p) {
  const LthTopology *t = p->t;
  LitheCount n = t->n_live_faces, corners = t->n_pool - t->n_waste;
  LTH_RESERVE(ctx, p->face_record, p->face_cap, n);
  LTH_RESERVE(ctx, p->face_cell, p->face_cell_cap, 2 * n);
  LTH_RESERVE(ctx, p->face_tag, p->face_tag_cap, n);
  LTH_RESERVE(ctx, p->face_loop_off, p->face_loop_cap, n + 1);
  LTH_RESERVE(ctx, p->loop_off, p->loop_off_cap, n + n / 16 + 1);
  LTH_RESERVE(ctx, p->loop_point, p->loop_point_cap, corners);
  LTH_RESERVE(ctx, p->point_record, p->point_cap, t->n_points);
  return LITHE_OK;
}

static LitheStatus list_faces(LitheCtx *ctx, Packing *p, bool all) {
  LthTopology *t = p->t;
  if (all) LITHE_TRY(make_room(ctx, p));
  LTH_RESERVE(ctx, t->work->mesh_point, t->work->mesh_point_cap, t->n_points);
  p->point_of = t->work->mesh_point;
  for (LitheIndex i = 0; all && i < t->n_surface_points; i++) LITHE_TRY(add_point(ctx, p, i));
  LTH_RESERVE(ctx, p->face_loop_off, p->face_loop_cap, 1);
  LTH_RESERVE(ctx, p->loop_off, p->loop_off_cap, 1);
  p->face_loop_off[0] = p->loop_off[0] = 0;
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  for (LitheIndex c = 0; c < p->n_cells; c++)
    for (LitheIndex i = 0; i < t->cells[p->cell_record[c]].n_faces; i++) {
      LitheIndex face = lth_topology_cell_faces(t, p->cell_record[c])[i];
      if (t->faces[face].is_line || !lth_topology_visit_face(t, face)) continue;
      LITHE_TRY(add_face(ctx, p, face));
    }
  return LITHE_OK;
}

static LitheStatus copy_points(LitheCtx *ctx, Packing *p) {
  LTH_NEW(ctx, p->points, 3 * (LitheCount)p->n_points);
  LTH_NEW(ctx, p->rank, p->n_points);
  for (LitheIndex i = 0; i < p->n_points; i++) {
    LitheCount from = p->point_record[i];
    lth_v3_copy(p->t->points + 3 * from, p->points + 3 * (LitheCount)i);
    p->rank[i] = p->t->point_rank[from];
  }
  return LITHE_OK;
}

/// Numbers of cells and points back to none: at the cost of the mesh, not of the topology.
static void clear_numbers(Packing *p) {
  for (LitheIndex i = 0; i < p->n_cells; i++) p->cell_of[p->cell_record[i]] = 0;
  for (LitheIndex i = 0; i < p->n_points; i++) p->point_of[p->point_record[i]] = 0;
}

LitheStatus lth_topology_mesh(LitheCtx *ctx, const LthTopology *topology, LitheIndex n,
                              const LitheIndex *cells, LthMesh **mesh, LitheIndex **cell_record,
                              LitheIndex **face_record) {
  // scratch alone is written
  Packing p = {.t = (LthTopology *)(uintptr_t)topology};
  LitheStatus status = LITHE_OK;
  *mesh = NULL;
  LITHE_TRY_OR(done, list_cells(ctx, &p, n, cells));
  LITHE_TRY_OR(done, list_faces(ctx, &p, !cells));
  LITHE_TRY_OR(done, copy_points(ctx, &p));
  LthMeshDef def = {.n_points = p.n_points,
                    .n_faces = p.n_faces,
                    .n_cells = p.n_cells,
                    .n_surface_points = cells ? 0 : topology->n_surface_points,
                    .point_rank = p.rank,
                    .face_tag = p.face_tag,
                    .cell_size = topology->cell_size};
  LthMeshLists lists = {p.points, p.face_loop_off, p.loop_off, p.loop_point, p.face_cell};
  p.points = NULL;
  p.face_loop_off = p.loop_off = p.loop_point = p.face_cell = NULL;
  LITHE_TRY_OR(done, lth_mesh_create_of(ctx, &def, &lists, mesh));
done:;
  clear_numbers(&p);
  if (*mesh && cell_record) *cell_record = p.cell_record, p.cell_record = NULL;
  if (*mesh && face_record) *face_record = p.face_record, p.face_record = NULL;
  void *blocks[] = {p.point_record, p.cell_record, p.face_record, p.face_loop_off, p.loop_off,
                    p.loop_point,   p.face_cell,   p.face_tag,    p.points,        p.rank};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  return status;
}

static LitheStatus make_group(LitheCtx *ctx, const LthTopology *t, const LthMeshGroup *group,
                              const bool *is_in, const LitheIndex *record, LthMesh *mesh,
                              LthMeshGroup *made) {
  LitheCount cap = 0;
  LITHE_TRY(lth_copy_text(ctx, group->name, &made->name));
  made->tag = group->tag;
  made->of_cells = group->of_cells;
  for (LitheIndex i = 0; i < (group->of_cells ? mesh->n_cells : mesh->n_faces); i++) {
    LitheIndex source = group->of_cells ? t->cells[record[i]].source : t->faces[record[i]].source;
    bool is_inner = !group->of_cells && mesh->face_cell[2 * i + 1] >= 0;
    if (source < 0 || is_inner || !is_in[source]) continue;
    LTH_RESERVE(ctx, made->member, cap, (LitheCount)made->n + 1);
    made->member[made->n++] = i;
  }
  return LITHE_OK;
}

LitheStatus lth_topology_groups(LitheCtx *ctx, const LthTopology *t, const LthMesh *first,
                                const LitheIndex *cell_record, const LitheIndex *face_record,
                                LthMesh *mesh) {
  LitheStatus status = LITHE_OK;
  bool *is_in = NULL;
  LTH_NEW(ctx, mesh->groups, first->n_groups);
  LTH_NEW(ctx, is_in, first->n_cells > first->n_faces ? first->n_cells : first->n_faces);
  for (LitheIndex g = 0; g < first->n_groups; g++) {
    const LthMeshGroup *group = first->groups + g;
    for (LitheIndex i = 0; i < group->n; i++) is_in[group->member[i]] = true;
    mesh->n_groups++;
    LITHE_TRY_OR(done, make_group(ctx, t, group, is_in, group->of_cells ? cell_record : face_record,
                                  mesh, mesh->groups + g));
    for (LitheIndex i = 0; i < group->n; i++) is_in[group->member[i]] = false;
  }
done:
  lth_free(ctx, is_in);
  return status;
}
