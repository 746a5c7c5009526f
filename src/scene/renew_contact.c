/// What contacts remember, carried over to contacts of the same bodies with other points.
#include "scene/renew.h"

#include <string.h>

static bool same_place(const double *a, const double *b) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/// Points in the order of their places, by heap sort: equal ones in the order of their numbers.
static int compare(const LthEmbedding *e, LitheIndex a, LitheIndex b) {
  const double *x = e->rest + 3 * (size_t)a, *y = e->rest + 3 * (size_t)b;
  for (int i = 0; i < 3; i++)
    if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
  return a < b ? -1 : a > b;
}

static void sift(const LthEmbedding *e, LitheIndex *order, LitheIndex at, LitheIndex n) {
  for (LitheIndex child; (child = 2 * at + 1) < n; at = child) {
    if (child + 1 < n && compare(e, order[child], order[child + 1]) < 0) child++;
    if (compare(e, order[at], order[child]) >= 0) return;
    LitheIndex swap = order[at];
    order[at] = order[child];
    order[child] = swap;
  }
}

static void sort_points(const LthEmbedding *e, LitheIndex *order) {
  for (LitheIndex i = 0; i < e->n_points; i++) order[i] = i;
  for (LitheIndex i = e->n_points / 2; i-- > 0;) sift(e, order, i, e->n_points);
  for (LitheIndex n = e->n_points; n-- > 1;) {
    LitheIndex top = order[0];
    order[0] = order[n];
    order[n] = top;
    sift(e, order, 0, n);
  }
}

/// New number of each old point: its own where it lies where it lay, else that of the first point at its place, or -1.
static LitheStatus map_points(LitheCtx *ctx, const LthEmbedding *from, const LthEmbedding *to,
                              LitheIndex **map) {
  LitheStatus status = LITHE_OK;
  LitheIndex *order[2] = {NULL, NULL};
  LTH_NEW_OR(done, ctx, *map, from->n_points);
  LTH_NEW_OR(done, ctx, order[0], from->n_points);
  LTH_NEW_OR(done, ctx, order[1], to->n_points);
  sort_points(from, order[0]);
  sort_points(to, order[1]);
  for (LitheIndex i = 0, j = 0; i < from->n_points; i++) {
    LitheIndex p = order[0][i];
    const double *x = from->rest + 3 * (size_t)p;
    (*map)[p] = -1;
    if (p < to->n_points && same_place(x, to->rest + 3 * (size_t)p)) {
      (*map)[p] = p;
      continue;
    }
    for (; j < to->n_points; j++) {
      const double *y = to->rest + 3 * (size_t)order[1][j];
      bool is_before = y[0] != x[0] ? y[0] < x[0] : y[1] != x[1] ? y[1] < x[1] : y[2] < x[2];
      if (!is_before) break;
    }
    if (j < to->n_points && same_place(x, to->rest + 3 * (size_t)order[1][j]))
      (*map)[p] = order[1][j];
  }
done:
  lth_free(ctx, order[0]);
  lth_free(ctx, order[1]);
  return status;
}

static LitheStatus carry(LitheCtx *ctx, int n_sides, const LthEmbedding *const from[2],
                         const LthEmbedding *const to[2], bool same_surfaces, const LthContact *old,
                         LthContact *contact) {
  LitheStatus status = LITHE_OK;
  LitheIndex *map[2] = {NULL, NULL};
  for (int s = 0; s < n_sides; s++) LITHE_TRY_OR(done, map_points(ctx, from[s], to[s], map + s));
  LITHE_TRY_OR(
      done, lth_contact_inherit(ctx, contact, old, (const LitheIndex *const *)map, same_surfaces));
done:
  lth_free(ctx, map[0]);
  lth_free(ctx, map[1]);
  return status;
}

static LitheStatus carry_rigid(LitheCtx *ctx, const LthBody *body, const LthRenewal *r) {
  if (!r->old.def || !body->contact || !r->old.contact) return LITHE_OK;
  const LthEmbedding *from[2] = {r->old.nodes ? r->old.nodes : r->old.embedding, NULL};
  const LthEmbedding *to[2] = {body->nodes ? body->nodes : body->embedding, NULL};
  return carry(ctx, 1, from, to, true, r->old.contact, body->contact);
}

/// What the points of a body's touch surface followed before.
static const LthEmbedding *old_points(const LthWorld *world, const LthRenewal *r, LitheIndex b) {
  if (r[b].touch_embedding) return r[b].touch_embedding;
  return r[b].old.def ? r[b].old.embedding : world->bodies[b]->embedding;
}

static bool same_surface(const LthSurface *a, const LthSurface *b) {
  return a->n_points == b->n_points && a->n_tris == b->n_tris &&
         memcmp(a->tris, b->tris, 3 * sizeof *a->tris * (size_t)a->n_tris) == 0 &&
         memcmp(a->points, b->points, 3 * sizeof *a->points * (size_t)a->n_points) == 0;
}

static LitheStatus carry_pair(LitheCtx *ctx, const LthWorld *world, const LthRenewal *renewals,
                              const LthWorldPair *old, const LthWorldPair *pair) {
  const LthEmbedding *from[2], *to[2];
  bool same = true;
  if (old->by_parts != pair->by_parts) return LITHE_OK; // has become several parts: starts anew
  if (pair->by_parts) return lth_contact_inherit_parts(ctx, pair->contact, old->contact);
  for (int s = 0; s < 2; s++) {
    LitheIndex b = pair->body[s];
    from[s] = old_points(world, renewals, b);
    to[s] = lth_body_touch_points(world->bodies[b]);
    same = same && same_surface(renewals[b].touch, world->bodies[b]->touch);
  }
  return carry(ctx, 2, from, to, same, old->contact, pair->contact);
}

LitheStatus lth_world_carry_contacts(LitheCtx *ctx, LthWorld *world, const LthWorld *old,
                                     const LthRenewal *renewals) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    LITHE_TRY(carry_rigid(ctx, world->bodies[b], renewals + b));
  for (LitheIndex i = 0; i < world->n_pairs; i++) lth_contact_join_run(world->pairs[i].contact);
  for (LitheIndex i = 0; i < world->n_pairs; i++)
    for (LitheIndex j = 0; j < old->n_pairs; j++)
      if (memcmp(world->pairs[i].body, old->pairs[j].body, sizeof old->pairs[j].body) == 0)
        LITHE_TRY(carry_pair(ctx, world, renewals, old->pairs + j, world->pairs + i));
  return LITHE_OK;
}
