/// Dividing boundary by constraints: a binary tree of selections, of which only branches with area are kept.
#include "scene/boundary_parts.h"

#include <string.h>

bool lth_holds_wholly(const LthSceneConstraint *c) {
  return !c->normal_only && c->fixed[0] && c->fixed[1] && c->fixed[2];
}

/// A branch: boundary inside all of `inside` (some of them negated), and what is held on it.
typedef struct Branch {
  LthWhere *inside; ///< room for 1 + number of constraints; their children are borrowed
  LitheIndex n;
  bool blocked[3], blocked_normal;
} Branch;

typedef struct Division {
  LitheCtx *ctx;
  LthBody *body;
  LitheIndex n_by;
  const LitheIndex *by;
  LthBoundaryParts *parts;
} Division;

static double area_of(const LthPatches *patches) {
  double area = 0;
  for (LitheIndex i = 0; i < patches->n; i++) area += patches->area[i];
  return area;
}

static LitheStatus select_branch(const Division *d, const Branch *branch, LthPatches **patches) {
  LthWhere all = {.kind = LTH_WHERE_AND, .children = branch->inside, .n_children = branch->n};
  return lth_select_boundary(d->ctx, d->body->mesh, branch->n == 1 ? branch->inside : &all,
                             patches);
}

/// Selections that meet at an edge have no area in common, but for rounding.
static LitheStatus has_area(const Division *d, const Branch *branch, bool *result) {
  LthPatches *patches = NULL;
  LITHE_TRY(select_branch(d, branch, &patches));
  *result = area_of(patches) > 1e-12 * d->body->size * d->body->size;
  lth_patches_destroy(d->ctx, &patches);
  return LITHE_OK;
}

static LitheStatus keep(const Division *d, const Branch *branch) {
  LthPatches *patches = NULL;
  LthBody *body = d->body;
  LITHE_TRY(select_branch(d, branch, &patches));
  if (!(area_of(patches) > 1e-12 * body->size * body->size)) {
    lth_patches_destroy(d->ctx, &patches);
    return LITHE_OK;
  }
  LITHE_TRY(lth_body_own_patches(d->ctx, body, patches));
  LTH_RESERVE(d->ctx, d->parts->items, d->parts->cap, d->parts->n + 1);
  LthBoundaryPart *part = d->parts->items + d->parts->n++;
  *part = (LthBoundaryPart){.patches = patches, .blocked_normal = branch->blocked_normal};
  memcpy(part->blocked, branch->blocked, sizeof part->blocked);
  return LITHE_OK;
}

/// Divide a branch by the constraints from number i on.
static LitheStatus divide(const Division *d, Branch branch, LitheIndex i) {
  if (i == d->n_by) return keep(d, &branch);
  const LthSceneConstraint *c = d->body->def->constraints + d->by[i];
  LthWhere held = c->where, // borrowed, as are the children of both
      free = {.kind = LTH_WHERE_NOT, .children = &held, .n_children = 1};
  bool meets = false;
  Branch inner = branch;
  inner.inside[inner.n++] = held;
  LITHE_TRY(has_area(d, &inner, &meets));
  if (!meets) return divide(d, branch, i + 1);
  if (!lth_holds_wholly(c)) {
    inner.blocked_normal |= c->normal_only;
    for (int a = 0; a < 3; a++) inner.blocked[a] |= !c->normal_only && c->fixed[a];
    LITHE_TRY(divide(d, inner, i + 1));
  }
  branch.inside[branch.n++] = free;
  return divide(d, branch, i + 1);
}

LitheStatus lth_boundary_divide(LitheCtx *ctx, LthBody *body, const char *place,
                                const LthWhere *where, LitheIndex n_by, const LitheIndex *by,
                                LthBoundaryParts *parts) {
  LthPatches *all = NULL;
  Branch root = {0};
  *parts = (LthBoundaryParts){0};
  LITHE_TRY(lth_build_patches(ctx, body, place, where, &all));
  LitheStatus status = LITHE_OK;
  if (all->n == 0) {
    lth_patches_destroy(ctx, &all);
    return LITHE_OK;
  }
  if (n_by == 0) {
    LITHE_TRY(lth_body_own_patches(ctx, body, all));
    LTH_RESERVE(ctx, parts->items, parts->cap, 1);
    parts->items[parts->n++] = (LthBoundaryPart){.patches = all};
    return LITHE_OK;
  }
  lth_patches_destroy(ctx, &all);
  LTH_NEW(ctx, root.inside, 1 + n_by);
  root.inside[root.n++] = *where;
  Division division = {ctx, body, n_by, by, parts};
  status = divide(&division, root, 0);
  lth_free(ctx, root.inside);
  return status;
}
