/// Contact of two bodies: the points of each against the moved surface of the other.
///
/// The nearest feature of a thin part may lie on its far side. So a point only touches what faces it: a surface
/// whose normal turns away from the point's own.
#include "base/tensor.h"
#include "embed/contact_priv.h"
#include "geometry/bvh.h"

#define REACH_CELLS 0.1 ///< of a cell: how far beyond a straight step points are watched
#define REACH_STEPS 2   ///< straight steps that they are watched for
#define FACING 0.3      ///< largest cosine between the normals of what touches
#define CHANGES_MAX                                                                                \
  3 ///< of triangle within a search for an equilibrium, then a point keeps the one it has
#define FAST 0.5 ///< of the thinner body in a step: faster ones may pass through each other

/// The point of the other body's surface that a point may touch.
typedef struct Hit {
  LitheIndex tri; ///< -1: none
  double point[3], normal[3], gap;
  bool held; ///< to the plane of its triangle, perhaps beside it
} Hit;

/// What a point has met in a search for an equilibrium. Inside facets the nearest triangle, and the normal with it,
/// jumps: a point that is pushed over an edge by either of two triangles would go to and fro for ever.
typedef struct Hold {
  LitheIndex tri; ///< last one met inside, -1
  int changes;
} Hold;

/// A body's surface as it is now, and what its points meet.
typedef struct PairSide {
  LthPairSide def;
  LthSurface surface; ///< the one at rest with points of its own
  LthBvh *bvh;
  LitheIndex *home; ///< of each point: its point of the surface, or -1 - triangle (n_points)
  Hit *hit;         ///< (n_points)
  Hold *hold;       ///< (n_points)
  double *velocity; ///< (n_points x 3)
  double mean[3], spread, box[6];
} PairSide;

typedef struct LthPair {
  PairSide side[2];
  bool is_near;
  double depth; ///< points deeper than this are not sought [m]
} LthPair;

static void pair_destroy(LitheCtx *ctx, LthContact *c) {
  LthPair *pair = c->self;
  if (!pair) return;
  for (int s = 0; s < 2; s++) {
    lth_bvh_destroy(ctx, &pair->side[s].bvh);
    lth_free(ctx, pair->side[s].surface.points);
    lth_free(ctx, pair->side[s].home);
    lth_free(ctx, pair->side[s].hit);
    lth_free(ctx, pair->side[s].hold);
    lth_free(ctx, pair->side[s].velocity);
  }
  lth_free(ctx, pair);
}

/// Where on its body's surface each point sits at rest: that is whose normal it has.
static LitheStatus find_homes(LitheCtx *ctx, PairSide *s) {
  const LthEmbedding *e = s->def.points;
  LTH_NEW(ctx, s->home, e->n_points);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    LthBvhPoint closest;
    bool touches = !e->area || e->area[p] > 0;
    if (touches && lth_bvh_closest(s->bvh, e->rest + 3 * (size_t)p, INFINITY, NULL, NULL, &closest))
      s->home[p] = -1 - closest.tri;
  }
  for (LitheIndex i = 0; i < s->surface.n_points; i++) s->home[s->def.surface_point[i]] = i;
  return LITHE_OK;
}

static LitheStatus create_side(LitheCtx *ctx, const LthPairSide *def, PairSide *s) {
  const size_t n = 3 * (size_t)def->surface->n_points;
  s->def = *def;
  s->surface = *def->surface;
  s->surface.points = NULL;
  LTH_NEW(ctx, s->surface.points, (LitheCount)n);
  memcpy(s->surface.points, def->surface->points, sizeof(double) * n);
  LITHE_TRY(lth_bvh_create_surface(ctx, &s->surface, &s->bvh));
  LTH_NEW(ctx, s->hit, def->points->n_points);
  LTH_NEW(ctx, s->hold, def->points->n_points);
  LTH_NEW(ctx, s->velocity, 3 * (LitheCount)def->points->n_points);
  return find_homes(ctx, s);
}

/// What one body's normal is at a point of it, as it is now.
static void own_normal(const PairSide *s, LitheIndex p, double n[3]) {
  LitheIndex home = s->home[p];
  lth_v3_copy(home < 0 ? s->bvh->tri_normal + 3 * (size_t)(-1 - home)
                       : s->bvh->point_normal + 3 * (size_t)home,
              n);
  lth_v3_normalize(n);
}

