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
#define DEEP 0.01       ///< of a cell: bodies that begin farther inside each other are warned of
#define FAST 0.5        ///< of the thinner body in a step: faster ones may pass through each other

/// A body's surface as it is now, and what its points meet.
typedef struct PairSide {
  LthPairSide def;
  LthSurface surface; ///< the one at rest with points of its own
  LthBvh *bvh;
  LitheIndex *home; ///< of each point: its point of the surface, or -1 - triangle (n_points)
  LthHit *hit;      ///< (n_points)
  LthHold *hold;    ///< (n_points)
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

/// How deep points may be: deeper than in the last step by what they went since. At the start, anywhere.
static double depth_limit(const LthContact *c, const LthPair *pair, double reach) {
  double thin = fmax(lth_box_thickness(pair->side[0].box), lth_box_thickness(pair->side[1].box));
  return !c->started ? thin : fmin(thin, 2 * c->penetration + reach);
}

/// Move the surfaces to where the bodies are, if those are anywhere near each other.
static LitheStatus pair_begin(LitheCtx *ctx, LthContact *c) {
  (void)ctx;
  LthPair *pair = c->self;
  for (int s = 0; s < 2; s++) {
    lth_contact_box(&c->side[s], pair->side[s].box);
    measure_velocities(&c->side[s], &pair->side[s]);
  }
  double reach = REACH_STEPS * c->dt * speed(pair) + REACH_CELLS * c->cell_size;
  pair->is_near = lth_box_gap(pair->side[0].box, pair->side[1].box) <= reach;
  pair->depth = depth_limit(c, pair, reach);
  if (!pair->is_near && c->n_touch == 0) return LITHE_OK;
  for (int s = 0; s < 2; s++) {
    PairSide *side = &pair->side[s];
    for (LitheIndex i = 0; i < side->surface.n_points; i++)
      lth_v3_copy(c->side[s].position + 3 * (size_t)side->def.surface_point[i],
                  side->surface.points + 3 * (size_t)i);
    lth_bvh_refit_surface(side->bvh);
  }
  return LITHE_OK;
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
    LthSeeker seeker = {
        .bvh = other->bvh, .facing = FACING, .way_out = lth_box_thickness(other->bvh->box)};
    own_normal(mine, p, seeker.normal);
    const double *x = c->side[s].position + 3 * (size_t)p;
    lth_seek(&seeker, x, reach, pair->depth, &mine->hit[p]);
    if (c->look != LTH_LOOK_STEP)
      lth_hold_on(other->bvh, x, c->look == LTH_LOOK_FIRST, &mine->hold[p], &mine->hit[p]);
  }
}

static void pair_move_anchor(const LthContact *c, LthTouch *touch, const double x[3]) {
  const LthPair *pair = c->self;
  const PairSide *other = &pair->side[1 - touch->side];
  LthSeeker seeker = {.bvh = other->bvh, .facing = FACING};
  LthBvhPoint closest;
  own_normal(&pair->side[touch->side], touch->point, seeker.normal);
  if (lth_bvh_closest(other->bvh, x, INFINITY, lth_seeker_faces, &seeker, &closest))
    lth_touch_fix(&other->surface, closest.tri, closest.point, touch);
}

/// The point and the corners that carry its counterpart.
static void set_legs(const PairSide *other, const LthHit *hit, LthTouch *touch) {
  touch->n_own = touch->n_legs = 1;
  touch->leg[0] = (LthLeg){touch->side, touch->point, 1};
  lth_touch_add_foot(&other->surface, hit, 1 - touch->side, touch);
  for (int k = 1; k < touch->n_legs; k++)
    touch->leg[k].point = other->def.surface_point[touch->leg[k].point];
}

static LitheStatus collect(LitheCtx *ctx, LthContact *c, int s) {
  const LthPair *pair = c->self;
  const PairSide *mine = &pair->side[s], *other = &pair->side[1 - s];
  for (LitheIndex p = 0; p < mine->def.points->n_points; p++) {
    const LthHit *hit = &mine->hit[p];
    double v[3];
    if (hit->tri < 0) continue;
    LthTouch touch = {.side = s, .point = p};
    set_legs(other, hit, &touch);
    lth_touch_value(c, &touch, v);
    if (hit->gap > REACH_STEPS * c->dt * lth_v3_norm(v) + REACH_CELLS * c->cell_size) continue;
    touch.stiffness = lth_contact_share(c, mine->def.points, p);
    lth_touch_meet(c, &other->surface, hit, v, &touch);
    LITHE_TRY(lth_touch_add(ctx, c, &touch));
  }
  return LITHE_OK;
}

static void warn_of_speed(LitheCtx *ctx, LthContact *c, double way) {
  const LthPair *pair = c->self;
  double thin =
      fmin(lth_box_thickness(pair->side[0].bvh->box), lth_box_thickness(pair->side[1].bvh->box));
  if (c->warned || !(way > FAST * thin)) return;
  c->warned = true;
  lth_warn(ctx,
           "%s and %s approach by up to %.3g m a step at t = %.3g s, the thinner of them measures "
           "%.3g m: they may pass through each other; take smaller steps",
           pair->side[0].def.name, pair->side[1].def.name, way, c->t, thin);
}

/// Slack in the first step of a run is what bodies begin inside each other by.
static void warn_of_depth(LitheCtx *ctx, const LthContact *c) {
  const LthPair *pair = c->self;
  double deepest = 0;
  for (LitheIndex i = 0; i < c->n_touch && !c->started; i++)
    deepest = fmax(deepest, c->touch[i].slack);
  if (!(deepest > DEEP * c->cell_size)) return;
  lth_warn(ctx,
           "%s and %s begin up to %.3g m inside each other: contact holds them from going deeper, "
           "and does not push "
           "them apart; a static run finds where they balance",
           pair->side[0].def.name, pair->side[1].def.name, deepest);
}

static LitheStatus pair_find_near(LitheCtx *ctx, LthContact *c) {
  const LthPair *pair = c->self;
  if (!pair->is_near) return LITHE_OK;
  warn_of_speed(ctx, c, c->dt * speed(pair));
  for (int s = 0; s < 2; s++) {
    find_hits(c, s);
    LITHE_TRY(collect(ctx, c, s));
  }
  warn_of_depth(ctx, c);
  return LITHE_OK;
}

static const LthContactKind pair_kind = {.begin = pair_begin,
                                         .find_near = pair_find_near,
                                         .move_anchor = pair_move_anchor,
                                         .destroy = pair_destroy,
                                         .keeps_energy = true};

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
  if (c->is_auto) {
    const LthPairSide *a = &def->side[0], *b = &def->side[1];
    c->stiffness = lth_contact_pair_stiffness(
        fmin(lth_contact_auto_stiffness(a->modulus, a->cell_size, 0, a->body_size),
             lth_contact_auto_stiffness(b->modulus, b->cell_size, 0, b->body_size)),
        a->cell_size, fmin(a->body_weight, b->body_weight), c->body_size);
  }
  for (int s = 0; s < 2; s++) LITHE_TRY_OR(done, create_side(ctx, &def->side[s], &pair->side[s]));
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, contact);
  return status;
}
