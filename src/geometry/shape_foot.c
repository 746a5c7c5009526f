/// Nearest boundary points of shapes: closed forms, search trees, candidates of parts, or Newton's iteration.
#include "geometry/shape_foot.h"

#include "base/tensor.h"

#define STEP 1e-4 // of differences, in scales: their error is its square over that of the radius
#define NEAR 1e-6 // in scales: on the boundary
#define STEPS 12
#define REACH 100 // in scales

static void gradient(const LthShape *s, const double x[3], double step, double g[3]) {
  for (int a = 0; a < 3; a++) {
    double up[3], down[3];
    lth_v3_copy(x, up);
    lth_v3_copy(x, down);
    up[a] += step;
    down[a] -= step;
    g[a] = (lth_shape_value(s, up) - lth_shape_value(s, down)) / (2 * step);
  }
}

/// Newton's iteration along the gradient.
static bool root_foot(const LthShape *s, const double x[3], double scale, LthFoot *foot) {
  lth_v3_copy(x, foot->point);
  for (int i = 0; i < STEPS; i++) {
    double value = lth_shape_value(s, foot->point);
    gradient(s, foot->point, STEP * scale, foot->normal);
    double slope = lth_v3_normalize(foot->normal);
    if (!(slope > 0) || !(fabs(value) < REACH * scale * slope)) return false;
    lth_v3_axpy(-value / slope, foot->normal, foot->point);
    if (fabs(value) <= NEAR * scale * slope) break;
  }
  double distance = lth_v3_distance(x, foot->point);
  if (!(distance < REACH * scale)) return false;
  foot->distance = lth_shape_value(s, x) < 0 ? -distance : distance;
  return true;
}

/// The sphere of radius r about c; outward is towards `side` (1) or away from it (-1).
static void ball_foot(const double c[3], double r, double side, const double x[3], LthFoot *foot) {
  lth_v3_sub(x, c, foot->normal);
  double length = lth_v3_normalize(foot->normal);
  if (!(length > 0)) foot->normal[0] = 1;
  lth_v3_copy(c, foot->point);
  lth_v3_axpy(r, foot->normal, foot->point);
  lth_v3_scale(side, foot->normal);
  foot->distance = side * (length - r);
}

static bool shell_foot(const LthShape *s, const double x[3], LthFoot *foot) {
  double middle = (s->radius + s->inner) / 2;
  if (lth_v3_distance(x, s->a) >= middle)
    ball_foot(s->a, s->radius, 1, x, foot);
  else
    ball_foot(s->a, s->inner, -1, x, foot);
  return true;
}

/// Outside: the nearest point of the box; inside: of its nearest side.
static void box_foot(const double min[3], const double max[3], const double x[3], LthFoot *foot) {
  double nearest = INFINITY;
  int axis = 0, side = 1;
  for (int a = 0; a < 3; a++) {
    foot->point[a] = fmin(fmax(x[a], min[a]), max[a]);
    foot->normal[a] = x[a] - foot->point[a];
    for (int k = -1; k <= 1; k += 2) {
      double depth = k < 0 ? x[a] - min[a] : max[a] - x[a];
      if (depth < nearest) nearest = depth, axis = a, side = k;
    }
  }
  foot->distance = lth_v3_normalize(foot->normal);
  if (foot->distance > 0) return;
  lth_v3_copy(x, foot->point);
  foot->point[axis] = side < 0 ? min[axis] : max[axis];
  foot->normal[0] = foot->normal[1] = foot->normal[2] = 0;
  foot->normal[axis] = side;
  foot->distance = -nearest;
}

static bool mesh_foot(const LthShape *s, const double x[3], LthFoot *foot) {
  LthBvhPoint closest;
  if (!lth_bvh_closest(s->bvh, x, INFINITY, NULL, NULL, &closest)) return false;
  lth_v3_copy(closest.point, foot->point);
  foot->distance = lth_bvh_gap(s->bvh, x, &closest, foot->normal);
  return true;
}

/// The nearest candidate of the parts that lies on the boundary of all; beside edges where they meet there is
/// none, and Newton's iteration goes from part to part.
static bool parts_foot(const LthShape *s, const double x[3], double scale, LthFoot *foot) {
  double value = lth_shape_value(s, x), least = INFINITY;
  for (LitheIndex i = 0; i < s->n_children; i++) {
    LthFoot f;
    if (!lth_shape_foot(&s->children[i], x, scale, &f) || !(fabs(f.distance) < least)) continue;
    if (fabs(lth_shape_value(s, f.point)) > 10 * NEAR * scale) continue;
    least = fabs(f.distance);
    *foot = f;
    if (s->kind == LTH_SHAPE_DIFFERENCE && i > 0) lth_v3_scale(-1, foot->normal);
  }
  if (least == INFINITY) return root_foot(s, x, scale, foot);
  foot->distance = value < 0 ? -least : least;
  return true;
}

bool lth_shape_foot(const LthShape *shape, const double x[3], double scale, LthFoot *foot) {
  *foot = (LthFoot){0};
  switch (shape->kind) {
  case LTH_SHAPE_BOX:
    box_foot(shape->a, shape->b, x, foot);
    return true;
  case LTH_SHAPE_SPHERE:
  case LTH_SHAPE_DISK: // met at z = 0
    ball_foot(shape->a, shape->radius, 1, x, foot);
    return true;
  case LTH_SHAPE_SHELL:
  case LTH_SHAPE_ANNULUS:
    return shell_foot(shape, x, foot);
  case LTH_SHAPE_POLYGON:
    foot->distance = lth_loops_distance(shape->loops, x, foot->point, foot->normal);
    return true;
  case LTH_SHAPE_MESH:
    return shape->bvh ? mesh_foot(shape, x, foot) : root_foot(shape, x, scale, foot);
  case LTH_SHAPE_UNION:
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
    return parts_foot(shape, x, scale, foot);
  default:
    return root_foot(shape, x, scale, foot);
  }
}
