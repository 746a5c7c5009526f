/// Sides of cuts: cells around the points of cut faces, in parts that hang together there.
#include "mesh/skin_priv.h"

#include "base/disjoint_sets.h"
#include "base/order.h"

#include <stdlib.h>
#include <string.h>

static bool is_cut(const LthTopologyFace *f) { return f->is_live && f->tag <= LTH_TAG_CUT; }

static LitheStatus mark_points(LitheCtx *ctx, SkinWork *w) {
  const LthTopology *t = w->t;
  LTH_NEW(ctx, w->cut_point, t->n_points);
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    if (!is_cut(t->faces + i)) continue;
    LthFaceView f = lth_topology_face(t, i);
    for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++)
      if (w->cut_point[f.loop_point[k]] == 0) w->cut_point[f.loop_point[k]] = ++w->n_cut_points;
  }
  return LITHE_OK;
}

/// Visit the corners of all live faces that lie on cuts: count or enter their cells, or join those of inner faces.
typedef enum Pass { COUNT, ENTER, JOIN } Pass;

static LitheIndex find_entry(const SkinWork *w, LitheIndex cut_point, LitheIndex cell) {
  LitheCount end = w->off[cut_point + 1],
             at = lth_lower_bound(w->cell, w->off[cut_point], end, cell);
  return at < end && w->cell[at] == cell ? (LitheIndex)at : -1;
}

static void visit_corner(SkinWork *w, Pass pass, const LitheIndex cell[2], LitheIndex k) {
  int n_sides = cell[1] < 0 ? 1 : 2;
  if (pass == COUNT) w->off[k + 1] += n_sides;
  for (int s = 0; pass == ENTER && s < n_sides; s++) w->cell[w->off[k]++] = cell[s];
  if (pass == JOIN && n_sides == 2)
    lth_sets_unite(w->part, find_entry(w, k, cell[0]), find_entry(w, k, cell[1]));
}

static void visit(SkinWork *w, Pass pass) {
  const LthTopology *t = w->t;
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    if (!t->faces[i].is_live) continue;
    LthFaceView f = lth_topology_face(t, i);
    for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++) {
      LitheIndex number = w->cut_point[f.loop_point[k]];
      if (number > 0) visit_corner(w, pass, t->faces[i].cell, number - 1);
    }
  }
}

/// Sort the entries of each point and keep each once.
static void compact(SkinWork *w) {
  LitheCount n = 0, begin = 0;
  for (LitheIndex k = 0; k < w->n_cut_points; k++) {
    LitheCount end = w->off[k + 1];
    LitheIndex kept = lth_sort_unique(w->cell + begin, (LitheIndex)(end - begin));
    memmove(w->cell + n, w->cell + begin, sizeof *w->cell * (size_t)kept);
    n += kept;
    begin = end;
    w->off[k + 1] = n;
  }
}

static LitheStatus find_cells(LitheCtx *ctx, SkinWork *w) {
  LTH_NEW(ctx, w->off, (LitheCount)w->n_cut_points + 1);
  visit(w, COUNT);
  for (LitheIndex k = 0; k < w->n_cut_points; k++) w->off[k + 1] += w->off[k];
  LitheCount total = w->off[w->n_cut_points];
  LTH_NEW(ctx, w->cell, total);
  visit(w, ENTER);
  for (LitheIndex k = w->n_cut_points; k > 0; k--) w->off[k] = w->off[k - 1];
  w->off[0] = 0;
  compact(w);
  total = w->off[w->n_cut_points];
  if (total + w->t->n_points > INT32_MAX)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting a surface: more than 2^31 corners on cuts");
  LTH_NEW(ctx, w->part, total);
  LTH_NEW(ctx, w->owner, total);
  lth_sets_reset(w->part, (LitheIndex)total);
  visit(w, JOIN);
  // the root of a set is its first entry
  for (LitheIndex i = 0; i < total; i++) w->part[i] = lth_sets_root(w->part, i);
  for (LitheIndex p = 0; p < w->t->n_points; p++)
    for (LitheCount i = w->cut_point[p] ? w->off[w->cut_point[p] - 1] : 0;
         w->cut_point[p] && i < w->off[w->cut_point[p]]; i++)
      w->owner[i] = p;
  return LITHE_OK;
}

LitheIndex lth_skin_node(const SkinWork *w, LitheIndex point, LitheIndex cell) {
  LitheIndex k = w->cut_point[point];
  if (k == 0) return point;
  LitheIndex entry = find_entry(w, k - 1, cell);
  return entry < 0 ? -1 : w->t->n_points + w->part[entry];
}

/// Whether the skin's point still is the point of the topology that it was.
static bool is_there(const SkinWork *w, LitheIndex i) {
  LitheIndex p = w->skin->point[i];
  return p >= 0 && p < w->t->n_points && w->t->point_use[p] > 0 &&
         memcmp(w->t->points + 3 * (LitheCount)p, w->skin->place + 3 * (LitheCount)i,
                3 * sizeof(double)) == 0;
}

