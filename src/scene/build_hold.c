/// Constraints of staggered bodies: which unknowns they hold, which sides of the surface count as full, and which are rollers of another
/// kind.
#include "scene/staggered_body.h"

#include "base/tensor.h"
#include "geometry/fractions_complete.h"
#include "scene/expression.h"

#include <string.h>

#define ALONG 0.5     // cosine: a normal that looks along an axis, be it at an edge
#define STRAIGHT 1e-6 // sine of the angle by which a roller's normal may miss its axis
#define ALIGNED 1e-6  // of a cell: a side along faces of the grid
#define DIRECTIONS 6  // of a roller: along each axis and against it
#define INSIDE 1e-3   // of a cell: where an edge is one of its sides
#define BESIDE 0.5    // of a cell: how far a side is flat at least

static bool is_axis(const double n[3]) {
  return fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2]))) >= 1 - STRAIGHT;
}

/// The normal of the boundary nearest to a place a little inside, where edges have that of a side, and aside along axis b.
static bool normal_beside(const LthBody *body, const LthPlace *place, int b, double aside,
                          double normal[3]) {
  const double h = body->staggered->h;
  LthFoot foot;
  double x[3];
  lth_v3_copy(place->point, x);
  lth_v3_axpy(-INSIDE * h, place->normal, x);
  x[b] += aside * h;
  bool found = lth_shape_foot(&body->def->shape, x, h, &foot);
  lth_v3_copy(foot.normal, normal);
  return found;
}

/// Is the boundary at a place a plane across an axis? Curved ones have an axis for normal at single points.
static bool is_along_axis(const LthBody *body, const LthPlace *place) {
  double own[3], other[3];
  if (!normal_beside(body, place, 0, 0, own) || !is_axis(own)) return false;
  for (int b = 0; b < body->scene->dimension; b++) {
    bool is_flat = fabs(own[b]) > ALONG;
    for (int side = -1; side <= 1 && !is_flat; side += 2)
      is_flat = normal_beside(body, place, b, side * BESIDE, other) &&
                lth_v3_dot(own, other) >= 1 - STRAIGHT;
    if (!is_flat) return false;
  }
  return true;
}

static double against(const void *self, const double x[3], double t) {
  const LthHoldPlace *p = self;
  return -lth_value_at(&p->value, x, t);
}

/// Is a place of the boundary selected, by itself or by the boundary point nearest to it?
static bool contains_either(const LthWhereSolid *where, LthPlace *place) {
  if (lth_where_solid_contains(where, place)) return true;
  lth_v3_copy(place->point, place->x);
  return lth_where_solid_contains(where, place);
}

/// Unknowns inside `where`, and those on or beyond the boundary whose nearest boundary point is; of rollers these alone, with a
/// normal that looks their way.
static bool selects(const void *self, const double x[3]) {
  const LthHoldPlace *h = self;
  LthPlace place = {.x = {x[0], x[1], x[2]}};
  if (!h->is_roller && lth_where_solid_contains(h->where, &place)) return true;
  if (!lth_where_solid_is_near(h->where, x, 2 * h->body->staggered->diagonal)) return false;
  if (!lth_staggered_boundary_place(h->body, x, 0, &place)) return false;
  if (h->is_roller && !(h->sign * place.normal[h->axis] > ALONG)) return false;
  if (h->is_roller && *h->is_oblique && !is_along_axis(h->body, &place)) return false;
  return contains_either(h->where, &place);
}

static bool holds_wholly(const LthBody *body, const LthSceneConstraint *c) {
  bool all = !c->normal_only;
  for (int a = 0; a < body->scene->dimension; a++) all = all && c->fixed[a];
  return all;
}

/// All components by a displacement that is the same everywhere.
static bool is_wall(const LthBody *body, const LthSceneConstraint *c) {
  bool even = holds_wholly(body, c) && !c->is_position;
  for (int a = 0; a < body->scene->dimension; a++) {
    const LthValue *v = &c->value[a];
    even = even && (!v->eval || (v->eval == lth_expression_eval &&
                                 !(lth_expression_uses(v->self) & ~LTH_USES_T)));
  }
  return even;
}

