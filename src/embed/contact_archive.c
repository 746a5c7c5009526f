/// Contact's memory from one step to the next, as bytes.
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
  lth_archive_count(a, &n);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room(c, n);
  if (a->status != LITHE_OK) return;
  c->n_touch = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(a, c->touch, n);
  if (!a->is_reading || a->status != LITHE_OK) return;
  a->status = lth_contact_reserve(c->ctx, c);
  if (a->status == LITHE_OK) lth_contact_index(c);
}
