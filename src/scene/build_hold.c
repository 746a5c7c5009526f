/// Constraints of staggered bodies: which unknowns they hold, and which sides of the surface count as full.
#include "scene/staggered_body.h"

#include "base/tensor.h"
#include "geometry/fractions_complete.h"
#include "scene/expression.h"

#include <string.h>

#define ALONG 0.5     // cosine: a normal that looks along an axis, be it at an edge
#define STRAIGHT 1e-6 // sine of the angle by which a roller's normal may miss its axis
#define ALIGNED 1e-6  // of a cell: a side along faces of the grid
#define DIRECTIONS 6  // of a roller: along each axis and against it

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

// --- rollers hold along an axis ---

/// The first place of a roller whose normal is no axis.
static LitheStatus check_roller(LitheCtx *ctx, const LthBody *body, LitheIndex i) {
  static const double middle[3] = {0.5, 0.5, 0.5};
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    LitheIndex at[3];
    LthPlace place;
    double x[3];
    if (!(s->filled[slot] > 0) || s->filled[slot] == 1) continue;
    lth_sparse_grid_cell(g, slot, at);
    lth_sparse_grid_place(g, at, middle, x);
    if (!lth_staggered_boundary_place(body, x, s->diagonal, &place)) continue;
    if (lth_shape_value(&body->def->shape, x) >= 0) continue; // normals at edges look anywhere
    lth_v3_copy(place.point, place.x);
    if (!lth_where_solid_contains(s->constraint_where + i, &place)) continue;
    const double *n = place.normal;
    double most = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
    if (most >= 1 - STRAIGHT) continue;
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: unknowns of a staggered grid are held along the axes, got a roller with the "
               "normal (%.4g, %.4g, %.4g) at (%g, %g, %g); expected a boundary along an axis, or "
               "method dg",
               body->def->constraints[i].place, n[0], n[1], n[2], place.point[0], place.point[1],
               place.point[2]);
  }
  return LITHE_OK;
}

LitheStatus lth_staggered_hold_sides(LitheCtx *ctx, LthBody *body) {
  LthStaggeredBody *s = body->staggered;
  LitheIndex n = body->def->n_constraints;
  LTH_NEW(ctx, s->constraint_where, n);
  LTH_NEW(ctx, s->holds, DIRECTIONS * (LitheCount)n);
  LTH_NEW(ctx, s->hold_place, DIRECTIONS * (LitheCount)n);
  LTH_NEW(ctx, s->hold_of, DIRECTIONS * (LitheCount)n);
  for (LitheIndex i = 0; i < n; i++) {
    const LthSceneConstraint *c = body->def->constraints + i;
    s->n_constraints = i + 1;
    LITHE_TRY(lth_staggered_where(ctx, body, &c->where, c->interior, s->constraint_where + i));
    for (int k = 0; c->normal_only && k < 2 * body->scene->dimension; k++)
      add_hold(body, i, k / 2, k % 2 ? -1 : 1);
    if (!c->normal_only) add_hold(body, i, 0, 1);
    if (c->normal_only) LITHE_TRY(check_roller(ctx, body, i));
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
  for (LitheIndex i = 0; i < body->def->n_constraints && empty < 0; i++)
    if (!found[i] && !selects_any(body, i)) empty = i;
  lth_free(ctx, found);
  if (empty < 0) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects no unknown of the grid; the body reaches from (%g, %g, %g) to (%g, "
             "%g, %g)",
             body->def->constraints[empty].place, box[0], box[1], box[2], box[3], box[4], box[5]);
}
