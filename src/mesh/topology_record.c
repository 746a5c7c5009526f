/// Records of points, faces and cells: their numbers, lists and measures.
#include "mesh/topology_priv.h"

#include "mesh/mesh_measure.h"

LitheStatus lth_topology_add_point(LitheCtx *ctx, LthTopology *t, const double x[3],
                                   LitheIndex *point) {
  LthTopologyWork *w = t->work;
  if (w->n_free_points > 0) {
    *point = w->free_points[--w->n_free_points];
  } else {
    if (t->n_points >= INT32_MAX / 3)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting: more than 2^31 coordinates; use larger cells");
    LTH_RESERVE(ctx, t->points, t->points_cap, 3 * ((LitheCount)t->n_points + 1));
    LTH_RESERVE(ctx, t->point_rank, t->point_rank_cap, (LitheCount)t->n_points + 1);
    LTH_RESERVE(ctx, t->point_use, t->point_use_cap, (LitheCount)t->n_points + 1);
    *point = t->n_points++;
  }
  lth_v3_copy(x, t->points + 3 * (LitheCount)*point);
  t->point_rank[*point] = 0;
  t->point_use[*point] = 0;
  return LITHE_OK;
}

LitheStatus lth_topology_drop_point(LitheCtx *ctx, LthTopology *t, LitheIndex point) {
  LthTopologyWork *w = t->work;
  LITHE_ASSERT(t->point_use[point] == 0);
  LTH_RESERVE(ctx, w->free_points, w->free_points_cap, w->n_free_points + 1);
  t->point_use[point] = -1;
  w->free_points[w->n_free_points++] = point;
  return LITHE_OK;
}

/// Room for n numbers in the pool.
static LitheStatus take(LitheCtx *ctx, LthTopology *t, LitheCount n, LitheCount *block) {
  LTH_RESERVE(ctx, t->pool, t->pool_cap, t->n_pool + n);
  *block = t->n_pool;
  t->n_pool += n;
  return LITHE_OK;
}

static LitheStatus use_points(LitheCtx *ctx, LthTopology *t, const LthTopologyFace *f, int change) {
  const LitheIndex *corner = lth_topology_loops(t, f) + f->n_loops + 1;
  LthTopologyWork *w = t->work;
  for (LitheIndex i = 0; i < f->n_corners; i++) {
    t->point_use[corner[i]] += change;
    if (t->point_use[corner[i]] > 0) continue;
    LTH_RESERVE(ctx, w->loose_points, w->loose_points_cap, w->n_loose_points + 1);
    w->loose_points[w->n_loose_points++] = corner[i];
  }
  return LITHE_OK;
}

/// Write loops into a new block of the pool; backwards they keep their first corner.
static LitheStatus write_loops(LitheCtx *ctx, LthTopology *t, LthTopologyFace *f,
                               LitheIndex n_loops, const LitheIndex *loop_off,
                               const LitheIndex *corner, bool is_turned) {
  f->n_loops = n_loops;
  f->n_corners = loop_off[n_loops] - loop_off[0];
  LITHE_TRY(take(ctx, t, n_loops + 1 + f->n_corners, &f->block));
  LitheIndex *off = t->pool + f->block, *to = off + n_loops + 1;
  for (LitheIndex l = 0; l <= n_loops; l++) off[l] = loop_off[l] - loop_off[0];
  for (LitheIndex l = 0; l < n_loops; l++) {
    LitheIndex n = off[l + 1] - off[l];
    const LitheIndex *from = corner + loop_off[l];
    for (LitheIndex i = 0; i < n; i++) to[off[l] + i] = from[is_turned && i > 0 ? n - i : i];
  }
  return use_points(ctx, t, f, 1);
}

static void measure_face(LthTopology *t, LitheIndex face) {
  LthFaceView view = lth_topology_face(t, face);
  t->faces[face].area = lth_face_area_centroid(&view, t->faces[face].centroid);
}