static void add_hold(LthBody *body, LitheIndex constraint, int axis, double sign) {
  LthStaggeredBody *s = body->staggered;
  const LthSceneConstraint *c = body->def->constraints + constraint;
  LthHoldPlace *place = s->hold_place + s->n_holds;
  LthStaggeredHold *hold = s->holds + s->n_holds;
  s->hold_of[s->n_holds++] = constraint;
  *place = (LthHoldPlace){.body = body,
                          .where = s->constraint_where + constraint,
                          .is_roller = c->normal_only,
                          .is_oblique = s->is_oblique + constraint,
                          .axis = axis,
                          .sign = sign,
                          .value = c->value[0]};
  *hold = (LthStaggeredHold){.selects = selects,
                             .self = place,
                             .is_position = c->is_position,
                             .is_wall = is_wall(body, c)};
  memcpy(hold->value, c->value, sizeof hold->value);
  memcpy(hold->fixed, c->fixed, sizeof hold->fixed);
  if (!c->normal_only) return;
  memset(hold->fixed, 0, sizeof hold->fixed);
  hold->fixed[axis] = true;
  hold->value[axis] = c->value[0];
  if (sign < 0 && c->value[0].eval)
    hold->value[axis] = (LthValue){.eval = against, .self = place};
  else if (sign < 0)
    hold->value[axis].constant = -c->value[0].constant;
}

// --- sides that are held count as full ---

/// Does a constraint hold the material behind a boundary with this normal?
static bool holds_along(const LthBody *body, const LthSceneConstraint *c, const double normal[3]) {
  double along = 0;
  for (int a = 0; a < body->scene->dimension; a++)
    if (c->fixed[a]) along += normal[a] * normal[a];
  return c->normal_only || along > ALONG;
}

/// Does a boundary along an axis pass between the faces of the cell of a part at x?
static bool is_cut_through(const LthBody *body, const double x[3], const LthPlace *place) {
  const LthSparseGrid *g = body->staggered->fractions->grid;
  for (int a = 0; a < g->dim; a++) {
    if (fabs(place->normal[a]) < 1 - STRAIGHT) continue;
    double cell = floor((x[a] - g->origin[a]) / g->h[a]);
    double t = (place->point[a] - g->origin[a]) / g->h[a] - cell;
    return t > ALIGNED && t < 1 - ALIGNED;
  }
  return true;
}

/// A part of a cell at the boundary. A roller's side that lies along faces of the grid cuts nothing. Beyond the surface only what holds all components goes on,
/// and only where the boundary itself is selected: a constraint that ends before the body does not reach it.
static bool part_is_held(const LthBody *body, const double x[3], bool is_cut) {
  const LthStaggeredBody *s = body->staggered;
  LthPlace place;
  bool is_known = false;
  for (LitheIndex i = 0; i < body->def->n_constraints; i++) {
    const LthSceneConstraint *c = body->def->constraints + i;
    const LthWhereSolid *where = s->constraint_where + i;
    bool wholly = holds_wholly(body, c);
    if (!wholly && !is_cut) continue;
    if (!lth_where_solid_is_near(where, x, 2 * s->diagonal)) continue;
    if (!is_known && !lth_staggered_boundary_place(body, x, s->diagonal, &place)) return false;
    is_known = true;
    if (!wholly && !(holds_along(body, c, place.normal) && is_cut_through(body, x, &place)))
      continue;
    if (s->is_oblique[i] && !is_along_axis(body, &place)) continue;
    lth_v3_copy(is_cut ? x : place.point, place.x);
    if (contains_either(where, &place)) return true;
  }
  return false;
}

