/// Closest points, pseudonormals and signed distance of a closed triangle surface.
#include "geometry/bvh.h"

#include "base/tensor.h"

#include <stdlib.h>
#include <string.h>

static const double *corner(const LthSurface *s, LitheIndex tri, int k) {
  return s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
}

double lth_solid_angle(const double a[3], const double b[3], const double c[3], const double x[3]) {
  double p[3], q[3], r[3], qr[3];
  lth_v3_sub(a, x, p);
  lth_v3_sub(b, x, q);
  lth_v3_sub(c, x, r);
  lth_v3_cross(q, r, qr);
  double lp = lth_v3_norm(p), lq = lth_v3_norm(q), lr = lth_v3_norm(r);
  double below =
      lp * lq * lr + lth_v3_dot(p, q) * lr + lth_v3_dot(q, r) * lp + lth_v3_dot(r, p) * lq;
  return 2 * atan2(lth_v3_dot(p, qr), below);
}

/// Closest point of segment ab; returns its parameter, exactly 0 or 1 at the ends.
static double closest_on_segment(const double a[3], const double b[3], const double x[3],
                                 double closest[3]) {
  double ab[3], ax[3];
  lth_v3_sub(b, a, ab);
  lth_v3_sub(x, a, ax);
  double length2 = lth_v3_dot(ab, ab), t = length2 > 0 ? lth_v3_dot(ab, ax) / length2 : 0;
  if (t >= 1) {
    lth_v3_copy(b, closest);
    return 1;
  }
  lth_v3_copy(a, closest);
  if (!(t > 0)) return 0;
  lth_v3_axpy(t, ab, closest);
  return t;
}

/// True where x projects into the triangle's inside; then `closest` is that projection.
static bool project_inside(const double a[3], const double b[3], const double c[3],
                           const double x[3], double closest[3]) {
  double ab[3], ac[3], ax[3], n[3], t[3];
  lth_v3_sub(b, a, ab);
  lth_v3_sub(c, a, ac);
  lth_v3_sub(x, a, ax);
  lth_v3_cross(ab, ac, n);
  double nn = lth_v3_dot(n, n);
  if (!(nn > 0)) return false;
  lth_v3_cross(ax, ac, t);
  double v = lth_v3_dot(t, n) / nn;
  lth_v3_cross(ab, ax, t);
  double w = lth_v3_dot(t, n) / nn;
  if (!(v > 0 && w > 0 && v + w < 1)) return false;
  lth_v3_copy(a, closest);
  lth_v3_axpy(v, ab, closest);
  lth_v3_axpy(w, ac, closest);
  return true;
}

int lth_closest_on_triangle(const double a[3], const double b[3], const double c[3],
                            const double x[3], double closest[3]) {
  lth_v3_copy(a, closest); // where x is not a number
  if (project_inside(a, b, c, x, closest)) return 6;
  const double *p[3] = {a, b, c};
  double best = INFINITY;
  int part = 0;
  for (int k = 0; k < 3; k++) {
    double q[3], t = closest_on_segment(p[k], p[(k + 1) % 3], x, q), d = lth_v3_distance(q, x);
    if (!(d < best)) continue;
    best = d;
    lth_v3_copy(q, closest);
    part = t <= 0 ? k : t >= 1 ? (k + 1) % 3 : 3 + k;
  }
  return part;
}

static void make_tri_normals(const LthSurface *s, double *normal) {
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double ab[3], ac[3];
    lth_v3_sub(corner(s, t, 1), corner(s, t, 0), ab);
    lth_v3_sub(corner(s, t, 2), corner(s, t, 0), ac);
    lth_v3_cross(ab, ac, normal + 3 * (size_t)t);
    lth_v3_normalize(normal + 3 * (size_t)t);
  }
}