static bool is_line(const LthTopology *t, const LthTopologyFace *f) {
  double least = t->cells[f->cell[0]].area;
  if (f->cell[1] >= 0) least = fmin(least, t->cells[f->cell[1]].area);
  return !(f->area > TOPOLOGY_NO_FACE * least);
}

void lth_topology_judge_line(LthTopology *t, LitheIndex face) {
  LthTopologyFace *f = t->faces + face;
  if (!f->is_line || is_line(t, f)) return;
  f->is_line = false;
  t->n_live_faces++;
}

LitheStatus lth_topology_list_face(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                   LitheIndex face) {
  LthTopologyCell *c = t->cells + cell;
  if (c->n_faces == c->room) {
    LitheCount old = c->block, block = 0;
    LitheIndex room = 2 * c->room + 4;
    LITHE_TRY(take(ctx, t, room, &block));
    memcpy(t->pool + block, t->pool + old, sizeof *t->pool * (size_t)c->n_faces);
    t->n_waste += c->room;
    c->block = block;
    c->room = room;
  }
  t->pool[c->block + c->n_faces++] = face;
  return LITHE_OK;
}

static void unlist_face(LthTopology *t, LitheIndex cell, LitheIndex face) {
  LthTopologyCell *c = t->cells + cell;
  LitheIndex *list = t->pool + c->block;
  for (LitheIndex i = 0; i < c->n_faces; i++)
    if (list[i] == face) {
      list[i] = list[--c->n_faces];
      return;
    }
  LITHE_ASSERT(false);
}

LitheStatus lth_topology_add_face(LitheCtx *ctx, LthTopology *t, const LthTopologyFace *like,
                                  LitheIndex n_loops, const LitheIndex *loop_off,
                                  const LitheIndex *corner, bool is_turned, LitheIndex *face) {
  LthTopologyWork *w = t->work;
  if (w->n_free_faces > 0) {
    *face = w->free_faces[--w->n_free_faces];
  } else {
    if (t->n_faces >= INT32_MAX / 3)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting: more than 2^31 faces; use larger cells");
    LTH_RESERVE(ctx, t->faces, t->faces_cap, (LitheCount)t->n_faces + 1);
    *face = t->n_faces++;
  }
  LthTopologyFace made = *like;
  made.is_live = true;
  LITHE_TRY(write_loops(ctx, t, &made, n_loops, loop_off, corner, is_turned));
  t->faces[*face] = made;
  measure_face(t, *face);
  t->faces[*face].is_line = is_line(t, t->faces + *face);
  t->n_live_faces += !t->faces[*face].is_line;
  LITHE_TRY(lth_topology_list_face(ctx, t, made.cell[0], *face));
  return made.cell[1] < 0 ? LITHE_OK : lth_topology_list_face(ctx, t, made.cell[1], *face);
}

LitheStatus lth_topology_set_loops(LitheCtx *ctx, LthTopology *t, LitheIndex face,
                                   LitheIndex n_loops, const LitheIndex *loop_off,
                                   const LitheIndex *corner) {
  LthTopologyFace *f = t->faces + face, old = *f;
  LITHE_TRY(write_loops(ctx, t, f, n_loops, loop_off, corner, false));
  t->n_waste += old.n_loops + 1 + old.n_corners;
  return use_points(ctx, t, &old, -1);
}

LitheStatus lth_topology_end_face(LitheCtx *ctx, LthTopology *t, LitheIndex face,
                                  LitheIndex except) {
  LthTopologyLog *log = &t->log;
  LthTopologyFace *f = t->faces + face;
  LITHE_ASSERT(f->is_live);
  LTH_RESERVE(ctx, log->dead_faces, log->dead_faces_cap, (LitheCount)log->n_dead_faces + 1);
  log->dead_faces[log->n_dead_faces++] = face;
  f->is_live = false;
  t->n_live_faces -= !f->is_line;
  for (int i = 0; i < 2; i++)
    if (f->cell[i] >= 0 && f->cell[i] != except && t->cells[f->cell[i]].is_live)
      unlist_face(t, f->cell[i], face);
  return use_points(ctx, t, f, -1);
}

