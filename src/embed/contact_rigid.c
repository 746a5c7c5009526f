/// Contact with rigid colliders: which points are near which collider, and where.
#include "base/tensor.h"
#include "embed/collider.h"
#include "embed/contact_priv.h"

#define REACH_CELLS 0.1 ///< of a cell: how far beyond a straight step points are watched
#define REACH_STEPS 2   ///< straight steps that they are watched for

typedef struct LthRigid {
  LitheIndex n_colliders;
  LthCollider *colliders; ///< copies, meshes with a tree
  bool *owns_bvh;
  double *gap; ///< to the present collider                  (n_points)
} LthRigid;

static LitheStatus copy_colliders(LitheCtx *ctx, const LthContactDef *def, LthRigid *r) {
  r->n_colliders = def->n_colliders;
  LTH_NEW(ctx, r->colliders, def->n_colliders);
  LTH_NEW(ctx, r->owns_bvh, def->n_colliders);
  for (LitheIndex i = 0; i < def->n_colliders; i++) {
    LthCollider *k = &r->colliders[i];
    *k = def->colliders[i];
    if (k->kind != LTH_COLLIDER_MESH || k->shape.bvh) continue;
    k->shape.kind = LTH_SHAPE_MESH;
    LITHE_TRY(lth_bvh_create_surface(ctx, k->shape.surface, &k->shape.bvh));
    r->owns_bvh[i] = true;
  }
  return LITHE_OK;
}

static void rigid_destroy(LitheCtx *ctx, LthContact *c) {
  LthRigid *r = c->self;
  if (!r) return;
  for (LitheIndex i = 0; r->owns_bvh && i < r->n_colliders; i++)
    if (r->owns_bvh[i]) lth_bvh_destroy(ctx, &r->colliders[i].shape.bvh);
  lth_free(ctx, r->colliders);
  lth_free(ctx, r->owns_bvh);
  lth_free(ctx, r->gap);
  lth_free(ctx, r);
}

static void rigid_move_anchor(const LthContact *c, LthTouch *touch, const double x[3]) {
  const LthRigid *r = c->self;
  LthPose now = lth_collider_pose(&r->colliders[touch->other], c->t);
  lth_pose_to_rest(&now, x, touch->anchor);
}

/// Gaps of all points to a collider, INFINITY beyond `reach`.
static void find_gaps(const LthContact *c, const LthCollider *k, const LthPose *next,
                      double reach) {
  const LthRigid *r = c->self;
  double box[6];
  lth_collider_rest_box(k, box);
#pragma omp parallel for schedule(static) num_threads(lth_threads(c->ctx))
  for (LitheIndex p = 0; p < c->side[0].points->n_points; p++) {
    double rest[3];
    lth_pose_to_rest(next, c->side[0].position + 3 * (size_t)p, rest);
    r->gap[p] = INFINITY;
    if (lth_box_distance2(box, rest) > reach * reach) continue;
    double gap = lth_collider_rest_gap(k, rest, NULL);
    if (gap < reach) r->gap[p] = gap;
  }
}

/// True where the collider's box, as a ball, is farther from the body's box than `reach`.
static bool is_far(const LthCollider *k, const LthPose *next, const double body[6], double reach) {
  double box[6], center[3], x[3];
  if (k->kind == LTH_COLLIDER_PLANE) return false;
  lth_collider_rest_box(k, box);
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (box[i] + box[3 + i]);
  double radius = lth_v3_distance(box, center);
  lth_pose_to_world(next, center, x);
  return lth_box_distance2(body, x) > (radius + reach) * (radius + reach);
}

/// Normal, stiffness, collider's velocity and first guess of a new touching point.
static void fill_touch(const LthContact *c, LthTouch *touch, const LthPose *now,
                       const LthPose *next, const double v[3]) {
  const LthRigid *r = c->self;
  const double *x = c->side[0].position + 3 * (size_t)touch->point;
  double rest[3], n[3], before[3];
  lth_pose_to_rest(next, x, rest);
  touch->gap = lth_collider_rest_gap(&r->colliders[touch->other], rest, n);
  lth_m3_apply(next->R, n, touch->normal);
  lth_pose_to_world(now, rest, before);
  for (int i = 0; i < 3; i++) touch->velocity[i] = (x[i] - before[i]) / c->dt;
  touch->stiffness = lth_contact_share(c, c->side[0].points, touch->point);
  double end = touch->gap + c->dt * lth_v3_dot(touch->normal, v);
  touch->active = end < 0;
  touch->limit = c->friction * touch->stiffness * fmax(-end, 0);
  lth_pose_to_rest(now, x, touch->anchor);
}