static double thickness(const double box[6]) {
  return fmin(box[3] - box[0], fmin(box[4] - box[1], box[5] - box[2]));
}

/// Velocities of a body's points, and about their mean: what the other body sees come.
static void measure_velocities(const LthContactSide *from, PairSide *s) {
  const LthEmbedding *e = from->points;
  double largest2 = 0;
  memset(s->mean, 0, sizeof s->mean);
  for (LitheIndex p = 0; p < e->n_points; p++) {
    lth_embedding_from_samples(e, p, from->sample_value, s->velocity + 3 * (size_t)p);
    lth_v3_add(s->mean, s->velocity + 3 * (size_t)p, s->mean);
  }
  lth_v3_scale(1.0 / e->n_points, s->mean);
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double about[3];
    lth_v3_sub(s->velocity + 3 * (size_t)p, s->mean, about);
    largest2 = fmax(largest2, lth_v3_dot(about, about));
  }
  s->spread = sqrt(largest2);
}

/// The largest speed at which points of the two may come towards each other.
static double speed(const LthPair *pair) {
  return lth_v3_distance(pair->side[0].mean, pair->side[1].mean) + pair->side[0].spread +
         pair->side[1].spread;
}

static double box_gap(const double a[6], const double b[6]) {
  double d2 = 0;
  for (int i = 0; i < 3; i++) {
    double d = fmax(fmax(a[i] - b[3 + i], b[i] - a[3 + i]), 0);
    d2 += d * d;
  }
  return sqrt(d2);
}

/// How deep points may be: deeper than in the last step by what they went since. At the start, anywhere.
static double depth_limit(const LthContact *c, const LthPair *pair, double reach) {
  double thin = fmax(thickness(pair->side[0].box), thickness(pair->side[1].box));
  return !c->started ? thin : fmin(thin, 2 * c->penetration + reach);
}

/// Move the surfaces to where the bodies are, if those are anywhere near each other.
static void pair_begin(LthContact *c) {
  LthPair *pair = c->self;
  for (int s = 0; s < 2; s++) {
    lth_contact_box(&c->side[s], pair->side[s].box);
    measure_velocities(&c->side[s], &pair->side[s]);
  }
  double reach = REACH_STEPS * c->dt * speed(pair) + REACH_CELLS * c->cell_size;
  pair->is_near = box_gap(pair->side[0].box, pair->side[1].box) <= reach;
  pair->depth = depth_limit(c, pair, reach);
  if (!pair->is_near && c->n_touch == 0) return;
  for (int s = 0; s < 2; s++) {
    PairSide *side = &pair->side[s];
    for (LitheIndex i = 0; i < side->surface.n_points; i++)
      lth_v3_copy(c->side[s].position + 3 * (size_t)side->def.surface_point[i],
                  side->surface.points + 3 * (size_t)i);
    lth_bvh_refit_surface(side->bvh);
  }
}

/// A point and its own normal, for choosing triangles that face it.
typedef struct Seeker {
  const LthBvh *bvh;
  double normal[3];
} Seeker;

static bool faces(const void *self, LitheIndex tri) {
  const Seeker *seeker = self;
  return lth_v3_dot(seeker->normal, seeker->bvh->tri_normal + 3 * (size_t)tri) < FACING;
}

/// What point x of one body meets on the other's surface. A point that is inside nearest to a face it cannot have
/// come through is led back to one that it can.
static void seek(const Seeker *seeker, const double x[3], double reach, double depth, Hit *hit) {
  const LthBvh *bvh = seeker->bvh;
  LthBvhPoint closest;
  hit->tri = -1, hit->held = false;
  if (lth_box_distance2(bvh->box, x) > reach * reach) return;
  if (!lth_bvh_closest(bvh, x, fmax(reach, depth), NULL, NULL, &closest)) return;
  hit->gap = lth_bvh_gap(bvh, x, &closest, hit->normal);
  if (hit->gap > reach) return;
  if (!(lth_v3_dot(hit->normal, seeker->normal) < FACING)) {
    if (hit->gap > 0 || !lth_bvh_closest(bvh, x, thickness(bvh->box), faces, seeker, &closest))
      return;
    hit->gap = -closest.distance;
    lth_v3_sub(closest.point, x, hit->normal);
    lth_v3_normalize(hit->normal);
    if (!(lth_v3_dot(hit->normal, bvh->tri_normal + 3 * (size_t)closest.tri) > FACING)) return;
  }
  hit->tri = closest.tri;
  lth_v3_copy(closest.point, hit->point);
}

