/// Merging two cells, and slivers into their neighbours.
#include "mesh/topology_priv.h"

#include "base/order.h"

#include <math.h>
#include <stdlib.h>

/// A common face below this share of the smaller cell's area is a line or a point.
#define NO_CONTACT 1e-12

/// Of a cell: how far apart two sides of a cut may be by rounding; less the cosine of their normals is more than -1.
#define TWINS 1e-9

/// Area of the common faces.
static double contact(const LthTopology *t, LitheIndex a, LitheIndex b) {
  double area = 0;
  for (LitheIndex i = 0; i < t->cells[a].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, a)[i];
    if (lth_topology_across(t, face, a) == b && !t->faces[face].is_line)
      area += t->faces[face].area;
  }
  return area;
}

/// Is a place inside of face f, by its middle or well inside of a corner, in face g of the same plane?
static bool covers(const LthTopology *t, LitheIndex f, LitheIndex g, double near) {
  LthFaceView v = lth_topology_face(t, f), w = lth_topology_face(t, g);
  const double *middle = t->faces[f].centroid;
  if (lth_face_distance2(&w, middle) <= near * near) return true;
  for (LitheIndex i = 0; i < v.loop_off[v.n_loops]; i++) {
    double x[3], d[3];
    lth_v3_sub(v.points + 3 * (LitheCount)v.loop_point[i], middle, d);
    lth_v3_copy(middle, x);
    lth_v3_axpy(0.9, d, x);
    if (lth_face_distance2(&w, x) <= near * near) return true;
  }
  return false;
}

/// Do two faces of one cut lie face to face? Its two sides have the same plane there, whatever was split or joined since, and
/// cover each other.
static bool are_twins(const LthTopology *t, LitheIndex f, LitheIndex g) {
  const double *p = t->faces[f].plane, *q = t->faces[g].plane, near = TWINS * t->cell_size;
  if (lth_v3_dot(p, q) > TWINS - 1 || fabs(p[3] + q[3]) > near) return false;
  return covers(t, f, g, near) || covers(t, g, f, near);
}

/// A cell must not have both sides of a cut.
static bool is_parted(const LthTopology *t, LitheIndex a, LitheIndex b) {
  const LitheIndex *fa = lth_topology_cell_faces(t, a), *fb = lth_topology_cell_faces(t, b);
  for (LitheIndex i = 0; i < t->cells[a].n_faces; i++) {
    if (t->faces[fa[i]].tag > LTH_TAG_CUT) continue;
    for (LitheIndex j = 0; j < t->cells[b].n_faces; j++)
      if (t->faces[fb[j]].tag == t->faces[fa[i]].tag && are_twins(t, fa[i], fb[j])) return true;
  }
  return false;
}

bool lth_topology_may_merge(const LthTopology *t, LitheIndex a, LitheIndex b) {
  if (a == b || !t->cells[a].is_live || !t->cells[b].is_live) return false;
  double least = NO_CONTACT * fmin(t->cells[a].area, t->cells[b].area);
  return contact(t, a, b) > least && !is_parted(t, a, b);
}

static LitheStatus move_faces(LitheCtx *ctx, LthTopology *t, LitheIndex from, LitheIndex other,
                              LitheIndex to) {
  for (LitheIndex i = 0; i < t->cells[from].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, from)[i];
    LthTopologyFace *f = t->faces + face;
    if (!f->is_live) continue;
    if (lth_topology_across(t, face, from) == other) {
      LITHE_TRY(lth_topology_end_face(ctx, t, face, -1));
      continue;
    }
    f->cell[f->cell[0] != from] = to;
    LITHE_TRY(lth_topology_list_face(ctx, t, to, face));
  }
  return LITHE_OK;
}

/// Points of the common faces: no others lose an edge when these vanish.
static LitheStatus list_common(LitheCtx *ctx, const LthTopology *t, LitheIndex a, LitheIndex b,
                               LitheIndex **points, LitheIndex *n) {
  LitheCount cap = 0;
  *n = 0;
  for (LitheIndex i = 0; i < t->cells[a].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, a)[i];
    if (lth_topology_across(t, face, a) != b) continue;
    LthFaceView view = lth_topology_face(t, face);
    LTH_RESERVE(ctx, *points, cap, (LitheCount)*n + view.loop_off[view.n_loops]);
    for (LitheIndex k = view.loop_off[0]; k < view.loop_off[view.n_loops]; k++)
      (*points)[(*n)++] = view.loop_point[k];
  }
  *n = lth_sort_unique(*points, *n);
  return LITHE_OK;
}

/// What is left to do when the two have all faces of one.
static LitheStatus tidy(LitheCtx *ctx, LthTopology *t, LitheIndex merged, LitheIndex n_points,
                        const LitheIndex *points) {
  LITHE_TRY(lth_topology_join_faces(ctx, t, merged));
  LITHE_TRY(lth_topology_drop_corners(ctx, t, merged, n_points, points));
  lth_topology_measure_cell(t, merged);
#ifdef LITHE_ASSERTS
  LITHE_TRY(lth_topology_check(ctx, t, 1, &merged));
#endif
  return LITHE_OK;
}