/// Stretch of friction's spring at the start, and what it would be if the point went on as it does.
static void set_offset(const LthContact *c, LthTouch *touch, const LthPose *next,
                       const double v[3]) {
  double anchor[3];
  lth_pose_to_world(next, touch->anchor, anchor);
  lth_v3_sub(c->side[0].position + 3 * (size_t)touch->point, anchor, touch->offset);
  lth_v3_axpy(-lth_v3_dot(touch->offset, touch->normal), touch->normal, touch->offset);
  lth_touch_stretch(c, touch, v);
}

/// Collect the points near one collider.
static LitheStatus collect(LitheCtx *ctx, LthContact *c, LitheIndex collider, const LthPose *now,
                           const LthPose *next) {
  const LthContactSide *s = &c->side[0];
  const LthRigid *r = c->self;
  for (LitheIndex p = 0; p < s->points->n_points; p++) {
    double v[3];
    if (r->gap[p] == INFINITY) continue;
    lth_embedding_from_samples(s->points, p, s->sample_value, v);
    if (r->gap[p] > REACH_STEPS * c->dt * lth_v3_norm(v) + REACH_CELLS * c->cell_size) continue;
    LthTouch touch = {.point = p, .other = collider, .n_legs = 1, .n_own = 1, .leg = {{0, p, 1}}};
    lth_v3_copy(v, touch.start);
    fill_touch(c, &touch, now, next, v);
    lth_touch_remember(c, &touch, v);
    set_offset(c, &touch, next, v);
    lth_touch_linearize(c, &touch);
    LITHE_TRY(lth_touch_add(ctx, c, &touch));
  }
  return LITHE_OK;
}

static LitheStatus rigid_find_near(LitheCtx *ctx, LthContact *c) {
  const LthRigid *r = c->self;
  double body[6], reach = REACH_STEPS * c->dt * lth_contact_fastest(&c->side[0]);
  reach += REACH_CELLS * c->cell_size;
  lth_contact_box(&c->side[0], body);
  for (LitheIndex k = 0; k < r->n_colliders; k++) {
    LthPose now = lth_collider_pose(&r->colliders[k], c->t);
    LthPose next = lth_collider_pose(&r->colliders[k], lth_contact_end(c));
    if (is_far(&r->colliders[k], &next, body, reach)) continue;
    find_gaps(c, &r->colliders[k], &next, reach);
    LITHE_TRY(collect(ctx, c, k, &now, &next));
  }
  return LITHE_OK;
}

static const LthContactKind rigid_kind = {.find_near = rigid_find_near,
                                          .move_anchor = rigid_move_anchor,
                                          .destroy = rigid_destroy,
                                          .may_grow = true};

LitheStatus lth_contact_create(LitheCtx *ctx, const LthContactDef *def, LthContact **contact) {
  LitheStatus status = LITHE_OK;
  LthRigid *r = NULL;
  LITHE_TRY(lth_contact_create_sides(ctx, 1, &def->points, def->stiffness, contact));
  LthContact *c = *contact;
  c->kind = &rigid_kind;
  LTH_NEW_OR(done, ctx, r, 1);
  c->self = r;
  c->friction = def->friction, c->damping = def->damping;
  c->cell_size = def->cell_size, c->body_size = def->body_size;
  if (c->is_auto) {
    double cell = def->cell_size > 0 ? def->cell_size : def->body_size > 0 ? def->body_size : 1;
    c->stiffness =
        lth_contact_auto_stiffness(def->modulus, def->cell_size, def->body_weight, def->body_size) *
        (def->points->area ? 1 : cell * cell);
  }
  LTH_NEW_OR(done, ctx, r->gap, def->points->n_points);
  LITHE_TRY_OR(done, copy_colliders(ctx, def, r));
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, contact);
  return status;
}
