/// Where a plane passes through a cell, and a point inside it.
#include "mesh/topology_section.h"

#include "base/tensor.h"
#include "geometry/bvh.h"

#include <math.h>

void lth_section_free(LitheCtx *ctx, LthSection *section) {
  lth_free(ctx, section->ends);
  lth_free(ctx, section->along);
  *section = (LthSection){0};
}

#define ON_PLANE 1e-12 ///< of a cell: corners that close to the plane lie in it

/// Height above a plane, 0 for what is within `reach`.
static double height_of(const LthPlane *plane, double reach, const double x[3]) {
  double d[3];
  lth_v3_sub(x, plane->point, d);
  double height = lth_v3_dot(plane->normal, d);
  return fabs(height) > reach ? height : 0;
}

/// Append the place where the edge a b meets the plane, if it does, with its height along the line of the cut, sorted.
static LitheStatus cross_edge(LitheCtx *ctx, LthSection *s, const LthPlane *plane,
                              const double line[3], const double *a, const double *b, double reach,
                              LitheIndex *n) {
  double ha = height_of(plane, reach, a), hb = height_of(plane, reach, b), x[4];
  if ((ha >= 0) == (hb >= 0)) return LITHE_OK;
  for (int i = 0; i < 3; i++) x[i] = a[i] + ha / (ha - hb) * (b[i] - a[i]);
  x[3] = lth_v3_dot(line, x);
  LTH_RESERVE(ctx, s->along, s->along_cap, 4 * ((LitheCount)*n + 1));
  LitheIndex at = (*n)++;
  for (; at > 0 && s->along[4 * (at - 1) + 3] > x[3]; at--)
    memcpy(s->along + 4 * (LitheCount)at, s->along + 4 * (LitheCount)(at - 1), sizeof x);
  memcpy(s->along + 4 * (LitheCount)at, x, sizeof x);
  return LITHE_OK;
}

/// Between crossings of odd and of even number the line of the cut is inside the face.
static LitheStatus add_face(LitheCtx *ctx, LthSection *s, const LthPlane *plane,
                            const LthFaceView *face, double reach) {
  double line[3];
  LitheIndex n = 0;
  lth_v3_cross(face->normal, plane->normal, line);
  for (LitheIndex l = 0; l < face->n_loops; l++)
    for (LitheIndex i = face->loop_off[l]; i < face->loop_off[l + 1]; i++) {
      LitheIndex next = i + 1 < face->loop_off[l + 1] ? i + 1 : face->loop_off[l];
      LITHE_TRY(cross_edge(ctx, s, plane, line, face->points + 3 * (size_t)face->loop_point[i],
                           face->points + 3 * (size_t)face->loop_point[next], reach, &n));
    }
  LTH_RESERVE(ctx, s->ends, s->ends_cap, 6 * ((LitheCount)s->n + n / 2));
  for (LitheIndex i = 0; i + 1 < n; i += 2, s->n++) {
    memcpy(s->ends + 6 * (LitheCount)s->n, s->along + 4 * (LitheCount)i, 3 * sizeof *s->ends);
    memcpy(s->ends + 6 * (LitheCount)s->n + 3, s->along + 4 * (LitheCount)i + 4,
           3 * sizeof *s->ends);
  }
  return LITHE_OK;
}

LitheStatus lth_topology_section(LitheCtx *ctx, const LthTopology *t, LitheIndex cell,
                                 const LthPlane *plane, LthSection *section) {
  const double *box = t->cells[cell].box;
  double reach = ON_PLANE * lth_v3_distance(box, box + 3);
  section->n = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LthFaceView face = lth_topology_face(t, lth_topology_cell_faces(t, cell)[i]);
    LITHE_TRY(add_face(ctx, section, plane, &face, reach));
  }
  return LITHE_OK;
}

// --- a point inside ---

/// Solid angle of the cell's boundary over 4 pi: 1 inside, 0 outside.
static double winding(const LthTopology *t, LitheIndex cell, const double x[3]) {
  double sum = 0;
  LitheIndex c[3];
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex f = lth_topology_cell_faces(t, cell)[i];
    LthFaceView face = lth_topology_face(t, f);
    double side = lth_topology_side(t, f, cell);
    for (LthFan fan = lth_fan(&face); lth_fan_next(&fan, c);)
      sum += side * lth_solid_angle(t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                                    t->points + 3 * (size_t)c[2], x);
  }
  return sum / (4 * 3.14159265358979323846);
}

void lth_topology_inner_point(const LthTopology *t, LitheIndex cell, double x[3]) {
  const LthTopologyCell *k = t->cells + cell;
  lth_v3_copy(k->centroid, x);
  if (winding(t, cell, x) > 0.5) return;
  for (double depth = 0.1; depth > 1e-6; depth *= 0.1)
    for (LitheIndex i = 0; i < k->n_faces; i++) {
      LitheIndex f = lth_topology_cell_faces(t, cell)[i];
      const LthTopologyFace *face = t->faces + f;
      lth_v3_copy(face->centroid, x);
      lth_v3_axpy(-lth_topology_side(t, f, cell) * depth * k->volume / k->area, face->plane, x);
      if (winding(t, cell, x) > 0.5) return;
    }
  lth_v3_copy(k->centroid, x);
}
