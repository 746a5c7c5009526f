/// What a point meets on another surface.
///
/// The nearest feature of a thin part may lie on its far side. So a point only touches what faces it: a surface whose
/// normal turns away from the point's own.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define FRONT 0.3 ///< least cosine between a triangle's normal and the way out of it
#define ABOVE 0.7 ///< the same on the other side of a crack
#define CHANGES_MAX                                                                                \
  3 ///< of triangle within a search for an equilibrium, then a point keeps the one it has

/// Triangles that are not on the point's own side of a crack: LthBvhAccept.
static bool is_across(const void *self, LitheIndex tri) {
  const LthSeeker *seeker = self;
  const LthCrackSides *crack = seeker->crack;
  if (!crack) return true;
  if (crack->sheet[tri] < 0) return false;
  LitheIndex low = 0, high = crack->n_mates;
  while (low < high) {
    const LitheIndex mid = low + (high - low) / 2, *pair = crack->mates + 2 * (size_t)mid;
    if (pair[0] == seeker->sheet && pair[1] == crack->sheet[tri]) return true;
    bool is_before =
        pair[0] != seeker->sheet ? pair[0] < seeker->sheet : pair[1] < crack->sheet[tri];
    if (is_before)
      low = mid + 1;
    else
      high = mid;
  }
  return false;
}

bool lth_seeker_faces(const void *self, LitheIndex tri) {
  const LthSeeker *seeker = self;
  if (!is_across(self, tri)) return false;
  return lth_v3_dot(seeker->normal, seeker->bvh->tri_normal + 3 * (size_t)tri) < seeker->facing;
}

void lth_seek(const LthSeeker *seeker, const double x[3], double reach, double depth, LthHit *hit) {
  const LthBvh *bvh = seeker->bvh;
  LthBvhPoint closest;
  hit->tri = -1, hit->held = false;
  if (lth_box_distance2(bvh->box, x) > reach * reach) return;
  LthBvhAccept accept = seeker->crack ? is_across : NULL;
  if (!lth_bvh_closest(bvh, x, fmax(reach, depth), accept, seeker, &closest)) return;
  hit->gap = lth_bvh_gap(bvh, x, &closest, hit->normal);
  if (hit->gap > reach) return;
  if (!(lth_v3_dot(hit->normal, seeker->normal) < seeker->facing)) {
    if (hit->gap > 0 ||
        !lth_bvh_closest(bvh, x, seeker->way_out, lth_seeker_faces, seeker, &closest))
      return;
    hit->gap = -closest.distance;
    lth_v3_sub(closest.point, x, hit->normal);
    lth_v3_normalize(hit->normal);
    if (!(lth_v3_dot(hit->normal, bvh->tri_normal + 3 * (size_t)closest.tri) > FRONT)) return;
  }
  // beside the rim of the other side there is nothing to touch
  if (seeker->crack &&
      !(lth_v3_dot(hit->normal, bvh->tri_normal + 3 * (size_t)closest.tri) > ABOVE))
    return;
  hit->tri = closest.tri;
  lth_v3_copy(closest.point, hit->point);
}

void lth_hold_on(const LthBvh *other, const double x[3], bool first, LthHold *hold, LthHit *hit) {
  if (first) *hold = (LthHold){.tri = -1};
  bool inside = hit->tri >= 0 && hit->gap < 0, changed = inside && hold->tri != hit->tri;
  if (hold->tri >= 0 && hold->changes >= CHANGES_MAX) {
    LthHit held = {.tri = hold->tri, .held = true};
    if (lth_meet_plane(other, hold->tri, x, &held.gap, held.point)) {
      lth_v3_copy(other->tri_normal + 3 * (size_t)hold->tri, held.normal);
      *hit = held;
      return;
    }
    hold->changes = 0;
  }
  if (changed && hold->tri >= 0) hold->changes++;
  if (changed) hold->tri = hit->tri;
}