/// A cell without material counts where it has a face in common with one that has.
static bool has_full_side(const LthStaggeredBody *s, LitheCount slot) {
  const LthSparseGrid *g = s->fractions->grid;
  for (int a = 0; a < g->dim; a++)
    for (int side = -1; side <= 1; side += 2) {
      int step[3] = {a == 0 ? side : 0, a == 1 ? side : 0, a == 2 ? side : 0};
      LitheCount other = lth_sparse_grid_step(g, slot, step);
      if (other >= 0 && s->filled[other] > 0) return true;
    }
  return false;
}

/// Parts that become full.
static uint8_t choose_parts(const void *self, LitheCount slot) {
  const LthBody *body = self;
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  bool is_cut = s->filled[slot] > 0;
  uint8_t mask = 0;
  LitheIndex at[3];
  if (!is_cut && !has_full_side(s, slot)) return 0;
  lth_sparse_grid_cell(g, slot, at);
  for (int q = 0; q < s->fractions->n_parts; q++) {
    double x[3], offset[3] = {q & 1 ? 0.75 : 0.25, q & 2 ? 0.75 : 0.25,
                              g->dim == 2 ? 0.5
                              : q & 4     ? 0.75
                                          : 0.25};
    if (lth_fractions_part(s->fractions, slot, q) == 1) continue;
    lth_sparse_grid_place(g, at, offset, x);
    if (part_is_held(body, x, is_cut)) mask |= (uint8_t)(1 << q);
  }
  return mask;
}

// --- rollers that are not along an axis ---

/// Place q of a cell, one in each part; beside its middle, lest it be on the boundary of shapes that fit the grid, where normals are those
/// of rounding.
static void place_in_part(const LthSparseGrid *g, LitheCount slot, int q, double x[3]) {
  LitheIndex at[3];
  double offset[3] = {0.27 + 0.5 * (q & 1), 0.26 + 0.5 * (q >> 1 & 1), 0.24 + 0.5 * (q >> 2)};
  if (g->dim == 2) offset[2] = 0.5;
  lth_sparse_grid_cell(g, slot, at);
  lth_sparse_grid_place(g, at, offset, x);
}

/// Does roller i hold boundary that is not along an axis near a place inside the body?
static bool is_oblique_near(const LthBody *body, LitheIndex i, const double x[3], LthPlace *place) {
  const LthStaggeredBody *s = body->staggered;
  if (!lth_staggered_boundary_place(body, x, s->diagonal, place)) return false;
  if (lth_shape_value(&body->def->shape, x) >= 0) return false; // normals at edges look anywhere
  lth_v3_copy(place->point, place->x);
  return !is_axis(place->normal) && lth_where_solid_contains(s->constraint_where + i, place);
}

/// A place of a roller whose normal is no axis; false where there is none.
static bool find_oblique(const LthBody *body, LitheIndex i, LthPlace *place) {
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    if (!(s->filled[slot] > 0) || s->filled[slot] == 1) continue;
    for (int q = 0; q < s->fractions->n_parts; q++) {
      double x[3];
      place_in_part(g, slot, q, x);
      if (is_oblique_near(body, i, x, place)) return true;
    }
  }
  return false;
}

static bool selects_oblique(const void *self, const double point[3], const double normal[3]) {
  const LthRollerPlace *r = self;
  const LthPlace place = lth_place_at_boundary(point, normal);
  return !is_along_axis(r->body, &place) && lth_where_solid_contains(r->where, &place);
}

