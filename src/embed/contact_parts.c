/// Contact of parts of bodies: triangles of each against the moved surfaces of the others, closed part by part.
///
/// Two sides of a cut lie face to face, and their rims coincide. A vertex on the rim has no side of its own; a place
/// inside a triangle has the triangle's. So triangles touch by a place in their middle, or, where they are large, by
/// three a little inside of their corners.
#include "embed/contact_parts.h"

#include "base/tensor.h"

#define FACING                                                                                     \
  (-0.05) ///< largest cosine between the normals of what touches: walls beside a right angle do not
#define FAST 0.5   ///< of the thinner part in a step: faster ones may pass through each other
#define INSIDE 0.1 ///< of a triangle: from its corners to where it touches
#define SOFT                                                                                       \
  0.3 ///< of the stiffness of other contacts: less work, and still a third of what a layer of cells gives way by
#define LARGE 0.4   ///< of a cell: longest edge of a triangle that touches by its middle
#define MARGIN 0.01 ///< of a cell: depth of points that were not inside in the last step ...
#define WAYS 1.5    ///< ... besides what they went in it
#define SERIAL 256  ///< up to so many triangles waking threads costs more than it saves

static void parts_destroy(LitheCtx *ctx, LthContact *c) {
  LthParts *parts = c->self;
  if (!parts) return;
  for (LitheIndex k = 0; parts->part && k < parts->n_parts; k++) {
    lth_bvh_destroy(ctx, &parts->part[k].bvh);
    lth_free(ctx, parts->part[k].surface.points);
    lth_free(ctx, parts->part[k].tri_spot);
  }
  for (int s = 0; s < 2; s++) {
    lth_free(ctx, parts->spot[s]);
    lth_free(ctx, parts->share[s]);
    lth_free(ctx, parts->hold[s]);
    lth_free(ctx, parts->velocity[s]);
  }
  lth_free(ctx, parts->part);
  lth_free(ctx, parts->order);
  lth_free(ctx, parts->near);
  lth_free(ctx, parts->tri);
  lth_free(ctx, parts->hit);
  lth_free(ctx, parts);
}

static LitheStatus create_part(LitheCtx *ctx, const LthPartsSide *def, int side, LitheIndex k,
                               LthPart *part) {
  const size_t n = 3 * (size_t)def->surface[k].n_points;
  part->side = side;
  part->first_point = def->first_point[k];
  part->crack = def->cracks && def->cracks[k].sheet ? &def->cracks[k] : NULL;
  part->surface = def->surface[k];
  part->surface.points = NULL;
  LTH_NEW(ctx, part->surface.points, (LitheCount)n);
  memcpy(part->surface.points, def->surface[k].points, sizeof(double) * n);
  LTH_NEW(ctx, part->tri_spot, (LitheCount)part->surface.n_tris + 1);
  return lth_bvh_create_surface(ctx, &part->surface, &part->bvh);
}

static const double *corner(const LthSurface *s, LitheIndex tri, int k) {
  return s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
}

static double tri_area(const LthSurface *s, LitheIndex tri) {
  double e1[3], e2[3], n[3];
  lth_v3_sub(corner(s, tri, 1), corner(s, tri, 0), e1);
  lth_v3_sub(corner(s, tri, 2), corner(s, tri, 0), e2);
  lth_v3_cross(e1, e2, n);
  return 0.5 * lth_v3_norm(n);
}

static int count_spots(const LthPartsSide *side, const LthPart *part, LitheIndex tri) {
  const LthSurface *s = &part->surface;
  double longest = 0;
  for (int k = 0; side->excluded && k < 3; k++)
    if (side->excluded[part->first_point + s->tris[3 * (size_t)tri + (size_t)k]]) return 0;
  for (int k = 0; k < 3; k++)
    longest = fmax(longest, lth_v3_distance(corner(s, tri, k), corner(s, tri, (k + 1) % 3)));
  return longest > LARGE * side->cell_size ? 3 : 1;
}

