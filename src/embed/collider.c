/// Rigid colliders: pose, gap and normal.
#include "embed/collider.h"

#include "base/tensor.h"

LthPose lth_collider_pose(const LthCollider *c, double t) {
  LthPose p;
  double k[3], angle = lth_value_at(&c->angle, c->pivot, t);
  lth_v3_copy(c->axis, k);
  lth_v3_copy(c->pivot, p.pivot);
  for (int i = 0; i < 3; i++) p.shift[i] = lth_value_at(&c->translation[i], c->pivot, t);
  lth_m3_identity(p.R);
  if (angle == 0 || !(lth_v3_normalize(k) > 0)) return p;
  lth_m3_rotation(k, angle, p.R);
  return p;
}

void lth_pose_to_rest(const LthPose *p, const double x[3], double rest[3]) {
  double d[3];
  for (int i = 0; i < 3; i++) d[i] = x[i] - p->pivot[i] - p->shift[i];
  lth_m3_apply_t(p->R, d, rest);
  lth_v3_axpy(1, p->pivot, rest);
}

void lth_pose_to_world(const LthPose *p, const double rest[3], double x[3]) {
  double d[3];
  lth_v3_sub(rest, p->pivot, d);
  lth_m3_apply(p->R, d, x);
  for (int i = 0; i < 3; i++) x[i] += p->pivot[i] + p->shift[i];
}

/// Direction of d and its length; z where it has none.
static double direction(const double d[3], double normal[3]) {
  lth_v3_copy(d, normal);
  double length = lth_v3_normalize(normal);
  if (!(length > 0)) normal[0] = normal[1] = 0, normal[2] = 1;
  return length;
}

static double plane_gap(const LthCollider *c, const double x[3], double normal[3]) {
  double d[3];
  direction(c->normal, normal);
  lth_v3_sub(x, c->point, d);
  return lth_v3_dot(d, normal);
}

static double ball_gap(const double center[3], double radius, const double x[3], double normal[3]) {
  double d[3];
  lth_v3_sub(x, center, d);
  return direction(d, normal) - radius;
}

static double box_gap(const LthShape *s, const double x[3], double normal[3]) {
  double d[3] = {0, 0, 0}, depth = -INFINITY;
  int axis = 0;
  bool outside = false;
  for (int i = 0; i < 3; i++) {
    double low = s->a[i] - x[i], high = x[i] - s->b[i], beyond = fmax(low, high);
    if (beyond > 0) outside = true, d[i] = high > low ? beyond : -beyond;
    if (beyond > depth) depth = beyond, axis = i;
  }
  if (outside) return direction(d, normal);
  normal[0] = normal[1] = normal[2] = 0;
  normal[axis] = x[axis] - s->a[axis] > s->b[axis] - x[axis] ? 1 : -1;
  return depth;
}

static double capsule_gap(const LthShape *s, const double x[3], double normal[3]) {
  double d[3], r[3], center[3];
  lth_v3_sub(s->b, s->a, d);
  lth_v3_sub(x, s->a, r);
  double length2 = lth_v3_dot(d, d), t = length2 > 0 ? lth_v3_dot(d, r) / length2 : 0;
  lth_v3_copy(s->a, center);
  lth_v3_axpy(fmin(fmax(t, 0), 1), d, center);
  return ball_gap(center, s->radius, x, normal);
}

/// Without a search tree: every triangle, and the gradient by differences.
static double plain_gap(const LthShape *s, const double x[3], double normal[3]) {
  double min[3], max[3], d[3];
  lth_shape_bounds(s, min, max);
  double h = 1e-6 * lth_v3_distance(min, max);
  for (int i = 0; i < 3; i++) {
    double low[3], high[3];
    lth_v3_copy(x, low);
    lth_v3_copy(x, high);
    low[i] -= h, high[i] += h;
    d[i] = lth_shape_value(s, high) - lth_shape_value(s, low);
  }
  direction(d, normal);
  return lth_shape_value(s, x);
}

double lth_collider_rest_gap(const LthCollider *c, const double x[3], double normal[3]) {
  double n[3];
  if (!normal) normal = n;
  switch (c->kind) {
  case LTH_COLLIDER_PLANE:
    return plane_gap(c, x, normal);
  case LTH_COLLIDER_SPHERE:
    return ball_gap(c->shape.a, c->shape.radius, x, normal);
  case LTH_COLLIDER_BOX:
    return box_gap(&c->shape, x, normal);
  case LTH_COLLIDER_CAPSULE:
    return capsule_gap(&c->shape, x, normal);
  case LTH_COLLIDER_MESH:
    break;
  }
  if (c->shape.bvh) return lth_bvh_signed_distance(c->shape.bvh, x, normal);
  return plain_gap(&c->shape, x, normal);
}

void lth_collider_rest_box(const LthCollider *c, double box[6]) {
  for (int i = 0; i < 3; i++) box[i] = -INFINITY, box[3 + i] = INFINITY;
  if (c->kind != LTH_COLLIDER_PLANE) lth_shape_bounds(&c->shape, box, box + 3);
}
