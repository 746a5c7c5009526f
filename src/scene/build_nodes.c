/// Constraints of conforming bodies: nodes that are held, or terms on the boundary; and their discretisation.
#include "scene/body.h"

#include "base/tensor.h"
#include "mesh/node_selection.h"
#include "mesh/where.h"

#include <math.h>
#include <string.h>

/// A constraint holds one motion, a roller one for each direction of the axes.
#define MOTIONS 7

/// The axis that a normal lies along: 1 + axis, negative where it points back; 0: none.
static int axis_of(const double normal[3]) {
  for (int a = 0; a < 3; a++)
    if (fabs(normal[a]) > 1 - 1e-9) return normal[a] > 0 ? 1 + a : -1 - a;
  return 0;
}

static const double *piece_normal(const LthBody *body, const LthPatches *patches, LitheIndex i) {
  return body->mesh->face_normal + 3 * (LitheCount)patches->face[i];
}

static LitheStatus build_disc(LitheCtx *ctx, LthBody *body) {
  LthCgDef def = {.elements = body->elements,
                  .mesh = body->mesh,
                  .cell_element = body->cell_element,
                  .young = body->young,
                  .poisson = body->poisson,
                  .density = body->density,
                  .warped = body->warped,
                  .weak = body->weak,
                  .n_weak = body->n_weak};
  return lth_cg_disc_create(ctx, &def, &body->disc);
}

/// Holding of nodes while it is collected.
typedef struct Holding {
  LitheCtx *ctx;
  const LthBody *body;
  LthPatches *patches;   ///< of the constraint at hand, or NULL
  LitheIndex *motion_of; ///< (n_dofs)
  LthCgMotion *motions;  ///< (n_constraints x MOTIONS)
  uint8_t *node;         ///< scratch (n_funcs)
} Holding;

/// Give the marked nodes' components that no earlier constraint has to a motion; clears the marks.
static bool take_nodes(const Holding *h, LitheIndex motion, const bool fixed[3]) {
  bool any = false;
  for (LitheIndex i = 0; i < h->body->disc->n_funcs; i++) {
    if (!h->node[i]) continue;
    h->node[i] = 0;
    any = true;
    for (int a = 0; a < 3; a++) {
      LitheIndex *of = h->motion_of + 3 * (LitheCount)i + a;
      if (fixed[a] && *of < 0) *of = motion;
    }
  }
  return any;
}

/// Nodes inside `where`, and those of cells inside it where elements reach beyond the body.
static LitheStatus mark_interior(const Holding *h, const LthWhere *where) {
  const LthBody *body = h->body;
  LitheStatus status = LITHE_OK;
  LthWhereReady ready = {0};
  LthPatches *patches = NULL;
  uint8_t *cells = NULL;
  LITHE_TRY_OR(done, lth_where_prepare(h->ctx, body->mesh, where, &ready));
  LITHE_TRY_OR(done, lth_select_boundary(h->ctx, body->mesh, where, &patches));
  LTH_NEW_OR(done, h->ctx, cells, body->mesh->n_cells);
  for (LitheIndex i = 0; i < patches->n; i++) lth_cg_patch_nodes(body->disc, patches, i, h->node);
  if (body->cell_element) LITHE_TRY_OR(done, lth_select_cells(h->ctx, body->mesh, where, cells));
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    if (!cells[c]) continue;
    LitheIndex e = body->cell_element[c];
    for (LitheIndex k = body->elements->element_off[e]; k < body->elements->element_off[e + 1]; k++)
      h->node[body->elements->element_node[k]] = 1;
  }
  for (LitheIndex i = 0; !body->cell_element && i < body->elements->n_nodes; i++)
    if (lth_where_contains(&ready, body->elements->nodes + 3 * (LitheCount)i, -1)) h->node[i] = 1;
done:
  lth_where_ready_free(h->ctx, &ready);
  lth_patches_destroy(h->ctx, &patches);
  lth_free(h->ctx, cells);
  return status;
}

