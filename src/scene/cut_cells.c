/// Cells that a cut looks at: planes and places of the moment, windows in planes, and parts of cells that are merged again.
#include "scene/cut_priv.h"

#include "base/tensor.h"
#include "disc/dg/dg_transfer.h"

#include <math.h>

#define INNER 1e-9 ///< of a window: what is closer to its edges touches it only

// --- places ---

/// The old cell whose polynomial moves a record.
static LitheIndex old_cell(const LthCutting *c, LitheIndex record) {
  return c->body->change->record_cell[lth_topology_before(c->t, record)];
}

bool lth_cutting_plane(const LthCutting *c, const LthPlane *plane, LitheIndex cell,
                       LthPlane *rest) {
  *rest = *plane;
  return !c->x || lth_dg_plane_to_rest(c->body->space, old_cell(c, cell), c->x, plane, rest);
}

void lth_cutting_place(const LthCutting *c, LitheIndex cell, const double rest[3], double at[3]) {
  if (c->x)
    lth_dg_sample(c->body->space, old_cell(c, cell), c->x, rest, at);
  else
    lth_v3_copy(rest, at);
}

bool lth_plane_passes(const LthTopologyCell *cell, const LthPlane *plane, double margin) {
  double reach = 0, height = 0;
  for (int a = 0; a < 3; a++) {
    double half = 0.5 * (cell->box[3 + a] - cell->box[a]);
    height += plane->normal[a] * (cell->box[a] + half - plane->point[a]);
    reach += (1 + margin) * half * fabs(plane->normal[a]);
  }
  return fabs(height) <= reach;
}

// --- windows ---

static void to_window(const LthWindow *w, const double x[3], double p[2]) {
  double d[3];
  lth_v3_sub(x, w->origin, d);
  for (int i = 0; i < 2; i++) p[i] = lth_v3_dot(w->axis[i], d);
}

LthWindow lth_window_make(int n, const double *const corners[]) {
  LthWindow w = {.n = n};
  double normal[3], last[3];
  for (int i = 0; i < n; i++) lth_v3_axpy(1.0 / n, corners[i], w.origin);
  lth_v3_sub(corners[1], corners[0], w.axis[0]);
  lth_v3_sub(corners[n - 1], corners[0], last);
  lth_v3_cross(w.axis[0], last, normal);
  lth_v3_normalize(w.axis[0]);
  lth_v3_normalize(normal);
  lth_v3_cross(normal, w.axis[0], w.axis[1]);
  for (int i = 0; i < n; i++) to_window(&w, corners[i], w.corner[i]);
  return w;
}

/// Is some part of the segment inside? Corners run counter-clockwise.
static bool meets_segment(const LthWindow *w, const double p[2], const double q[2]) {
  double low = 0, high = 1;
  for (int i = 0; i < w->n; i++) {
    const double *a = w->corner[i], *b = w->corner[(i + 1) % w->n];
    double edge[2] = {b[0] - a[0], b[1] - a[1]}, length2 = edge[0] * edge[0] + edge[1] * edge[1];
    double hp = (edge[0] * (p[1] - a[1]) - edge[1] * (p[0] - a[0])) - INNER * length2;
    double hq = (edge[0] * (q[1] - a[1]) - edge[1] * (q[0] - a[0])) - INNER * length2;
    if (hp <= 0 && hq <= 0) return false;
    if (hp < 0) low = fmax(low, hp / (hp - hq));
    if (hq < 0) high = fmin(high, hp / (hp - hq));
  }
  return low < high;
}

bool lth_cutting_meets(const LthCutting *c, LitheIndex cell, const LthWindow *w) {
  bool is_around = false;
  double level = INNER * hypot(w->corner[0][0], w->corner[0][1]);
  for (LitheIndex i = 0; i < c->section.n; i++) {
    const double *ends = c->section.ends + 6 * (LitheCount)i;
    double at[2][3], p[2][2];
    for (int e = 0; e < 2; e++) {
      lth_cutting_place(c, cell, ends + 3 * e, at[e]);
      to_window(w, at[e], p[e]);
    }
    if (meets_segment(w, p[0], p[1])) return true;
    // the outline around the window's middle, the origin: even or odd. A corner that two segments have in common comes out with
    // two roundings, so the ray is a little above where corners of regular meshes lie
    bool crosses = (p[0][1] > level) != (p[1][1] > level);
    if (crosses && p[0][0] + (level - p[0][1]) * (p[1][0] - p[0][0]) / (p[1][1] - p[0][1]) > 0)
      is_around = !is_around;
  }
  return is_around;
}