LitheStatus lth_topology_merge(LitheCtx *ctx, LthTopology *t, LitheIndex a, LitheIndex b,
                               LitheIndex *merged) {
  LITHE_ASSERT(lth_topology_may_merge(t, a, b));
  const LthTopologyCell *ca = t->cells + a, *cb = t->cells + b;
  LitheIndex source = ca->volume >= cb->volume ? ca->source : cb->source,
             room = ca->n_faces + cb->n_faces, *points = NULL, n_points = 0;
  LitheStatus status = list_common(ctx, t, a, b, &points, &n_points);
  if (status == LITHE_OK) status = lth_topology_add_cell(ctx, t, source, room, merged);
  LITHE_TRY_OR(done, status);
  t->cells[*merged].area = t->cells[a].area + t->cells[b].area;
  LITHE_TRY_OR(done, lth_topology_note_birth(ctx, t, *merged, a));
  LITHE_TRY_OR(done, lth_topology_note_birth(ctx, t, *merged, b));
  t->cells[a].into = t->cells[b].into = *merged;
  LITHE_TRY_OR(done, lth_topology_end_cell(ctx, t, a));
  LITHE_TRY_OR(done, lth_topology_end_cell(ctx, t, b));
  LITHE_TRY_OR(done, move_faces(ctx, t, a, b, *merged));
  LITHE_TRY_OR(done, move_faces(ctx, t, b, a, *merged));
  status = tidy(ctx, t, *merged, n_points, points);
done:
  lth_free(ctx, points);
  return status;
}

/// The neighbour with the largest common face that a cell may merge with, -1: none.
static LitheStatus best_neighbour(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                  LitheIndex *best) {
  double largest = NO_CONTACT * t->cells[cell].area;
  *best = -1;
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i],
               across = lth_topology_across(t, face, cell);
    if (across < 0 || t->faces[face].is_line || !lth_topology_visit_cell(t, across)) continue;
    double area = contact(t, cell, across);
    bool is_better = area > largest || (area == largest && *best >= 0 && across < *best);
    if (!is_better || is_parted(t, cell, across)) continue;
    largest = area;
    *best = across;
  }
  return LITHE_OK;
}

/// Slivers that wait, as a heap: smallest first, ties by number.
typedef struct Waiting {
  const LthTopology *t;
  LitheIndex *cell;
  LitheCount n, cap;
} Waiting;

static bool is_smaller(const LthTopology *t, LitheIndex a, LitheIndex b) {
  double x = t->cells[a].volume, y = t->cells[b].volume;
  return x != y ? x < y : a < b;
}

static LitheStatus push(LitheCtx *ctx, Waiting *h, LitheIndex cell) {
  LTH_RESERVE(ctx, h->cell, h->cap, h->n + 1);
  LitheCount i = h->n++;
  for (; i > 0 && is_smaller(h->t, cell, h->cell[(i - 1) / 2]); i = (i - 1) / 2)
    h->cell[i] = h->cell[(i - 1) / 2];
  h->cell[i] = cell;
  return LITHE_OK;
}

static LitheIndex pop(Waiting *h) {
  LitheIndex top = h->cell[0], last = h->cell[--h->n];
  LitheCount i = 0, j;
  for (; (j = 2 * i + 1) < h->n; i = j) {
    if (j + 1 < h->n && is_smaller(h->t, h->cell[j + 1], h->cell[j])) j++;
    if (!is_smaller(h->t, h->cell[j], last)) break;
    h->cell[i] = h->cell[j];
  }
  h->cell[i] = last;
  return top;
}

LitheStatus lth_topology_merge_slivers(LitheCtx *ctx, LthTopology *t, LitheIndex n,
                                       const LitheIndex *cells, double volume,
                                       LitheIndex *n_merged) {
  LitheStatus status = LITHE_OK;
  Waiting heap = {.t = t};
  *n_merged = 0;
  LitheIndex n_given = cells ? n : t->n_cells;
  for (LitheIndex i = 0; i < n_given; i++) {
    LitheIndex c = cells ? cells[i] : i;
    if (t->cells[c].is_live && t->cells[c].volume < volume) LITHE_TRY_OR(done, push(ctx, &heap, c));
  }
  while (heap.n > 0) {
    LitheIndex cell = pop(&heap), other = -1, merged = 0;
    if (!t->cells[cell].is_live) continue;
    LITHE_TRY_OR(done, best_neighbour(ctx, t, cell, &other));
    if (other < 0) continue;
    LITHE_TRY_OR(done, lth_topology_merge(ctx, t, cell, other, &merged));
    ++*n_merged;
    if (t->cells[merged].volume < volume) LITHE_TRY_OR(done, push(ctx, &heap, merged));
  }
done:
  lth_free(ctx, heap.cell);
  return status;
}
