/// The start of a step: which points are near which collider, and what they remember of the last step.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define REACH_CELLS 0.1  ///< of a cell: how far beyond a straight step points are watched
#define REACH_STEPS 2    ///< straight steps that they are watched for
#define AUTO_DEPTH 0.003 ///< of the body's size: deeper rest makes an automatic stiffness grow
#define AUTO_GROWTH 1.25
#define AUTO_GROWTH_MAX 1e3 ///< over the stiffness at the start

/// A body at rest too deep in a collider: a somewhat stiffer one for the next step.
static void adapt_stiffness(LthContact *c) {
  bool rests = fabs(c->penetration - c->last_penetration) < 0.1 * c->penetration;
  c->last_penetration = c->penetration;
  if (!c->is_auto || !rests || !(c->def.body_size > 0)) return;
  if (c->penetration > AUTO_DEPTH * c->def.body_size && c->growth < AUTO_GROWTH_MAX) {
    c->stiffness *= AUTO_GROWTH;
    c->growth *= AUTO_GROWTH;
  }
}

/// Points that slid take the anchor of their friction along: it ends where its pull is at the limit.
static void move_anchors(LthContact *c, double t) {
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    LthTouch *touch = &c->touch[i];
    double pull = touch->stiffness * lth_v3_norm(touch->trial);
    if (!touch->active || !(pull > touch->limit)) continue;
    LthPose now = lth_collider_pose(&c->colliders[touch->collider], t);
    double x[3];
    lth_v3_copy(c->position + 3 * (size_t)touch->point, x);
    lth_v3_axpy(-touch->limit / pull, touch->trial, x);
    lth_pose_to_rest(&now, x, touch->anchor);
  }
}

static double fastest_sample(const LthContact *c) {
  const LthEmbedding *e = c->def.points;
  double v2 = 0;
  for (LitheIndex s = 0; s < e->n_samples; s++) {
    const double *v = c->sample_value + 4 * (size_t)s;
    v2 = fmax(v2, lth_v3_dot(v, v));
  }
  return sqrt(v2);
}

/// Gaps of all points to a collider, INFINITY beyond `reach`.
static void find_gaps(const LthContact *c, LitheIndex collider, const LthPose *next, double reach) {
  const LthCollider *k = &c->colliders[collider];
  double box[6];
  lth_collider_rest_box(k, box);
#pragma omp parallel for schedule(static) num_threads(lth_threads(c->ctx))
  for (LitheIndex p = 0; p < c->def.points->n_points; p++) {
    double rest[3];
    lth_pose_to_rest(next, c->position + 3 * (size_t)p, rest);
    c->gap[p] = INFINITY;
    if (lth_box_distance2(box, rest) > reach * reach) continue;
    double gap = lth_collider_rest_gap(k, rest, NULL);
    if (gap < reach) c->gap[p] = gap;
  }
}

/// True where the collider's box, as a ball, is farther from the body's box than `reach`.
static bool is_far(const LthContact *c, LitheIndex collider, const LthPose *next,
                   const double body[6], double reach) {
  double box[6], center[3], x[3];
  if (c->colliders[collider].kind == LTH_COLLIDER_PLANE) return false;
  lth_collider_rest_box(&c->colliders[collider], box);
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (box[i] + box[3 + i]);
  double radius = lth_v3_distance(box, center);
  lth_pose_to_world(next, center, x);
  return lth_box_distance2(body, x) > (radius + reach) * (radius + reach);
}

static void find_body_box(const LthContact *c, double box[6]) {
  for (int i = 0; i < 3; i++) box[i] = INFINITY, box[3 + i] = -INFINITY;
  for (LitheIndex p = 0; p < c->def.points->n_points; p++)
    for (int i = 0; i < 3; i++) {
      box[i] = fmin(box[i], c->position[3 * (size_t)p + (size_t)i]);
      box[3 + i] = fmax(box[3 + i], c->position[3 * (size_t)p + (size_t)i]);
    }
}

/// Normal, stiffness, collider's velocity and first guess of a new touching point.
static void fill_touch(const LthContact *c, LthTouch *touch, const LthPose *now,
                       const LthPose *next, const double v[3]) {
  const LthEmbedding *e = c->def.points;
  const double *x = c->position + 3 * (size_t)touch->point;
  double rest[3], n[3], before[3];
  lth_pose_to_rest(next, x, rest);
  touch->gap = lth_collider_rest_gap(&c->colliders[touch->collider], rest, n);
  lth_m3_apply(next->R, n, touch->normal);
  lth_pose_to_world(now, rest, before);
  for (int i = 0; i < 3; i++) touch->velocity[i] = (x[i] - before[i]) / c->dt;
  touch->stiffness = c->stiffness * (e->area ? e->area[touch->point] : 1);
  double end = touch->gap + c->dt * lth_v3_dot(touch->normal, v);
  touch->active = end < 0;
  touch->limit = c->def.friction * touch->stiffness * fmax(-end, 0);
  lth_pose_to_rest(now, x, touch->anchor);
}

