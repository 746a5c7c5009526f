/// A `where` tree asked at places of a solid that has no mesh.
#include "mesh/where_place.h"

#include "base/tensor.h"
#include "mesh/surface_patch.h"

/// What patches grow on.
typedef struct Ground {
  int dim;
  const LthShape *solid;
  double resolution;
} Ground;

static LitheStatus grow_along_curve(LitheCtx *ctx, const LthWhere *w, const Ground *g,
                                    LthWhereSolid *r) {
  LthFoot foot = {0};
  double at[3] = {w->point[0], w->point[1], 0};
  if (!r->curve) LITHE_TRY(lth_curve_create(ctx, g->solid, g->resolution, &r->curve));
  LTH_RESERVE(ctx, r->patches, r->cap_patches, r->n_patches + 1);
  LthGrownPatch *patch = &r->patches[r->n_patches++];
  *patch = (LthGrownPatch){.node = w};
  LTH_NEW(ctx, patch->member, r->curve->n);
  if (!lth_shape_foot(g->solid, at, g->resolution, &foot)) return LITHE_OK;
  return lth_curve_grow(ctx, r->curve, lth_curve_nearest(r->curve, foot.point, foot.normal),
                        w->angle, patch->member);
}

/// Grow the patch of a node on the surface; it is made where there is none.
static LitheStatus grow(LitheCtx *ctx, const LthWhere *w, const Ground *g, LthWhereSolid *r) {
  if (g->dim == 2) return grow_along_curve(ctx, w, g, r);
  if (!r->bvh) {
    LITHE_TRY(lth_shape_tessellate(ctx, g->solid, g->resolution, &r->own_surface));
    LITHE_TRY(lth_bvh_create_surface(ctx, r->own_surface, &r->own_bvh));
    r->bvh = r->own_bvh;
  }
  LTH_RESERVE(ctx, r->patches, r->cap_patches, r->n_patches + 1);
  LthGrownPatch *patch = &r->patches[r->n_patches++];
  *patch = (LthGrownPatch){.node = w};
  LTH_NEW(ctx, patch->member, r->bvh->surface->n_tris);
  return lth_surface_patch_grow(ctx, r->bvh, w->point, w->angle, patch->member);
}

static LitheStatus prepare_node(LitheCtx *ctx, const LthWhere *w, const Ground *g,
                                LthWhereSolid *r) {
  if (w->kind == LTH_WHERE_FACE) LITHE_TRY(grow(ctx, w, g, r));
  for (LitheIndex i = 0; i < w->n_children; i++)
    LITHE_TRY(prepare_node(ctx, &w->children[i], g, r));
  return LITHE_OK;
}

LitheStatus lth_where_solid_prepare(LitheCtx *ctx, const LthWhere *where, int dim,
                                    const LthShape *solid, const LthBvh *bvh, double resolution,
                                    bool all_inside, LthWhereSolid *ready) {
  const Ground ground = {dim, solid, resolution};
  double low[3], high[3], size = 0;
  lth_shape_bounds(solid, low, high);
  for (int a = 0; a < 3; a++)
    if (isfinite(high[a] - low[a])) size = fmax(size, high[a] - low[a]);
  *ready = (LthWhereSolid){
      .where = where, .tolerance = 1e-9 * size, .all_inside = all_inside, .bvh = bvh};
  return prepare_node(ctx, where, &ground, ready);
}

void lth_where_solid_free(LitheCtx *ctx, LthWhereSolid *ready) {
  for (LitheIndex i = 0; i < ready->n_patches; i++) lth_free(ctx, ready->patches[i].member);
  lth_free(ctx, ready->patches);
  lth_curve_destroy(ctx, &ready->curve);
  lth_bvh_destroy(ctx, &ready->own_bvh);
  lth_surface_destroy(ctx, &ready->own_surface);
  *ready = (LthWhereSolid){0};
}

/// Kleene's three values; `not` is YES - answer, `and` the smaller, `or` the larger.
typedef enum Answer { NO, UNKNOWN, YES } Answer;

static Answer answer_if(bool yes) { return yes ? YES : NO; }

/// Values of implicit shapes and images are no lengths: with a reach they may hold anything.
static bool has_lengths(const LthShape *s) {
  if (s->kind == LTH_SHAPE_IMPLICIT || s->kind == LTH_SHAPE_IMAGE) return false;
  for (LitheIndex i = 0; i < s->n_children; i++)
    if (!has_lengths(&s->children[i])) return false;
  return true;
}

static Answer within_shape(const LthWhereSolid *r, const LthShape *shape, const double x[3],
                           double slack) {
  if (fabs(slack) > r->tolerance && !has_lengths(shape)) return UNKNOWN;
  return answer_if(lth_shape_value(shape, x) <= slack);
}

static Answer within_normal(const LthWhere *w, const double normal[3]) {
  double cross[3];
  lth_v3_cross(w->normal, normal, cross);
  return answer_if(atan2(lth_v3_norm(cross), lth_v3_dot(w->normal, normal)) <= w->angle + 1e-9);
}

static Answer within_patch(const LthWhereSolid *r, const LthWhere *w, const LthPlace *p) {
  LthBvhPoint closest;
  LitheIndex i = 0;
  while (r->patches[i].node != w) i++;
  if (r->curve) {
    LitheIndex k = lth_curve_nearest(r->curve, p->point, p->normal);
    return answer_if(k >= 0 && r->patches[i].member[k]);
  }
  if (!lth_bvh_closest(r->bvh, p->point, INFINITY, NULL, NULL, &closest)) return NO;
  return answer_if(r->patches[i].member[closest.tri]);
}

/// Sets are closed and widened by `slack`; behind `not` they are open and shrunk by it.
static Answer ask(const LthWhereSolid *r, const LthWhere *w, const LthPlace *p, double slack) {
  double d[3];
  Answer answer, child;
  switch (w->kind) {
  case LTH_WHERE_ALL:
    return p->is_boundary || r->all_inside ? YES : UNKNOWN;
  case LTH_WHERE_SHAPE:
    return within_shape(r, &w->shape, p->x, slack);
  case LTH_WHERE_PLANE:
    lth_v3_sub(p->x, w->point, d);
    return answer_if(lth_v3_dot(d, w->normal) >= -slack);
  case LTH_WHERE_NORMAL:
    return p->is_boundary ? within_normal(w, p->normal) : UNKNOWN;
  case LTH_WHERE_FACE:
    return p->is_boundary ? within_patch(r, w, p) : UNKNOWN;
  case LTH_WHERE_LABEL:
    return NO; // of mesh files; those of images are shapes
  case LTH_WHERE_NOT:
    return (Answer)(YES - ask(r, &w->children[0], p, -slack));
  case LTH_WHERE_AND:
  case LTH_WHERE_OR:
    answer = w->kind == LTH_WHERE_AND ? YES : NO;
    for (LitheIndex i = 0; i < w->n_children; i++) {
      child = ask(r, &w->children[i], p, slack);
      if (w->kind == LTH_WHERE_AND ? child < answer : child > answer) answer = child;
    }
    return answer;
  }
  return NO;
}

bool lth_where_solid_contains(const LthWhereSolid *ready, const LthPlace *place) {
  return ask(ready, ready->where, place, ready->tolerance) == YES;
}

bool lth_where_solid_is_near(const LthWhereSolid *ready, const double x[3], double reach) {
  LthPlace place = {.x = {x[0], x[1], x[2]}};
  return ask(ready, ready->where, &place, reach + ready->tolerance) != NO;
}
