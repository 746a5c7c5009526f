/// Splitting a cell by a plane: clip, connect, and only then change records, so that what fails changes nothing.
#include "mesh/topology_priv.h"

/// A cut that does not come out is tried again with points farther away on the plane, so often in all.
#define TRIES 2

static LitheStatus drop_fresh(LitheCtx *ctx, LthTopology *t) {
  LthTopologyWork *w = t->work;
  for (LitheCount i = 0; i < w->n_fresh; i++)
    LITHE_TRY(lth_topology_drop_point(ctx, t, w->fresh[i]));
  w->n_fresh = 0;
  lth_topology_forget_cuts(t);
  return LITHE_OK;
}

static LitheStatus make_cells(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LthSplit *split) {
  LthTopologyWork *w = t->work;
  for (LitheIndex i = 0; i < w->n_pieces; i++) {
    TopologyPiece *piece = w->pieces + i;
    LitheIndex room = 0;
    for (LitheIndex p = 0; p < w->n_parts; p++) room += w->parts[p].cell[piece->side] == i;
    LITHE_TRY(lth_topology_add_cell(ctx, t, t->cells[cell].source, room, &piece->record));
    LthTopologyCell *c = t->cells + piece->record;
    c->volume = piece->volume;
    c->area = piece->area;
    lth_v3_copy(piece->centroid, c->centroid);
    memcpy(c->box, piece->box, sizeof c->box);
    LITHE_TRY(lth_topology_note_birth(ctx, t, piece->record, cell));
    split->n++;
    split->n_below += piece->side == 0;
  }
  return LITHE_OK;
}

/// A face, or a part of it, moves to the new cell on its side.
static LitheStatus move_part(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                             const TopologyPart *part) {
  LthTopologyWork *w = t->work;
  LthTopologyFace *f = t->faces + part->face;
  LitheIndex to = w->pieces[part->cell[part->side]].record;
  if (part->n_loops == 0) {
    f->cell[f->cell[0] != cell] = to;
    lth_topology_judge_line(t, part->face);
    return lth_topology_list_face(ctx, t, to, part->face);
  }
  LthTopologyFace like = *f;
  LitheIndex made = 0;
  like.cell[like.cell[0] != cell] = to;
  if (f->is_live) {
    LitheIndex across = lth_topology_across(t, part->face, cell);
    LITHE_TRY(lth_topology_end_face(ctx, t, part->face, cell));
    if (across >= 0) LITHE_TRY(lth_topology_note_change(ctx, t, across));
  }
  return lth_topology_add_face(ctx, t, &like, part->n_loops, w->loop_off + part->first_loop,
                               w->corner, false, &made);
}

/// A part of the cap joins the cells below and above, or is a boundary face of either.
static LitheStatus make_cap(LitheCtx *ctx, LthTopology *t, LitheIndex tag,
                            const TopologyPart *part) {
  LthTopologyWork *w = t->work;
  LitheIndex below = w->pieces[part->cell[0]].record, above = w->pieces[part->cell[1]].record,
             made = 0;
  LthTopologyFace like = {.cell = {below, tag == -1 ? above : -1}, .tag = tag, .source = -1};
  const LitheIndex *off = w->loop_off + part->first_loop;
  memcpy(like.plane, w->plane, sizeof like.plane);
  w->cap_area += part->area;
  LITHE_TRY(lth_topology_add_face(ctx, t, &like, part->n_loops, off, w->corner, false, &made));
  if (tag == -1) return LITHE_OK;
  like.cell[0] = above;
  for (int i = 0; i < 4; i++) like.plane[i] = -like.plane[i];
  return lth_topology_add_face(ctx, t, &like, part->n_loops, off, w->corner, true, &made);
}

static LitheStatus commit(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex tag,
                          LthSplit *split) {
  LthTopologyWork *w = t->work;
  t->off_plane = fmax(t->off_plane, w->reach);
  LITHE_TRY(lth_topology_divide_edges(ctx, t, cell));
  LITHE_TRY(make_cells(ctx, t, cell, split));
  for (LitheIndex p = 0; p < w->n_parts; p++)
    LITHE_TRY(w->parts[p].face >= 0 ? move_part(ctx, t, cell, w->parts + p)
                                    : make_cap(ctx, t, tag, w->parts + p));
  return lth_topology_end_cell(ctx, t, cell);
}

LitheStatus lth_topology_split_in_hand(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                       LitheIndex tag, LthSplit *split, bool *is_clean) {
  int side = 0;
  LITHE_ASSERT(t->cells[cell].is_live && (tag == -1 || tag <= LTH_TAG_CUT));
  *split = (LthSplit){.first = t->log.n_births};
  *is_clean = true;
  LITHE_TRY(lth_topology_classify(ctx, t, cell, &side));
  if (side != 0) return LITHE_OK;
  LITHE_TRY(lth_topology_clip(ctx, t, cell, is_clean));
  if (*is_clean) LITHE_TRY(lth_topology_connect(ctx, t, cell, is_clean));
  return *is_clean ? commit(ctx, t, cell, tag, split) : drop_fresh(ctx, t);
}

LitheStatus lth_topology_split(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                               const LthPlane *plane, LitheIndex tag, LthSplit *split) {
  double p[4];
  lth_topology_plane(t, plane, p);
  double reach = lth_topology_reach(t, cell, p);
  bool is_clean = false;
  for (int i = 0; i < TRIES && !is_clean; i++, reach *= LTH_TOPOLOGY_WIDEN) {
    lth_topology_take_plane(t, p, reach);
    LITHE_TRY(lth_topology_split_in_hand(ctx, t, cell, tag, split, &is_clean));
  }
#ifdef LITHE_ASSERTS
  for (LitheIndex i = 0; i < split->n; i++) {
    LitheIndex child = t->log.births[split->first + i].cell;
    LITHE_TRY(lth_topology_check(ctx, t, 1, &child));
  }
#endif
  return LITHE_OK;
}

/// Split every live cell among the births from `first` on by a plane through x.
static LitheStatus split_births(LitheCtx *ctx, LthTopology *t, LitheIndex first, const double x[3],
                                int axis, LthSplit *total) {
  LthPlane plane = {.point = {x[0], x[1], x[2]}};
  plane.normal[axis] = 1;
  LitheIndex n = t->log.n_births;
  for (LitheIndex i = first; i < n; i++) {
    LitheIndex cell = t->log.births[i].cell;
    LthSplit split;
    if (!t->cells[cell].is_live) continue;
    LITHE_TRY(lth_topology_split(ctx, t, cell, &plane, -1, &split));
    total->n += split.n > 0 ? split.n - 1 : 0;
  }
  return LITHE_OK;
}

LitheStatus lth_topology_split_eight(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                     LthSplit *split) {
  double x[3];
  lth_v3_copy(t->cells[cell].centroid, x);
  *split = (LthSplit){.first = t->log.n_births};
  for (int axis = 0; axis < 3; axis++) {
    if (split->n > 0) {
      LITHE_TRY(split_births(ctx, t, split->first, x, axis, split));
      continue;
    }
    LthPlane plane = {.point = {x[0], x[1], x[2]}};
    plane.normal[axis] = 1;
    LITHE_TRY(lth_topology_split(ctx, t, cell, &plane, -1, split));
  }
  split->n_below = 0;
  return LITHE_OK;
}

LitheStatus lth_topology_split_two(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                   const double normal[3], LthSplit *split) {
  LthPlane plane;
  lth_v3_copy(t->cells[cell].centroid, plane.point);
  lth_v3_copy(normal, plane.normal);
  return lth_topology_split(ctx, t, cell, &plane, -1, split);
}
