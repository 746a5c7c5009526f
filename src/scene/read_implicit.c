/// Implicit shapes: expressions in their own axes, and boxes to look for them in.
#include "scene/reader.h"

#include "base/tensor.h"

#include <math.h>
#include <string.h>

/// Side of the box of an implicit shape that has none: as good as all of space.
#define UNBOUNDED 1e30
#define PLACES 17 ///< along each axis of a box at which an expression has to be a number

/// An expression that is evaluated in the axes from before `place`.
typedef struct PlacedValue {
  LthValue value;
  LthPlacement place;
} PlacedValue;

static double eval_placed(const void *self, const double x[3], double t) {
  const PlacedValue *p = self;
  double d[3], local[3];
  lth_v3_sub(x, p->place.translation, d);
  lth_m3_apply_t(p->place.rotation, d, local);
  return lth_value_at(&p->value, local, t);
}

/// Box around the placed corners of a box, in a plane scene endless along z.
static void place_box(const LthReader *r, const LthPlacement *place, double box[6]) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; corner++) {
    double x[3], placed[3];
    for (int i = 0; i < 3; i++) x[i] = box[corner >> i & 1 ? 3 + i : i];
    lth_place_point(place, x, placed);
    for (int i = 0; i < 3; i++)
      low[i] = fmin(low[i], placed[i]), high[i] = fmax(high[i], placed[i]);
  }
  memcpy(box, low, sizeof low);
  memcpy(box + 3, high, sizeof high);
  lth_open_box(r, box, box + 3);
}

static bool read_box(LthReader *r, const LthNode *node, double box[6]) {
  if (!lth_node_find(node, "min") && !lth_node_find(node, "max")) return false;
  if (!lth_read_vector(node, "min", box) || !lth_read_vector(node, "max", box + 3)) {
    if (!lth_node_find(node, "min") || !lth_node_find(node, "max"))
      lth_report(r->report, node, "half a box, got one of min and max; expected both");
    return false;
  }
  for (int i = 0; i < r->scene->dimension; i++) {
    if (box[i] < box[3 + i]) continue;
    lth_report(r->report, lth_node_find(node, "max"),
               "an empty box, got max not above min along %c; expected max > min", "xyz"[i]);
    return false;
  }
  return true;
}

LitheStatus lth_read_implicit(LthReader *r, const LthNode *node, const LthPlacement *place,
                              LthShape *shape) {
  shape->kind = LTH_SHAPE_IMPLICIT;
  for (int i = 0; i < 3; i++) shape->box[i] = -UNBOUNDED, shape->box[3 + i] = UNBOUNDED;
  bool is_map = node->kind == LTH_NODE_MAP;
  LthValue value = is_map ? lth_read_value(node, "value") : node->value;
  double box[6];
  if (is_map && read_box(r, node, box)) {
    memcpy(shape->box, box, sizeof box);
    place_box(r, place, shape->box);
  }
  shape->value = value;
  lth_expression_list_allow_gaps(&r->owned->expressions, &value);
  bool is_moved = place->rotates || lth_v3_norm(place->translation) > 0;
  if (!is_moved) return LITHE_OK;
  PlacedValue *placed = lth_arena_take(r->arena, sizeof *placed);
  if (!placed) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  *placed = (PlacedValue){value, *place};
  shape->value = (LthValue){.eval = eval_placed, .self = placed};
  return LITHE_OK;
}

static bool is_bounded(const LthShape *s) {
  switch (s->kind) {
  case LTH_SHAPE_IMPLICIT:
    return s->box[3] < UNBOUNDED;
  case LTH_SHAPE_UNION:
    for (LitheIndex i = 0; i < s->n_children; i++)
      if (!is_bounded(&s->children[i])) return false;
    return true;
  case LTH_SHAPE_INTERSECTION:
    for (LitheIndex i = 0; i < s->n_children; i++)
      if (is_bounded(&s->children[i])) return true;
    return false;
  case LTH_SHAPE_DIFFERENCE:
    return s->n_children > 0 && is_bounded(&s->children[0]);
  default:
    return true;
  }
}

static const LthNode *child_list(const LthNode *node) {
  static const char *const keys[] = {"union", "intersection", "difference"};
  for (int i = 0; i < 3; i++)
    if (lth_node_find(node, keys[i])) return lth_node_find(node, keys[i]);
  return NULL;
}

/// What is already bounded around a part tells where to look for it.
static bool neighbour_box(const LthShape *s, double box[6]) {
  bool is_found = false;
  LitheIndex n = s->kind == LTH_SHAPE_DIFFERENCE && s->n_children > 0 ? 1 : s->n_children;
  if (s->kind == LTH_SHAPE_UNION) return false;
  for (LitheIndex i = 0; i < n; i++) {
    if (!is_bounded(&s->children[i])) continue;
    double low[3], high[3];
    lth_shape_bounds(&s->children[i], low, high);
    for (int k = 0; k < 3; k++) {
      box[k] = is_found ? fmax(box[k], low[k]) : low[k];
      box[3 + k] = is_found ? fmin(box[3 + k], high[k]) : high[k];
    }
    is_found = true;
  }
  for (int k = 0; k < 3; k++) box[3 + k] = fmax(box[3 + k], box[k]);
  return is_found;
}

/// The first place of a lattice over the shape's box at which the expression is no number.
static bool find_gap(const LthReader *r, const LthShape *shape, double x[3]) {
  int deep = r->scene->dimension == 3 ? PLACES : 1;
  for (int s = 0; s < PLACES * PLACES * deep; s++) {
    int place[3] = {s % PLACES, s / PLACES % PLACES, s / (PLACES * PLACES)};
    for (int a = 0; a < 3; a++) {
      const double *box = shape->box + a;
      x[a] = a < r->scene->dimension ? box[0] + (box[3] - box[0]) * (place[a] + 0.5) / PLACES : 0;
    }
    if (isnan(lth_value_at(&shape->value, x, 0))) return true;
  }
  return false;
}

static void check_numbers(LthReader *r, const LthNode *node, const LthShape *shape) {
  double x[3];
  if (!is_bounded(shape) || !find_gap(r, shape, x)) return;
  lth_report(r->report, lth_node_find(node, "implicit"),
             "not a number everywhere in its box, got none at (%g, %g, %g); expected one, as of "
             "`x > 0 ? log(x) : 1` for log(x)",
             x[0], x[1], x[2]);
}

void lth_bound_shape(LthReader *r, const LthNode *node, LthShape *shape, const double *search) {
  if (shape->kind == LTH_SHAPE_IMPLICIT) {
    if (is_bounded(shape)) {
      check_numbers(r, node, shape);
    } else if (search) {
      memcpy(shape->box, search, sizeof shape->box);
      lth_open_box(r, shape->box, shape->box + 3);
      check_numbers(r, node, shape);
    } else {
      lth_report(r->report, lth_node_find(node, "implicit"),
                 "no box to look for the shape in, got an expression alone; expected {value, min, "
                 "max}, or "
                 "method.grid");
    }
    return;
  }
  const LthNode *child_node = child_list(node);
  child_node = child_node ? child_node->first : NULL;
  for (LitheIndex i = 0; i < shape->n_children && child_node; i++, child_node = child_node->next) {
    double box[6] = {0};
    bool has_box = neighbour_box(shape, box);
    lth_bound_shape(r, child_node, &shape->children[i], has_box ? box : search);
  }
}