/// Points that have changed their triangle too often keep to its plane, until their foot is far beside it.
static void hold_on(const PairSide *other, const double x[3], bool first, Hold *hold, Hit *hit) {
  if (first) *hold = (Hold){.tri = -1};
  bool inside = hit->tri >= 0 && hit->gap < 0, changed = inside && hold->tri != hit->tri;
  if (hold->tri >= 0 && hold->changes >= CHANGES_MAX) {
    Hit held = {.tri = hold->tri, .held = true};
    if (lth_meet_plane(other->bvh, hold->tri, x, &held.gap, held.point)) {
      lth_v3_copy(other->bvh->tri_normal + 3 * (size_t)hold->tri, held.normal);
      *hit = held;
      return;
    }
    hold->changes = 0;
  }
  if (changed && hold->tri >= 0) hold->changes++;
  if (changed) hold->tri = hit->tri;
}

/// What all points of side s meet that is as near as they may go.
static void find_hits(const LthContact *c, int s) {
  const LthPair *pair = c->self;
  const PairSide *mine = &pair->side[s], *other = &pair->side[1 - s];
  const LthEmbedding *e = mine->def.points;
#pragma omp parallel for schedule(dynamic, 256) num_threads(lth_threads(c->ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    mine->hit[p].tri = -1;
    if (e->area && !(e->area[p] > 0)) continue;
    if (mine->def.excluded && mine->def.excluded[p]) continue;
    double way = lth_v3_distance(mine->velocity + 3 * (size_t)p, other->mean) + other->spread;
    double reach = REACH_STEPS * c->dt * way + REACH_CELLS * c->cell_size;
    Seeker seeker = {.bvh = other->bvh};
    own_normal(mine, p, seeker.normal);
    const double *x = c->side[s].position + 3 * (size_t)p;
    seek(&seeker, x, reach, pair->depth, &mine->hit[p]);
    if (c->look != LTH_LOOK_STEP)
      hold_on(other, x, c->look == LTH_LOOK_FIRST, &mine->hold[p], &mine->hit[p]);
  }
}

static void set_anchor(const PairSide *other, LthTouch *touch, LitheIndex tri, const double x[3]) {
  touch->anchor_tri = tri;
  lth_corner_weights(&other->surface, tri, x, touch->anchor);
}

static void pair_move_anchor(const LthContact *c, LthTouch *touch, const double x[3]) {
  const LthPair *pair = c->self;
  const PairSide *other = &pair->side[1 - touch->side];
  Seeker seeker = {.bvh = other->bvh};
  LthBvhPoint closest;
  own_normal(&pair->side[touch->side], touch->point, seeker.normal);
  if (lth_bvh_closest(other->bvh, x, INFINITY, faces, &seeker, &closest))
    set_anchor(other, touch, closest.tri, closest.point);
}

/// Stretch of friction's spring at the start, and what it would be if the point went on as it does.
static void set_offset(const LthContact *c, const PairSide *other, LthTouch *touch,
                       const double v[3]) {
  lth_v3_copy(c->side[touch->side].position + 3 * (size_t)touch->point, touch->offset);
  for (int k = 0; k < 3; k++)
    lth_v3_axpy(-touch->anchor[k],
                other->surface.points +
                    3 * (size_t)other->surface.tris[3 * (size_t)touch->anchor_tri + (size_t)k],
                touch->offset);
  lth_v3_axpy(-lth_v3_dot(touch->offset, touch->normal), touch->normal, touch->offset);
  lth_touch_stretch(c, touch, v);
}

/// The point and the corners that carry its counterpart.
static void set_legs(const PairSide *other, const Hit *hit, LthTouch *touch) {
  double w[3];
  if (hit->held)
    lth_plane_weights(&other->surface, hit->tri, hit->point, w);
  else
    lth_corner_weights(&other->surface, hit->tri, hit->point, w);
  touch->n_legs = 4;
  touch->leg[0] = (LthLeg){touch->side, touch->point, 1};
  for (int k = 0; k < 3; k++) {
    LitheIndex corner = other->surface.tris[3 * (size_t)hit->tri + (size_t)k];
    touch->leg[1 + k] = (LthLeg){1 - touch->side, other->def.surface_point[corner], -w[k]};
  }
}

