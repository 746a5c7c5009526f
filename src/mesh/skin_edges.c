/// Edges in which a body touches itself: four and more polygons have them. Every two between which the body lies get an edge of
/// their own, which passes a point in the middle, so that each edge of a skin has two polygons.
#include "mesh/skin_priv.h"

#include <math.h>
#include <stdlib.h>

#define SAME_ANGLE 1e-7 ///< polygons of a cut that look at each other, but for rounding

/// An edge as a polygon has it.
typedef struct Use {
  LitheIndex low, high, poly, corner; ///< corner: of the polygon, where the edge begins
  int direction;                      ///< 1: from the lower number to the higher, -1
  double angle;                       ///< about the edge, from lower to higher number
  LitheIndex other;                   ///< of the pair, -1
} Use;

/// Parting of edges in progress.
typedef struct Edges {
  SkinWork *w;
  bool *is_cut; ///< points that lie on cuts                              (n_points)
  Use *use;
  LitheIndex n, n_inserted, n_middles;
  LitheCount cap, middles_cap;
  LitheIndex *inserted; ///< point + 1 behind each corner of the polygons      (n_corners_out)
  LitheIndex *middles;  ///< points that were put into edges before and are free, -1: taken again
  bool has_middles;
} Edges;

static int compare_uses(const void *a, const void *b) {
  const Use *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->corner > q->corner) - (p->corner < q->corner);
}

/// Only points of cuts can have more than two polygons at their edges that had two before.
static LitheStatus list_uses(LitheCtx *ctx, Edges *e) {
  const SkinWork *w = e->w;
  const LthSoup *s = &w->out;
  LTH_NEW(ctx, e->is_cut, w->skin->soup->n_points);
  for (LitheIndex node = w->t->n_points; node < w->n_nodes; node++)
    if (w->number[node] >= 0) e->is_cut[w->number[node]] = true;
  for (LitheIndex p = 0; p < s->n_polys; p++)
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++) {
      LitheIndex a = s->poly_point[i],
                 b = s->poly_point[i + 1 < s->poly_off[p + 1] ? i + 1 : s->poly_off[p]];
      if (!e->is_cut[a] || !e->is_cut[b]) continue;
      LTH_RESERVE(ctx, e->use, e->cap, (LitheCount)e->n + 1);
      e->use[e->n++] = (Use){.low = a < b ? a : b,
                             .high = a < b ? b : a,
                             .poly = p,
                             .corner = i,
                             .direction = a < b ? 1 : -1,
                             .other = -1};
    }
  if (e->n > 0) qsort(e->use, (size_t)e->n, sizeof *e->use, compare_uses);
  return LITHE_OK;
}

// ------------------------------------------------------------------ pairs

static void swap_uses(Use *a, Use *b) {
  Use moved = *a;
  *a = *b;
  *b = moved;
}

/// Sort by angle about the edge. Of two sides of a cut at one angle the one that ends what lies before it comes first.
static void sort_around(const Edges *e, Use *use, LitheIndex n) {
  const LthSoup *s = &e->w->out;
  const double *points = e->w->skin->soup->points;
  double d[3], u[3], v[3], normal[3], inside[3];
  lth_v3_sub(points + 3 * (LitheCount)use->high, points + 3 * (LitheCount)use->low, d);
  lth_v3_normalize(d);
  lth_face_frame(d, u, v);
  for (LitheIndex i = 0; i < n; i++) {
    const LitheIndex first = s->poly_off[use[i].poly];
    lth_polygon_normal(points, s->poly_off[use[i].poly + 1] - first, s->poly_point + first, normal);
    lth_v3_cross(normal, d, inside);
    lth_v3_scale(use[i].direction, inside);
    use[i].angle = atan2(lth_v3_dot(inside, v), lth_v3_dot(inside, u));
    for (LitheIndex k = i; k > 0 && use[k].angle < use[k - 1].angle; k--)
      swap_uses(use + k, use + k - 1);
  }
  for (LitheIndex i = 0; i < n; i++) {
    Use *a = use + i, *b = use + (i + 1) % n;
    double turn = fabs(a->angle - b->angle);
    bool is_same = turn < SAME_ANGLE || turn > 2 * M_PI - SAME_ANGLE;
    if (is_same && a->direction < 0 && b->direction > 0) swap_uses(a, b);
  }
}

/// About the edge the body goes on, counter-clockwise, from each polygon that runs down to the next that runs up: these are a pair.
/// Where they do not alternate those in between are paired first.
static void find_pairs(Use *use, LitheIndex n) {
  for (LitheIndex n_left = n; n_left > 0;)
    for (LitheIndex i = 0; i < n; i++) {
      LitheIndex next = i;
      if (use[i].other >= 0 || use[i].direction > 0) continue;
      do next = (next + 1) % n;
      while (use[next].other >= 0);
      if (use[next].direction < 0) continue;
      use[i].other = next;
      use[next].other = i;
      n_left -= 2;
    }
}

// ------------------------------------------------------------------ middles

static LitheStatus list_middles(LitheCtx *ctx, Edges *e) {
  const LthSkin *skin = e->w->skin;
  if (e->has_middles) return LITHE_OK;
  e->has_middles = true;
  for (LitheIndex i = skin->first->n_points; i < e->w->n_before; i++) {
    if (skin->point[i] >= 0) continue;
    LTH_RESERVE(ctx, e->middles, e->middles_cap, (LitheCount)e->n_middles + 1);
    e->middles[e->n_middles++] = i;
  }
  return LITHE_OK;
}