/// Where the triangles of the parts of a side touch others.
static LitheStatus place_spots(LitheCtx *ctx, LthParts *parts, int side) {
  LitheIndex n = 0;
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    LthPart *part = &parts->part[k];
    if (part->side != side) continue;
    part->tri_spot[0] = n;
    for (LitheIndex t = 0; t < part->surface.n_tris; t++)
      part->tri_spot[t + 1] = n += count_spots(&parts->side[side], part, t);
  }
  parts->n_spots[side] = n;
  LTH_NEW(ctx, parts->spot[side], n);
  LTH_NEW(ctx, parts->share[side], n);
  LTH_NEW(ctx, parts->hold[side], n);
  LTH_NEW(ctx, parts->velocity[side], 3 * (LitheCount)parts->side[side].points->n_points);
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    const LthPart *part = &parts->part[k];
    for (LitheIndex t = 0; part->side == side && t < part->surface.n_tris; t++) {
      const LitheIndex first = part->tri_spot[t], count = part->tri_spot[t + 1] - first;
      for (LitheIndex i = 0; i < count; i++) {
        parts->spot[side][first + i] = (LthSpot){t, count == 3 ? (int)i : 3};
        parts->share[side][first + i] = tri_area(&part->surface, t) / count;
      }
    }
  }
  return LITHE_OK;
}

void lth_spot_weights(const LthSpot *spot, double w[3]) {
  for (int k = 0; k < 3; k++)
    w[k] = spot->corner == 3 ? 1.0 / 3 : k == spot->corner ? 1 - 2 * INSIDE : INSIDE;
}

/// Bring the surfaces of parts that are near something, or were touched, to where they are.
static void move_surfaces(const LthContact *c) {
  LthParts *parts = c->self;
  for (LitheIndex i = 0; i < c->n_touch; i++) parts->part[c->touch[i].other].is_near = true;
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(c->ctx))
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    LthPart *part = &parts->part[k];
    if (!part->is_near) continue;
    memcpy(part->surface.points, c->side[part->side].position + 3 * (size_t)part->first_point,
           sizeof(double) * 3 * (size_t)part->surface.n_points);
    lth_bvh_refit_surface(part->bvh);
  }
}

static LitheStatus parts_begin(LitheCtx *ctx, LthContact *c) {
  LITHE_TRY(lth_parts_find_near(ctx, c));
  move_surfaces(c);
  return LITHE_OK;
}

/// How deep points may be: deeper than in the last step by what they went since. At the start, anywhere.
static double depth_limit(const LthContact *c, const LthPart *a, const LthPart *b, double reach) {
  double thin = fmax(lth_box_thickness(a->box), lth_box_thickness(b->box));
  return !c->started ? thin : fmin(thin, 2 * c->penetration + reach);
}

/// What the spots of one triangle meet on part `other`.
static void seek_triangle(const LthContact *c, const LthPart *mine, const LthPart *other,
                          LitheIndex tri, double reach, LthHit *hit) {
  const LthParts *parts = c->self;
  const double depth = depth_limit(c, mine, other, reach);
  LthSeeker seeker = {.bvh = other->bvh, .facing = FACING, .way_out = depth};
  if (mine == other) seeker.crack = mine->crack, seeker.sheet = mine->crack->sheet[tri];
  lth_v3_copy(mine->bvh->tri_normal + 3 * (size_t)tri, seeker.normal);
  for (LitheIndex i = mine->tri_spot[tri]; i < mine->tri_spot[tri + 1]; i++, hit++) {
    const LthSpot *spot = &parts->spot[mine->side][i];
    double w[3], x[3] = {0, 0, 0};
    hit->tri = -1;
    if (mine == other && !(mine->crack->touches[tri] >> spot->corner & 1)) continue;
    lth_spot_weights(spot, w);
    for (int k = 0; k < 3; k++) lth_v3_axpy(w[k], corner(&mine->surface, tri, k), x);
    lth_seek(&seeker, x, reach, depth, hit);
    if (c->look != LTH_LOOK_STEP)
      lth_hold_on(other->bvh, x, c->look == LTH_LOOK_FIRST, &parts->hold[mine->side][i], hit);
  }
}