static void make_point_normals(const LthSurface *s, const double *tri_normal, double *normal) {
  memset(normal, 0, sizeof *normal * 3 * (size_t)s->n_points);
  for (LitheIndex t = 0; t < s->n_tris; t++)
    for (int k = 0; k < 3; k++) {
      double p[3], q[3], pq[3];
      lth_v3_sub(corner(s, t, (k + 1) % 3), corner(s, t, k), p);
      lth_v3_sub(corner(s, t, (k + 2) % 3), corner(s, t, k), q);
      lth_v3_cross(p, q, pq);
      double angle = atan2(lth_v3_norm(pq), lth_v3_dot(p, q));
      lth_v3_axpy(angle, tri_normal + 3 * (size_t)t,
                  normal + 3 * (size_t)s->tris[3 * (size_t)t + (size_t)k]);
    }
}

/// An undirected edge and the corner it starts at.
typedef struct Edge {
  LitheIndex low, high, half;
} Edge;

static int compare_edges(const void *a, const void *b) {
  const Edge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->half > q->half) - (p->half < q->half);
}

/// The triangle across every edge, -1 where there is none; of more than two the next in order, so that the
/// edges of a defective surface have some normal, too.
static LitheStatus find_neighbours(LitheCtx *ctx, const LthSurface *s, LitheIndex *across) {
  Edge *edges = NULL;
  LitheIndex n = 3 * s->n_tris;
  LTH_NEW(ctx, edges, n);
  for (LitheIndex h = 0; h < n; h++) {
    LitheIndex p = s->tris[h], q = s->tris[h / 3 * 3 + (h % 3 + 1) % 3];
    edges[h] = (Edge){p < q ? p : q, p < q ? q : p, h};
  }
  qsort(edges, (size_t)n, sizeof *edges, compare_edges);
  for (LitheIndex i = 0, j; i < n; i = j) {
    for (j = i; j < n && edges[j].low == edges[i].low && edges[j].high == edges[i].high;) j++;
    for (LitheIndex k = i; k < j; k++)
      across[edges[k].half] = j - i > 1 ? edges[k + 1 < j ? k + 1 : i].half / 3 : -1;
  }
  lth_free(ctx, edges);
  return LITHE_OK;
}

static void triangle_box(const LthSurface *s, LitheIndex t, double box[6]) {
  for (int i = 0; i < 3; i++) {
    double a = corner(s, t, 0)[i], b = corner(s, t, 1)[i], c = corner(s, t, 2)[i];
    box[i] = fmin(a, fmin(b, c));
    box[3 + i] = fmax(a, fmax(b, c));
  }
}

static void unite(double a[6], const double b[6]) {
  for (int i = 0; i < 3; i++) {
    a[i] = fmin(a[i], b[i]);
    a[3 + i] = fmax(a[3 + i], b[3 + i]);
  }
}

void lth_bvh_refit_surface(LthBvh *t) {
  for (LitheIndex node = t->n_nodes - 1; node >= 0; node--) { // children come behind their parents
    double *box = t->box + 6 * (size_t)node;
    if (t->right[node] >= 0) {
      memcpy(box, t->box + 6 * (size_t)(node + 1), 6 * sizeof *box);
      unite(box, t->box + 6 * (size_t)t->right[node]);
      continue;
    }
    for (int i = 0; i < 3; i++) box[i] = INFINITY, box[3 + i] = -INFINITY;
    for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++) {
      double of_tri[6];
      triangle_box(t->surface, t->item[i], of_tri);
      unite(box, of_tri);
    }
  }
  make_tri_normals(t->surface, t->tri_normal);
  make_point_normals(t->surface, t->tri_normal, t->point_normal);
}

