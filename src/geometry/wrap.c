/// From a soup to triangles with a winding number: cleaned without asking for a solid, and what was found.
#include "geometry/wrap.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"
#include "geometry/tri_tri.h"

#include <stdlib.h>

#define STACK_MAX 96

/// Sums of solid angles that are worth making to find shells that are inside out.
#define TURN_WORK_MAX 1e9

/// --- equal triangles ---

/// A triangle by its points in rising order.
typedef struct Key {
  LitheIndex low, mid, high, tri;
  int parity; ///< +1 where the triangle runs through them in that order, else -1
} Key;

static int compare_keys(const void *a, const void *b) {
  const Key *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->mid != q->mid) return p->mid < q->mid ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->tri > q->tri) - (p->tri < q->tri);
}

static void swap(LitheIndex *a, LitheIndex *b) {
  LitheIndex t = *a;
  *a = *b;
  *b = t;
}

static Key key_of(const LthCleaner *c, LitheIndex tri) {
  const LitheIndex *t = c->tris + 3 * (size_t)tri;
  Key k = {t[0], t[1], t[2], tri, 1};
  if (k.low > k.mid) swap(&k.low, &k.mid), k.parity = -k.parity;
  if (k.mid > k.high) swap(&k.mid, &k.high), k.parity = -k.parity;
  if (k.low > k.mid) swap(&k.low, &k.mid), k.parity = -k.parity;
  return k;
}

static bool same_points(const Key *a, const Key *b) {
  return a->low == b->low && a->mid == b->mid && a->high == b->high;
}

/// Of a run of equal triangles the first of the sense that most have stays, none where they cancel.
static void mark_run(const Key *run, LitheCount n, bool *is_dropped) {
  int sum = 0;
  for (LitheCount i = 0; i < n; i++) sum += run[i].parity;
  bool is_kept = false;
  for (LitheCount i = 0; i < n; i++) {
    bool keep = !is_kept && run[i].parity * sum > 0;
    is_dropped[run[i].tri] = !keep;
    is_kept = is_kept || keep;
  }
}

static LitheStatus merge_repeated(LthCleaner *c, LthWrap *w) {
  LitheStatus status = LITHE_OK;
  Key *keys = NULL;
  bool *is_dropped = NULL;
  LitheIndex n = 0;
  LTH_NEW_OR(done, c->ctx, keys, c->n_tris);
  LTH_NEW_OR(done, c->ctx, is_dropped, c->n_tris);
  for (LitheIndex t = 0; t < c->n_tris; t++) keys[t] = key_of(c, t);
  qsort(keys, (size_t)c->n_tris, sizeof *keys, compare_keys);
  for (LitheIndex i = 0, end; i < c->n_tris; i = end) {
    for (end = i + 1; end < c->n_tris && same_points(keys + i, keys + end);) end++;
    if (end - i > 1) mark_run(keys + i, end - i, is_dropped);
  }
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    if (is_dropped[t]) continue;
    memmove(c->tris + 3 * (size_t)n, c->tris + 3 * (size_t)t, 3 * sizeof *c->tris);
    c->tri_poly[n++] = c->tri_poly[t];
  }
  w->n_repeated = c->n_tris - n;
  c->n_tris = n;
  if (n == 0)
    status = lth_fail(c->ctx, LITHE_BAD_INPUT,
                      "%s: no triangle that bounds a volume is left, expected a solid", c->name);
done:
  lth_free(c->ctx, keys);
  lth_free(c->ctx, is_dropped);
  return status;
}

/// --- shells that are inside out ---

static double solid_angle(const LthCleaner *c, LitheIndex tri, const double x[3]) {
  const LitheIndex *t = c->tris + 3 * (size_t)tri;
  return lth_solid_angle(lth_clean_point(c, t[0]), lth_clean_point(c, t[1]),
                         lth_clean_point(c, t[2]), x);
}

