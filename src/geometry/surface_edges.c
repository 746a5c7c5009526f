/// Edges of a triangle soup by radix sorting, what cancels at them, and which of them are bad.
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"

/// Stable counting sort of `items` by key(item) in [0, n_keys) into `sorted`; `start` has n_keys + 1 rows.
typedef LitheIndex (*KeyFn)(const LthCleaner *c, LitheIndex item);

static void counting_sort(const LthCleaner *c, KeyFn key, LitheIndex n, const LitheIndex *items,
                          LitheIndex *sorted, LitheIndex *start) {
  for (LitheIndex k = 0; k <= c->n_points; k++) start[k] = 0;
  for (LitheIndex i = 0; i < n; i++) start[key(c, items[i]) + 1]++;
  for (LitheIndex k = 0; k < c->n_points; k++) start[k + 1] += start[k];
  for (LitheIndex i = 0; i < n; i++) sorted[start[key(c, items[i])]++] = items[i];
}

static LitheIndex lower(const LthCleaner *c, LitheIndex half) {
  LitheIndex a = lth_clean_from(c, half), b = lth_clean_to(c, half);
  return a < b ? a : b;
}

static LitheIndex upper(const LthCleaner *c, LitheIndex half) {
  LitheIndex a = lth_clean_from(c, half), b = lth_clean_to(c, half);
  return a < b ? b : a;
}

/// Number the runs of equal edges in edge_half.
static void number_edges(LthCleaner *c) {
  LitheIndex n = 3 * c->n_tris;
  c->n_edges = 0;
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex half = c->edge_half[i];
    bool is_new = i == 0 || lower(c, half) != lower(c, c->edge_half[i - 1]) ||
                  upper(c, half) != upper(c, c->edge_half[i - 1]);
    if (is_new) c->edge_off[c->n_edges++] = i;
    c->half_edge[half] = c->n_edges - 1;
  }
  c->edge_off[c->n_edges] = n;
}

LitheStatus lth_clean_edges(LthCleaner *c) {
  LitheStatus status = LITHE_OK;
  LitheIndex *start = NULL, *by_upper = NULL, *halves = NULL, n = 3 * c->n_tris;
  if (!c->edge_off) { // the number of triangles never grows
    LTH_NEW(c->ctx, c->edge_half, n);
    LTH_NEW(c->ctx, c->half_edge, n);
    LTH_NEW(c->ctx, c->edge_off, (LitheCount)n + 1);
  }
  LTH_NEW_OR(done, c->ctx, start, (LitheCount)c->n_points + 1);
  LTH_NEW_OR(done, c->ctx, by_upper, n);
  LTH_NEW_OR(done, c->ctx, halves, n);
  for (LitheIndex i = 0; i < n; i++) halves[i] = i;
  counting_sort(c, upper, n, halves, by_upper, start);
  counting_sort(c, lower, n, by_upper, c->edge_half, start);
  number_edges(c);
done:
  lth_free(c->ctx, start);
  lth_free(c->ctx, by_upper);
  lth_free(c->ctx, halves);
  return status;
}

// ------------------------------------------------------------------ triangles that cancel

/// The k-th smallest point of a triangle.
static LitheIndex ranked(const LthCleaner *c, LitheIndex tri, int k) {
  const LitheIndex *t = c->tris + 3 * (size_t)tri;
  LitheIndex low = t[0] < t[1] ? t[0] : t[1], high = t[0] < t[1] ? t[1] : t[0];
  if (t[2] < low) return k == 0 ? t[2] : k == 1 ? low : high;
  if (t[2] > high) return k == 0 ? low : k == 1 ? high : t[2];
  return k == 0 ? low : k == 1 ? t[2] : high;
}

static LitheIndex rank0(const LthCleaner *c, LitheIndex tri) { return ranked(c, tri, 0); }
static LitheIndex rank1(const LthCleaner *c, LitheIndex tri) { return ranked(c, tri, 1); }
static LitheIndex rank2(const LthCleaner *c, LitheIndex tri) { return ranked(c, tri, 2); }

static bool same_points(const LthCleaner *c, LitheIndex s, LitheIndex t) {
  return rank0(c, s) == rank0(c, t) && rank1(c, s) == rank1(c, t) && rank2(c, s) == rank2(c, t);
}

/// +1 where the points come in rising order up to rotation, else -1.
static int parity(const LthCleaner *c, LitheIndex tri) {
  const LitheIndex *t = c->tris + 3 * (size_t)tri;
  return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2 ? 1 : -1;
}

static bool edges_are_even(const LthCleaner *c, const LitheIndex *edge_count, LitheIndex tri) {
  for (LitheIndex k = 0; k < 3; k++)
    if (edge_count[c->half_edge[3 * tri + k]] % 2) return false;
  return true;
}

static void drop(const LthCleaner *c, LitheIndex tri, LitheIndex *edge_count, bool *is_dropped) {
  is_dropped[tri] = true;
  for (LitheIndex k = 0; k < 3; k++) edge_count[c->half_edge[3 * tri + k]]--;
}

