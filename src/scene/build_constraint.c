/// Constraints of a scene -> weak constraints on boundary patches, and strong ones of elements.
#include "scene/boundary_parts.h"

#include "base/tensor.h"
#include "scene/change.h"
#include "scene/expression.h"

#include <math.h>
#include <string.h>

/// What may have kept a selection from finding anything, by the kind of mesh.
static const char *hint_of(const LthSceneBody *def) {
  if (def->mesh_kind == LTH_MESH_VOXELS)
    return "; voxels leave out parts thinner than half a cell: take smaller cells or `mesh: "
           "embedded`";
  if (def->mesh_kind == LTH_MESH_FILE)
    return "; of a mesh file only whole boundary faces are selected, a set of single nodes has "
           "none";
  return "";
}

LitheStatus lth_build_patches(LitheCtx *ctx, const LthBody *body, const char *place,
                              const LthWhere *where, LthPatches **patches) {
  const double *box = body->box;
  bool is_loss = false;
  LITHE_TRY(lth_select_boundary(ctx, body->mesh, where, patches));
  if ((*patches)->n > 0) return LITHE_OK;
  LitheStatus status = lth_body_lose(ctx, body, place, &is_loss);
  if (status == LITHE_OK && is_loss) return LITHE_OK;
  lth_patches_destroy(ctx, patches);
  LITHE_TRY(status);
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "%s.where: selects nothing of the body's boundary; the body reaches from (%g, %g, %g) to "
      "(%g, %g, %g)%s",
      place, box[0], box[1], box[2], box[3], box[4], box[5], hint_of(body->def));
}

LitheStatus lth_body_own_patches(LitheCtx *ctx, LthBody *body, LthPatches *patches) {
  LitheStatus status = lth_reserve_(ctx, (void **)&body->patches, &body->cap_patches,
                                    body->n_patches + 1, sizeof(LthPatches *));
  if (status != LITHE_OK)
    lth_patches_destroy(ctx, &patches);
  else
    body->patches[body->n_patches++] = patches;
  return status;
}

bool lth_is_strong(const LthSceneConstraint *c) { return c->strong || c->interior; }

// --- weak ---

/// Two weak constraints on the same boundary are held there once: the one that holds everything counts, then
/// the one that comes first.
static bool comes_before(const LthSceneBody *def, LitheIndex j, LitheIndex i) {
  const LthSceneConstraint *a = def->constraints + j, *b = def->constraints + i;
  if (i == j || lth_is_strong(a)) return false;
  if (lth_holds_wholly(a) != lth_holds_wholly(b)) return lth_holds_wholly(a);
  return j < i;
}

/// How the held components of a mask meet the normals of a part.
typedef enum Meeting { APART, WITHIN, ASKEW } Meeting;

/// APART: at right angles to every normal. WITHIN: every normal lies among them.
static Meeting meet(const LthBody *body, const LthPatches *patches, const bool held[3]) {
  bool apart = true, within = true;
  for (LitheIndex p = 0; p < patches->n; p++) {
    const double *n = body->mesh->face_normal + 3 * (LitheCount)patches->face[p];
    for (int a = 0; a < 3; a++)
      if (fabs(n[a]) > 1e-9) *(held[a] ? &apart : &within) = false;
  }
  return apart ? APART : within ? WITHIN : ASKEW;
}

static LitheStatus fail_askew(LitheCtx *ctx, const LthBody *body, const LthSceneConstraint *c,
                              const LthPatches *patches) {
  const double *at = patches->centroid,
               *n = body->mesh->face_normal + 3 * (LitheCount)patches->face[0];
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "%s.where: overlaps another constraint near (%g, %g, %g), where the normal (%g, %g, %g) of a "
      "roller and the components held beside it are neither the same nor at right angles; let "
      "one of them hold all three components, or select apart",
      c->place, at[0], at[1], at[2], n[0], n[1], n[2]);
}