/// The lowest cell at each point of the boundary (+ 1), and which of the skin's points have the cell that they name.
static void look_at_boundary(const SkinWork *w, bool *is_right) {
  const LthTopology *t = w->t;
  for (int pass = 0; pass < 2; pass++)
    for (LitheIndex i = 0; i < t->n_faces; i++) {
      if (!lth_skin_is_boundary(t->faces + i)) continue;
      LthFaceView f = lth_topology_face(t, i);
      LitheIndex cell = t->faces[i].cell[0];
      for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++) {
        LitheIndex p = f.loop_point[k], q = w->number[p];
        if (pass == 0 && (w->lowest[p] == 0 || cell < w->lowest[p] - 1)) w->lowest[p] = cell + 1;
        if (pass == 1 && q >= 0 && w->skin->cell[q] == cell) is_right[q] = true;
      }
    }
}

/// A point on no cut may have any cell around it; one that a merge had taken out and a split put back where it was
/// may name another.
static LitheStatus mend_cells(LitheCtx *ctx, SkinWork *w) {
  bool *is_right = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, w->lowest, w->t->n_points);
  LTH_NEW_OR(done, ctx, is_right, w->n_before);
  look_at_boundary(w, is_right);
  for (LitheIndex i = 0; i < w->n_before; i++) {
    LitheIndex node = w->node[i];
    if (node < 0 || node >= w->t->n_points || w->lowest[node] == 0) continue;
    LitheIndex first = w->number[node]; // others at the place go with it
    if (first == i && !is_right[i]) w->skin->cell[i] = w->lowest[node] - 1;
    if (first != i) w->skin->cell[i] = w->skin->cell[first];
  }
done:
  lth_free(ctx, is_right);
  return status;
}

/// A point on a cut that has lost its cell takes a side that has no point yet.
static void find_lost(SkinWork *w, LitheIndex i) {
  LitheIndex k = w->cut_point[w->skin->point[i]] - 1;
  for (LitheCount e = w->off[k]; e < w->off[k + 1]; e++) {
    LitheIndex node = w->t->n_points + w->part[e];
    if (w->number[node] >= 0) continue;
    w->number[node] = i;
    w->node[i] = node;
    w->skin->cell[i] = w->cell[e];
    return;
  }
}

static LitheStatus find_numbers(LitheCtx *ctx, SkinWork *w) {
  const LthSkin *skin = w->skin;
  w->n_before = skin->soup->n_points;
  w->n_nodes = w->t->n_points + (LitheIndex)w->off[w->n_cut_points];
  LTH_NEW(ctx, w->number, w->n_nodes);
  LTH_NEW(ctx, w->node, w->n_before);
  LTH_NEW(ctx, w->is_kept, w->t->n_points);
  for (LitheIndex i = 0; i < w->n_nodes; i++) w->number[i] = -1;
  for (LitheIndex i = w->n_before - 1; i >= 0; i--) {
    w->node[i] = is_there(w, i) ? lth_skin_node(w, skin->point[i], skin->cell[i]) : -1;
    if (w->node[i] >= 0) w->number[w->node[i]] = i;
  }
  for (LitheIndex i = 0; i < w->n_before; i++) {
    if (w->node[i] < 0 && is_there(w, i)) find_lost(w, i);
    if (w->node[i] >= 0 && i < skin->first->n_points) w->is_kept[skin->point[i]] = true;
  }
  for (LitheIndex p = 0; p < w->t->n_points; p++) w->is_kept[p] |= w->cut_point[p] > 0;
  return mend_cells(ctx, w);
}

LitheStatus lth_skin_find_sides(LitheCtx *ctx, SkinWork *w) {
  LITHE_TRY(mark_points(ctx, w));
  LITHE_TRY(find_cells(ctx, w));
  return find_numbers(ctx, w);
}

LitheStatus lth_skin_add_point(LitheCtx *ctx, LthSkin *skin, const double x[3], LitheIndex point,
                               LitheIndex cell, LitheIndex *number) {
  LitheCount n = skin->soup->n_points;
  if (n >= INT32_MAX / 3)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "cutting a surface: more than 2^31 coordinates");
  LTH_RESERVE(ctx, skin->soup->points, skin->points_cap, 3 * (n + 1));
  LTH_RESERVE(ctx, skin->cell, skin->cell_cap, n + 1);
  LTH_RESERVE(ctx, skin->point, skin->point_cap, n + 1);
  LTH_RESERVE(ctx, skin->place, skin->place_cap, 3 * (n + 1));
  lth_v3_copy(x, skin->soup->points + 3 * n);
  lth_v3_copy(x, skin->place + 3 * n);
  skin->cell[n] = cell;
  skin->point[n] = point;
  *number = skin->soup->n_points++;
  return LITHE_OK;
}

LitheStatus lth_skin_number(LitheCtx *ctx, SkinWork *w, LitheIndex node, LitheIndex *number) {
  *number = w->number[node];
  if (*number >= 0) return LITHE_OK;
  LitheIndex cell = node < w->t->n_points ? w->lowest[node] - 1 : w->cell[node - w->t->n_points];
  LITHE_TRY(lth_skin_add_point(ctx, w->skin, lth_skin_place(w, node), lth_skin_point(w, node), cell,
                               number));
  w->number[node] = *number;
  return LITHE_OK;
}