/// A point in the middle of an edge: one that was there before, or a new one.
static LitheStatus find_middle(LitheCtx *ctx, Edges *e, const Use *use, LitheIndex cell,
                               LitheIndex *number) {
  LthSkin *skin = e->w->skin;
  const double *a = skin->soup->points + 3 * (LitheCount)use->low,
               *b = skin->soup->points + 3 * (LitheCount)use->high;
  double x[3];
  for (int k = 0; k < 3; k++) x[k] = a[k] + 0.5 * (b[k] - a[k]);
  LITHE_TRY(list_middles(ctx, e));
  for (LitheIndex i = 0; i < e->n_middles; i++) {
    *number = e->middles[i];
    if (*number < 0 || memcmp(skin->place + 3 * (LitheCount)*number, x, sizeof x) != 0) continue;
    e->middles[i] = -1;
    skin->cell[*number] = cell;
    return LITHE_OK;
  }
  return lth_skin_add_point(ctx, skin, x, -1, cell, number);
}

/// Put a middle into both polygons of a pair. Faces of cuts say which element they bound.
static LitheStatus insert_middle(LitheCtx *ctx, Edges *e, const Use *p, const Use *q) {
  const LitheIndex *cell = e->w->poly_cell;
  LitheIndex middle = -1, first_cap = e->w->out.n_polys - e->w->skin->n_caps;
  LITHE_TRY(find_middle(ctx, e, p, cell[p->poly >= first_cap ? p->poly : q->poly], &middle));
  e->inserted[p->corner] = e->inserted[q->corner] = middle + 1;
  e->n_inserted += 2;
  return LITHE_OK;
}

static LitheStatus part_edge(LitheCtx *ctx, Edges *e, Use *use, LitheIndex n) {
  LitheIndex sum = 0, first = 0;
  for (LitheIndex i = 0; i < n; i++) sum += use[i].direction;
  if (n <= 2 || sum != 0) return LITHE_OK;
  if (!e->inserted) LTH_NEW(ctx, e->inserted, e->w->n_corners_out);
  sort_around(e, use, n);
  find_pairs(use, n);
  for (LitheIndex i = 0; i < n; i++)
    if (use[i].corner < use[first].corner) first = i;
  for (LitheIndex i = 0; i < n; i++) {
    if (use[i].direction > 0 || i == first || use[i].other == first) continue;
    LITHE_TRY(insert_middle(ctx, e, use + i, use + use[i].other));
  }
  return LITHE_OK;
}

// ------------------------------------------------------------------ polygons

/// Texture in the middle of the edge behind a corner; -1: none.
static LitheStatus middle_uv(LitheCtx *ctx, SkinWork *w, LitheIndex p, LitheIndex q,
                             LitheIndex *uv) {
  LitheIndex a = w->out.poly_uv[p], b = w->out.poly_uv[q];
  *uv = -1;
  if (a < 0 || b < 0) return LITHE_OK;
  const double *s = w->out.uvs + 2 * (LitheCount)a, *t = w->out.uvs + 2 * (LitheCount)b;
  return lth_skin_add_uv(ctx, w, 0.5 * (s[0] + t[0]), 0.5 * (s[1] + t[1]), uv);
}

static LitheStatus write_middles(LitheCtx *ctx, const Edges *e) {
  SkinWork *w = e->w;
  LthSoup *s = &w->out;
  LitheStatus status = LITHE_OK;
  LitheIndex *point = NULL, *uv = NULL, to = 0;
  LTH_NEW_OR(done, ctx, point, w->n_corners_out + e->n_inserted);
  LTH_NEW_OR(done, ctx, uv, w->n_corners_out + e->n_inserted);
  for (LitheIndex p = 0; p < s->n_polys; p++) {
    LitheIndex begin = s->poly_off[p], end = s->poly_off[p + 1];
    s->poly_off[p] = to;
    for (LitheIndex i = begin; i < end; i++) {
      point[to] = s->poly_point[i];
      uv[to++] = s->poly_uv[i];
      if (e->inserted[i] == 0) continue;
      point[to] = e->inserted[i] - 1;
      LITHE_TRY_OR(done, middle_uv(ctx, w, i, i + 1 < end ? i + 1 : begin, uv + to++));
    }
    if (p + 1 == s->n_polys) s->poly_off[s->n_polys] = to;
  }
done:
  lth_free(ctx, status == LITHE_OK ? s->poly_point : point);
  lth_free(ctx, status == LITHE_OK ? s->poly_uv : uv);
  if (status == LITHE_OK) s->poly_point = point, s->poly_uv = uv;
  return status;
}

LitheStatus lth_skin_part_edges(LitheCtx *ctx, SkinWork *w) {
  LitheStatus status = LITHE_OK;
  Edges e = {.w = w};
  LITHE_TRY_OR(done, list_uses(ctx, &e));
  for (LitheIndex i = 0, j; i < e.n; i = j) {
    for (j = i + 1; j < e.n && e.use[j].low == e.use[i].low && e.use[j].high == e.use[i].high;) j++;
    LITHE_TRY_OR(done, part_edge(ctx, &e, e.use + i, j - i));
  }
  if (e.n_inserted > 0) status = write_middles(ctx, &e);
done:
  lth_free(ctx, e.is_cut);
  lth_free(ctx, e.use);
  lth_free(ctx, e.inserted);
  lth_free(ctx, e.middles);
  return status;
}
