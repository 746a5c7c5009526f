/// Parts of a sharp surface that touch each other in edges and points without being neighbours come apart.
#include "geometry/sharp_priv.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"

/// Half-edge 3 t + k goes from corner k of triangle t to the next.
typedef struct Halves {
  const LthSharp *s;
  LthHash edges;
  LitheIndex n_edges;
  LitheIndex *last; ///< last half-edge of each edge             (n_edges <= 3 n_tris)
  LitheIndex *back; ///< half-edge of the same edge before, -1   (3 n_tris)
} Halves;

static LitheIndex next_half(LitheIndex h) { return h % 3 == 2 ? h - 2 : h + 1; }

static const double *start_of(const Halves *x, LitheIndex h) {
  return x->s->points + 3 * (size_t)x->s->tris[h];
}

static void release_halves(Halves *x) {
  lth_hash_free(x->s->ctx, &x->edges);
  lth_free(x->s->ctx, x->last);
  lth_free(x->s->ctx, x->back);
  *x = (Halves){.s = x->s};
}

static LitheStatus list_halves(Halves *x) {
  LitheIndex n = 3 * x->s->n_tris, edge;
  LTH_NEW(x->s->ctx, x->last, n);
  LTH_NEW(x->s->ctx, x->back, n);
  for (LitheIndex h = 0; h < n; h++) {
    LitheIndex a = x->s->tris[h], b = x->s->tris[next_half(h)];
    uint64_t key = lth_hash_pair(a < b ? a : b, a < b ? b : a);
    LITHE_TRY(lth_hash_insert(x->s->ctx, &x->edges, key, 0, x->n_edges, &edge));
    if (edge == x->n_edges) x->last[x->n_edges++] = -1;
    x->back[h] = x->last[edge];
    x->last[edge] = h;
  }
  return LITHE_OK;
}

static bool are_opposite(const Halves *x, LitheIndex g, LitheIndex h) {
  return x->s->tris[g] != x->s->tris[h];
}

/// Angle from the triangle of h through the inside to that of g about their edge, in (0, 2 pi].
static double inner_angle(const Halves *x, LitheIndex h, LitheIndex g) {
  double along[3], own[3], other[3], normal[3], angle;
  lth_v3_sub(start_of(x, next_half(h)), start_of(x, h), along);
  lth_v3_sub(start_of(x, next_half(next_half(h))), start_of(x, h), own);
  lth_v3_sub(start_of(x, next_half(next_half(g))), start_of(x, h), other);
  lth_v3_normalize(along);
  lth_v3_axpy(-lth_v3_dot(own, along), along, own);
  lth_v3_normalize(own);
  lth_v3_cross(along, own, normal);
  angle = atan2(-lth_v3_dot(other, normal), lth_v3_dot(other, own));
  return angle > 0 ? angle : angle + 2 * M_PI;
}

/// The opposite half-edge that bounds the same inside; -1 where there is none.
static LitheIndex twin_of(const Halves *x, LitheIndex edge, LitheIndex h) {
  LitheIndex best = -1, n = 0;
  double least = INFINITY;
  for (LitheIndex g = x->last[edge]; g >= 0; g = x->back[g]) n++;
  for (LitheIndex g = x->last[edge]; g >= 0; g = x->back[g]) {
    if (!are_opposite(x, g, h)) continue;
    double angle = n > 2 ? inner_angle(x, h, g) : 0;
    if (angle < least) least = angle, best = g;
  }
  return best;
}

/// Unite corners of triangles that are neighbours at a point; false where an edge has no neighbour, or not one each.
static bool unite_corners(const Halves *x, LitheIndex *parent) {
  lth_sets_reset(parent, 3 * x->s->n_tris);
  for (LitheIndex e = 0; e < x->n_edges; e++)
    for (LitheIndex h = x->last[e]; h >= 0; h = x->back[h]) {
      LitheIndex twin = twin_of(x, e, h);
      if (twin < 0 || twin_of(x, e, twin) != h) return false;
      lth_sets_unite(parent, h, next_half(twin));
      lth_sets_unite(parent, next_half(h), twin);
    }
  return true;
}

/// The first set of corners at a point keeps it, others get copies.
static LitheStatus copy_points(LthSharp *s, LitheIndex *parent) {
  LitheStatus status = LITHE_OK;
  LitheIndex *point = NULL, *taken = NULL; // of a set + 1; set of a point + 1
  LTH_NEW_OR(done, s->ctx, point, 3 * (LitheCount)s->n_tris);
  LTH_NEW_OR(done, s->ctx, taken, s->n_points);
  for (LitheIndex h = 0; h < 3 * s->n_tris; h++) {
    LitheIndex set = lth_sets_root(parent, h), p = s->tris[h];
    if (!point[set] && !taken[p]) {
      taken[p] = set + 1;
      point[set] = p + 1;
    } else if (!point[set]) {
      LTH_RESERVE_OR(done, s->ctx, s->points, s->points_cap, 3 * ((LitheCount)s->n_points + 1));
      lth_v3_copy(s->points + 3 * (size_t)p, s->points + 3 * (size_t)s->n_points);
      point[set] = ++s->n_points;
    }
    s->tris[h] = point[set] - 1;
  }
done:
  lth_free(s->ctx, point);
  lth_free(s->ctx, taken);
  return status;
}

/// Two sheets that have both ends of an edge in common still have more than two triangles at it.
static bool has_pairs_alone(const Halves *x) {
  for (LitheIndex e = 0; e < x->n_edges; e++)
    if (x->back[x->last[e]] < 0 || x->back[x->back[x->last[e]]] >= 0) return false;
  return true;
}

LitheStatus lth_sharp_separate(LthSharp *s, bool *is_closed) {
  LitheStatus status = LITHE_OK;
  Halves x = {.s = s};
  LitheIndex *parent = NULL;
  LITHE_TRY_OR(done, list_halves(&x));
  LTH_NEW_OR(done, s->ctx, parent, 3 * (LitheCount)s->n_tris);
  *is_closed = unite_corners(&x, parent);
  if (!*is_closed) goto done;
  LITHE_TRY_OR(done, copy_points(s, parent));
  release_halves(&x);
  LITHE_TRY_OR(done, list_halves(&x));
  *is_closed = has_pairs_alone(&x);
done:
  release_halves(&x);
  lth_free(s->ctx, parent);
  return status;
}
