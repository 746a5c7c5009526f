/// Probes: sides of boxes from bounds on a shape's value.
#include "geometry/shape_probe.h"

#include "base/tensor.h"

#define SCAN_MAX 4096      ///< voxels or cells of a map that are looked at for one box
#define TOUCH 1e-11        ///< of a box: sides that meet but for rounding
#define ROUNDING 0x1p-40   ///< of a value's bound
#define WRAP_CLEARANCE 2.3 ///< of half a box's width: as in wrap_map.c
#define WRAP_SURE 0.35     ///< of a winding number around one half
#define WRAP_OPENING 2.0

/// --- building ---

static LitheStatus build(LitheCtx *ctx, const LthShape *shape, double cell, LthProbe *p) {
  p->shape = shape;
  if (shape->kind == LTH_SHAPE_WRAP) return lth_wrap_map_create(ctx, shape->wrap, cell, &p->map);
  if (shape->n_children == 0) return LITHE_OK;
  LTH_NEW(ctx, p->children, shape->n_children);
  for (LitheIndex i = 0; i < shape->n_children; i++)
    LITHE_TRY(build(ctx, &shape->children[i], cell, &p->children[i]));
  return LITHE_OK;
}

static void release(LitheCtx *ctx, LthProbe *p) {
  for (LitheIndex i = 0; p->children && i < p->shape->n_children; i++)
    if (p->children[i].shape) release(ctx, &p->children[i]);
  lth_free(ctx, p->children);
  lth_wrap_map_destroy(ctx, &p->map);
}

LitheStatus lth_probe_create(LitheCtx *ctx, const LthShape *shape, double cell, LthProbe **probe) {
  LTH_NEW(ctx, *probe, 1);
  LitheStatus status = build(ctx, shape, cell, *probe);
  if (status != LITHE_OK) lth_probe_destroy(ctx, probe);
  return status;
}

void lth_probe_destroy(LitheCtx *ctx, LthProbe **probe) {
  if (!probe || !*probe) return;
  release(ctx, *probe);
  lth_free(ctx, *probe);
  *probe = NULL;
}

/// --- places ---

/// Level of the voxel that holds x, positive beyond the image.
static double voxel_level(const LthImage *m, const double x[3]) {
  double at[3];
  LitheIndex v[3];
  lth_volume_locate(m->volume, x, at);
  for (int i = 0; i < 3; i++) {
    double nearest = floor(at[i] + 0.5);
    if (!(nearest >= 0 && nearest < m->volume->n[i])) return INFINITY;
    v[i] = (LitheIndex)nearest;
  }
  return (double)m->level[lth_volume_index(m->volume, v[0], v[1], v[2])];
}

/// `closed`: does the boundary count as inside?
static bool is_inside(const LthProbe *p, const double x[3], bool closed) {
  const LthShape *s = p->shape;
  double value;
  switch (s->kind) {
  case LTH_SHAPE_UNION:
    for (LitheIndex i = 0; i < s->n_children; i++)
      if (is_inside(&p->children[i], x, closed)) return true;
    return false;
  case LTH_SHAPE_INTERSECTION:
    for (LitheIndex i = 0; i < s->n_children; i++)
      if (!is_inside(&p->children[i], x, closed)) return false;
    return s->n_children > 0;
  case LTH_SHAPE_DIFFERENCE:
    if (s->n_children == 0 || !is_inside(&p->children[0], x, closed)) return false;
    for (LitheIndex i = 1; i < s->n_children; i++)
      if (is_inside(&p->children[i], x, !closed)) return false;
    return true;
  case LTH_SHAPE_WRAP:
    return lth_wrap_map_inside(p->map, x);
  case LTH_SHAPE_IMAGE:
    value = s->image->is_smoothed ? lth_image_value(s->image, x) : voxel_level(s->image, x);
    return value < 0;
  default:
    value = lth_shape_value(s, x);
    return closed ? value <= 0 : value < 0;
  }
}

bool lth_probe_inside(const LthProbe *p, const double x[3]) { return is_inside(p, x, true); }

/// To first order.
static double scaled_value(const LthShape *s, const double x[3], int dim, double step) {
  double value = lth_shape_value(s, x), gg = 0;
  for (int i = 0; i < dim; i++) {
    double low[3], high[3];
    lth_v3_copy(x, low);
    lth_v3_copy(x, high);
    low[i] -= 0.5 * step;
    high[i] += 0.5 * step;
    double g = (lth_shape_value(s, high) - lth_shape_value(s, low)) / step;
    gg += g * g;
  }
  return gg > 0 && isfinite(gg) ? value / sqrt(gg) : value > 0 ? INFINITY : -INFINITY;
}