/// Volume under each shell's triangles about the box's centre, and whether the shell is closed.
static void measure_shells(const LthCleaner *c, double *volume, bool *is_closed,
                           LitheIndex *first) {
  double center[3], a[3][3], cross[3];
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (c->min[i] + c->max[i]);
  for (LitheIndex s = 0; s < c->n_shells; s++) is_closed[s] = true, first[s] = -1;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    LitheIndex s = c->tri_shell[t];
    if (first[s] < 0) first[s] = t;
    for (int k = 0; k < 3; k++) {
      LitheIndex edge = c->half_edge[3 * t + k];
      if (c->edge_off[edge + 1] - c->edge_off[edge] != 2) is_closed[s] = false;
      lth_v3_sub(lth_clean_point(c, c->tris[3 * (size_t)t + (size_t)k]), center, a[k]);
    }
    lth_v3_cross(a[1], a[2], cross);
    volume[s] += lth_v3_dot(a[0], cross) / 6;
  }
}

/// Winding number of all but one shell at that shell's first triangle: a cavity lies within others.
static double wound_by_others(const LthCleaner *c, LitheIndex shell, LitheIndex first) {
  double x[3] = {0, 0, 0}, sum = 0;
  for (int k = 0; k < 3; k++)
    lth_v3_axpy(1.0 / 3, lth_clean_point(c, c->tris[3 * (size_t)first + (size_t)k]), x);
  for (LitheIndex t = 0; t < c->n_tris; t++)
    if (c->tri_shell[t] != shell) sum += solid_angle(c, t, x);
  return sum / (4 * M_PI);
}

static void turn_marked(LthCleaner *c, const bool *is_turned) {
  for (LitheIndex t = 0; t < c->n_tris; t++)
    if (is_turned[c->tri_shell[t]]) swap(&c->tris[3 * (size_t)t + 1], &c->tris[3 * (size_t)t + 2]);
}

/// Closed shells with inward volume that no other shell surrounds, and all open shells where together they
/// face inwards.
static void mark_turned(const LthCleaner *c, const double *volume, const bool *is_closed,
                        const LitheIndex *first, bool *is_turned) {
  double work = 0, open_volume = 0;
  for (LitheIndex s = 0; s < c->n_shells; s++) {
    if (!is_closed[s]) open_volume += volume[s];
    if (!is_closed[s] || volume[s] >= 0 || (work += c->n_tris) > TURN_WORK_MAX) continue;
    is_turned[s] = wound_by_others(c, s, first[s]) < 0.5;
  }
  if (open_volume >= 0) return;
  for (LitheIndex s = 0; s < c->n_shells; s++) is_turned[s] = is_turned[s] || !is_closed[s];
}

static LitheStatus turn_shells(LthCleaner *c, LthWrap *w) {
  LitheStatus status = LITHE_OK;
  double *volume = NULL;
  bool *is_closed = NULL, *is_turned = NULL;
  LitheIndex *first = NULL;
  LTH_NEW_OR(done, c->ctx, volume, c->n_shells);
  LTH_NEW_OR(done, c->ctx, is_closed, c->n_shells);
  LTH_NEW_OR(done, c->ctx, is_turned, c->n_shells);
  LTH_NEW_OR(done, c->ctx, first, c->n_shells);
  measure_shells(c, volume, is_closed, first);
  mark_turned(c, volume, is_closed, first, is_turned);
  turn_marked(c, is_turned);
  for (LitheIndex s = 0; s < c->n_shells; s++) w->n_turned_shells += is_turned[s];
done:
  lth_free(c->ctx, volume);
  lth_free(c->ctx, is_closed);
  lth_free(c->ctx, is_turned);
  lth_free(c->ctx, first);
  return status;
}

/// --- holes ---

static bool is_open(const LthCleaner *c, LitheIndex edge) {
  return c->edge_off[edge + 1] - c->edge_off[edge] == 1;
}