LitheStatus lth_bvh_create_surface(LitheCtx *ctx, const LthSurface *surface, LthBvh **bvh) {
  LitheStatus status = LITHE_OK;
  double *boxes = NULL;
  *bvh = NULL;
  LTH_NEW(ctx, boxes, 6 * (LitheCount)surface->n_tris);
  for (LitheIndex i = 0; i < surface->n_tris; i++) triangle_box(surface, i, boxes + 6 * (size_t)i);
  LITHE_TRY_OR(done, lth_bvh_create_boxes(ctx, surface->n_tris, boxes, bvh));
  LthBvh *t = *bvh;
  t->surface = surface;
  LTH_NEW_OR(done, ctx, t->tri_normal, 3 * (LitheCount)surface->n_tris);
  LTH_NEW_OR(done, ctx, t->across, 3 * (LitheCount)surface->n_tris);
  LTH_NEW_OR(done, ctx, t->point_normal, 3 * (LitheCount)surface->n_points);
  make_tri_normals(surface, t->tri_normal);
  make_point_normals(surface, t->tri_normal, t->point_normal);
  LITHE_TRY_OR(done, find_neighbours(ctx, surface, t->across));
done:
  lth_free(ctx, boxes);
  if (status != LITHE_OK) lth_bvh_destroy(ctx, bvh);
  return status;
}

/// A search for the closest point.
typedef struct Closest {
  const LthSurface *surface;
  LthBvhAccept accept;
  const void *self;
  LthBvhPoint *best;
} Closest;

static double tri_distance2(void *self, LitheIndex tri, const double x[3], double limit) {
  Closest *closest = self;
  const LthSurface *s = closest->surface;
  double q[3], d[3];
  int part = lth_closest_on_triangle(corner(s, tri, 0), corner(s, tri, 1), corner(s, tri, 2), x, q);
  lth_v3_sub(x, q, d);
  double d2 = lth_v3_dot(d, d);
  if (!(d2 < limit) || (closest->accept && !closest->accept(closest->self, tri))) return INFINITY;
  *closest->best = (LthBvhPoint){.tri = tri, .part = part, .distance = sqrt(d2)};
  lth_v3_copy(q, closest->best->point);
  return d2;
}

bool lth_bvh_closest(const LthBvh *t, const double x[3], double reach, LthBvhAccept accept,
                     const void *self, LthBvhPoint *closest) {
  Closest search = {t->surface, accept, self, closest};
  double limit = reach * reach;
  closest->tri = -1;
  closest->distance = INFINITY;
  return lth_bvh_nearest(t, x, tri_distance2, &search, &limit) >= 0;
}

/// Sum of the unit normals of the triangles that meet in a point of the surface, by their angles.
static void pseudonormal(const LthBvh *t, const LthBvhPoint *c, double normal[3]) {
  size_t tri = (size_t)c->tri;
  if (c->part < 3) {
    lth_v3_copy(t->point_normal + 3 * (size_t)t->surface->tris[3 * tri + (size_t)c->part], normal);
    return;
  }
  lth_v3_copy(t->tri_normal + 3 * tri, normal);
  if (c->part == 6) return;
  LitheIndex other = t->across[3 * tri + (size_t)(c->part - 3)];
  if (other >= 0) lth_v3_axpy(1, t->tri_normal + 3 * (size_t)other, normal);
}

double lth_bvh_gap(const LthBvh *t, const double x[3], const LthBvhPoint *c, double normal[3]) {
  double away[3], n[3];
  pseudonormal(t, c, n);
  lth_v3_sub(x, c->point, away);
  double sign = lth_v3_dot(away, n) < 0 ? -1 : 1;
  if (!normal) return sign * c->distance;

  // next to the surface the direction is all rounding: the pseudonormal is the gradient there
  const double *box = t->box;
  double size = fmax(box[3] - box[0], fmax(box[4] - box[1], box[5] - box[2]));
  if (c->distance > 1e-9 * size) {
    lth_v3_copy(away, normal);
    lth_v3_scale(sign / c->distance, normal);
  } else {
    lth_v3_copy(n, normal);
    lth_v3_normalize(normal);
  }
  return sign * c->distance;
}

double lth_bvh_signed_distance(const LthBvh *t, const double x[3], double normal[3]) {
  LthBvhPoint closest;
  if (lth_bvh_closest(t, x, INFINITY, NULL, NULL, &closest))
    return lth_bvh_gap(t, x, &closest, normal);
  if (normal) normal[0] = normal[1] = 0, normal[2] = 1; // no triangles, or x is not a number
  return INFINITY;
}
