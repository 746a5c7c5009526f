/// Removing triangles without area from a closed surface without changing it.
///
/// A triangle (a, b, m) with m between a and b covers nothing but the segment ab. Together with its
/// neighbour (b, a, y) across ab it is the polygon a y b m; cutting that along ym instead of ab gives
/// (b, m, y) and (m, a, y), which cover just the neighbour: the surface is the same set of points and
/// the triangle without area is gone (or, next to another one, has become shorter).
#include "base/tensor.h"
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"

#include <stdlib.h>

#define ROUNDS_MAX 1000

typedef struct Needle {
  LitheIndex half; ///< its longest side
  double length;
} Needle;

static bool has_no_area(const LthCleaner *c, LitheIndex tri) {
  const LitheIndex *t = c->tris + 3 * (size_t)tri;
  return lth_collinear(lth_clean_point(c, t[0]), lth_clean_point(c, t[1]),
                       lth_clean_point(c, t[2]));
}

/// Points of a line are met in lexicographic order, so this finds the middle one exactly.
static bool comes_before(const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i];
  return false;
}

static LitheIndex longest_side(const LthCleaner *c, LitheIndex tri) {
  for (LitheIndex k = 0; k < 3; k++) {
    const double *a = lth_clean_point(c, c->tris[3 * tri + k]),
                 *b = lth_clean_point(c, c->tris[3 * tri + (k + 1) % 3]),
                 *m = lth_clean_point(c, c->tris[3 * tri + (k + 2) % 3]);
    if ((comes_before(a, m) && comes_before(m, b)) || (comes_before(b, m) && comes_before(m, a)))
      return 3 * tri + k;
  }
  return 3 * tri;
}

static double side_length(const LthCleaner *c, LitheIndex half) {
  return lth_v3_distance(lth_clean_point(c, lth_clean_from(c, half)),
                         lth_clean_point(c, lth_clean_to(c, half)));
}

static int compare_needles(const void *a, const void *b) {
  const Needle *p = a, *q = b;
  if (p->length != q->length) return p->length < q->length ? 1 : -1;
  return (p->half > q->half) - (p->half < q->half);
}

static void link_twins(LitheIndex *twin, LitheIndex a, LitheIndex b) {
  twin[a] = b;
  twin[b] = a;
}

/// Turn the side `half` in the two triangles around it; false where that would fold them together or
/// where the neighbour, without area itself, has to go first.
static bool turn_side(LthCleaner *c, LitheIndex *twin, LitheIndex half) {
  LitheIndex t = half / 3, k = half % 3, other = twin[half], u = other / 3, l = other % 3;
  LitheIndex *p = c->tris + 3 * (size_t)t, *q = c->tris + 3 * (size_t)u;
  LitheIndex a = p[k], b = p[(k + 1) % 3], m = p[(k + 2) % 3], y = q[(l + 2) % 3];
  if (y == m || u == t) return false;
  if (has_no_area(c, u) && longest_side(c, u) != other) return false;

  LitheIndex bm = twin[3 * t + (k + 1) % 3], ma = twin[3 * t + (k + 2) % 3];
  LitheIndex ay = twin[3 * u + (l + 1) % 3], yb = twin[3 * u + (l + 2) % 3];
  p[0] = b, p[1] = m, p[2] = y;
  q[0] = m, q[1] = a, q[2] = y;
  link_twins(twin, 3 * t, bm);
  link_twins(twin, 3 * t + 1, 3 * u + 2);
  link_twins(twin, 3 * t + 2, yb);
  link_twins(twin, 3 * u, ma);
  link_twins(twin, 3 * u + 1, ay);
  // the first triangle now lies in the neighbour's polygon as well
  c->tri_poly[t] = c->tri_poly[u];
  return true;
}

/// One pass over all triangles without area, longest first; returns the number of sides turned.
static LitheIndex turn_round(LthCleaner *c, LitheIndex *twin, Needle *needle, LitheIndex n) {
  LitheIndex turned = 0;
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex t = needle[i].half / 3;
    // an earlier turn may have changed this triangle
    if (!has_no_area(c, t)) continue;
    turned += turn_side(c, twin, longest_side(c, t));
  }
  return turned;
}

static LitheIndex find_needles(const LthCleaner *c, Needle *needle) {
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    if (!has_no_area(c, t)) continue;
    LitheIndex half = longest_side(c, t);
    if (needle) needle[n] = (Needle){half, side_length(c, half)};
    n++;
  }
  return n;
}

static LitheStatus make_twins(LthCleaner *c, LitheIndex **twin) {
  LTH_NEW(c->ctx, *twin, 3 * (LitheCount)c->n_tris);
  for (LitheIndex e = 0; e < c->n_edges; e++)
    link_twins(*twin, c->edge_half[c->edge_off[e]], c->edge_half[c->edge_off[e] + 1]);
  return LITHE_OK;
}

LitheStatus lth_clean_needles(LthCleaner *c, LitheIndex *n_turned) {
  LitheStatus status = LITHE_OK;
  LitheIndex *twin = NULL, n = find_needles(c, NULL), n_first = n;
  Needle *needle = NULL;
  *n_turned = 0;
  if (n == 0) return LITHE_OK;
  LITHE_TRY_OR(done, make_twins(c, &twin));
  for (int round = 0; n > 0 && round < ROUNDS_MAX; round++) {
    lth_free(c->ctx, needle);
    LTH_NEW_OR(done, c->ctx, needle, n);
    find_needles(c, needle);
    qsort(needle, (size_t)n, sizeof *needle, compare_needles);
    LitheIndex turned = turn_round(c, twin, needle, n);
    if (turned == 0) break;
    *n_turned += turned;
    n = find_needles(c, NULL);
  }
  if (n < n_first)
    lth_warn(c->ctx, "%s: %d triangles without area removed by dividing their neighbours", c->name,
             n_first - n);
done:
  lth_free(c->ctx, needle);
  lth_free(c->ctx, twin);
  return status;
}