/// Connected open edges are one hole; the largest by the diagonal of its box.
static LitheStatus find_holes(LthCleaner *c, LthWrap *w) {
  LitheStatus status = LITHE_OK;
  LitheIndex *parent = NULL;
  double *box = NULL;
  LTH_NEW_OR(done, c->ctx, parent, c->n_points);
  LTH_NEW_OR(done, c->ctx, box, 6 * (LitheCount)c->n_points);
  lth_sets_reset(parent, c->n_points);
  for (LitheIndex i = 0; i < 6 * c->n_points; i++) box[i] = i % 6 < 3 ? INFINITY : -INFINITY;
  for (LitheIndex e = 0; e < c->n_edges; e++) {
    LitheIndex half = c->edge_half[c->edge_off[e]];
    w->n_crowded_edges += c->edge_off[e + 1] - c->edge_off[e] > 2;
    if (!is_open(c, e)) continue;
    w->n_open_edges++;
    lth_sets_unite(parent, lth_clean_from(c, half), lth_clean_to(c, half));
  }
  for (LitheIndex e = 0; e < c->n_edges; e++) {
    if (!is_open(c, e)) continue;
    LitheIndex half = c->edge_half[c->edge_off[e]];
    const double *a = lth_clean_point(c, lth_clean_from(c, half)),
                 *b = lth_clean_point(c, lth_clean_to(c, half));
    double *hole = box + 6 * (size_t)lth_sets_root(parent, lth_clean_from(c, half));
    for (int i = 0; i < 3; i++) {
      hole[i] = fmin(hole[i], fmin(a[i], b[i]));
      hole[3 + i] = fmax(hole[3 + i], fmax(a[i], b[i]));
    }
  }
  for (LitheIndex p = 0; p < c->n_points; p++) {
    const double *hole = box + 6 * (size_t)p;
    if (!(hole[0] <= hole[3])) continue;
    w->n_holes++;
    w->largest_hole = fmax(w->largest_hole, lth_v3_distance(hole, hole + 3));
  }
done:
  lth_free(c->ctx, parent);
  lth_free(c->ctx, box);
  return status;
}

/// --- crossings ---

static bool is_flat(const LthSurface *s, LitheIndex tri) {
  const LitheIndex *p = s->tris + 3 * (size_t)tri;
  return lth_collinear(s->points + 3 * (size_t)p[0], s->points + 3 * (size_t)p[1],
                       s->points + 3 * (size_t)p[2]);
}

/// Does a triangle cross another? Triangles without area do not.
static bool crosses_others(const LthBvh *t, LitheIndex tri) {
  const LthSurface *s = t->surface;
  LitheIndex stack[STACK_MAX];
  double box[6];
  int top = 0;
  if (is_flat(s, tri)) return false;
  for (int a = 0; a < 3; a++) {
    box[a] = INFINITY, box[3 + a] = -INFINITY;
    for (int c = 0; c < 3; c++) {
      double x = s->points[3 * (size_t)s->tris[3 * (size_t)tri + (size_t)c] + (size_t)a];
      box[a] = fmin(box[a], x);
      box[3 + a] = fmax(box[3 + a], x);
    }
  }
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (!lth_boxes_meet(t->box + 6 * (size_t)node, box)) continue;
    if (t->right[node] >= 0) {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = t->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++) {
      LitheIndex other = t->item[i];
      if (other != tri && !is_flat(s, other) &&
          lth_triangles_cross(s->points, s->tris + 3 * (size_t)tri, s->tris + 3 * (size_t)other))
        return true;
    }
  }
  return false;
}

static LitheStatus find_crossings(LitheCtx *ctx, LthWrap *w) {
  LTH_NEW(ctx, w->crosses, w->raw->n_tris);
#pragma omp parallel for schedule(dynamic, 256) num_threads(lth_threads(ctx))
  for (LitheIndex t = 0; t < w->raw->n_tris; t++) w->crosses[t] = crosses_others(w->bvh, t);
  return LITHE_OK;
}