double lth_probe_distance(const LthProbe *p, const double x[3], int dim, double step) {
  const LthShape *s = p->shape;
  double d = s->kind == LTH_SHAPE_UNION ? INFINITY : -INFINITY;
  switch (s->kind) {
  case LTH_SHAPE_UNION:
    for (LitheIndex i = 0; i < s->n_children; i++)
      d = fmin(d, lth_probe_distance(&p->children[i], x, dim, step));
    return d;
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
    for (LitheIndex i = 0; i < s->n_children; i++) {
      double of_child = lth_probe_distance(&p->children[i], x, dim, step);
      d = fmax(d, i > 0 && s->kind == LTH_SHAPE_DIFFERENCE ? -of_child : of_child);
    }
    return s->n_children > 0 ? d : INFINITY;
  case LTH_SHAPE_IMPLICIT:
  case LTH_SHAPE_IMAGE:
    return scaled_value(s, x, dim, step);
  case LTH_SHAPE_WRAP:
    d = fabs(lth_bvh_signed_distance(s->wrap->bvh, x, NULL));
    return lth_wrap_map_inside(p->map, x) ? -d : d;
  default:
    return lth_shape_value(s, x);
  }
}

/// --- boxes ---

static LthSide box_side(const LthShape *s, const double c[3], const double half[3]) {
  bool is_in = true;
  for (int i = 0; i < 3; i++) {
    double low = c[i] - half[i] * (1 - TOUCH), high = c[i] + half[i] * (1 - TOUCH);
    if (half[i] > 0 ? high <= s->a[i] || low >= s->b[i] : c[i] < s->a[i] || c[i] > s->b[i])
      return LTH_SIDE_OUTSIDE;
    is_in = is_in && low >= s->a[i] && high <= s->b[i];
  }
  return is_in ? LTH_SIDE_INSIDE : LTH_SIDE_MIXED;
}

/// The value changes by no more than the distance.
static LthSide distance_side(const LthShape *s, const double c[3], const double half[3]) {
  double value = lth_shape_value(s, c), reach = lth_v3_norm(half) * (1 + ROUNDING);
  if (value > reach) return LTH_SIDE_OUTSIDE;
  return value < -reach ? LTH_SIDE_INSIDE : LTH_SIDE_MIXED;
}

static bool are_apart(const double box[6], const double c[3], const double half[3]) {
  for (int i = 0; i < 3; i++)
    if (c[i] - half[i] > box[3 + i] || c[i] + half[i] < box[i]) return true;
  return false;
}

/// What values at 3 places along each axis tell: they differ by less than their smallest.
static LthSide sampled_side(const LthShape *s, const double c[3], const double half[3]) {
  if (are_apart(s->box, c, half)) return LTH_SIDE_OUTSIDE;
  double low = INFINITY, high = -INFINITY;
  for (int k = half[2] > 0 ? -1 : 0; k <= (half[2] > 0); k++)
    for (int j = -1; j <= 1; j++)
      for (int i = -1; i <= 1; i++) {
        double x[3] = {c[0] + i * half[0], c[1] + j * half[1], c[2] + k * half[2]};
        double value = lth_shape_value(s, x);
        if (!isfinite(value)) return LTH_SIDE_MIXED;
        low = fmin(low, value);
        high = fmax(high, value);
      }
  if (low > high - low) return LTH_SIDE_OUTSIDE;
  return high < low - high ? LTH_SIDE_INSIDE : LTH_SIDE_MIXED;
}

/// Voxels whose levels decide about a box; false where some of the box is beyond the image.
static bool voxel_range(const LthImage *m, const double c[3], const double half[3],
                        LitheIndex low[3], LitheIndex high[3], bool *is_apart) {
  const LthVolume *v = m->volume;
  double at[3];
  bool is_within = true;
  lth_volume_locate(v, c, at);
  *is_apart = false;
  for (int i = 0; i < 3; i++) {
    double reach = 0;
    for (int j = 0; j < 3; j++) reach += fabs(v->to_voxel[4 * i + j]) * half[j];
    double first = at[i] - reach, last = at[i] + reach, top = v->n[i] - 1;
    if (last < -0.5 || first > top + 0.5) *is_apart = true;
    is_within = is_within && first >= -0.5 && last <= top + 0.5;
    // centres around the box; or voxels that it enters by more than rounding
    first = m->is_smoothed ? floor(first) : floor(first + 0.5 + 1e-9);
    last = m->is_smoothed ? ceil(last) : ceil(last + 0.5 - 1e-9) - 1;
    low[i] = (LitheIndex)fmin(fmax(first, 0), top);
    high[i] = (LitheIndex)fmax(fmin(fmax(last, first), top), low[i]);
  }
  return is_within;
}

