/// Shapes: distance, bounds and ownership.
#include "geometry/shape.h"

#include "base/tensor.h"

void lth_shape_free(LitheCtx *ctx, LthShape *shape) {
  for (LitheIndex i = 0; i < shape->n_children; i++) lth_shape_free(ctx, &shape->children[i]);
  lth_free(ctx, shape->children);
  lth_bvh_destroy(ctx, &shape->bvh);
  shape->children = NULL;
  shape->n_children = 0;
}

LitheStatus lth_shape_prepare(LitheCtx *ctx, LthShape *shape) {
  for (LitheIndex i = 0; i < shape->n_children; i++)
    LITHE_TRY(lth_shape_prepare(ctx, &shape->children[i]));
  if (shape->kind != LTH_SHAPE_MESH || shape->bvh || !shape->surface) return LITHE_OK;
  return lth_bvh_create_surface(ctx, shape->surface, &shape->bvh);
}

/// Signed distance of a box given by the distances beyond its sides (negative within).
static double beyond_sides(const double *d, int n) {
  double outside = 0, inside = -INFINITY;
  for (int i = 0; i < n; i++) {
    outside += d[i] > 0 ? d[i] * d[i] : 0;
    inside = fmax(inside, d[i]);
  }
  return inside > 0 ? sqrt(outside) : inside;
}

static double box_value(const double min[3], const double max[3], const double x[3]) {
  double d[3];
  for (int i = 0; i < 3; i++) d[i] = fmax(min[i] - x[i], x[i] - max[i]);
  return beyond_sides(d, 3);
}

/// Place of x along the axis a -> b [m] and its distance from it; returns the axis' length.
static double axis_place(const double a[3], const double b[3], const double x[3], double *along,
                         double *radial) {
  double d[3], r[3];
  lth_v3_sub(b, a, d);
  lth_v3_sub(x, a, r);
  double length = lth_v3_normalize(d);
  *along = lth_v3_dot(r, d);
  lth_v3_axpy(-*along, d, r);
  *radial = lth_v3_norm(r);
  return length;
}

static double cylinder_value(const LthShape *s, const double x[3]) {
  double along, radial, length = axis_place(s->a, s->b, x, &along, &radial);
  double d[2] = {radial - s->radius, fmax(-along, along - length)};
  return beyond_sides(d, 2);
}

static double capsule_value(const LthShape *s, const double x[3]) {
  double along, radial, length = axis_place(s->a, s->b, x, &along, &radial);
  double past = fmax(fmax(-along, along - length), 0);
  return hypot(radial, past) - s->radius;
}

/// Without a search tree: the closest of all triangles, and the sign of the winding number.
static double mesh_value_plain(const LthSurface *s, const double x[3]) {
  double best = INFINITY, angle = 0, q[3];
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    const double *p[3];
    for (int k = 0; k < 3; k++) p[k] = s->points + 3 * (size_t)s->tris[3 * (size_t)t + (size_t)k];
    lth_closest_on_triangle(p[0], p[1], p[2], x, q);
    best = fmin(best, lth_v3_distance(q, x));
    angle += lth_solid_angle(p[0], p[1], p[2], x);
  }
  return angle > 2 * M_PI ? -best : best;
}

double lth_shape_value(const LthShape *s, const double x[3]) {
  double value;
  switch (s->kind) {
  case LTH_SHAPE_BOX:
    return box_value(s->a, s->b, x);
  case LTH_SHAPE_SPHERE:
    return lth_v3_distance(x, s->a) - s->radius;
  case LTH_SHAPE_CYLINDER:
    return cylinder_value(s, x);
  case LTH_SHAPE_CAPSULE:
    return capsule_value(s, x);
  case LTH_SHAPE_SHELL:
    value = lth_v3_distance(x, s->a);
    return fmax(value - s->radius, s->inner - value);
  case LTH_SHAPE_MESH:
    return s->bvh ? lth_bvh_signed_distance(s->bvh, x, NULL) : mesh_value_plain(s->surface, x);
  case LTH_SHAPE_IMPLICIT:
    value = lth_value_at(&s->value, x, 0);
    return isnan(value) ? INFINITY : fmax(value, box_value(s->box, s->box + 3, x));
  case LTH_SHAPE_UNION:
    value = INFINITY;
    for (LitheIndex i = 0; i < s->n_children; i++)
      value = fmin(value, lth_shape_value(&s->children[i], x));
    return value;
  case LTH_SHAPE_INTERSECTION:
    value = s->n_children > 0 ? -INFINITY : INFINITY;
    for (LitheIndex i = 0; i < s->n_children; i++)
      value = fmax(value, lth_shape_value(&s->children[i], x));
    return value;
  case LTH_SHAPE_DIFFERENCE:
    value = s->n_children > 0 ? lth_shape_value(&s->children[0], x) : INFINITY;
    for (LitheIndex i = 1; i < s->n_children; i++)
      value = fmax(value, -lth_shape_value(&s->children[i], x));
    return value;
  case LTH_SHAPE_IMAGE:
    return lth_image_value(s->image, x);
  case LTH_SHAPE_WRAP:
    return lth_wrap_value(s->wrap, x);
  case LTH_SHAPE_DISK:
    return hypot(x[0] - s->a[0], x[1] - s->a[1]) - s->radius;
  case LTH_SHAPE_ANNULUS:
    value = hypot(x[0] - s->a[0], x[1] - s->a[1]);
    return fmax(value - s->radius, s->inner - value);
  case LTH_SHAPE_POLYGON:
    return lth_loops_distance(s->loops, x, NULL, NULL);
  }
  return INFINITY;
}