static LitheStatus add_roller(LitheCtx *ctx, LthBody *body, LitheIndex i) {
  LthStaggeredBody *s = body->staggered;
  const LthSceneConstraint *c = body->def->constraints + i;
  LthPlace place;
  if (!find_oblique(body, i, &place)) return LITHE_OK;
  const double *n = place.normal, *x = place.point;
  if (body->def->materials[0].material.model != LTH_MATERIAL_LINEAR)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: staggered bodies of large deformation are held along the axes, got a roller "
               "with the normal (%.4g, %.4g, %.4g) at (%g, %g, %g); expected a boundary along an "
               "axis, model: linear, or method dg",
               c->place, n[0], n[1], n[2], x[0], x[1], x[2]);
  LthRollerPlace *of = s->roller_place + s->n_rollers;
  *of = (LthRollerPlace){.body = body, .where = s->constraint_where + i};
  s->rollers[s->n_rollers++] = (LthStaggeredRoller){
      .selects = selects_oblique, .self = of, .value = c->value[0], .moves = lth_moves(c->value)};
  s->is_oblique[i] = true;
  LTH_RESERVE(ctx, body->weak_of, body->cap_weak_of, body->n_weak + 1);
  body->weak_of[body->n_weak++] = i;
  return LITHE_OK;
}

LitheStatus lth_staggered_hold_sides(LitheCtx *ctx, LthBody *body) {
  LthStaggeredBody *s = body->staggered;
  LitheIndex n = body->def->n_constraints;
  LTH_NEW(ctx, s->constraint_where, n);
  LTH_NEW(ctx, s->holds, DIRECTIONS * (LitheCount)n);
  LTH_NEW(ctx, s->hold_place, DIRECTIONS * (LitheCount)n);
  LTH_NEW(ctx, s->hold_of, DIRECTIONS * (LitheCount)n);
  LTH_NEW(ctx, s->is_oblique, n);
  LTH_NEW(ctx, s->rollers, n);
  LTH_NEW(ctx, s->roller_place, n);
  for (LitheIndex i = 0; i < n; i++) {
    const LthSceneConstraint *c = body->def->constraints + i;
    s->n_constraints = i + 1;
    LITHE_TRY(lth_staggered_where(ctx, body, &c->where, c->interior, s->constraint_where + i));
    for (int k = 0; c->normal_only && k < 2 * body->scene->dimension; k++)
      add_hold(body, i, k / 2, k % 2 ? -1 : 1);
    if (!c->normal_only) add_hold(body, i, 0, 1);
    if (c->normal_only) LITHE_TRY(add_roller(ctx, body, i));
  }
  return n > 0 ? lth_fractions_complete(ctx, s->fractions, choose_parts, body, &s->own) : LITHE_OK;
}

/// Would some unknown be held by constraint i, were there no others?
static bool selects_any(const LthBody *body, LitheIndex i) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  const LthStaggeredBody *b = body->staggered;
  for (LitheIndex func = 0; func < s->disc.n_funcs; func++)
    for (int a = 0; a < s->dim; a++) {
      double x[3];
      if (s->level.state[a][s->slot[func]] == LTH_UNKNOWN_DEAD) continue;
      lth_staggered_place(s, func, a, x);
      for (LitheIndex k = 0; k < b->n_holds; k++)
        if (b->hold_of[k] == i && b->holds[k].fixed[a] && selects(b->holds[k].self, x)) return true;
    }
  return false;
}

LitheStatus lth_staggered_check_holds(LitheCtx *ctx, const LthBody *body) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  const double *box = body->box;
  uint8_t *found = NULL;
  LTH_NEW(ctx, found, body->def->n_constraints);
  for (LitheCount k = 0; k < s->disc.n_dofs; k++)
    if (s->hold[k] >= 0) found[body->staggered->hold_of[s->hold[k]]] = 1;
  LitheIndex empty = -1;
  for (LitheIndex k = 0; k < body->n_weak; k++)
    if (lth_staggered_roller_acts(body->disc, k)) found[body->weak_of[k]] = 1;
  for (LitheIndex i = 0; i < body->def->n_constraints && empty < 0; i++)
    if (!found[i] && !selects_any(body, i)) empty = i;
  lth_free(ctx, found);
  if (empty < 0) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects no unknown of the grid; the body reaches from (%g, %g, %g) to (%g, "
             "%g, %g)",
             body->def->constraints[empty].place, box[0], box[1], box[2], box[3], box[4], box[5]);
}
