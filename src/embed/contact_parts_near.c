/// Which parts of bodies are near each other: boxes sorted along an axis, so that many parts cost little more than few.
#include "base/order.h"
#include "base/tensor.h"
#include "embed/contact_parts.h"

#include <stdlib.h>

#define REACH_CELLS 0.1 ///< of a cell: how far beyond a straight step points are watched
#define REACH_STEPS 2   ///< straight steps that they are watched for

double lth_parts_reach(const LthContact *c, const LthPart *a, const LthPart *b) {
  double way = lth_v3_distance(a->mean, b->mean) + a->spread + b->spread;
  return REACH_STEPS * c->dt * way + REACH_CELLS * c->cell_size;
}

/// Box and velocity of a part.
static void measure(const LthContact *c, const LthParts *parts, LthPart *part) {
  const LthContactSide *side = &c->side[part->side];
  const LitheIndex n = part->surface.n_points;
  double largest2 = 0;
  memset(part->mean, 0, sizeof part->mean);
  for (int a = 0; a < 3; a++) part->box[a] = INFINITY, part->box[3 + a] = -INFINITY;
  for (LitheIndex i = 0; i < n; i++) {
    const size_t p = 3 * (size_t)(part->first_point + i);
    double *v = parts->velocity[part->side] + p;
    lth_embedding_from_samples(side->points, part->first_point + i, side->sample_value, v);
    lth_v3_add(part->mean, v, part->mean);
    for (int a = 0; a < 3; a++) {
      part->box[a] = fmin(part->box[a], side->position[p + (size_t)a]);
      part->box[3 + a] = fmax(part->box[3 + a], side->position[p + (size_t)a]);
    }
  }
  lth_v3_scale(1.0 / n, part->mean);
  for (LitheIndex i = 0; i < n; i++) {
    double about[3];
    lth_v3_sub(parts->velocity[part->side] + 3 * (size_t)(part->first_point + i), part->mean,
               about);
    largest2 = fmax(largest2, lth_v3_dot(about, about));
  }
  part->spread = sqrt(largest2);
}

/// The axis along which all parts together are longest.
static int longest_axis(const LthParts *parts) {
  double all[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  int axis = 0;
  for (LitheIndex k = 0; k < parts->n_parts; k++)
    for (int a = 0; a < 3; a++) {
      all[a] = fmin(all[a], parts->part[k].box[a]);
      all[3 + a] = fmax(all[3 + a], parts->part[k].box[3 + a]);
    }
  for (int a = 1; a < 3; a++)
    if (all[3 + a] - all[a] > all[3 + axis] - all[axis]) axis = a;
  return axis;
}

/// Order parts by where their boxes begin: nearly in order from the step before.
static void sort(LthParts *parts, int axis) {
  LitheIndex *order = parts->order;
  for (LitheIndex i = 1; i < parts->n_parts; i++) {
    LitheIndex k = order[i], j = i;
    for (; j > 0 && parts->part[order[j - 1]].box[axis] > parts->part[k].box[axis]; j--)
      order[j] = order[j - 1];
    order[j] = k;
  }
}

static LitheStatus add_near(LitheCtx *ctx, LthParts *parts, LitheIndex mine, LitheIndex other) {
  LTH_RESERVE(ctx, parts->near, parts->near_cap, (LitheCount)parts->n_near + 1);
  parts->near[parts->n_near++] = (LthNearParts){parts->part[mine].side, mine, other};
  parts->part[mine].is_near = parts->part[other].is_near = true;
  return LITHE_OK;
}

static int compare_near(const void *a, const void *b) {
  const LthNearParts *p = a, *q = b;
  if (p->side != q->side) return p->side < q->side ? -1 : 1;
  if (p->other != q->other) return p->other < q->other ? -1 : 1;
  return (p->mine > q->mine) - (p->mine < q->mine);
}

/// The largest way that any part's points go in a step, but for what all have in common.
static double largest_way(const LthContact *c, const LthParts *parts) {
  double mean[3] = {0, 0, 0}, way = 0;
  for (LitheIndex k = 0; k < parts->n_parts; k++)
    lth_v3_axpy(1.0 / parts->n_parts, parts->part[k].mean, mean);
  for (LitheIndex k = 0; k < parts->n_parts; k++)
    way = fmax(way, lth_v3_distance(parts->part[k].mean, mean) + parts->part[k].spread);
  return 2 * REACH_STEPS * c->dt * way + REACH_CELLS * c->cell_size;
}

LitheStatus lth_parts_find_near(LitheCtx *ctx, LthContact *c) {
  LthParts *parts = c->self;
  for (LitheIndex k = 0; k < parts->n_parts; k++) {
    measure(c, parts, &parts->part[k]);
    parts->part[k].is_near = false;
  }
  const int axis = longest_axis(parts);
  const double farthest = largest_way(c, parts);
  sort(parts, axis);
  parts->n_near = 0;
  for (LitheIndex i = 0; i < parts->n_parts; i++) {
    const LitheIndex a = parts->order[i];
    for (LitheIndex j = i + 1; j < parts->n_parts; j++) {
      const LitheIndex b = parts->order[j];
      const LthPart *first = &parts->part[a], *second = &parts->part[b];
      if (second->box[axis] - first->box[3 + axis] > farthest) break;
      if (c->n_sides == 2 && first->side == second->side) continue;
      if (lth_box_gap(first->box, second->box) > lth_parts_reach(c, first, second)) continue;
      LITHE_TRY(add_near(ctx, parts, a, b));
      LITHE_TRY(add_near(ctx, parts, b, a));
    }
  }
  for (LitheIndex k = 0; k < parts->n_parts && c->n_sides == 1; k++)
    if (parts->part[k].crack) LITHE_TRY(add_near(ctx, parts, k, k));
  // as touches come: by side, other, point
  if (parts->n_near > 0)
    qsort(parts->near, (size_t)parts->n_near, sizeof *parts->near, compare_near);
  return LITHE_OK;
}

LitheStatus lth_parts_find_tris(LitheCtx *ctx, LthParts *parts, const LthPart *mine,
                                const double box[6], double reach) {
  const LthBvh *bvh = mine->bvh;
  LitheIndex stack[64];
  int depth = 0;
  parts->n_tri = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    LitheIndex node = stack[--depth];
    if (lth_box_gap(bvh->box + 6 * (size_t)node, box) > reach) continue;
    if (bvh->right[node] >= 0) {
      stack[depth++] = bvh->right[node];
      stack[depth++] = node + 1;
      continue;
    }
    LTH_RESERVE(ctx, parts->tri, parts->tri_cap, (LitheCount)parts->n_tri + bvh->count[node]);
    for (LitheIndex i = 0; i < bvh->count[node]; i++)
      parts->tri[parts->n_tri++] = bvh->item[bvh->first[node] + i];
  }
  parts->n_tri = lth_sort_unique(parts->tri, parts->n_tri);
  return LITHE_OK;
}

LitheStatus lth_parts_find_crack_tris(LitheCtx *ctx, LthParts *parts, const LthPart *mine) {
  parts->n_tri = 0;
  LTH_RESERVE(ctx, parts->tri, parts->tri_cap, mine->surface.n_tris);
  for (LitheIndex t = 0; t < mine->surface.n_tris; t++)
    if (mine->crack->touches[t] && mine->crack->sheet[t] >= 0) parts->tri[parts->n_tri++] = t;
  return LITHE_OK;
}