/// A box of a plane scene is endless along z.
static void box_bounds(const double low[3], const double high[3], double min[3], double max[3]) {
  int n = isinf(low[2]) ? 2 : 3;
  for (int i = 0; i < n; i++) min[i] = low[i], max[i] = high[i];
}

static void axis_bounds(const LthShape *s, double min[3], double max[3]) {
  double d[3];
  lth_v3_sub(s->b, s->a, d);
  lth_v3_normalize(d);
  for (int i = 0; i < 3; i++) {
    // a flat disc of the radius reaches sin(angle) of it along an axis; a ball all of it
    double reach = s->kind == LTH_SHAPE_CAPSULE ? 1 : sqrt(fmax(0, 1 - d[i] * d[i]));
    min[i] = fmin(s->a[i], s->b[i]) - reach * s->radius;
    max[i] = fmax(s->a[i], s->b[i]) + reach * s->radius;
  }
}

/// Bounds of a union (grow) or an intersection (shrink) of the children.
static void children_bounds(const LthShape *s, bool is_union, double min[3], double max[3]) {
  for (LitheIndex c = 0; c < s->n_children; c++) {
    double low[3], high[3];
    lth_shape_bounds(&s->children[c], low, high);
    for (int i = 0; i < 3; i++) {
      min[i] = c == 0 ? low[i] : is_union ? fmin(min[i], low[i]) : fmax(min[i], low[i]);
      max[i] = c == 0 ? high[i] : is_union ? fmax(max[i], high[i]) : fmin(max[i], high[i]);
    }
  }
  for (int i = 0; i < 3; i++) max[i] = fmax(min[i], max[i]);
}

void lth_shape_bounds(const LthShape *s, double min[3], double max[3]) {
  for (int i = 0; i < 3; i++) min[i] = max[i] = 0;
  switch (s->kind) {
  case LTH_SHAPE_BOX:
    box_bounds(s->a, s->b, min, max);
    return;
  case LTH_SHAPE_SPHERE:
  case LTH_SHAPE_SHELL:
    for (int i = 0; i < 3; i++) min[i] = s->a[i] - s->radius, max[i] = s->a[i] + s->radius;
    return;
  case LTH_SHAPE_CYLINDER:
  case LTH_SHAPE_CAPSULE:
    axis_bounds(s, min, max);
    return;
  case LTH_SHAPE_MESH:
    lth_surface_bounds(s->surface, min, max);
    return;
  case LTH_SHAPE_IMPLICIT:
    box_bounds(s->box, s->box + 3, min, max);
    return;
  case LTH_SHAPE_UNION:
  case LTH_SHAPE_INTERSECTION:
    children_bounds(s, s->kind == LTH_SHAPE_UNION, min, max);
    return;
  case LTH_SHAPE_DIFFERENCE:
    if (s->n_children > 0) lth_shape_bounds(&s->children[0], min, max);
    return;
  case LTH_SHAPE_IMAGE:
    lth_v3_copy(s->image->box, min);
    lth_v3_copy(s->image->box + 3, max);
    return;
  case LTH_SHAPE_WRAP:
    lth_v3_copy(s->wrap->box, min);
    lth_v3_copy(s->wrap->box + 3, max);
    return;
  case LTH_SHAPE_DISK:
  case LTH_SHAPE_ANNULUS:
    for (int i = 0; i < 2; i++) min[i] = s->a[i] - s->radius, max[i] = s->a[i] + s->radius;
    return;
  case LTH_SHAPE_POLYGON:
    for (int i = 0; i < 2; i++) min[i] = s->loops->box[i], max[i] = s->loops->box[2 + i];
    return;
  }
}
