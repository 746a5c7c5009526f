/// Flat sides of staggered bodies that rollers hold, which smooth fractions take as planes of symmetry.
#include "scene/staggered_body.h"

#include "base/tensor.h"
#include "geometry/fractions_mirror.h"

#define STRAIGHT 1e-6 // sine of the angle between a flat side's normal and its axis
#define SAME 1e-6     // of a cell: places in one plane
#define BESIDE 0.5    // of a cell: how far a side is flat at least

/// A flat side and the constraint that holds what is normal to it.
typedef struct Side {
  const LthWhereSolid *where;
  LthMirror mirror;
} Side;

typedef struct Sides {
  LthBody *body;
  LthWhereSolid *where; ///< of all constraints                       (n_constraints)
  Side *side;
  LitheCount n, cap;
} Sides;

static bool side_contains(const void *self, const double x[3]) {
  const Side *side = self;
  LthPlace place = {.x = {x[0], x[1], x[2]}, .is_boundary = true, .point = {x[0], x[1], x[2]}};
  place.normal[side->mirror.axis] = side->mirror.sign;
  return lth_where_solid_contains(side->where, &place);
}

/// The axis of a normal that is one; its components that are held have to be those alone.
static int roller_axis(const LthBody *body, const LthSceneConstraint *c, const double normal[3]) {
  for (int a = 0; a < body->scene->dimension; a++) {
    bool is_alone = fabs(normal[a]) > 1 - STRAIGHT;
    for (int b = 0; b < 3; b++)
      is_alone =
          is_alone && (a == b || (fabs(normal[b]) < STRAIGHT &&
                                  (c->normal_only || b >= body->scene->dimension || !c->fixed[b])));
    if (is_alone && (c->normal_only || c->fixed[a])) return a;
  }
  return -1;
}

/// Does the boundary near a boundary point lie in the same plane, on one side at least along each axis?
static bool is_flat(const LthBody *body, const LthPlace *at, int axis) {
  const double h = body->staggered->h;
  for (int b = 0; b < body->scene->dimension; b++) {
    bool found = b == axis;
    for (int side = -1; side <= 1 && !found; side += 2) {
      LthFoot foot;
      double x[3];
      lth_v3_copy(at->point, x);
      x[b] += side * BESIDE * h;
      found = lth_shape_foot(&body->def->shape, x, h, &foot) &&
              fabs(foot.point[axis] - at->point[axis]) < SAME * h &&
              fabs(foot.normal[axis]) > 1 - STRAIGHT;
    }
    if (!found) return false;
  }
  return true;
}

static LitheStatus note_side(LitheCtx *ctx, Sides *s, LitheIndex constraint, int axis,
                             const LthPlace *at) {
  const LthWhereSolid *where = &s->where[constraint];
  LthMirror mirror = {
      .axis = axis, .sign = at->normal[axis] > 0 ? 1 : -1, .place = at->point[axis]};
  for (LitheCount i = 0; i < s->n; i++) {
    const LthMirror *m = &s->side[i].mirror;
    if (s->side[i].where == where && m->axis == axis && m->sign == mirror.sign &&
        fabs(m->place - mirror.place) < SAME * s->body->staggered->h)
      return LITHE_OK;
  }
  if (!is_flat(s->body, at, axis)) return LITHE_OK;
  LTH_RESERVE(ctx, s->side, s->cap, s->n + 1);
  s->side[s->n++] = (Side){.where = where, .mirror = mirror};
  return LITHE_OK;
}

/// Sides that a constraint holds, from boundary points near cells that are cut.
static LitheStatus find_sides(LitheCtx *ctx, Sides *s, LitheIndex constraint) {
  static const double middle[3] = {0.5, 0.5, 0.5};
  const LthStaggeredBody *b = s->body->staggered;
  const LthSceneConstraint *c = s->body->def->constraints + constraint;
  const LthSparseGrid *g = b->fractions->grid;
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    LitheIndex at[3];
    LthPlace place;
    double x[3];
    if (!(b->filled[slot] > 0) || b->filled[slot] == 1) continue;
    lth_sparse_grid_cell(g, slot, at);
    lth_sparse_grid_place(g, at, middle, x);
    if (!lth_where_solid_is_near(&s->where[constraint], x, 2 * b->diagonal)) continue;
    if (!lth_staggered_boundary_place(s->body, x, b->diagonal, &place)) continue;
    int axis = roller_axis(s->body, c, place.normal);
    if (axis < 0) continue;
    lth_v3_copy(place.point, place.x);
    if (lth_where_solid_contains(&s->where[constraint], &place))
      LITHE_TRY(note_side(ctx, s, constraint, axis, &place));
  }
  return LITHE_OK;
}

/// Give the sides to the fractions.
static LitheStatus mirror_at(LitheCtx *ctx, const Sides *s) {
  const LthSceneBody *def = s->body->def;
  LthMirror *mirror = NULL;
  if (s->n == 0) return LITHE_OK;
  LTH_NEW(ctx, mirror, (LitheIndex)s->n);
  for (LitheCount i = 0; i < s->n; i++) {
    mirror[i] = s->side[i].mirror;
    mirror[i].contains = side_contains;
    mirror[i].self = &s->side[i];
  }
  LitheStatus status = lth_fractions_mirror(ctx, s->body->staggered->fractions, &def->shape,
                                            &def->fractions, mirror, (LitheIndex)s->n);
  lth_free(ctx, mirror);
  return status;
}

LitheStatus lth_staggered_mirror_sides(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  Sides s = {.body = body};
  LitheIndex n = 0;
  LTH_NEW_OR(done, ctx, s.where, body->def->n_constraints);
  for (; n < body->def->n_constraints; n++) {
    const LthSceneConstraint *c = body->def->constraints + n;
    LITHE_TRY_OR(done, lth_staggered_where(ctx, body, &c->where, c->interior, &s.where[n]));
  }
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY_OR(done, find_sides(ctx, &s, i));
  LITHE_TRY_OR(done, mirror_at(ctx, &s));
done:
  for (LitheIndex i = 0; s.where && i < body->def->n_constraints; i++)
    lth_where_solid_free(ctx, &s.where[i]);
  lth_free(ctx, s.where);
  lth_free(ctx, s.side);
  return status;
}