/// Drop opposite pairs in a run of triangles with the same points; returns the number of pairs.
static LitheIndex cancel_run(const LthCleaner *c, const LitheIndex *run, LitheIndex n,
                             LitheIndex *edge_count, bool *is_dropped) {
  LitheIndex pairs = 0, j = 0;
  if (n < 2 || !edges_are_even(c, edge_count, run[0])) return 0;
  // match each rising triangle with the next falling one
  for (LitheIndex i = 0; i < n; i++) {
    if (parity(c, run[i]) < 0) continue;
    while (j < n && parity(c, run[j]) > 0) j++;
    if (j == n) break;
    drop(c, run[i], edge_count, is_dropped);
    drop(c, run[j++], edge_count, is_dropped);
    pairs++;
  }
  return pairs;
}

static LitheStatus cancel_pairs(LthCleaner *c, LitheIndex *edge_count, bool *is_dropped) {
  LitheStatus status = LITHE_OK;
  LitheIndex *start = NULL, *a = NULL, *b = NULL, pairs = 0, n = c->n_tris;
  LTH_NEW_OR(done, c->ctx, start, (LitheCount)c->n_points + 1);
  LTH_NEW_OR(done, c->ctx, a, n);
  LTH_NEW_OR(done, c->ctx, b, n);
  for (LitheIndex i = 0; i < n; i++) a[i] = i;
  counting_sort(c, rank2, n, a, b, start);
  counting_sort(c, rank1, n, b, a, start);
  counting_sort(c, rank0, n, a, b, start);
  for (LitheIndex i = 0, end; i < n; i = end) {
    for (end = i + 1; end < n && same_points(c, b[i], b[end]);) end++;
    pairs += cancel_run(c, b + i, end - i, edge_count, is_dropped);
  }
  if (pairs)
    lth_warn(c->ctx, "%s: %d pairs of equal triangles that face each other dropped", c->name,
             pairs);
done:
  lth_free(c->ctx, start);
  lth_free(c->ctx, a);
  lth_free(c->ctx, b);
  return status;
}

/// A triangle without area whose three edges all have a partner too few or too many is not part of the
/// surface.
static void drop_strays(LthCleaner *c, LitheIndex *edge_count, bool *is_dropped) {
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    const LitheIndex *p = c->tris + 3 * (size_t)t;
    bool is_odd = !is_dropped[t];
    for (LitheIndex k = 0; k < 3; k++) is_odd = is_odd && edge_count[c->half_edge[3 * t + k]] % 2;
    if (!is_odd || !lth_collinear(lth_clean_point(c, p[0]), lth_clean_point(c, p[1]),
                                  lth_clean_point(c, p[2])))
      continue;
    drop(c, t, edge_count, is_dropped);
    n++;
  }
  if (n) lth_warn(c->ctx, "%s: %d stray triangles without area dropped", c->name, n);
}

static void compact(LthCleaner *c, const bool *is_dropped) {
  LitheIndex n = 0;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    if (is_dropped[t]) continue;
    for (size_t k = 0; k < 3; k++) c->tris[3 * (size_t)n + k] = c->tris[3 * (size_t)t + k];
    c->tri_poly[n] = c->tri_poly[t];
    c->tri_is_mixed[n++] = c->tri_is_mixed[t];
  }
  c->n_tris = n;
}

LitheStatus lth_clean_reduce(LthCleaner *c) {
  LitheStatus status = LITHE_OK;
  LitheIndex *edge_count = NULL, before = c->n_tris;
  bool *is_dropped = NULL;
  LITHE_TRY(lth_clean_edges(c));
  LTH_NEW_OR(done, c->ctx, edge_count, c->n_edges);
  LTH_NEW_OR(done, c->ctx, is_dropped, c->n_tris);
  for (LitheIndex e = 0; e < c->n_edges; e++) edge_count[e] = c->edge_off[e + 1] - c->edge_off[e];
  LITHE_TRY_OR(done, cancel_pairs(c, edge_count, is_dropped));
  drop_strays(c, edge_count, is_dropped);
  compact(c, is_dropped);
  if (c->n_tris < before) LITHE_TRY_OR(done, lth_clean_edges(c));
  if (c->n_tris == 0)
    status =
        lth_fail(c->ctx, LITHE_BAD_INPUT,
                 "%s: no triangle that bounds a volume is left, expected a closed solid", c->name);
done:
  lth_free(c->ctx, edge_count);
  lth_free(c->ctx, is_dropped);
  return status;
}

LitheStatus lth_clean_find_bad_edges(LthCleaner *c) {
  for (LitheIndex e = 0; e < c->n_edges; e++) {
    LitheIndex n = c->edge_off[e + 1] - c->edge_off[e], half = c->edge_half[c->edge_off[e]];
    if (n == 2) continue;
    LITHE_TRY(lth_defects_add(
        c->ctx, c->defects, n == 1 ? LTH_DEFECT_OPEN_EDGE : LTH_DEFECT_NON_MANIFOLD,
        lth_clean_point(c, lth_clean_from(c, half)), lth_clean_point(c, lth_clean_to(c, half))));
  }
  return LITHE_OK;
}
