/// Mending slight local crossings, such as the folds that hole filling programs leave behind.
///
/// Only two changes are tried, on the triangles of a crossing pair themselves: turning an edge within
/// the four corners around it, and removing a corner that has three triangles. A change is made where it
/// leaves fewer crossings and moves the surface by less than a thousandth of its size; whatever is
/// deeper stays a defect.
#include "base/tensor.h"
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"
#include "geometry/tri_tri.h"

#define REACH 1e-3 // of the size
#define SAMPLES 8  // of an edge, to measure by how much it moves
#define STACK_MAX 128

/// Triangles `old` are replaced by the triangles `tri`.
typedef struct Change {
  int n_old, n_new;
  LitheIndex old[3];
  LitheIndex tri[2][3];
  double moved;    ///< about the largest distance of the new from the old [m]
  LitheIndex gain; ///< crossings less than before
} Change;

typedef struct Mend {
  LthCleaner *c;
  const LthBvh *bvh;
  bool *is_busy; ///< points of triangles that were changed in this round
} Mend;

static LitheIndex next_in_tri(LitheIndex half) { return half % 3 == 2 ? half - 2 : half + 1; }

static LitheIndex twin_of(const LthCleaner *c, LitheIndex half) {
  LitheIndex first = c->edge_off[c->half_edge[half]];
  return c->edge_half[first] == half ? c->edge_half[first + 1] : c->edge_half[first];
}

/// Edges are sorted by their lower, then their upper point.
static bool has_edge(const LthCleaner *c, LitheIndex p, LitheIndex q) {
  LitheIndex low = 0, high = c->n_edges, a = p < q ? p : q, b = p < q ? q : p;
  while (low < high) {
    LitheIndex mid = low + (high - low) / 2, half = c->edge_half[c->edge_off[mid]];
    LitheIndex from = lth_clean_from(c, half), to = lth_clean_to(c, half);
    LitheIndex u = from < to ? from : to, v = from < to ? to : from;
    if (u == a && v == b) return true;
    if (u < a || (u == a && v < b))
      low = mid + 1;
    else
      high = mid;
  }
  return false;
}

static bool has_area(const LthCleaner *c, const LitheIndex t[3]) {
  return !lth_collinear(lth_clean_point(c, t[0]), lth_clean_point(c, t[1]),
                        lth_clean_point(c, t[2]));
}

static double distance_to_old(const LthCleaner *c, const Change *change, const double x[3]) {
  double nearest = INFINITY, at[3];
  for (int i = 0; i < change->n_old; i++) {
    const LitheIndex *t = c->tris + 3 * (size_t)change->old[i];
    lth_closest_on_triangle(lth_clean_point(c, t[0]), lth_clean_point(c, t[1]),
                            lth_clean_point(c, t[2]), x, at);
    nearest = fmin(nearest, lth_v3_distance(x, at));
  }
  return nearest;
}

/// Turn the edge of `half`: (a, b, m) and (b, a, y) become (b, m, y) and (m, a, y).
static bool make_turn(const LthCleaner *c, LitheIndex half, Change *change) {
  LitheIndex other = twin_of(c, half), a = lth_clean_from(c, half), b = lth_clean_to(c, half);
  LitheIndex m = lth_clean_to(c, next_in_tri(half)), y = lth_clean_to(c, next_in_tri(other));
  if (m == y || has_edge(c, m, y)) return false;
  *change = (Change){2, 2, {half / 3, other / 3}, {{b, m, y}, {m, a, y}}, 0, 0};
  if (!has_area(c, change->tri[0]) || !has_area(c, change->tri[1])) return false;
  for (int i = 1; i < SAMPLES; i++) {
    double x[3], s = (double)i / SAMPLES;
    for (int k = 0; k < 3; k++)
      x[k] = (1 - s) * lth_clean_point(c, m)[k] + s * lth_clean_point(c, y)[k];
    change->moved = fmax(change->moved, distance_to_old(c, change, x));
  }
  return true;
}

/// Remove the point that `half` starts from, if three triangles meet there: one takes their place.
static bool make_removal(const LthCleaner *c, LitheIndex half, Change *change) {
  LitheIndex at = half;
  double closest[3];
  *change = (Change){.n_old = 3, .n_new = 1};
  for (int i = 0; i < 3; i++) {
    change->old[i] = at / 3;
    change->tri[0][i] = lth_clean_to(c, at);
    // from (v, p, q) over its edge qv to (v, q, r)
    at = twin_of(c, next_in_tri(next_in_tri(at)));
  }
  if (at != half || !has_area(c, change->tri[0])) return false;
  // a tetrahedron would become a flat pair
  LitheIndex far = lth_clean_to(c, next_in_tri(twin_of(c, next_in_tri(half))));
  if (far == change->tri[0][2]) return false;
  const double *v = lth_clean_point(c, lth_clean_from(c, half));
  const LitheIndex *t = change->tri[0];
  lth_closest_on_triangle(lth_clean_point(c, t[0]), lth_clean_point(c, t[1]),
                          lth_clean_point(c, t[2]), v, closest);
  change->moved = lth_v3_distance(v, closest);
  return true;
}