LitheStatus lth_topology_add_cell(LitheCtx *ctx, LthTopology *t, LitheIndex source, LitheIndex room,
                                  LitheIndex *cell) {
  LthTopologyWork *w = t->work;
  LthTopologyCell made = {
      .source = source, .room = room, .is_live = true, .before = -1, .into = -1};
  if (w->n_free_cells > 0) {
    *cell = w->free_cells[--w->n_free_cells];
  } else {
    if (t->n_cells >= INT32_MAX / 6)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting: more than 2^31 cells; use larger cells");
    LTH_RESERVE(ctx, t->cells, t->cells_cap, (LitheCount)t->n_cells + 1);
    *cell = t->n_cells++;
  }
  LITHE_TRY(take(ctx, t, room, &made.block));
  t->cells[*cell] = made;
  t->n_live_cells++;
  return LITHE_OK;
}

LitheStatus lth_topology_end_cell(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LthTopologyLog *log = &t->log;
  LTH_RESERVE(ctx, log->dead_cells, log->dead_cells_cap, (LitheCount)log->n_dead_cells + 1);
  log->dead_cells[log->n_dead_cells++] = cell;
  t->cells[cell].is_live = false;
  t->n_live_cells--;
  return LITHE_OK;
}

LitheStatus lth_topology_note_birth(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                    LitheIndex parent) {
  LthTopologyLog *log = &t->log;
  LTH_RESERVE(ctx, log->births, log->births_cap, (LitheCount)log->n_births + 1);
  log->births[log->n_births++] = (LthTopologyBirth){cell, parent};
  LthTopologyCell *c = t->cells + cell;
  LitheIndex before = lth_topology_before(t, parent);
  c->before = !c->is_new || c->before == before ? before : -1;
  c->is_new = true;
  return LITHE_OK;
}

LitheStatus lth_topology_note_change(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LthTopologyLog *log = &t->log;
  LthTopologyCell *c = t->cells + cell;
  if (c->is_new || c->is_changed) return LITHE_OK;
  c->is_changed = true;
  LTH_RESERVE(ctx, log->changed_cells, log->changed_cells_cap,
              (LitheCount)log->n_changed_cells + 1);
  log->changed_cells[log->n_changed_cells++] = cell;
  return LITHE_OK;
}

void lth_topology_measure_cell(LthTopology *t, LitheIndex cell) {
  LthTopologyCell *c = t->cells + cell;
  for (int i = 0; i < 3; i++) c->box[i] = INFINITY, c->box[3 + i] = -INFINITY;
  c->area = 0;
  const LitheIndex *list = t->pool + c->block;
  for (LitheIndex i = 0; i < c->n_faces; i++) {
    const LthTopologyFace *f = t->faces + list[i];
    const LitheIndex *corner = lth_topology_loops(t, f) + f->n_loops + 1;
    c->area += f->area;
    for (LitheIndex j = 0; j < f->n_corners; j++)
      for (int a = 0; a < 3; a++) {
        double x = t->points[3 * (LitheCount)corner[j] + a];
        if (x < c->box[a]) c->box[a] = x;
        if (x > c->box[3 + a]) c->box[3 + a] = x;
      }
  }
  double volume = 0, moment[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) c->centroid[a] = c->box[a] + 0.5 * (c->box[3 + a] - c->box[a]);
  for (LitheIndex i = 0; i < c->n_faces; i++) {
    LthFaceView view = lth_topology_face(t, list[i]);
    lth_mesh_add_cone(&view, lth_topology_side(t, list[i], cell), c->centroid, &volume, moment);
  }
  c->volume = volume / 6;
  if (volume > 0) lth_v3_axpy(1 / (4 * volume), moment, c->centroid);
}

