/// The foot of a point on a triangle of the other body, and its weights there.
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
