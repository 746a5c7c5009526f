/// What a change in the middle of a run left nothing of: constraints, loads and ties that act on nothing from then on.
#include "scene/change.h"

#include <stdio.h>

enum { CONSTRAINT, LOAD, TIE };

const char *lth_loss_name(const LthBody *body, const LthLoss *loss, char *name, size_t size) {
  static const char *const lists[] = {"constraints", "loads"};
  if (loss->kind == TIE)
    snprintf(name, size, "tie.%d", loss->index);
  else
    snprintf(name, size, "bodies.%d.%s.%d", (int)(body->def - body->scene->bodies),
             lists[loss->kind], loss->index);
  return name;
}

/// The entry of the scene with a place, which is told by its address.
static LthLoss entry_at(const LthBody *body, const char *place) {
  const LthSceneBody *def = body->def;
  for (LitheIndex i = 0; i < def->n_constraints; i++)
    if (def->constraints[i].place == place) return (LthLoss){.kind = CONSTRAINT, .index = i};
  for (LitheIndex i = 0; i < def->n_loads; i++)
    if (def->loads[i].place == place) return (LthLoss){.kind = LOAD, .index = i};
  LthLoss tie = {.kind = TIE};
  while (body->scene->ties[tie.index].place != place) tie.index++;
  return tie;
}

LitheStatus lth_body_lose(LitheCtx *ctx, const LthBody *body, const char *place, bool *is_loss) {
  LthBodyChange *c = body->change;
  *is_loss = c && c->is_running;
  if (!*is_loss) return LITHE_OK;
  char name[80]; // not the place: a run that goes on names its file otherwise
  LthLoss loss = entry_at(body, place);
  loss.t = body->sim ? lth_simulation_time(body->sim) : 0;
  for (LitheIndex i = 0; i < c->n_losses; i++)
    if (c->losses[i].kind == loss.kind && c->losses[i].index == loss.index) return LITHE_OK;
  LTH_RESERVE(ctx, c->losses, c->cap_losses, (LitheCount)c->n_losses + 1);
  c->losses[c->n_losses++] = loss;
  lth_warn(ctx,
           "%s: nothing of what it selects is left of the body `%s` at %g s; from now on it acts "
           "on nothing",
           lth_loss_name(body, &loss, name, sizeof name), body->def->name, loss.t);
  return LITHE_OK;
}

static LitheStatus make_room(LitheCtx *ctx, LthBodyChange *c, LitheCount n) {
  LTH_RESERVE(ctx, c->losses, c->cap_losses, n);
  return LITHE_OK;
}

void lth_losses_archive(LthBodyChange *c, LthArchive *a) {
  LitheCount n = c->n_losses;
  lth_archive_count(a, &n);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room(a->ctx, c, n);
  if (a->status != LITHE_OK) return;
  c->n_losses = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(a, c->losses, n);
}