/// What is left for a constraint on a part where others hold something: false where nothing is.
static LitheStatus leave_free(LitheCtx *ctx, const LthBody *body, const LthSceneConstraint *c,
                              const LthBoundaryPart *part, LthWeakConstraint *weak, bool *any) {
  Meeting meeting = APART;
  *any = true;
  if (c->normal_only) {
    *any = !part->blocked_normal;
    meeting = meet(body, part->patches, part->blocked);
    if (meeting == WITHIN) *any = false;
  } else {
    for (int a = 0; a < 3; a++) weak->fixed[a] = weak->fixed[a] && !part->blocked[a];
    if (part->blocked_normal) meeting = meet(body, part->patches, weak->fixed);
    const double *n = body->mesh->face_normal + 3 * (LitheCount)part->patches->face[0];
    for (int a = 0; a < 3 && meeting == WITHIN; a++)
      if (fabs(n[a]) > 1e-9) weak->fixed[a] = false;
    *any = weak->fixed[0] || weak->fixed[1] || weak->fixed[2];
  }
  return *any && meeting == ASKEW ? fail_askew(ctx, body, c, part->patches) : LITHE_OK;
}

/// Expressions know whether they use t; other callbacks may.
bool lth_moves(const LthValue value[3]) {
  for (int a = 0; a < 3; a++)
    if (value[a].eval == lth_expression_eval ? lth_expression_uses(value[a].self) & LTH_USES_T
                                             : value[a].eval != NULL)
      return true;
  return false;
}

static LitheStatus add_weak(LitheCtx *ctx, LthBody *body, LitheIndex i,
                            const LthBoundaryPart *part) {
  const LthSceneConstraint *c = body->def->constraints + i;
  LthWeakConstraint weak = {.patches = part->patches,
                            .normal_only = c->normal_only,
                            .is_position = c->is_position,
                            .moves = lth_moves(c->value)};
  bool any;
  memcpy(weak.fixed, c->fixed, sizeof weak.fixed);
  memcpy(weak.value, c->value, sizeof weak.value);
  LITHE_TRY(leave_free(ctx, body, c, part, &weak, &any));
  if (!any) return LITHE_OK;
  LTH_RESERVE(ctx, body->weak, body->cap_weak, body->n_weak + 1);
  LTH_RESERVE(ctx, body->weak_of, body->cap_weak_of, body->n_weak + 1);
  body->weak_of[body->n_weak] = i;
  body->weak[body->n_weak++] = weak;
  return LITHE_OK;
}

LitheStatus lth_build_weak(LitheCtx *ctx, LthBody *body, LitheIndex i) {
  LitheStatus status = LITHE_OK;
  const LthSceneBody *def = body->def;
  const LthSceneConstraint *c = def->constraints + i;
  LthBoundaryParts parts = {0};
  LitheIndex *before = NULL, n_before = 0;
  LTH_NEW_OR(done, ctx, before, def->n_constraints);
  for (LitheIndex j = 0; j < def->n_constraints; j++)
    if (comes_before(def, j, i)) before[n_before++] = j;
  LITHE_TRY_OR(done, lth_boundary_divide(ctx, body, c->place, &c->where, n_before, before, &parts));
  for (LitheCount p = 0; p < parts.n; p++)
    LITHE_TRY_OR(done, add_weak(ctx, body, i, parts.items + p));
done:
  lth_free(ctx, before);
  lth_free(ctx, parts.items);
  return status;
}

// --- strong ---

/// Give unknown a of a cell to a motion, unless an earlier constraint has it.
static void take(LitheIndex *motion_of, LitheIndex cell, int a, LitheIndex motion) {
  LitheIndex *at = motion_of + 3 * (LitheCount)cell + a;
  if (*at < 0) *at = motion;
}

static LitheStatus fail_empty(LitheCtx *ctx, const LthBody *body, const LthSceneConstraint *c) {
  const double *box = body->box;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects no element; the body reaches from (%g, %g, %g) to (%g, %g, %g)",
             c->place, box[0], box[1], box[2], box[3], box[4], box[5]);
}

