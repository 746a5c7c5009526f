/// Contact's memory from one step to the next: as bytes, and in another contact's place.
#include "embed/contact_priv.h"

static LitheStatus make_room(LthContact *c, LitheCount n) {
  LTH_RESERVE(c->ctx, c->touch, c->touch_cap, n);
  return LITHE_OK;
}

void lth_contact_archive(LthContact *c, LthArchive *a) {
  LitheCount n = c->n_touch;
  lth_archive_mark(a, "contact");
  LTH_ARCHIVE(a, c->t);
  LTH_ARCHIVE(a, c->dt);
  LTH_ARCHIVE(a, c->is_search);
  LTH_ARCHIVE(a, c->stiffness);
  LTH_ARCHIVE(a, c->growth);
  LTH_ARCHIVE(a, c->penetration);
  LTH_ARCHIVE(a, c->last_penetration);
  LTH_ARCHIVE(a, c->force);
  LTH_ARCHIVE(a, c->warned);
  LTH_ARCHIVE(a, c->started);
  LTH_ARCHIVE(a, c->spare);
  LTH_ARCHIVE(a, c->spent);
  lth_archive_count(a, &n);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room(c, n);
  if (a->status != LITHE_OK) return;
  c->n_touch = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(a, c->touch, n);
  if (!a->is_reading || a->status != LITHE_OK) return;
  a->status = lth_contact_reserve(c->ctx, c);
  if (a->status == LITHE_OK) lth_contact_index(c);
}

/// A touching point with the numbers of now; false where one of its points is gone.
static bool renumber(LthTouch *touch, const LitheIndex *const point_of[2]) {
  for (int l = 0; l < touch->n_legs; l++) {
    LitheIndex point = point_of[touch->leg[l].side][touch->leg[l].point];
    if (point < 0) return false;
    touch->leg[l].point = point;
  }
  touch->point = point_of[touch->side][touch->point];
  return touch->point >= 0;
}

static bool comes_before(const LthTouch *a, const LthTouch *b) {
  if (a->side != b->side) return a->side < b->side;
  return a->other != b->other ? a->other < b->other : a->point < b->point;
}

void lth_contact_take(LthContact *c, const LthContact *from) {
  double stored;
  c->t = from->t;
  c->dt = from->dt;
  c->is_search = from->is_search;
  c->stiffness = from->stiffness;
  c->growth = from->growth;
  c->penetration = from->penetration;
  c->last_penetration = from->last_penetration;
  c->force = from->force;
  c->warned = from->warned;
  c->started = from->started;
  lth_contact_energy(from, &stored, &c->spare);
  c->n_touch = 0;
}

LitheStatus lth_contact_insert(LitheCtx *ctx, LthContact *c, const LthTouch *touch) {
  LTH_RESERVE(ctx, c->touch, c->touch_cap, (LitheCount)c->n_touch + 1);
  LitheIndex at = c->n_touch++; // near its place: numbers mostly ascend
  for (; at > 0 && comes_before(touch, c->touch + at - 1); at--) c->touch[at] = c->touch[at - 1];
  c->touch[at] = *touch;
  c->touch[at].lost = 0; // of steps before: it is in `spare` by now
  return LITHE_OK;
}

LitheStatus lth_contact_inherit(LitheCtx *ctx, LthContact *c, const LthContact *from,
                                const LitheIndex *const point_of[2], bool same_surfaces) {
  lth_contact_take(c, from);
  for (LitheIndex i = 0; same_surfaces && i < from->n_touch; i++) {
    LthTouch touch = from->touch[i];
    if (!renumber(&touch, point_of)) continue;
    LITHE_TRY(lth_contact_insert(ctx, c, &touch));
  }
  LITHE_TRY(lth_contact_reserve(ctx, c));
  lth_contact_index(c);
  return LITHE_OK;
}
