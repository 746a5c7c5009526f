/// Shapes taken apart into smooth functions.
#include "geometry/solid.h"

#include "base/tensor.h"

#define SAME 1e-12 ///< of the shape's size: places that differ by rounding alone
#define LARGEST 1e50

// ------------------------------------------------------------------ functions

double lth_field_value(const LthField *f, const double x[3]) {
  double r[3], value = 0;
  lth_v3_sub(x, f->at, r);
  switch (f->kind) {
  case LTH_FIELD_PLANE:
    return f->axis >= 0 ? r[f->axis] : lth_v3_dot(f->normal, r);
  case LTH_FIELD_BALL:
    return lth_v3_norm(r) - f->radius;
  case LTH_FIELD_ROUND:
    lth_v3_axpy(-lth_v3_dot(r, f->normal), f->normal, r);
    return lth_v3_norm(r) - f->radius;
  case LTH_FIELD_VALUE:
    value = lth_shape_value(f->shape, x);
    break;
  case LTH_FIELD_FORMULA:
    value = lth_value_at(&f->shape->value, x, 0);
    break;
  }
  return isnan(value) ? LARGEST : fmin(fmax(value, -LARGEST), LARGEST);
}

/// Are both the same function (1), each other's negative (-1), or neither (0)?
static int compare_fields(const LthField *a, const LthField *b, double rounding) {
  double cross[3], off[3];
  if (a->kind != b->kind || a->shape || b->shape) return 0;
  lth_v3_sub(b->at, a->at, off);
  if (a->kind == LTH_FIELD_BALL)
    return lth_v3_norm(off) <= rounding && fabs(a->radius - b->radius) <= rounding;
  lth_v3_cross(a->normal, b->normal, cross);
  if (lth_v3_norm(cross) > SAME) return 0;
  if (a->kind == LTH_FIELD_PLANE) {
    if (fabs(lth_v3_dot(off, a->normal)) > rounding) return 0;
    return lth_v3_dot(a->normal, b->normal) > 0 ? 1 : -1;
  }
  lth_v3_axpy(-lth_v3_dot(off, a->normal), a->normal, off);
  return lth_v3_norm(off) <= rounding && fabs(a->radius - b->radius) <= rounding;
}

// ------------------------------------------------------------------ building

typedef struct SolidMaker {
  LitheCtx *ctx;
  LthSolid *solid;
} SolidMaker;

static LitheStatus add_node(SolidMaker *m, LitheIndex parent, LthSolidNode node, LitheIndex *at) {
  LthSolid *s = m->solid;
  LTH_RESERVE(m->ctx, s->node, s->node_cap, (LitheCount)s->n_nodes + 1);
  *at = s->n_nodes++;
  node.child = node.next = -1;
  if (parent >= 0) {
    node.next = s->node[parent].child;
    s->node[parent].child = *at;
  }
  s->node[*at] = node;
  return LITHE_OK;
}

/// `sign` 1: the part where the field is negative, -1: where it is positive.
static LitheStatus add_leaf(SolidMaker *m, LitheIndex parent, const LthField *field, int sign) {
  LthSolid *s = m->solid;
  LitheIndex at, node;
  int same = 0;
  for (at = 0; at < s->n_fields; at++) {
    same = compare_fields(&s->field[at], field, s->rounding);
    if (same) break;
  }
  if (at == s->n_fields) {
    LTH_RESERVE(m->ctx, s->field, s->field_cap, (LitheCount)s->n_fields + 1);
    s->field[s->n_fields++] = *field;
    same = 1;
  }
  return add_node(m, parent, (LthSolidNode){.field = at, .sign = sign * same}, &node);
}

static LitheStatus add_plane(SolidMaker *m, LitheIndex parent, const double at[3],
                             const double normal[3], int sign) {
  LthField f = {.kind = LTH_FIELD_PLANE, .axis = -1};
  lth_v3_copy(at, f.at);
  lth_v3_copy(normal, f.normal);
  for (int a = 0; a < 3; a++) {
    if (fabs(normal[a]) < 1 || normal[(a + 1) % 3] != 0 || normal[(a + 2) % 3] != 0) continue;
    f.axis = a;
    if (normal[a] < 0) f.normal[a] = 1, sign = -sign;
  }
  return add_leaf(m, parent, &f, sign);
}

static LitheStatus add_box(SolidMaker *m, LitheIndex parent, const double min[3],
                           const double max[3]) {
  for (int a = 0; a < 3; a++) {
    double normal[3] = {a == 0, a == 1, a == 2};
    LITHE_TRY(add_plane(m, parent, min, normal, -1));
    LITHE_TRY(add_plane(m, parent, max, normal, 1));
  }
  return LITHE_OK;
}

static LitheStatus add_cylinder(SolidMaker *m, LitheIndex parent, const LthShape *s) {
  LthField round = {.kind = LTH_FIELD_ROUND, .radius = s->radius, .axis = -1};
  lth_v3_copy(s->a, round.at);
  lth_v3_sub(s->b, s->a, round.normal);
  lth_v3_normalize(round.normal);
  LITHE_TRY(add_leaf(m, parent, &round, 1));
  LITHE_TRY(add_plane(m, parent, s->a, round.normal, -1));
  return add_plane(m, parent, s->b, round.normal, 1);
}

static LitheStatus add_ball(SolidMaker *m, LitheIndex parent, const double at[3], double radius,
                            int sign) {
  LthField f = {.kind = LTH_FIELD_BALL, .radius = radius, .axis = -1};
  lth_v3_copy(at, f.at);
  return add_leaf(m, parent, &f, sign);
}

