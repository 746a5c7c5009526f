/// Dividing the triangles of a closed surface until no edge is longer than wanted.
#include "base/tensor.h"
#include "geometry/surface.h"

#include <stdlib.h>

/// An edge of a triangle by its end points; `corner` is 3 triangle + the corner it starts at.
typedef struct Edge {
  LitheIndex low, high, corner;
} Edge;

static int compare_edges(const void *a, const void *b) {
  const Edge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->corner > q->corner) - (p->corner < q->corner);
}

/// Number the midpoints of edges longer than `length`: middle (n_tris x 3), -1 where an edge stays. Returns how many.
static LitheIndex number_middles(const LthSurface *s, double length, Edge *edges,
                                 LitheIndex *middle) {
  LitheIndex n = 3 * s->n_tris, count = 0;
  for (LitheIndex h = 0; h < n; h++) {
    LitheIndex p = s->tris[h], q = s->tris[h / 3 * 3 + (h % 3 + 1) % 3];
    edges[h] = (Edge){p < q ? p : q, p < q ? q : p, h};
  }
  qsort(edges, (size_t)n, sizeof *edges, compare_edges);
  for (LitheIndex i = 0, j; i < n; i = j) {
    const double *p = s->points + 3 * (size_t)edges[i].low;
    bool is_long = lth_v3_distance(p, s->points + 3 * (size_t)edges[i].high) > length;
    for (j = i; j < n && edges[j].low == edges[i].low && edges[j].high == edges[i].high; j++)
      middle[edges[j].corner] = is_long ? s->n_points + count : -1;
    count += is_long;
  }
  return count;
}

/// The parts of one triangle (at most four) by which of its edges have a middle.
static int divide(const LitheIndex tri[3], const LitheIndex middle[3], LitheIndex part[4][3]) {
  int n_long = (middle[0] >= 0) + (middle[1] >= 0) + (middle[2] >= 0), first = 0;
  if (n_long == 1)
    while (middle[first] < 0) first++;
  if (n_long == 2) // start behind the edge that stays
    while (middle[(first + 2) % 3] >= 0) first++;
  const LitheIndex a = tri[first], b = tri[(first + 1) % 3], c = tri[(first + 2) % 3];
  const LitheIndex ab = middle[first], bc = middle[(first + 1) % 3], ca = middle[(first + 2) % 3];
  const LitheIndex whole[1][3] = {{a, b, c}}, two[2][3] = {{a, ab, c}, {ab, b, c}},
                   three[3][3] = {{ab, b, bc}, {a, ab, bc}, {a, bc, c}},
                   four[4][3] = {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
  const LitheIndex(*from)[3] = n_long == 0 ? whole : n_long == 1 ? two : n_long == 2 ? three : four;
  memcpy(part, from, sizeof(LitheIndex) * 3 * (size_t)(n_long + 1));
  return n_long + 1;
}

/// One round: every edge that is too long is halved.
static LitheStatus refine_once(LitheCtx *ctx, const LthSurface *s, double length, LthSurface **out,
                               bool *changed) {
  LitheStatus status = LITHE_OK;
  Edge *edges = NULL;
  LitheIndex *middle = NULL;
  LthSurface *r = NULL;
  LTH_NEW_OR(done, ctx, edges, 3 * (LitheCount)s->n_tris);
  LTH_NEW_OR(done, ctx, middle, 3 * (LitheCount)s->n_tris);
  LitheIndex n_new = number_middles(s, length, edges, middle);
  LitheCount n_tris = s->n_tris;
  for (LitheIndex h = 0; h < 3 * s->n_tris; h++) n_tris += middle[h] >= 0;
  *changed = n_new > 0;
  LTH_NEW_OR(done, ctx, r, 1);
  r->n_points = s->n_points + n_new, r->n_shells = s->n_shells;
  LTH_NEW_OR(done, ctx, r->points, 3 * (LitheCount)r->n_points);
  LTH_NEW_OR(done, ctx, r->tris, 3 * n_tris);
  LTH_NEW_OR(done, ctx, r->tri_shell, n_tris);
  LTH_NEW_OR(done, ctx, r->tri_poly, n_tris);
  if (s->n_points > 0) // a crumb may have no triangles left
    memcpy(r->points, s->points, sizeof *s->points * 3 * (size_t)s->n_points);
  for (LitheIndex i = 0; i < 3 * s->n_tris; i++) {
    const Edge *e = &edges[i];
    if (middle[e->corner] < 0) continue;
    double *m = r->points + 3 * (size_t)middle[e->corner];
    for (int a = 0; a < 3; a++)
      m[a] = 0.5 * (s->points[3 * (size_t)e->low + (size_t)a] +
                    s->points[3 * (size_t)e->high + (size_t)a]);
  }
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    LitheIndex part[4][3];
    int n = divide(s->tris + 3 * (size_t)t, middle + 3 * (size_t)t, part);
    memcpy(r->tris + 3 * (size_t)r->n_tris, part, sizeof **part * 3 * (size_t)n);
    for (int k = 0; k < n; k++, r->n_tris++) {
      r->tri_shell[r->n_tris] = s->tri_shell[t];
      r->tri_poly[r->n_tris] = s->tri_poly[t];
    }
  }
done:
  lth_free(ctx, edges);
  lth_free(ctx, middle);
  if (status != LITHE_OK) lth_surface_destroy(ctx, &r);
  *out = r;
  return status;
}

LitheStatus lth_surface_refine(LitheCtx *ctx, const LthSurface *surface, double length,
                               LthSurface **refined) {
  bool changed = true;
  *refined = NULL;
  while (changed) {
    LthSurface *next = NULL;
    LitheStatus status = refine_once(ctx, *refined ? *refined : surface, length, &next, &changed);
    lth_surface_destroy(ctx, refined);
    LITHE_TRY(status);
    *refined = next;
  }
  return LITHE_OK;
}