// --- parts of cells ---

LitheStatus lth_cut_roots_begin(LitheCtx *ctx, const LthTopology *t, LthCutRoots *roots) {
  roots->n = t->n_cells;
  roots->n_births = t->log.n_births;
  LTH_RESERVE(ctx, roots->root, roots->cap, roots->n);
  for (LitheIndex i = 0; i < roots->n; i++) roots->root[i] = t->cells[i].is_live ? i : -1;
  return LITHE_OK;
}

LitheStatus lth_cut_roots_follow(LitheCtx *ctx, const LthTopology *t, LthCutRoots *roots) {
  LTH_RESERVE(ctx, roots->root, roots->cap, t->n_cells);
  for (; roots->n < t->n_cells; roots->n++) roots->root[roots->n] = -1;
  for (; roots->n_births < t->log.n_births; roots->n_births++) {
    const LthTopologyBirth *birth = t->log.births + roots->n_births;
    roots->root[birth->cell] = roots->root[birth->parent];
  }
  return LITHE_OK;
}

/// In which round a cell was made, by record.
typedef struct Rounds {
  LitheIndex now, *of;
  LitheCount cap;
} Rounds;

/// A neighbour that a cell came of one root with, on the same side, and that this round has not made; -1.
static LitheIndex find_other(const LthCutting *c, const LthCutRoots *roots, const int8_t *side,
                             const LitheIndex *round_of, LitheIndex cell) {
  const LthTopology *t = c->t;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i];
    LitheIndex other = t->faces[face].cell[t->faces[face].cell[0] == cell];
    if (other < 0 || roots->root[other] != roots->root[cell]) continue;
    if ((side && side[other] != side[cell]) || round_of[other] == round_of[cell]) continue;
    if (lth_topology_may_merge(t, cell, other)) return other;
  }
  return -1;
}

/// Merge in rounds, two by two: one cell that grew by all others in turn would be gone through again for each.
static LitheStatus merge_round(LitheCtx *ctx, LthCutting *c, LthCutRoots *roots, int8_t **side,
                               LitheCount *side_cap, Rounds *rounds, LitheIndex *n_merged) {
  LthTopology *t = c->t;
  LitheIndex n = t->n_cells;
  *n_merged = 0;
  rounds->now++;
  for (LitheIndex cell = 0; cell < n; cell++) {
    LitheIndex merged = 0;
    if (!t->cells[cell].is_live || roots->root[cell] == cell) continue;
    if (rounds->of[cell] == rounds->now) continue;
    rounds->of[cell] = rounds->now; // and so are all that it must not be merged with
    LitheIndex other = find_other(c, roots, side ? *side : NULL, rounds->of, cell);
    rounds->of[cell] = 0;
    if (other < 0) continue;
    LITHE_TRY(lth_topology_merge(ctx, t, cell, other, &merged));
    LITHE_TRY(lth_cut_roots_follow(ctx, t, roots));
    LTH_RESERVE(ctx, rounds->of, rounds->cap, t->n_cells);
    rounds->of[merged] = rounds->now;
    if (side) LTH_RESERVE(ctx, *side, *side_cap, t->n_cells);
    if (side) (*side)[merged] = (*side)[cell];
    ++*n_merged;
  }
  return LITHE_OK;
}

LitheStatus lth_cut_merge_roots(LitheCtx *ctx, LthCutting *c, LthCutRoots *roots, int8_t **side,
                                LitheCount *side_cap) {
  LitheStatus status = LITHE_OK;
  Rounds rounds = {0};
  LitheIndex n_merged;
  LTH_RESERVE_OR(done, ctx, rounds.of, rounds.cap, c->t->n_cells);
  do LITHE_TRY_OR(done, merge_round(ctx, c, roots, side, side_cap, &rounds, &n_merged));
  while (n_merged > 0);
done:
  lth_free(ctx, rounds.of);
  return status;
}