static void set_legs(const LthPart *mine, const LthPart *other, const LthSpot *spot,
                     const LthHit *hit, LthTouch *touch) {
  double w[3];
  lth_spot_weights(spot, w);
  touch->n_own = touch->n_legs = 3;
  for (int k = 0; k < 3; k++) {
    LitheIndex point = mine->surface.tris[3 * (size_t)spot->tri + (size_t)k];
    touch->leg[k] = (LthLeg){mine->side, mine->first_point + point, w[k]};
  }
  lth_touch_add_foot(&other->surface, hit, other->side, touch);
  for (int k = 3; k < touch->n_legs; k++) touch->leg[k].point += other->first_point;
}

/// A point comes in by the way that it went towards the surface in the last step, from where it was seen then, and no
/// farther: what seems to be deeper is next to a sheet or a fin too thin to have two sides.
static bool is_too_deep(const LthContact *c, const LthTouch *old, const LthHit *hit,
                        const double v[3]) {
  if (c->look != LTH_LOOK_STEP || !(hit->gap < 0)) return false;
  double limit = MARGIN * c->cell_size, way = WAYS * c->dt;
  double gap = old ? old->gap_end - old->slack : 0;
  if (old && !old->active && -hit->gap > limit + way * lth_v3_norm(v) - gap) return true;
  if (old || !c->started) limit += way * fmax(-lth_v3_dot(v, hit->normal), 0);
  if (old) limit += fmax(-gap, 0);
  return -hit->gap > limit;
}

/// Turn the hits of the listed triangles into touches.
static LitheStatus collect(LitheCtx *ctx, LthContact *c, const LthNearParts *near, double reach) {
  const LthParts *parts = c->self;
  const LthPart *mine = &parts->part[near->mine], *other = &parts->part[near->other];
  for (LitheIndex t = 0; t < parts->n_tri; t++) {
    const LitheIndex tri = parts->tri[t];
    const LthHit *hit = parts->hit + 3 * (size_t)t;
    for (LitheIndex i = mine->tri_spot[tri]; i < mine->tri_spot[tri + 1]; i++, hit++) {
      double v[3];
      if (hit->tri < 0 || hit->gap > reach) continue;
      LthTouch touch = {.side = mine->side, .other = near->other, .point = i};
      set_legs(mine, other, &parts->spot[mine->side][i], hit, &touch);
      lth_touch_value(c, &touch, v);
      const LthTouch *old = lth_touch_before(c, &touch);
      if (is_too_deep(c, old, hit, v)) continue;
      touch.stiffness = c->stiffness * parts->share[mine->side][i];
      lth_touch_meet(c, &other->surface, hit, v, &touch);
      LITHE_TRY(lth_touch_add(ctx, c, &touch));
    }
  }
  return LITHE_OK;
}

static void warn_of_speed(LitheCtx *ctx, LthContact *c, const LthPart *a, const LthPart *b) {
  const LthParts *parts = c->self;
  double way = c->dt * (lth_v3_distance(a->mean, b->mean) + a->spread + b->spread);
  double thin = fmin(lth_box_thickness(a->box), lth_box_thickness(b->box));
  if (c->warned || !(way > FAST * thin)) return;
  c->warned = true;
  lth_warn(ctx,
           "parts of %s and %s approach by up to %.3g m a step at t = %.3g s, the thinner of them "
           "measures %.3g m: they may pass through each other; take smaller steps",
           parts->side[a->side].name, parts->side[b->side].name, way, c->t, thin);
}

static LitheStatus parts_find_near(LitheCtx *ctx, LthContact *c) {
  LthParts *parts = c->self;
  for (LitheIndex n = 0; n < parts->n_near; n++) {
    const LthNearParts *near = &parts->near[n];
    const LthPart *mine = &parts->part[near->mine], *other = &parts->part[near->other];
    const double reach = lth_parts_reach(c, mine, other);
    if (mine == other) {
      LITHE_TRY(lth_parts_find_crack_tris(ctx, parts, mine));
    } else {
      warn_of_speed(ctx, c, mine, other);
      LITHE_TRY(lth_parts_find_tris(ctx, parts, mine, other->bvh->box, reach));
    }
    LTH_RESERVE(ctx, parts->hit, parts->hit_cap, 3 * (LitheCount)parts->n_tri);
#pragma omp parallel for schedule(dynamic, 64)                                                     \
    num_threads(lth_threads(c->ctx)) if (parts->n_tri > SERIAL)
    for (LitheIndex t = 0; t < parts->n_tri; t++)
      seek_triangle(c, mine, other, parts->tri[t], reach, parts->hit + 3 * (size_t)t);
    LITHE_TRY(collect(ctx, c, near, reach));
  }
  return LITHE_OK;
}