LitheStatus lth_topology_begin_visit(LitheCtx *ctx, LthTopology *t) {
  LthTopologyWork *w = t->work;
  LTH_RESERVE(ctx, w->cell_seen, w->cell_seen_cap, t->n_cells);
  LTH_RESERVE(ctx, w->face_seen, w->face_seen_cap, t->n_faces);
  LTH_RESERVE(ctx, w->cell_side, w->cell_side_cap, t->n_cells);
  w->cell_stamp++;
  return LITHE_OK;
}

/// Move live blocks to the front of a new pool.
static LitheStatus compact(LitheCtx *ctx, LthTopology *t) {
  LitheIndex *pool = NULL;
  LitheCount n = 0;
  LTH_NEW(ctx, pool, t->n_pool + 1);
  for (LitheIndex f = 0; f < t->n_faces; f++) {
    LthTopologyFace *face = t->faces + f;
    LitheCount size = face->n_loops + 1 + face->n_corners;
    if (!face->is_live) continue;
    memcpy(pool + n, t->pool + face->block, sizeof *pool * (size_t)size);
    face->block = n;
    n += size;
  }
  for (LitheIndex c = 0; c < t->n_cells; c++) {
    LthTopologyCell *cell = t->cells + c;
    if (!cell->is_live) continue;
    memcpy(pool + n, t->pool + cell->block, sizeof *pool * (size_t)cell->n_faces);
    cell->block = n;
    n += cell->room;
  }
  lth_free(ctx, t->pool);
  t->pool_cap = t->n_pool + 1;
  t->pool = pool;
  t->n_pool = n;
  t->n_waste = 0;
  return LITHE_OK;
}

static LitheStatus append(LitheCtx *ctx, LitheIndex **to, LitheCount *n, LitheCount *cap,
                          const LitheIndex *from, LitheIndex n_from) {
  LTH_RESERVE(ctx, *to, *cap, *n + n_from);
  if (n_from > 0) memcpy(*to + *n, from, sizeof **to * (size_t)n_from);
  *n += n_from;
  return LITHE_OK;
}

LitheStatus lth_topology_forget(LitheCtx *ctx, LthTopology *t) {
  LthTopologyLog *log = &t->log;
  LthTopologyWork *w = t->work;
  for (LitheIndex i = 0; i < log->n_dead_faces; i++) {
    const LthTopologyFace *f = t->faces + log->dead_faces[i];
    t->n_waste += f->n_loops + 1 + f->n_corners;
  }
  for (LitheIndex i = 0; i < log->n_dead_cells; i++)
    t->n_waste += t->cells[log->dead_cells[i]].room;
  LITHE_TRY(append(ctx, &w->free_faces, &w->n_free_faces, &w->free_faces_cap, log->dead_faces,
                   log->n_dead_faces));
  LITHE_TRY(append(ctx, &w->free_cells, &w->n_free_cells, &w->free_cells_cap, log->dead_cells,
                   log->n_dead_cells));
  for (LitheCount i = 0; i < w->n_loose_points; i++) {
    LitheIndex point = w->loose_points[i];
    if (t->point_use[point] == 0 && point >= t->n_surface_points)
      LITHE_TRY(lth_topology_drop_point(ctx, t, point));
  }
  w->n_loose_points = 0;
  for (LitheIndex i = 0; i < log->n_births; i++) t->cells[log->births[i].cell].is_new = false;
  for (LitheIndex i = 0; i < log->n_changed_cells; i++)
    t->cells[log->changed_cells[i]].is_changed = false;
  log->n_births = log->n_dead_cells = log->n_dead_faces = log->n_changed_cells = 0;
  lth_topology_forget_cuts(t);
  return t->n_waste > t->n_pool / 2 ? compact(ctx, t) : LITHE_OK;
}