static LthSide image_side(const LthImage *m, const double c[3], const double half[3]) {
  LitheIndex low[3], high[3];
  bool is_apart, any_in = false, any_out = false;
  any_out = !voxel_range(m, c, half, low, high, &is_apart);
  if (is_apart) return LTH_SIDE_OUTSIDE;
  double n = 1;
  for (int i = 0; i < 3; i++) n *= high[i] - low[i] + 1;
  if (n > SCAN_MAX) return LTH_SIDE_MIXED;
  for (LitheIndex k = low[2]; k <= high[2]; k++)
    for (LitheIndex j = low[1]; j <= high[1]; j++)
      for (LitheIndex i = low[0]; i <= high[0]; i++) {
        bool is_in = m->level[lth_volume_index(m->volume, i, j, k)] < 0;
        any_in = any_in || is_in;
        any_out = any_out || !is_in;
        if (any_in && any_out) return LTH_SIDE_MIXED;
      }
  return any_in ? LTH_SIDE_INSIDE : LTH_SIDE_OUTSIDE;
}

/// Far from all triangles the number at the middle tells.
static LthSide far_side(const LthWrap *w, const double c[3], const double half[3]) {
  LthBvhPoint closest;
  double bound;
  if (lth_bvh_closest(w->bvh, c, WRAP_CLEARANCE * lth_v3_norm(half), NULL, NULL, &closest))
    return LTH_SIDE_MIXED;
  double number = lth_winding_number(w->winding, c, WRAP_OPENING, &bound);
  if (number - 0.5 > WRAP_SURE + bound) return LTH_SIDE_INSIDE;
  return 0.5 - number > WRAP_SURE + bound ? LTH_SIDE_OUTSIDE : LTH_SIDE_MIXED;
}

static LthSide wrap_side(const LthWrapMap *m, const double c[3], const double half[3]) {
  LitheIndex low[3], high[3];
  bool any_in = false, any_out = false;
  double n = 1;
  if (are_apart(m->wrap->box, c, half)) return LTH_SIDE_OUTSIDE;
  for (int i = 0; i < 3; i++) {
    double first = (c[i] - half[i] - m->origin[i]) / m->cell,
           last = (c[i] + half[i] - m->origin[i]) / m->cell;
    any_out = any_out || c[i] - half[i] < m->wrap->box[i] || c[i] + half[i] > m->wrap->box[3 + i];
    low[i] = (LitheIndex)fmin(fmax(floor(first), 0), m->n[i] - 1);
    high[i] = (LitheIndex)fmin(fmax(floor(last), 0), m->n[i] - 1);
    n *= high[i] - low[i] + 1;
  }
  if (n > SCAN_MAX) return any_out ? LTH_SIDE_MIXED : far_side(m->wrap, c, half);
  for (LitheIndex k = low[2]; k <= high[2]; k++)
    for (LitheIndex j = low[1]; j <= high[1]; j++)
      for (LitheIndex i = low[0]; i <= high[0]; i++) {
        uint8_t state = m->state[i + (LitheCount)m->n[0] * (j + (LitheCount)m->n[1] * k)];
        any_in = any_in || state != LTH_WRAP_OUTSIDE;
        any_out = any_out || state != LTH_WRAP_INSIDE;
        if (any_in && any_out) return LTH_SIDE_MIXED;
      }
  return any_in ? LTH_SIDE_INSIDE : LTH_SIDE_OUTSIDE;
}

/// A union is inside where a child is (`decides` INSIDE), an intersection is outside where a child is.
static LthSide children_side(const LthProbe *p, const double c[3], const double half[3],
                             LthSide decides) {
  LthSide side = decides == LTH_SIDE_INSIDE ? LTH_SIDE_OUTSIDE : LTH_SIDE_INSIDE;
  for (LitheIndex i = 0; i < p->shape->n_children; i++) {
    LthSide of_child = lth_probe_side(&p->children[i], c, half);
    if (i > 0 && p->shape->kind == LTH_SHAPE_DIFFERENCE && of_child != LTH_SIDE_MIXED)
      of_child = of_child == LTH_SIDE_INSIDE ? LTH_SIDE_OUTSIDE : LTH_SIDE_INSIDE;
    if (of_child == decides) return decides;
    if (of_child == LTH_SIDE_MIXED) side = LTH_SIDE_MIXED;
  }
  return p->shape->n_children > 0 ? side : LTH_SIDE_OUTSIDE;
}

LthSide lth_probe_side(const LthProbe *p, const double c[3], const double half[3]) {
  switch (p->shape->kind) {
  case LTH_SHAPE_UNION:
    return children_side(p, c, half, LTH_SIDE_INSIDE);
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
    return children_side(p, c, half, LTH_SIDE_OUTSIDE);
  case LTH_SHAPE_BOX:
    return box_side(p->shape, c, half);
  case LTH_SHAPE_IMPLICIT:
    return sampled_side(p->shape, c, half);
  case LTH_SHAPE_IMAGE:
    return image_side(p->shape->image, c, half);
  case LTH_SHAPE_WRAP:
    return wrap_side(p->map, c, half);
  default:
    return distance_side(p->shape, c, half);
  }
}