static bool is_old(const Change *change, LitheIndex tri) {
  for (int i = 0; i < change->n_old; i++)
    if (change->old[i] == tri) return true;
  return false;
}

/// Crossings of one triangle with all that the change leaves as they are.
static LitheIndex count_crossings(const Mend *mend, const Change *change, const LitheIndex t[3]) {
  const LthCleaner *c = mend->c;
  const LthBvh *bvh = mend->bvh;
  double box[6];
  LitheIndex stack[STACK_MAX], top = 0, n = 0;
  lth_clean_box(c, t, box);
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (!lth_boxes_meet(bvh->box + 6 * (size_t)node, box)) continue;
    if (bvh->right[node] >= 0) {
      stack[top++] = bvh->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = 0; i < bvh->count[node]; i++) {
      LitheIndex other = bvh->item[bvh->first[node] + i];
      const LitheIndex *u = c->tris + 3 * (size_t)other;
      if (is_old(change, other) || !has_area(c, u)) continue;
      n += lth_triangles_cross(c->points, t, u);
    }
  }
  return n;
}

static void measure_gain(const Mend *mend, Change *change) {
  const LthCleaner *c = mend->c;
  change->gain = 0;
  for (int i = 0; i < change->n_old; i++) {
    const LitheIndex *t = c->tris + 3 * (size_t)change->old[i];
    change->gain += count_crossings(mend, change, t);
    for (int j = 0; j < i; j++)
      change->gain += lth_triangles_cross(c->points, t, c->tris + 3 * (size_t)change->old[j]);
  }
  for (int i = 0; i < change->n_new; i++)
    change->gain -= count_crossings(mend, change, change->tri[i]);
  if (change->n_new == 2)
    change->gain -= lth_triangles_cross(c->points, change->tri[0], change->tri[1]);
}

static bool touches_busy(const Mend *mend, const Change *change) {
  for (int i = 0; i < change->n_old; i++)
    for (int k = 0; k < 3; k++)
      if (mend->is_busy[mend->c->tris[3 * change->old[i] + k]]) return true;
  return false;
}

/// Keep the better of two changes: more crossings gone, then less moved.
static void consider(const Mend *mend, Change *change, Change *best) {
  if (change->moved > REACH * mend->c->size || touches_busy(mend, change)) return;
  measure_gain(mend, change);
  if (change->gain > best->gain ||
      (change->gain == best->gain && change->gain > 0 && change->moved < best->moved))
    *best = *change;
}

static void mark_busy(const Mend *mend, const Change *change) {
  for (int i = 0; i < change->n_old; i++)
    for (int k = 0; k < 3; k++) mend->is_busy[mend->c->tris[3 * change->old[i] + k]] = true;
}

static void apply(LthCleaner *c, const Change *change) {
  for (int i = 0; i < change->n_old; i++)
    for (int k = 0; k < 3; k++)
      c->tris[3 * change->old[i] + k] = i < change->n_new ? change->tri[i][k] : -1;
}

static void remove_dropped(LthCleaner *c) {
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    if (c->tris[3 * t] < 0) continue;
    for (LitheIndex k = 0; k < 3; k++) c->tris[3 * n + k] = c->tris[3 * t + k];
    c->tri_poly[n] = c->tri_poly[t];
    c->tri_is_mixed[n++] = c->tri_is_mixed[t];
  }
  c->n_tris = n;
}

/// The best change to a triangle, with no gain if there is none.
static Change find_change(const Mend *mend, LitheIndex tri) {
  Change best = {.gain = 0}, change;
  for (LitheIndex k = 0; k < 3; k++) {
    if (make_turn(mend->c, 3 * tri + k, &change)) consider(mend, &change, &best);
    if (make_removal(mend->c, 3 * tri + k, &change)) consider(mend, &change, &best);
  }
  return best;
}

/// Changes of one round have no point in common, so they are found one by one and made together.
LitheStatus lth_clean_mend(LthCleaner *c, const LthBvh *bvh, LitheIndex *n_changes, double *moved) {
  LitheStatus status = LITHE_OK;
  Mend mend = {.c = c, .bvh = bvh};
  Change *change = NULL;
  *n_changes = 0;
  LTH_NEW_OR(done, c->ctx, mend.is_busy, c->n_points);
  LTH_NEW_OR(done, c->ctx, change, 2 * (LitheCount)c->n_pairs);
  for (LitheIndex i = 0; i < 2 * c->n_pairs; i++) {
    Change best = find_change(&mend, c->pair[i]);
    if (best.gain <= 0) continue;
    mark_busy(&mend, &best);
    *moved = fmax(*moved, best.moved);
    change[(*n_changes)++] = best;
  }
  for (LitheIndex i = 0; i < *n_changes; i++) apply(c, &change[i]);
  if (*n_changes > 0) {
    remove_dropped(c);
    LITHE_TRY_OR(done, lth_clean_edges(c));
    LITHE_TRY_OR(done, lth_clean_orient(c));
  }
done:
  lth_free(c->ctx, mend.is_busy);
  lth_free(c->ctx, change);
  return status;
}