static LitheStatus collect(LitheCtx *ctx, LthContact *c, int s) {
  const LthPair *pair = c->self;
  const PairSide *mine = &pair->side[s], *other = &pair->side[1 - s];
  for (LitheIndex p = 0; p < mine->def.points->n_points; p++) {
    const Hit *hit = &mine->hit[p];
    double v[3];
    if (hit->tri < 0) continue;
    LthTouch touch = {.side = s, .point = p, .gap = hit->gap};
    set_legs(other, hit, &touch);
    lth_touch_value(c, &touch, v);
    if (hit->gap > REACH_STEPS * c->dt * lth_v3_norm(v) + REACH_CELLS * c->cell_size) continue;
    lth_v3_copy(v, touch.start);
    lth_v3_copy(hit->normal, touch.normal);
    touch.stiffness = lth_contact_share(c, mine->def.points, p);
    double end = touch.gap + c->dt * lth_v3_dot(touch.normal, v);
    touch.active = end < 0;
    touch.limit = c->friction * touch.stiffness * fmax(-end, 0);
    set_anchor(other, &touch, hit->tri, hit->point);
    lth_touch_remember(c, &touch, v);
    set_offset(c, other, &touch, v);
    lth_touch_linearize(c, &touch);
    LITHE_TRY(lth_touch_add(ctx, c, &touch));
  }
  return LITHE_OK;
}

static void warn_of_speed(LitheCtx *ctx, LthContact *c, double way) {
  const LthPair *pair = c->self;
  double thin = fmin(thickness(pair->side[0].bvh->box), thickness(pair->side[1].bvh->box));
  if (c->warned || !(way > FAST * thin)) return;
  c->warned = true;
  lth_warn(ctx,
           "%s and %s approach by up to %.3g m a step at t = %.3g s, the thinner of them measures "
           "%.3g m: they may pass through each other; take smaller steps",
           pair->side[0].def.name, pair->side[1].def.name, way, c->t, thin);
}

static LitheStatus pair_find_near(LitheCtx *ctx, LthContact *c) {
  const LthPair *pair = c->self;
  if (!pair->is_near) return LITHE_OK;
  warn_of_speed(ctx, c, c->dt * speed(pair));
  for (int s = 0; s < 2; s++) {
    find_hits(c, s);
    LITHE_TRY(collect(ctx, c, s));
  }
  return LITHE_OK;
}

static const LthContactKind pair_kind = {pair_begin, pair_find_near, pair_move_anchor,
                                         pair_destroy};

/// As stiff as the softer body needs it, and enough for the lighter one's weight.
static double pair_stiffness(const LthPairDef *def) {
  const LthPairSide *a = &def->side[0], *b = &def->side[1];
  double soft = fmin(lth_contact_auto_stiffness(a->modulus, a->cell_size, 0, a->body_size),
                     lth_contact_auto_stiffness(b->modulus, b->cell_size, 0, b->body_size));
  double weight = lth_contact_auto_stiffness(0, a->cell_size, fmin(a->body_weight, b->body_weight),
                                             fmin(a->body_size, b->body_size));
  return fmax(soft, weight);
}

LitheStatus lth_contact_create_pair(LitheCtx *ctx, const LthPairDef *def, LthContact **contact) {
  LitheStatus status = LITHE_OK;
  LthPair *pair = NULL;
  const LthEmbedding *points[2] = {def->side[0].points, def->side[1].points};
  LITHE_TRY(lth_contact_create_sides(ctx, 2, points, def->stiffness, contact));
  LthContact *c = *contact;
  c->kind = &pair_kind;
  LTH_NEW_OR(done, ctx, pair, 1);
  c->self = pair;
  c->friction = def->friction, c->damping = def->damping;
  c->cell_size = fmin(def->side[0].cell_size, def->side[1].cell_size);
  c->body_size = fmin(def->side[0].body_size, def->side[1].body_size);
  if (c->is_auto) c->stiffness = pair_stiffness(def);
  for (int s = 0; s < 2; s++) LITHE_TRY_OR(done, create_side(ctx, &def->side[s], &pair->side[s]));
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, contact);
  return status;
}
