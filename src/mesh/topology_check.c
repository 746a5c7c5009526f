/// The invariants of a topology, from its records alone.
#include "mesh/topology_priv.h"

#include "mesh/mesh_measure.h"

#include <float.h>
#include <stdlib.h>

/// Cells are closed to this share of their area, and keep this share of their volume.
#define CLOSED_SHARE 1e-12
#define KEPT_SHARE 1e-12

static bool lists(const LthTopology *t, LitheIndex cell, LitheIndex face) {
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++)
    n += lth_topology_cell_faces(t, cell)[i] == face;
  return n == 1;
}

static LitheStatus check_face(LitheCtx *ctx, const LthTopology *t, LitheIndex face) {
  const LthTopologyFace *f = t->faces + face;
  if (!f->is_live) LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: face %d is listed but dead", face);
  for (int i = 0; i < 2; i++) {
    LitheIndex c = f->cell[i];
    if (i == 1 && c == -1) break;
    if (c < 0 || c >= t->n_cells || !t->cells[c].is_live || !lists(t, c, face))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: cell %d does not own face %d", c, face);
  }
  if (f->cell[0] == f->cell[1])
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: face %d has cell %d on both sides", face,
               f->cell[0]);
  if (f->cell[1] >= 0 && f->tag != -1)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: inner face %d has the tag %d", face, f->tag);
  LthFaceView view = lth_topology_face(t, face);
  for (LitheIndex l = 0; l < view.n_loops; l++)
    if (view.loop_off[l + 1] - view.loop_off[l] < 3)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: face %d has a loop of %d corners", face,
                 view.loop_off[l + 1] - view.loop_off[l]);
  for (LitheIndex j = 0; j < f->n_corners; j++)
    if (t->point_use[view.loop_point[j]] <= 0)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: face %d has the free point %d", face,
                 view.loop_point[j]);
  if (f->is_line) return LITHE_OK;

  // area, orientation, plane
  double n[3];
  lth_mesh_area_vector(&view, n);
  if (!(f->area > 0) || !(lth_v3_dot(n, f->plane) / 2 >= 0.5 * f->area))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: face %d has the area %g, its corners %g", face,
               f->area, lth_v3_dot(n, f->plane) / 2);
  for (LitheIndex j = 0; j < f->n_corners; j++) {
    double d[3];
    lth_v3_sub(t->points + 3 * (LitheCount)view.loop_point[j], t->origin, d);
    double height = lth_v3_dot(d, f->plane) - f->plane[3];
    if (!(fabs(height) <= t->off_plane + 64 * t->rounding))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: corner %d of face %d is %g m off its plane", j,
                 face, height);
  }
  return LITHE_OK;
}

static int compare_keys(const void *a, const void *b) {
  const TopologyEdge *x = a, *y = b;
  return (x->key > y->key) - (x->key < y->key);
}

/// Every edge of a cell is there as often in one direction as in the other: the cell is closed, and its faces
/// have the same corners along common edges.
static LitheStatus check_edges(LitheCtx *ctx, const LthTopology *t, LitheIndex cell) {
  TopologyEdge *edge = NULL;
  LitheStatus status = LITHE_OK;
  LitheCount n = 0, size = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++)
    size += t->faces[lth_topology_cell_faces(t, cell)[i]].n_corners;
  LTH_NEW(ctx, edge, size);
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i];
    LthFaceView view = lth_topology_face(t, face);
    bool is_out = t->faces[face].cell[0] == cell;
    for (LitheIndex l = 0; l < view.n_loops; l++)
      for (LitheIndex j = view.loop_off[l]; j < view.loop_off[l + 1]; j++) {
        LitheIndex a = view.loop_point[j],
                   b = view.loop_point[j + 1 < view.loop_off[l + 1] ? j + 1 : view.loop_off[l]];
        edge[n++] = (TopologyEdge){lth_topology_edge_key(a, b), 0, (a < b) == is_out ? 1 : -1};
      }
  }
  qsort(edge, (size_t)n, sizeof *edge, compare_keys);
  for (LitheCount i = 0, j; i < n && status == LITHE_OK; i = j) {
    int sum = 0;
    for (j = i; j < n && edge[j].key == edge[i].key; j++) sum += edge[j].direction;
    if (sum != 0)
      status = lth_fail(ctx, LITHE_BAD_INPUT, "topology: cell %d is open at the edge %d - %d", cell,
                        (int)(edge[i].key >> 32), (int)(uint32_t)edge[i].key);
  }
  lth_free(ctx, edge);
  return status;
}