static void parts_move_anchor(const LthContact *c, LthTouch *touch, const double x[3]) {
  const LthParts *parts = c->self;
  const LthPart *other = &parts->part[touch->other];
  LthSeeker seeker = {.bvh = other->bvh, .facing = FACING};
  LthBvhPoint closest;
  const LitheIndex *own = other->tri_spot;
  if (other->crack && touch->side == other->side && touch->point >= own[0] &&
      touch->point < own[other->surface.n_tris]) {
    seeker.crack = other->crack;
    seeker.sheet = other->crack->sheet[parts->spot[touch->side][touch->point].tri];
  }
  lth_v3_copy(touch->normal, seeker.normal);
  lth_v3_scale(-1, seeker.normal);
  if (lth_bvh_closest(other->bvh, x, INFINITY, lth_seeker_faces, &seeker, &closest))
    lth_touch_fix(&other->surface, closest.tri, closest.point, touch);
}

static const LthContactKind parts_kind = {.begin = parts_begin,
                                          .find_near = parts_find_near,
                                          .move_anchor = parts_move_anchor,
                                          .destroy = parts_destroy,
                                          .keeps_energy = true};

bool lth_contact_is_within(const LthContact *c) {
  return c->kind == &parts_kind && c->n_sides == 1;
}

static double parts_stiffness(const LthPartsDef *def) {
  const LthPartsSide *a = &def->side[0], *b = &def->side[def->n_sides - 1];
  return lth_contact_pair_stiffness(
      SOFT * fmin(lth_contact_auto_stiffness(a->modulus, a->cell_size, 0, a->body_size),
                  lth_contact_auto_stiffness(b->modulus, b->cell_size, 0, b->body_size)),
      a->cell_size, fmin(a->body_weight, b->body_weight), fmin(a->body_size, b->body_size));
}

static LitheStatus create_self(LitheCtx *ctx, const LthPartsDef *def, LthParts *parts) {
  LitheCount n = 0;
  for (int s = 0; s < def->n_sides; s++) {
    parts->side[s] = def->side[s];
    n += def->side[s].n_parts;
  }
  LTH_NEW(ctx, parts->part, n);
  LTH_NEW(ctx, parts->order, n);
  for (int s = 0; s < def->n_sides; s++)
    for (LitheIndex k = 0; k < def->side[s].n_parts; k++) {
      LthPart *part = &parts->part[parts->n_parts];
      parts->order[parts->n_parts] = parts->n_parts;
      parts->n_parts++;
      LITHE_TRY(create_part(ctx, &def->side[s], s, k, part));
    }
  for (int s = 0; s < def->n_sides; s++) LITHE_TRY(place_spots(ctx, parts, s));
  return LITHE_OK;
}

LitheStatus lth_contact_create_parts(LitheCtx *ctx, const LthPartsDef *def, LthContact **contact) {
  LitheStatus status = LITHE_OK;
  LthParts *parts = NULL;
  const LthEmbedding *points[2] = {def->side[0].points, def->side[1].points};
  const LthPartsSide *a = &def->side[0], *b = &def->side[def->n_sides - 1];
  LITHE_TRY(lth_contact_create_sides(ctx, def->n_sides, points, def->stiffness, contact));
  LthContact *c = *contact;
  c->kind = &parts_kind;
  LTH_NEW_OR(done, ctx, parts, 1);
  c->self = parts;
  c->friction = def->friction, c->damping = def->damping;
  c->cell_size = fmin(a->cell_size, b->cell_size);
  c->body_size = fmin(a->body_size, b->body_size);
  if (c->is_auto) c->stiffness = parts_stiffness(def);
  LITHE_TRY_OR(done, create_self(ctx, def, parts));
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, contact);
  return status;
}
