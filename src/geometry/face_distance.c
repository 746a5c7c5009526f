/// How far a point is from a planar face with holes.
#include "base/tensor.h"
#include "geometry/moments.h"

#include <stdbool.h>

/// Square of the distance from x to the segment a b.
static double segment_distance2(const double *a, const double *b, const double x[3]) {
  double ab[3], ax[3], r[3];
  lth_v3_sub(b, a, ab);
  lth_v3_sub(x, a, ax);
  double length2 = lth_v3_dot(ab, ab), t = length2 > 0 ? lth_v3_dot(ax, ab) / length2 : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (int i = 0; i < 3; i++) r[i] = ax[i] - t * ab[i];
  return lth_v3_dot(r, r);
}

double lth_face_distance2(const LthFaceView *face, const double x[3]) {
  double t1[3], t2[3], d[3], nearest = INFINITY;
  bool above = false;
  lth_face_frame(face->normal, t1, t2);
  for (LitheIndex l = 0; l < face->n_loops; l++)
    for (LitheIndex k = face->loop_off[l]; k < face->loop_off[l + 1]; k++) {
      LitheIndex next = k + 1 < face->loop_off[l + 1] ? k + 1 : face->loop_off[l];
      const double *a = face->points + 3 * (LitheCount)face->loop_point[k];
      const double *b = face->points + 3 * (LitheCount)face->loop_point[next];
      nearest = fmin(nearest, segment_distance2(a, b, x));
      // does the ray from x along t1 cross this edge?
      double u[3], v[3];
      lth_v3_sub(a, x, u);
      lth_v3_sub(b, x, v);
      double ua = lth_v3_dot(u, t2), vb = lth_v3_dot(v, t2);
      if ((ua > 0) == (vb > 0)) continue;
      double w = ua / (ua - vb);
      if ((1 - w) * lth_v3_dot(u, t1) + w * lth_v3_dot(v, t1) > 0) above = !above;
    }
  if (!above) return nearest;
  lth_v3_sub(x, face->points + 3 * (LitheCount)face->loop_point[face->loop_off[0]], d);
  double height = lth_v3_dot(d, face->normal);
  return height * height;
}