static LitheStatus add_whole(SolidMaker *m, LitheIndex parent, const LthShape *s) {
  LthField f = {.kind = s->kind == LTH_SHAPE_IMPLICIT ? LTH_FIELD_FORMULA : LTH_FIELD_VALUE,
                .axis = -1,
                .shape = s};
  return add_leaf(m, parent, &f, 1);
}

static LitheStatus add_shape(SolidMaker *m, LitheIndex parent, const LthShape *s, int sign);

static LitheStatus add_children(SolidMaker *m, LitheIndex parent, const LthShape *s) {
  for (LitheIndex c = 0; c < s->n_children; c++)
    LITHE_TRY(
        add_shape(m, parent, &s->children[c], s->kind == LTH_SHAPE_DIFFERENCE && c > 0 ? -1 : 1));
  return LITHE_OK;
}

static LitheStatus add_shape(SolidMaker *m, LitheIndex parent, const LthShape *s, int sign) {
  LitheIndex at;
  LITHE_TRY(add_node(
      m, parent, (LthSolidNode){.field = -1, .sign = sign, .is_union = s->kind == LTH_SHAPE_UNION},
      &at));
  switch (s->kind) {
  case LTH_SHAPE_BOX:
    return add_box(m, at, s->a, s->b);
  case LTH_SHAPE_CYLINDER:
    return add_cylinder(m, at, s);
  case LTH_SHAPE_SPHERE:
    return add_ball(m, at, s->a, s->radius, 1);
  case LTH_SHAPE_SHELL:
    LITHE_TRY(add_ball(m, at, s->a, s->radius, 1));
    return s->inner > 0 ? add_ball(m, at, s->a, s->inner, -1) : LITHE_OK;
  case LTH_SHAPE_IMPLICIT:
    LITHE_TRY(add_box(m, at, s->box, s->box + 3));
    return add_whole(m, at, s);
  case LTH_SHAPE_CAPSULE:
  case LTH_SHAPE_MESH:
  case LTH_SHAPE_IMAGE:
  case LTH_SHAPE_WRAP:
    return add_whole(m, at, s);
  case LTH_SHAPE_UNION:
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
    return add_children(m, at, s);
  case LTH_SHAPE_DISK:
  case LTH_SHAPE_ANNULUS:
  case LTH_SHAPE_POLYGON:
    break;
  }
  LITHE_FAIL(m->ctx, LITHE_BAD_INPUT, "a shape of two dimensions has no surface in space");
}

LitheStatus lth_solid_create(LitheCtx *ctx, const LthShape *shape, LthSolid **solid) {
  double min[3], max[3];
  LTH_NEW(ctx, *solid, 1);
  lth_shape_bounds(shape, min, max);
  (*solid)->rounding = SAME * lth_v3_distance(min, max);
  LitheStatus status = add_shape(&(SolidMaker){ctx, *solid}, -1, shape, 1);
  if (status != LITHE_OK) lth_solid_destroy(ctx, solid);
  return status;
}

void lth_solid_destroy(LitheCtx *ctx, LthSolid **solid) {
  if (!solid || !*solid) return;
  lth_free(ctx, (*solid)->field);
  lth_free(ctx, (*solid)->node);
  lth_free(ctx, *solid);
  *solid = NULL;
}

// ------------------------------------------------------------------ sides

/// Kleene's logic of three values: an intersection is where its last part is, a union where its first.
static LthFieldSide node_side(const LthSolid *s, LitheIndex at, const LthFieldSide *side) {
  const LthSolidNode *node = &s->node[at];
  if (node->field >= 0) return (LthFieldSide)(node->sign * side[node->field]);
  int joined = node->is_union ? 1 : -1;
  for (LitheIndex c = node->child; c >= 0; c = s->node[c].next) {
    int of_child = node_side(s, c, side);
    if (node->is_union ? of_child < joined : of_child > joined) joined = of_child;
    if (joined == (node->is_union ? -1 : 1)) break;
  }
  if (node->child < 0) joined = 1;
  return (LthFieldSide)(node->sign * joined);
}

LthFieldSide lth_solid_side(const LthSolid *solid, const LthFieldSide *side) {
  return node_side(solid, 0, side);
}

/// Put a number into a rising list that does not have it yet.
static LitheIndex insert(LitheIndex n, LitheIndex cap, LitheIndex *list, LitheIndex number) {
  LitheIndex at = n < cap ? n : cap;
  for (LitheIndex i = 0; i < at; i++)
    if (list[i] == number) return n;
  if (n >= cap) return n + 1;
  for (; at > 0 && list[at - 1] > number; at--) list[at] = list[at - 1];
  list[at] = number;
  return n + 1;
}

static LitheIndex collect(const LthSolid *s, LitheIndex at, const LthFieldSide *side, LitheIndex n,
                          LitheIndex cap, LitheIndex *field) {
  const LthSolidNode *node = &s->node[at];
  if (node_side(s, at, side) != 0) return n;
  if (node->field >= 0) return insert(n, cap, field, node->field);
  for (LitheIndex c = node->child; c >= 0; c = s->node[c].next)
    n = collect(s, c, side, n, cap, field);
  return n;
}

LitheIndex lth_solid_undecided(const LthSolid *solid, const LthFieldSide *side, LitheIndex cap,
                               LitheIndex *field) {
  return collect(solid, 0, side, 0, cap, field);
}