/// Take over what a point of the last step knows, and let v go on changing as it did; `*at` walks along the
/// old list, which has the same order.
static void remember(const LthContact *c, LthTouch *touch, LitheIndex *at, double v[3]) {
  while (*at < c->n_before &&
         (c->before[*at].collider < touch->collider ||
          (c->before[*at].collider == touch->collider && c->before[*at].point < touch->point)))
    ++*at;
  if (*at == c->n_before) return;
  const LthTouch *old = &c->before[*at];
  if (old->collider != touch->collider || old->point != touch->point || !old->active) return;
  touch->limit = old->limit;
  for (int i = 0; i < 3; i++) v[i] = 2 * v[i] - old->start[i];
  lth_v3_copy(old->anchor, touch->anchor);
}

/// Stretch of friction's spring at the start, and what it would be if the point went on as it does.
static void set_offset(const LthContact *c, LthTouch *touch, const LthPose *next,
                       const double v[3]) {
  double anchor[3];
  lth_pose_to_world(next, touch->anchor, anchor);
  lth_v3_sub(c->position + 3 * (size_t)touch->point, anchor, touch->offset);
  lth_v3_axpy(-lth_v3_dot(touch->offset, touch->normal), touch->normal, touch->offset);
  lth_touch_stretch(c, touch, v);
}

/// Collect the points near one collider.
static LitheStatus collect(LitheCtx *ctx, LthContact *c, LitheIndex collider, const LthPose *now,
                           const LthPose *next, LitheIndex *at) {
  const LthEmbedding *e = c->def.points;
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double v[3];
    if (c->gap[p] == INFINITY) continue;
    lth_embedding_from_samples(e, p, c->sample_value, v);
    if (c->gap[p] > REACH_STEPS * c->dt * lth_v3_norm(v) + REACH_CELLS * c->def.cell_size) continue;
    LTH_RESERVE(ctx, c->touch, c->touch_cap, (LitheCount)c->n_touch + 1);
    LthTouch *touch = &c->touch[c->n_touch++];
    *touch = (LthTouch){.point = p, .collider = collider};
    lth_v3_copy(v, touch->start);
    fill_touch(c, touch, now, next, v);
    remember(c, touch, at, v);
    set_offset(c, touch, next, v);
    lth_touch_linearize(c, touch);
  }
  return LITHE_OK;
}

static LitheStatus find_near(LitheCtx *ctx, LthContact *c) {
  double body[6], slow = fastest_sample(c) * c->weight_norm;
  double reach = REACH_STEPS * c->dt * slow + REACH_CELLS * c->def.cell_size;
  LitheIndex at = 0;
  find_body_box(c, body);
  for (LitheIndex k = 0; k < c->def.n_colliders; k++) {
    LthPose now = lth_collider_pose(&c->colliders[k], c->t);
    LthPose next = lth_collider_pose(&c->colliders[k], c->t + c->dt);
    if (is_far(c, k, &next, body, reach)) continue;
    find_gaps(c, k, &next, reach);
    LITHE_TRY(collect(ctx, c, k, &now, &next, &at));
  }
  return LITHE_OK;
}

static void swap_lists(LthContact *c) {
  LthTouch *list = c->before;
  LitheCount cap = c->before_cap;
  c->before = c->touch, c->before_cap = c->touch_cap, c->n_before = c->n_touch;
  c->touch = list, c->touch_cap = cap, c->n_touch = 0;
}

LitheStatus lth_contact_detect(LitheCtx *ctx, LthContact *c, double t, double dt, const double *u,
                               const double *v, LitheIndex *n_active) {
  const LthEmbedding *e = c->def.points;
  int threads = lth_threads(ctx);
  lth_embedding_sample(e, threads, u, c->sample_value);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double *x = c->position + 3 * (size_t)p;
    lth_embedding_from_samples(e, p, c->sample_value, x);
    lth_v3_axpy(1, e->rest + 3 * (size_t)p, x);
  }
  adapt_stiffness(c);
  move_anchors(c, t);
  swap_lists(c);
  c->t = t, c->dt = dt, c->round = 0, c->friction_round = 0;
  lth_embedding_sample(e, threads, v, c->sample_value);
  LITHE_TRY(find_near(ctx, c));
  LITHE_TRY(lth_contact_reserve(ctx, c));
  lth_contact_index(c);
  c->penetration = 0, c->force = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    c->penetration = fmax(c->penetration, -c->touch[i].gap);
  *n_active = c->n_active;
  return LITHE_OK;
}
