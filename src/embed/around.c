/// Cells around points: incidence first, then parts, of those points of the boundary alone that have several cells.
#include "embed/around.h"

#include "base/disjoint_sets.h"
#include "base/order.h"

#include <stdlib.h>

/// Incidence in the making.
typedef struct Making {
  const LthMesh *mesh;
  LthAround *around;
  LitheIndex *mark; ///< last cell that saw a point                     (n_points)
  LitheIndex *set;  ///< entries that hang together                     (entries)
} Making;

static LitheIndex first_corner(const LthMesh *m, LitheIndex face) {
  return m->loop_off[m->face_loop_off[face]];
}
static LitheIndex end_corner(const LthMesh *m, LitheIndex face) {
  return m->loop_off[m->face_loop_off[face + 1]];
}

/// Every point of a cell once.
static void count_or_fill(Making *w, LitheIndex cell, bool fill) {
  const LthMesh *m = w->mesh;
  LthAround *at = w->around;
  for (LitheIndex i = m->cell_face_off[cell]; i < m->cell_face_off[cell + 1]; i++) {
    LitheIndex f = m->cell_face[i];
    for (LitheIndex k = first_corner(m, f); k < end_corner(m, f); k++) {
      LitheIndex p = m->loop_point[k];
      if (w->mark[p] == cell) continue;
      w->mark[p] = cell;
      if (fill)
        at->cell[at->off[p]++] = cell;
      else
        at->off[p + 1]++;
    }
  }
}

static LitheStatus find_incidence(LitheCtx *ctx, Making *w) {
  const LthMesh *m = w->mesh;
  LthAround *at = w->around;
  LTH_NEW(ctx, at->off, (LitheCount)m->n_points + 1);
  LTH_NEW(ctx, w->mark, m->n_points);
  for (LitheIndex p = 0; p < m->n_points; p++) w->mark[p] = -1;
  for (LitheIndex c = 0; c < m->n_cells; c++) count_or_fill(w, c, false);
  for (LitheIndex p = 0; p < m->n_points; p++) at->off[p + 1] += at->off[p];
  LTH_NEW(ctx, at->cell, at->off[m->n_points]);
  LTH_NEW(ctx, at->part, at->off[m->n_points]);
  for (LitheIndex p = 0; p < m->n_points; p++) w->mark[p] = -1;
  for (LitheIndex c = 0; c < m->n_cells; c++) count_or_fill(w, c, true);
  for (LitheIndex p = m->n_points; p > 0; p--)
    at->off[p] = at->off[p - 1]; // fill moved each to its end
  at->off[0] = 0;
  return LITHE_OK;
}

/// Mark the points of the boundary that have several cells; false where there are none.
static bool mark_boundary(Making *w) {
  const LthMesh *m = w->mesh;
  bool any = false;
  for (LitheIndex p = 0; p < m->n_points; p++) w->mark[p] = 0;
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_cell[2 * (size_t)f + 1] >= 0) continue;
    for (LitheIndex k = first_corner(m, f); k < end_corner(m, f); k++) {
      LitheIndex p = m->loop_point[k];
      w->mark[p] = w->around->off[p + 1] - w->around->off[p] > 1;
      any = any || w->mark[p];
    }
  }
  return any;
}

static LitheIndex find_entry(const LthAround *at, LitheIndex p, LitheIndex cell) {
  return (LitheIndex)lth_lower_bound(at->cell, at->off[p], at->off[p + 1], cell);
}

/// The two cells of an inner face hang together at all its points.
static void join_cells(Making *w) {
  const LthMesh *m = w->mesh;
  const LthAround *at = w->around;
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    const LitheIndex *side = m->face_cell + 2 * (size_t)f;
    if (side[1] < 0) continue;
    for (LitheIndex k = first_corner(m, f); k < end_corner(m, f); k++) {
      LitheIndex p = m->loop_point[k];
      if (w->mark[p])
        lth_sets_unite(w->set, find_entry(at, p, side[0]), find_entry(at, p, side[1]));
    }
  }
}

/// Entries of a point in the order of their parts.
static void sort_parts(const Making *w, LitheIndex p) {
  LthAround *at = w->around;
  LitheCount begin = at->off[p], end = at->off[p + 1];
  LitheIndex n_parts = 0;
  for (LitheCount i = begin; i < end; i++) {
    // the root of a set is its first entry
    LitheIndex root = lth_sets_root(w->set, (LitheIndex)i);
    at->part[i] = root == i ? n_parts++ : at->part[root];
  }
  for (LitheCount i = begin + 1; n_parts > 1 && i < end; i++) {
    LitheIndex cell = at->cell[i], part = at->part[i];
    LitheCount j = i;
    for (; j > begin && at->part[j - 1] > part; j--)
      at->part[j] = at->part[j - 1], at->cell[j] = at->cell[j - 1];
    at->part[j] = part, at->cell[j] = cell;
  }
}

LitheStatus lth_around_create(LitheCtx *ctx, const LthMesh *mesh, LthAround *around) {
  LitheStatus status = LITHE_OK;
  Making w = {.mesh = mesh, .around = around};
  *around = (LthAround){0};
  LITHE_TRY_OR(done, find_incidence(ctx, &w));
  if (around->off[mesh->n_points] > INT32_MAX) {
    status = lth_fail(ctx, LITHE_UNSUPPORTED, "embedding: more than 2^31 corners of elements");
    goto done;
  }
  if (!mark_boundary(&w)) goto done;
  LTH_NEW_OR(done, ctx, w.set, around->off[mesh->n_points]);
  lth_sets_reset(w.set, (LitheIndex)around->off[mesh->n_points]);
  join_cells(&w);
  for (LitheIndex p = 0; p < mesh->n_points; p++)
    if (w.mark[p]) sort_parts(&w, p);
done:
  lth_free(ctx, w.mark);
  lth_free(ctx, w.set);
  if (status != LITHE_OK) lth_around_free(ctx, around);
  return status;
}

void lth_around_free(LitheCtx *ctx, LthAround *around) {
  lth_free(ctx, around->off);
  lth_free(ctx, around->cell);
  lth_free(ctx, around->part);
  *around = (LthAround){0};
}
