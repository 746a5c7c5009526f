/// The foot of a point on a triangle of another surface, its weights there, and the touch that it makes.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define BEYOND 0.5 ///< how far beside a triangle its plane is met, in weights of its corners

void lth_plane_weights(const LthSurface *s, LitheIndex tri, const double x[3], double w[3]) {
  const double *p[3];
  double n[3], e1[3], e2[3], r[3], t[3];
  for (int k = 0; k < 3; k++) p[k] = s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
  lth_v3_sub(p[1], p[0], e1);
  lth_v3_sub(p[2], p[0], e2);
  lth_v3_sub(x, p[0], r);
  lth_v3_cross(e1, e2, n);
  double nn = lth_v3_dot(n, n);
  w[0] = 1, w[1] = w[2] = 0;
  if (!(nn > 0)) return;
  lth_v3_cross(r, e2, t);
  w[1] = lth_v3_dot(t, n) / nn;
  lth_v3_cross(e1, r, t);
  w[2] = lth_v3_dot(t, n) / nn;
  w[0] = 1 - w[1] - w[2];
}

void lth_corner_weights(const LthSurface *s, LitheIndex tri, const double x[3], double w[3]) {
  lth_plane_weights(s, tri, x, w);
  w[1] = fmin(fmax(w[1], 0), 1);
  w[2] = fmin(fmax(w[2], 0), 1 - w[1]);
  w[0] = 1 - w[1] - w[2];
}

bool lth_meet_plane(const LthBvh *bvh, LitheIndex tri, const double x[3], double *gap,
                    double foot[3]) {
  const LthSurface *s = bvh->surface;
  const double *n = bvh->tri_normal + 3 * (size_t)tri;
  double w[3];
  lth_v3_sub(x, s->points + 3 * (size_t)s->tris[3 * (size_t)tri], foot);
  *gap = lth_v3_dot(foot, n);
  lth_v3_copy(x, foot);
  lth_v3_axpy(-*gap, n, foot);
  lth_plane_weights(s, tri, foot, w);
  return *gap < 0 && fmin(w[0], fmin(w[1], w[2])) > -BEYOND;
}

double lth_box_thickness(const double box[6]) {
  return fmin(box[3] - box[0], fmin(box[4] - box[1], box[5] - box[2]));
}

double lth_box_gap(const double a[6], const double b[6]) {
  double d2 = 0;
  for (int i = 0; i < 3; i++) {
    double d = fmax(fmax(a[i] - b[3 + i], b[i] - a[3 + i]), 0);
    d2 += d * d;
  }
  return sqrt(d2);
}

void lth_touch_fix(const LthSurface *surface, LitheIndex tri, const double x[3], LthTouch *touch) {
  touch->anchor_tri = tri;
  lth_corner_weights(surface, tri, x, touch->anchor);
}

void lth_touch_add_foot(const LthSurface *surface, const LthHit *hit, int side, LthTouch *touch) {
  double w[3];
  if (hit->held)
    lth_plane_weights(surface, hit->tri, hit->point, w);
  else
    lth_corner_weights(surface, hit->tri, hit->point, w);
  for (int k = 0; k < 3; k++)
    touch->leg[touch->n_legs++] =
        (LthLeg){side, surface->tris[3 * (size_t)hit->tri + (size_t)k], -w[k]};
}

/// Stretch of friction's spring at the start, and what it would be if the point went on as it does.
static void set_offset(const LthContact *c, const LthSurface *surface, const LthTouch *old,
                       LthTouch *touch, const double v[3]) {
  lth_touch_place(c, touch, touch->offset);
  for (int k = 0; k < 3; k++)
    lth_v3_axpy(-touch->anchor[k],
                surface->points +
                    3 * (size_t)surface->tris[3 * (size_t)touch->anchor_tri + (size_t)k],
                touch->offset);
  lth_v3_axpy(-lth_v3_dot(touch->offset, touch->normal), touch->normal, touch->offset);
  lth_touch_limit_stretch(c, old, touch);
  lth_touch_stretch(c, touch, v);
}

void lth_touch_meet(LthContact *c, const LthSurface *surface, const LthHit *hit, double v[3],
                    LthTouch *touch) {
  lth_v3_copy(v, touch->start);
  lth_v3_copy(hit->normal, touch->normal);
  const LthTouch *old = lth_touch_before(c, touch);
  lth_touch_begin(c, old, hit, touch);
  double end = touch->gap + c->dt * lth_v3_dot(touch->normal, v);
  touch->active = end < 0;
  touch->limit = c->friction * touch->stiffness * fmax(-end, 0);
  lth_touch_fix(surface, hit->tri, hit->point, touch);
  lth_touch_remember(c, touch, v);
  set_offset(c, surface, old, touch, v);
  lth_touch_linearize(c, touch);
}
