/// What contact of parts remembers, for parts that are others than before: places at rest stay what they are.
#include "embed/contact_parts.h"

#include "base/tensor.h"

#include <stdlib.h>

#define SAME_PLACE 1e-9  ///< of the body
#define SAME_NORMAL 0.99 ///< least cosine

/// A spot at rest.
typedef struct Place {
  double x[3], normal[3];
  LitheIndex part, spot;
} Place;

/// The surface of a part at rest.
static const LthSurface *rest_surface(const LthParts *parts, LitheIndex part) {
  const LitheIndex first = parts->part[part].side == 0 ? 0 : parts->side[0].n_parts; // of its side
  return &parts->side[parts->part[part].side].surface[part - first];
}

static void normal_at_rest(const LthSurface *s, LitheIndex tri, double normal[3]) {
  const LitheIndex *c = s->tris + 3 * (size_t)tri;
  double e1[3], e2[3];
  lth_v3_sub(s->points + 3 * (size_t)c[1], s->points + 3 * (size_t)c[0], e1);
  lth_v3_sub(s->points + 3 * (size_t)c[2], s->points + 3 * (size_t)c[0], e2);
  lth_v3_cross(e1, e2, normal);
  lth_v3_normalize(normal);
}

static void place_in(const LthSurface *s, LitheIndex tri, const double w[3], double x[3]) {
  x[0] = x[1] = x[2] = 0;
  for (int k = 0; k < 3; k++)
    lth_v3_axpy(w[k], s->points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k], x);
}

static void place_spot(const LthParts *parts, LitheIndex part, LitheIndex spot, Place *place) {
  const LthSpot *at = &parts->spot[parts->part[part].side][spot];
  const LthSurface *s = rest_surface(parts, part);
  double w[3];
  lth_spot_weights(at, w);
  place_in(s, at->tri, w, place->x);
  normal_at_rest(s, at->tri, place->normal);
  place->part = part, place->spot = spot;
}

static int compare_places(const void *a, const void *b) {
  const Place *p = a, *q = b;
  if (p->x[0] != q->x[0]) return p->x[0] < q->x[0] ? -1 : 1;
  if (p->part != q->part) return p->part < q->part ? -1 : 1;
  return (p->spot > q->spot) - (p->spot < q->spot);
}

/// The spots of a side, by x.
static LitheStatus list_places(LitheCtx *ctx, const LthParts *parts, int side, Place **list) {
  LitheIndex n = 0;
  LTH_NEW(ctx, *list, parts->n_spots[side]);
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    const LthPart *part = &parts->part[k];
    if (part->side != side) continue;
    for (LitheIndex i = part->tri_spot[0]; i < part->tri_spot[part->surface.n_tris]; i++)
      place_spot(parts, k, i, &(*list)[n++]);
  }
  if (n > 0) qsort(*list, (size_t)n, sizeof **list, compare_places);
  return LITHE_OK;
}

/// The spot at a place with the normal there, or NULL.
static const Place *find_place(const Place *list, LitheIndex n, const Place *wanted, double near) {
  LitheIndex low = 0, high = n;
  while (low < high) {
    LitheIndex mid = low + (high - low) / 2;
    if (list[mid].x[0] < wanted->x[0] - near)
      low = mid + 1;
    else
      high = mid;
  }
  for (; low < n && list[low].x[0] <= wanted->x[0] + near; low++)
    if (lth_v3_distance(list[low].x, wanted->x) <= near &&
        lth_v3_dot(list[low].normal, wanted->normal) > SAME_NORMAL)
      return &list[low];
  return NULL;
}

/// Triangles with a normal of their own: LthBvhAccept.
static bool has_normal(const void *self, LitheIndex tri) {
  const LthSeeker *seeker = self;
  return lth_v3_dot(seeker->normal, seeker->bvh->tri_normal + 3 * (size_t)tri) > SAME_NORMAL;
}

/// Fix the anchor of a touch where it was at rest; false where nothing is there any more. Trees are at rest yet.
static bool find_anchor(const LthParts *parts, LitheIndex own, bool is_within, const double x[3],
                        const double normal[3], double near, LthTouch *touch) {
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    const LthPart *part = &parts->part[k];
    LthSeeker seeker = {.bvh = part->bvh};
    LthBvhPoint closest;
    if ((k == own && !part->crack) || (part->side == parts->part[own].side) != is_within) continue;
    if (lth_box_distance2(part->bvh->box, x) > near * near) continue;
    lth_v3_copy(normal, seeker.normal);
    if (!lth_bvh_closest(part->bvh, x, near, has_normal, &seeker, &closest)) continue;
    touch->other = k;
    lth_touch_fix(&part->surface, closest.tri, closest.point, touch);
    return true;
  }
  return false;
}

/// An old touch with the numbers of now; false where one of its two ends is gone.
static bool renew(const LthContact *c, const LthParts *parts, const LthParts *was,
                  Place *const *list, const LthTouch *old, LthTouch *touch) {
  const double near = SAME_PLACE * c->body_size;
  Place spot;
  double anchor[3], normal[3], w[3];
  LitheIndex mine = 0;
  while (was->part[mine].side != old->side ||
         was->part[mine].tri_spot[was->part[mine].surface.n_tris] <= old->point)
    mine++;
  place_spot(was, mine, old->point, &spot);
  const Place *now = find_place(list[old->side], parts->n_spots[old->side], &spot, near);
  if (!now) return false;
  const LthSurface *other = rest_surface(was, old->other);
  place_in(other, old->anchor_tri, old->anchor, anchor);
  normal_at_rest(other, old->anchor_tri, normal);
  *touch = *old;
  if (!find_anchor(parts, now->part, c->n_sides == 1, anchor, normal, near, touch)) return false;
  const LthPart *part = &parts->part[now->part];
  const LthSpot *at = &parts->spot[old->side][now->spot];
  lth_spot_weights(at, w);
  touch->point = now->spot;
  touch->n_legs = touch->n_own;
  for (int k = 0; k < 3; k++)
    touch->leg[k] = (LthLeg){
        old->side, part->first_point + part->surface.tris[3 * (size_t)at->tri + (size_t)k], w[k]};
  return true;
}

LitheStatus lth_contact_inherit_parts(LitheCtx *ctx, LthContact *c, const LthContact *from) {
  LitheStatus status = LITHE_OK;
  const LthParts *parts = c->self, *was = from->self;
  Place *list[2] = {NULL, NULL};
  lth_contact_take(c, from);
  for (int s = 0; s < c->n_sides; s++) LITHE_TRY_OR(done, list_places(ctx, parts, s, &list[s]));
  for (LitheIndex i = 0; i < from->n_touch; i++) {
    LthTouch touch;
    const bool matters = from->touch[i].active || from->touch[i].slack > 0;
    if (!matters || !renew(c, parts, was, list, &from->touch[i], &touch)) continue;
    LITHE_TRY_OR(done, lth_contact_insert(ctx, c, &touch));
  }
  LITHE_TRY_OR(done, lth_contact_reserve(ctx, c));
  lth_contact_index(c);
done:
  for (int s = 0; s < 2; s++) lth_free(ctx, list[s]);
  return status;
}
