/// Making a topology from a mesh, and the log of its changes.
#include "mesh/topology_priv.h"

#include "mesh/mesh_measure.h"

#include <float.h>

void lth_topology_destroy(LitheCtx *ctx, LthTopology **topology) {
  if (!topology || !*topology) return;
  LthTopology *t = *topology;
  LthTopologyWork *w = t->work;
  if (w) {
    void *blocks[] = {w->point_stamp,
                      w->point_sign,
                      w->point_height,
                      w->cut_key,
                      w->cut_point,
                      w->cut_stamp,
                      w->chain[0].edge,
                      w->chain[1].edge,
                      w->cap.edge,
                      w->divider.edge,
                      w->cross,
                      w->queue,
                      w->trace_edge,
                      w->raw_off,
                      w->raw_corner,
                      w->raw_outer,
                      w->trace_used,
                      w->raw_area,
                      w->parts,
                      w->loop_off,
                      w->corner,
                      w->pieces,
                      w->set,
                      w->edges,
                      w->angle,
                      w->list,
                      w->fresh,
                      w->cell_seen,
                      w->face_seen,
                      w->cell_side,
                      w->free_faces,
                      w->free_cells,
                      w->free_points,
                      w->loose_points,
                      w->mesh_cell,
                      w->mesh_point,
                      w};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  }
  void *blocks[] = {
      t->points, t->point_rank, t->point_use,      t->faces,          t->cells,
      t->pool,   t->log.births, t->log.dead_cells, t->log.dead_faces, t->log.changed_cells,
      t};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *topology = NULL;
}

LthFaceView lth_topology_face(const LthTopology *t, LitheIndex face) {
  const LthTopologyFace *f = t->faces + face;
  const LitheIndex *block = lth_topology_loops(t, f);
  return (LthFaceView){t->points, block, block + f->n_loops + 1, f->n_loops, f->plane};
}

static LitheStatus copy_points(LitheCtx *ctx, LthTopology *t, const LthMesh *mesh) {
  LitheCount n = mesh->n_points;
  LTH_RESERVE(ctx, t->points, t->points_cap, 3 * n);
  LTH_RESERVE(ctx, t->point_rank, t->point_rank_cap, n);
  LTH_RESERVE(ctx, t->point_use, t->point_use_cap, n);
  memcpy(t->points, mesh->points, 3 * (size_t)n * sizeof *t->points);
  memcpy(t->point_rank, mesh->point_rank, (size_t)n);
  t->n_points = mesh->n_points;
  t->n_surface_points = mesh->n_surface_points;
  double lo[3], hi[3];
  lth_mesh_bounds(mesh, lo, hi);
  for (int a = 0; a < 3; a++) {
    t->origin[a] = lo[a] + 0.5 * (hi[a] - lo[a]);
    t->rounding = fmax(t->rounding, DBL_EPSILON * fmax(fabs(lo[a]), fabs(hi[a])));
  }
  return LITHE_OK;
}

static LitheStatus copy_cells(LitheCtx *ctx, LthTopology *t, const LthMesh *mesh) {
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    LitheIndex room = mesh->cell_face_off[c + 1] - mesh->cell_face_off[c], cell = 0;
    LITHE_TRY(lth_topology_add_cell(ctx, t, c, room, &cell));
    LthTopologyCell *k = t->cells + cell;
    k->volume = mesh->cell_volume[c];
    lth_v3_copy(mesh->cell_centroid + 3 * (LitheCount)c, k->centroid);
    memcpy(k->box, mesh->cell_box + 6 * (LitheCount)c, sizeof k->box);
    t->volume += k->volume;
  }
  return LITHE_OK;
}

/// The largest distance of a corner from the face's plane.
static double flatness(const LthTopology *t, LitheIndex face) {
  LthFaceView view = lth_topology_face(t, face);
  double most = 0;
  for (LitheIndex j = 0; j < t->faces[face].n_corners; j++) {
    double d[3];
    lth_v3_sub(t->points + 3 * (LitheCount)view.loop_point[j], t->origin, d);
    most = fmax(most, fabs(lth_v3_dot(view.normal, d) - view.normal[3]));
  }
  return most;
}