/// Hold the nodes of a roller: on every piece the component along its axis.
static LitheStatus hold_roller(const Holding *h, LitheIndex constraint, bool *any) {
  const LthBody *body = h->body;
  for (LitheIndex i = 0; i < h->patches->n; i++) {
    const double *n = piece_normal(body, h->patches, i);
    if (axis_of(n) == 0)
      LITHE_FAIL(h->ctx, LITHE_BAD_INPUT,
                 "%s: nodes cannot be held along a normal that is no axis, got (%g, %g, %g); use "
                 "`enforce: weak`",
                 body->def->constraints[constraint].place, n[0], n[1], n[2]);
  }
  for (int direction = -3; direction <= 3; direction++) {
    bool fixed[3] = {direction == 1 || direction == -1, direction == 2 || direction == -2,
                     direction == 3 || direction == -3};
    if (direction == 0) continue;
    for (LitheIndex i = 0; i < h->patches->n; i++)
      if (axis_of(piece_normal(body, h->patches, i)) == direction)
        lth_cg_patch_nodes(body->disc, h->patches, i, h->node);
    *any = take_nodes(h, MOTIONS * constraint + 3 + direction, fixed) || *any;
  }
  return LITHE_OK;
}

/// The motions of a constraint: rollers have three times two directions about the free place 3.
static void set_motions(const LthSceneConstraint *c, LitheIndex i, LthCgMotion *motions) {
  for (int k = 0; k < MOTIONS; k++) {
    LthCgMotion *m = motions + MOTIONS * i + k;
    *m = (LthCgMotion){.constraint = i, .is_position = c->is_position};
    for (int a = 0; a < 3; a++) {
      m->value[a] = c->value[c->normal_only ? 0 : a];
      m->factor[a] = c->normal_only && k < 3 ? -1 : 1;
    }
  }
}

static LitheStatus mark_nodes(Holding *h, const LthSceneConstraint *c) {
  const LthBody *body = h->body;
  if (c->interior) return mark_interior(h, &c->where);
  if (lth_where_has_label(&c->where) && !c->normal_only && !body->cell_element)
    return lth_select_nodes(h->ctx, body->mesh, body->elements, &c->where, h->node);
  LITHE_TRY(lth_build_patches(h->ctx, body, c->place, &c->where, &h->patches));
  for (LitheIndex k = 0; !c->normal_only && k < h->patches->n; k++)
    lth_cg_patch_nodes(body->disc, h->patches, k, h->node);
  return LITHE_OK;
}

static LitheStatus hold(Holding *h, LitheIndex i) {
  const LthBody *body = h->body;
  const LthSceneConstraint *c = body->def->constraints + i;
  bool any = false;
  set_motions(c, i, h->motions);
  LitheStatus status = mark_nodes(h, c);
  if (status == LITHE_OK && c->normal_only)
    status = hold_roller(h, i, &any);
  else if (status == LITHE_OK)
    any = take_nodes(h, MOTIONS * i + 3, c->fixed);
  if (h->patches) lth_patches_destroy(h->ctx, &h->patches);
  LITHE_TRY(status);
  if (any) return LITHE_OK;
  LITHE_FAIL(h->ctx, LITHE_BAD_INPUT,
             "%s.where: selects no node; the body reaches from (%g, %g, %g) to (%g, %g, %g)",
             c->place, body->box[0], body->box[1], body->box[2], body->box[3], body->box[4],
             body->box[5]);
}

static LitheStatus hold_nodes(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = body->def->n_constraints;
  Holding h = {.ctx = ctx, .body = body};
  LTH_NEW_OR(done, ctx, h.motion_of, body->disc->n_dofs);
  LTH_NEW_OR(done, ctx, h.motions, MOTIONS * (LitheCount)n);
  LTH_NEW_OR(done, ctx, h.node, body->disc->n_funcs);
  for (LitheCount i = 0; i < body->disc->n_dofs; i++) h.motion_of[i] = -1;
  for (LitheIndex i = 0; i < n; i++)
    if (lth_is_strong(body->def->constraints + i)) LITHE_TRY_OR(done, hold(&h, i));
  LITHE_TRY_OR(done, lth_cg_strong_create(ctx, body->disc, h.motion_of, MOTIONS * n, h.motions,
                                          &body->held_nodes));
done:
  lth_free(ctx, h.motion_of);
  lth_free(ctx, h.motions);
  lth_free(ctx, h.node);
  return status;
}

LitheStatus lth_build_nodes(LitheCtx *ctx, LthBody *body) {
  bool any = false;
  for (LitheIndex i = 0; i < body->def->n_constraints; i++) {
    if (lth_is_strong(body->def->constraints + i))
      any = true;
    else
      LITHE_TRY(lth_build_weak(ctx, body, i));
  }
  LITHE_TRY(build_disc(ctx, body));
  return any ? hold_nodes(ctx, body) : LITHE_OK;
}