static LitheStatus mark_components(LitheCtx *ctx, const LthBody *body, LitheIndex i,
                                   LitheIndex *motion_of) {
  const LthSceneConstraint *c = body->def->constraints + i;
  uint8_t *chosen = NULL;
  bool any = false;
  LTH_NEW(ctx, chosen, body->mesh->n_cells);
  LitheStatus status = lth_select_cells(ctx, body->mesh, &c->where, chosen);
  for (LitheIndex k = 0; status == LITHE_OK && k < body->mesh->n_cells; k++) {
    any = any || chosen[k];
    for (int a = 0; a < 3 && chosen[k]; a++)
      if (c->fixed[a]) take(motion_of, k, a, 2 * i);
  }
  lth_free(ctx, chosen);
  LITHE_TRY(status);
  if (!any) LITHE_TRY(lth_body_lose(ctx, body, c->place, &any));
  return any ? LITHE_OK : fail_empty(ctx, body, c);
}

/// A roller: elements at the selected boundary, along the axis of its normal; motion 2 i + 1 where the normal
/// points against it.
static LitheStatus mark_roller(LitheCtx *ctx, const LthBody *body, LitheIndex i,
                               LitheIndex *motion_of) {
  const LthSceneConstraint *c = body->def->constraints + i;
  LthPatches *patches = NULL;
  LITHE_TRY(lth_build_patches(ctx, body, c->place, &c->where, &patches));
  LitheStatus status = LITHE_OK;
  for (LitheIndex p = 0; p < patches->n && status == LITHE_OK; p++) {
    const double *n = body->mesh->face_normal + 3 * (LitheCount)patches->face[p];
    int axis = fabs(n[0]) > fabs(n[1]) ? 0 : 1;
    if (fabs(n[2]) > fabs(n[axis])) axis = 2;
    if (fabs(n[axis]) < 1 - 1e-12)
      status = lth_fail(ctx, LITHE_BAD_INPUT,
                        "%s.enforce: a strong roller holds elements along an axis, got the normal "
                        "(%g, %g, %g) at (%g, %g, %g); expected a normal along x, y or z, or "
                        "`enforce: weak`",
                        c->place, n[0], n[1], n[2], patches->centroid[3 * p],
                        patches->centroid[3 * p + 1], patches->centroid[3 * p + 2]);
    else
      take(motion_of, body->mesh->face_cell[2 * (LitheCount)patches->face[p]], axis,
           2 * i + (n[axis] < 0));
  }
  lth_patches_destroy(ctx, &patches);
  return status;
}

/// The two motions of a constraint; a roller's along the axes and against them.
static void set_motions(const LthSceneConstraint *c, LitheIndex i, LthStrongMotion *motions) {
  for (int side = 0; side < 2; side++) {
    LthStrongMotion *m = motions + 2 * i + side;
    *m = (LthStrongMotion){.is_position = c->is_position, .constraint = i, .factor = side ? -1 : 1};
    for (int a = 0; a < 3; a++) m->value[a] = c->value[c->normal_only ? 0 : a];
  }
}

static LitheStatus build_strong(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LitheIndex *motion_of = NULL, n = body->def->n_constraints;
  LthStrongMotion *motions = NULL;
  LTH_NEW_OR(done, ctx, motion_of, 3 * (LitheCount)body->mesh->n_cells);
  LTH_NEW_OR(done, ctx, motions, 2 * (LitheCount)n);
  for (LitheCount k = 0; k < 3 * (LitheCount)body->mesh->n_cells; k++) motion_of[k] = -1;
  for (LitheIndex i = 0; i < n; i++) {
    const LthSceneConstraint *c = body->def->constraints + i;
    set_motions(c, i, motions);
    if (!lth_is_strong(c)) continue;
    LITHE_TRY_OR(done, c->normal_only ? mark_roller(ctx, body, i, motion_of)
                                      : mark_components(ctx, body, i, motion_of));
  }
  LITHE_TRY_OR(done,
               lth_dg_strong_create(ctx, body->space, motion_of, 2 * n, motions, &body->strong));
done:
  lth_free(ctx, motion_of);
  lth_free(ctx, motions);
  return status;
}

LitheStatus lth_build_constraints(LitheCtx *ctx, LthBody *body) {
  bool any_strong = false;
  for (LitheIndex i = 0; i < body->def->n_constraints; i++) {
    if (lth_is_strong(body->def->constraints + i))
      any_strong = true;
    else
      LITHE_TRY(lth_build_weak(ctx, body, i));
  }
  return any_strong ? build_strong(ctx, body) : LITHE_OK;
}