static LitheStatus check_cell(LitheCtx *ctx, const LthTopology *t, LitheIndex cell) {
  const LthTopologyCell *c = t->cells + cell;
  double sum[3] = {0, 0, 0}, area = 0, volume = 0, moment[3] = {0, 0, 0};
  for (LitheIndex i = 0; i < c->n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i];
    double n[3];
    LITHE_TRY(check_face(ctx, t, face));
    LthFaceView view = lth_topology_face(t, face);
    lth_mesh_area_vector(&view, n);
    lth_v3_axpy(lth_topology_side(t, face, cell) / 2, n, sum);
    lth_mesh_add_cone(&view, lth_topology_side(t, face, cell), c->centroid, &volume, moment);
    area += t->faces[face].area;
  }
  LITHE_TRY(check_edges(ctx, t, cell));
  // of products of lengths, which are large beside the area where a cell is thin
  double length2 = pow(lth_v3_distance(c->box, c->box + 3), 2);
  double rounding = CLOSED_SHARE * area + 64 * DBL_EPSILON * length2;
  if (!(lth_v3_norm(sum) <= rounding))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: cell %d of area %g is open by %g m^2", cell, area,
               lth_v3_norm(sum));
  double tolerance = KEPT_SHARE * c->volume + 64 * DBL_EPSILON * sqrt(length2) * length2 +
                     (64 * t->rounding + t->off_plane) * area;
  if (!(c->volume > 0) || !(fabs(volume / 6 - c->volume) <= tolerance))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: cell %d has the volume %g, its faces hold %g", cell,
               c->volume, volume / 6);
  return LITHE_OK;
}

static LitheStatus check_totals(LitheCtx *ctx, const LthTopology *t) {
  double volume = 0, area = 0, cut = 0;
  LitheIndex n_cells = 0, n_faces = 0;
  LitheIndex *use = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, use, t->n_points);
  for (LitheIndex c = 0; c < t->n_cells; c++) {
    if (!t->cells[c].is_live) continue;
    n_cells++;
    volume += t->cells[c].volume;
  }
  for (LitheIndex f = 0; f < t->n_faces; f++) {
    const LthTopologyFace *face = t->faces + f;
    if (!face->is_live) continue;
    n_faces += !face->is_line;
    if (face->cell[1] < 0 && !face->is_line)
      *(face->tag <= LTH_TAG_CUT ? &cut : &area) += face->area;
    LthFaceView view = lth_topology_face(t, f);
    for (LitheIndex j = 0; j < face->n_corners; j++) use[view.loop_point[j]]++;
  }
  for (LitheIndex p = 0; p < t->n_points && status == LITHE_OK; p++)
    if (use[p] != (t->point_use[p] > 0 ? t->point_use[p] : 0))
      status = lth_fail(ctx, LITHE_BAD_INPUT, "topology: point %d has %d corners, not %d", p,
                        use[p], t->point_use[p]);
  lth_free(ctx, use);
  LITHE_TRY(status);
  if (n_cells != t->n_live_cells || n_faces != t->n_live_faces)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: %d cells and %d faces are alive, not %d and %d",
               n_cells, n_faces, t->n_live_cells, t->n_live_faces);
  // of what carving has left a small part of, rounding of places is more
  double rounding = 64 * t->rounding * (area + cut);
  if (!(fabs(volume - t->volume) <= KEPT_SHARE * t->volume + rounding))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: the volume changed from %.17g to %.17g", t->volume,
               volume);
  if (!(fabs(area - t->area) <= KEPT_SHARE * t->area))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: the surface changed from %.17g to %.17g", t->area,
               area);
  return LITHE_OK;
}

LitheStatus lth_topology_check(LitheCtx *ctx, const LthTopology *t, LitheIndex n,
                               const LitheIndex *cells) {
  for (LitheIndex i = 0; i < (cells ? n : t->n_cells); i++) {
    LitheIndex cell = cells ? cells[i] : i;
    if (cells && !t->cells[cell].is_live)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "topology: cell %d is dead", cell);
    if (t->cells[cell].is_live) LITHE_TRY(check_cell(ctx, t, cell));
  }
  return cells ? LITHE_OK : check_totals(ctx, t);
}