/// --- all of it ---

static LitheStatus clean(LthCleaner *c, LthWrap *w) {
  LITHE_TRY(lth_clean_weld(c));
  LITHE_TRY(lth_clean_triangulate(c));
  LTH_NEW(c->ctx, c->tri_is_mixed, c->n_tris);
  LTH_NEW(c->ctx, c->tri_shell, c->n_tris);
  LITHE_TRY(merge_repeated(c, w));
  LITHE_TRY(lth_clean_edges(c));
  LITHE_TRY(find_holes(c, w));
  LITHE_TRY(lth_clean_orient(c));
  w->n_one_sided = c->defects->count[LTH_DEFECT_UNORIENTABLE];
  return turn_shells(c, w);
}

static LitheStatus take_raw(LthCleaner *c, LthWrap *w) {
  LTH_NEW(c->ctx, w->raw, 1);
  LthSurface *s = w->raw;
  s->n_points = c->n_points;
  s->n_tris = c->n_tris;
  s->n_shells = c->n_shells;
  s->n_soup_points = c->soup->n_points;
  s->points = c->points, c->points = NULL;
  s->tris = c->tris, c->tris = NULL;
  s->tri_shell = c->tri_shell, c->tri_shell = NULL;
  s->tri_poly = c->tri_poly, c->tri_poly = NULL;
  s->soup_point = c->soup_point, c->soup_point = NULL;
  lth_surface_bounds(s, w->box, w->box + 3);
  w->size = lth_v3_distance(w->box, w->box + 3);
  LITHE_TRY(lth_bvh_create_surface(c->ctx, s, &w->bvh));
  LITHE_TRY(lth_rim_create(c->ctx, s, &w->rim));
  LITHE_TRY(find_crossings(c->ctx, w));
  return lth_winding_create(c->ctx, s->n_tris, s->points, s->tris, &w->winding);
}

static void cleaner_free(LthCleaner *c) {
  void *blocks[] = {c->points,    c->soup_point, c->tris,      c->tri_poly,  c->tri_is_mixed,
                    c->tri_shell, c->edge_off,   c->edge_half, c->half_edge, c->pair};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(c->ctx, blocks[i]);
}

LitheStatus lth_wrap_create(LitheCtx *ctx, const LthSoup *soup, const char *name, LthWrap **wrap) {
  LitheStatus status = LITHE_OK;
  LthDefects defects = {0};
  LthCleaner c = {.ctx = ctx, .name = name, .soup = soup, .defects = &defects};
  LthWrap *w = NULL;
  *wrap = NULL;
  LTH_NEW_OR(done, ctx, w, 1);
  LITHE_TRY_OR(done, clean(&c, w));
  LITHE_TRY_OR(done, take_raw(&c, w));
  *wrap = w;
  w = NULL;
done:
  cleaner_free(&c);
  lth_defects_free(ctx, &defects);
  lth_wrap_destroy(ctx, &w);
  return status;
}

void lth_wrap_destroy(LitheCtx *ctx, LthWrap **wrap) {
  if (!wrap || !*wrap) return;
  LthWrap *w = *wrap;
  lth_winding_destroy(ctx, &w->winding);
  lth_bvh_destroy(ctx, &w->bvh);
  lth_rim_destroy(ctx, &w->rim);
  lth_free(ctx, w->crosses);
  lth_surface_destroy(ctx, &w->raw);
  lth_free(ctx, w);
  *wrap = NULL;
}

bool lth_wrap_inside(const LthWrap *w, const double x[3]) {
  for (int i = 0; i < 3; i++)
    if (!(x[i] >= w->box[i] && x[i] <= w->box[3 + i])) return false;
  return lth_winding_inside(w->winding, x);
}

double lth_wrap_value(const LthWrap *w, const double x[3]) {
  double distance = fabs(lth_bvh_signed_distance(w->bvh, x, NULL));
  return lth_wrap_inside(w, x) ? -distance : distance;
}