/// Faces with their planes. Those along axes get the same bits wherever they lie in the same plane.
static LitheStatus copy_faces(LitheCtx *ctx, LthTopology *t, const LthMesh *mesh) {
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LthFaceView view = lth_mesh_face(mesh, f);
    LthTopologyFace like = {.cell = {mesh->face_cell[2 * f], mesh->face_cell[2 * f + 1]},
                            .tag = mesh->face_tag[f],
                            .source = f};
    double d[3];
    lth_v3_copy(view.normal, like.plane);
    lth_v3_sub(view.points + 3 * (LitheCount)view.loop_point[view.loop_off[0]], t->origin, d);
    like.plane[3] = lth_v3_dot(like.plane, d);

    // loop offsets of a mesh count from its first loop
    LitheIndex face = 0;
    LITHE_TRY(lth_topology_add_face(ctx, t, &like, view.n_loops, view.loop_off, view.loop_point,
                                    false, &face));
    if (like.cell[1] < 0) t->area += t->faces[face].area;
    t->off_plane = fmax(t->off_plane, flatness(t, face));
  }
  return LITHE_OK;
}

/// The plane of a part that is as good as a line: any that holds it.
static void plane_of_line(const LthTopology *t, const TopologyPart *part, double plane[4]) {
  const LthTopologyWork *w = t->work;
  LthFaceView view = {t->points, w->loop_off + part->first_loop, w->corner, part->n_loops, plane};
  double n[3], d[3];
  lth_mesh_area_vector(&view, n);
  if (lth_v3_normalize(n) > 0) lth_v3_copy(n, plane);
  lth_v3_sub(t->points + 3 * (LitheCount)w->corner[view.loop_off[0]], t->origin, d);
  plane[3] = lth_v3_dot(plane, d);
}

/// Slicing leaves out faces without area. The edges they leave open in a cell become lines.
static LitheStatus close_cell(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LthTopologyWork *w = t->work;
  TopologyChain *open = &w->chain[0];
  bool is_clean = true;
  open->n = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex f = lth_topology_cell_faces(t, cell)[i];
    bool out = t->faces[f].cell[0] == cell;
    LthFaceView view = lth_topology_face(t, f);
    for (LitheIndex l = 0; l < view.n_loops; l++)
      for (LitheIndex j = view.loop_off[l]; j < view.loop_off[l + 1]; j++) {
        LitheIndex a = view.loop_point[j],
                   b = view.loop_point[j + 1 < view.loop_off[l + 1] ? j + 1 : view.loop_off[l]];
        LITHE_TRY(lth_topology_chain_add(ctx, open, out ? b : a, out ? a : b));
      }
  }
  lth_topology_cancel(open);
  if (open->n == 0) return LITHE_OK;
  w->n_parts = w->n_loops = w->n_corners = 0;
  const double none[3] = {0, 0, 0};
  LITHE_TRY(lth_topology_trace(ctx, t, open, NULL, none, -1, 0, &is_clean));
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    LthTopologyFace like = {.cell = {cell, -1}, .plane = {0, 0, 1, 0}, .tag = -1, .source = -1};
    LitheIndex face = 0;
    const TopologyPart *part = w->parts + p;
    plane_of_line(t, part, like.plane);
    LITHE_TRY(lth_topology_add_face(ctx, t, &like, part->n_loops, w->loop_off + part->first_loop,
                                    w->corner, false, &face));
  }
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, const LthMesh *mesh, LthTopology *t) {
  LTH_NEW(ctx, t->work, 1);
  LITHE_TRY(copy_points(ctx, t, mesh));
  LITHE_TRY(copy_cells(ctx, t, mesh));
  LITHE_TRY(copy_faces(ctx, t, mesh));
  t->cell_size = mesh->cell_size > 0 ? mesh->cell_size : cbrt(t->volume / fmax(1, mesh->n_cells));
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    LITHE_TRY(close_cell(ctx, t, c));
    lth_topology_measure_cell(t, c);
  }
  return lth_topology_forget(ctx, t);
}

LitheStatus lth_topology_create(LitheCtx *ctx, const LthMesh *mesh, LthTopology **topology) {
  LthTopology *t = NULL;
  *topology = NULL;
  LTH_NEW(ctx, t, 1);
  LitheStatus status = build(ctx, mesh, t);
  if (status != LITHE_OK) lth_topology_destroy(ctx, &t);
  *topology = t;
  return status;
}
