/// Cuts through many cells, and parting along existing faces.
#include "mesh/topology_priv.h"

LitheStatus lth_topology_separate(LitheCtx *ctx, LthTopology *t, LitheIndex face, LitheIndex tag,
                                  LitheIndex pair[2]) {
  LthTopologyFace like = t->faces[face];
  LthTopologyWork *w = t->work;
  LITHE_ASSERT(like.is_live && like.cell[1] >= 0 && tag <= LTH_TAG_CUT);
  LTH_RESERVE(ctx, w->raw_off, w->raw_off_cap, like.n_loops + 1);
  LTH_RESERVE(ctx, w->raw_corner, w->raw_corner_cap, like.n_corners);
  const LitheIndex *block = lth_topology_loops(t, &like);
  memcpy(w->raw_off, block, sizeof *block * (size_t)(like.n_loops + 1));
  memcpy(w->raw_corner, block + like.n_loops + 1, sizeof *block * (size_t)like.n_corners);
  LITHE_TRY(lth_topology_end_face(ctx, t, face, -1));
  LitheIndex cells[2] = {like.cell[0], like.cell[1]}, made = 0;
  like.tag = tag;
  like.source = -1;
  like.cell[1] = -1;
  for (int i = 0; i < 2; i++) {
    like.cell[0] = cells[i];
    LITHE_TRY(lth_topology_add_face(ctx, t, &like, like.n_loops, w->raw_off, w->raw_corner, i == 1,
                                    &made));
    LITHE_TRY(lth_topology_note_change(ctx, t, cells[i]));
    if (pair) pair[i] = made;
    for (int a = 0; a < 4; a++) like.plane[a] = -like.plane[a];
  }
  return LITHE_OK;
}

/// A cut in progress.
typedef struct Cutting {
  LthTopology *t;
  LitheIndex tag, n;
  const LitheIndex *cells;
  LthSplit *splits; ///< (n)
  int8_t *side;     ///< of cells that were not split (n)
  LthCut cut;
} Cutting;

/// The reach that all cells share where they are cut by one plane, so that a point has one sign.
static double common_reach(const Cutting *c, const double plane[4]) {
  double reach = INFINITY;
  for (LitheIndex i = 0; i < c->n; i++)
    reach = fmin(reach, lth_topology_reach(c->t, c->cells[i], plane));
  return reach;
}

/// Split one cell by the plane in hand, or by itself with more points on the plane where that does not come out.
static LitheStatus cut_cell(LitheCtx *ctx, Cutting *c, LitheIndex i) {
  LthTopology *t = c->t;
  LthTopologyWork *w = t->work;
  bool is_clean = false;
  LitheIndex cell = c->cells[i];
  double plane[4], reach = w->reach, d[3];
  memcpy(plane, w->plane, sizeof plane);
  LITHE_TRY(lth_topology_split_in_hand(ctx, t, cell, c->tag, c->splits + i, &is_clean));
  if (!is_clean) {
    lth_topology_take_plane(t, plane, LTH_TOPOLOGY_WIDEN * reach);
    LITHE_TRY(lth_topology_split_in_hand(ctx, t, cell, c->tag, c->splits + i, &is_clean));
    lth_topology_take_plane(t, plane, reach);
  }
  c->cut.n_split += c->splits[i].n > 0;
  if (c->splits[i].n > 0) return LITHE_OK;
  int side = 0;
  LITHE_TRY(lth_topology_classify(ctx, t, cell, &side));
  lth_v3_sub(t->cells[cell].centroid, t->origin, d);
  if (side == 0) side = lth_v3_dot(d, plane) > plane[3] ? 1 : -1;
  c->side[i] = (int8_t)side;
  return LITHE_OK;
}

static LitheStatus cut_cells(LitheCtx *ctx, Cutting *c, LitheIndex n_planes,
                             const LthPlane *planes) {
  LthTopology *t = c->t;
  for (LitheIndex i = 0; i < c->n; i++) {
    double plane[4];
    if (i == 0 || n_planes > 1) {
      lth_topology_plane(t, planes + (n_planes > 1 ? i : 0), plane);
      double reach =
          n_planes > 1 ? lth_topology_reach(t, c->cells[i], plane) : common_reach(c, plane);
      lth_topology_take_plane(t, plane, reach);
    }
    LITHE_TRY(cut_cell(ctx, c, i));
  }
  return LITHE_OK;
}

static void note_side(LthTopology *t, LitheIndex cell, int8_t side) {
  lth_topology_visit_cell(t, cell);
  t->work->cell_side[cell] = side;
}

static void note_sides(Cutting *c) {
  LthTopology *t = c->t;
  for (LitheIndex i = 0; i < c->n; i++) {
    const LthSplit *s = c->splits + i;
    if (s->n == 0) note_side(t, c->cells[i], c->side[i]);
    for (LitheIndex k = 0; k < s->n; k++)
      note_side(t, t->log.births[s->first + k].cell, k < s->n_below ? -1 : 1);
  }
}

/// Part the faces of a cell below to cells above.
static LitheStatus part_cell(LitheCtx *ctx, Cutting *c, LitheIndex cell) {
  LthTopology *t = c->t;
  LthTopologyWork *w = t->work;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces;) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i],
               across = lth_topology_across(t, face, cell);
    bool is_cut = across >= 0 && w->cell_seen[across] == w->cell_stamp && w->cell_side[across] > 0;
    if (!is_cut) {
      i++;
      continue;
    }
    w->cap_area += t->faces[face].area;
    c->cut.n_separated += !t->faces[face].is_line;
    LITHE_TRY(lth_topology_separate(ctx, t, face, c->tag, NULL)); // another face takes its place i
  }
  return LITHE_OK;
}

static LitheStatus part_sides(LitheCtx *ctx, Cutting *c) {
  LthTopology *t = c->t;
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  note_sides(c);
  for (LitheIndex i = 0; i < c->n; i++) {
    const LthSplit *s = c->splits + i;
    if (s->n == 0 && c->side[i] < 0) LITHE_TRY(part_cell(ctx, c, c->cells[i]));
    for (LitheIndex k = 0; k < s->n_below; k++)
      LITHE_TRY(part_cell(ctx, c, t->log.births[s->first + k].cell));
  }
  return LITHE_OK;
}

LitheStatus lth_topology_cut(LitheCtx *ctx, LthTopology *t, LitheIndex n, const LitheIndex *cells,
                             LitheIndex n_planes, const LthPlane *planes, LitheIndex tag,
                             LthCut *cut) {
  Cutting c = {.t = t, .tag = tag, .n = n, .cells = cells};
  LitheStatus status = LITHE_OK;
  LITHE_ASSERT(n_planes == 1 || n_planes == n);
  *cut = c.cut;
  LTH_NEW_OR(done, ctx, c.splits, n);
  LTH_NEW_OR(done, ctx, c.side, n);
  t->work->cap_area = 0;
  LITHE_TRY_OR(done, cut_cells(ctx, &c, n_planes, planes));
  if (tag != -1) LITHE_TRY_OR(done, part_sides(ctx, &c));
  *cut = c.cut;
  cut->area = t->work->cap_area;
done:
  lth_free(ctx, c.splits);
  lth_free(ctx, c.side);
  return status;
}
