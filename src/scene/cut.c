/// Cuts of a scene: when they are due, the slivers that they leave, and what is told of them.
#include "scene/cut_priv.h"

#include <math.h>

#define ROUNDING 1e-9 ///< of a time: two that differ by less are the same

static LthChangeNote note_of(const LthWorld *world, LitheIndex i, LitheIndex b) {
  static const LthChangeKind kinds[] = {LTH_CHANGE_PLANE, LTH_CHANGE_BLADE, LTH_CHANGE_CARVE};
  return (LthChangeNote){.kind = kinds[world->scene->cuts[i].kind],
                         .t = world->sim ? lth_simulation_time(world->sim) : 0,
                         .body = b,
                         .cut = i};
}

/// One cut of one body.
static LitheStatus cut_body(LitheCtx *ctx, LthWorld *world, LitheIndex i, LitheIndex b, bool *any) {
  static LitheStatus (*const ways[])(LitheCtx *, LthCutting *) = {
      lth_cut_by_plane, lth_cut_by_blade, lth_cut_by_carving};
  const LthSceneCut *cut = world->scene->cuts + i;
  LthBody *body = world->bodies[b];
  LthChangeNote note = note_of(world, i, b);
  LthCutting c = {.body = body,
                  .t = body->change->topology,
                  .cut = cut,
                  .tag = LTH_TAG_CUT - body->change->n_cuts,
                  .note = &note};
  if (world->sim && !cut->at_rest) c.x = lth_body_position(body);
  LitheStatus status = ways[cut->kind](ctx, &c);
  lth_section_free(ctx, &c.section);
  LITHE_TRY(status);
  if (note.n_split + note.n_separated + note.n_removed == 0 && !note.is_refused) return LITHE_OK;
  *any = true;
  if (!note.is_refused) LITHE_TRY(lth_body_count_cut(ctx, body, note.n_removed > 0));
  return lth_world_note(ctx, world, &note);
}

/// A cut of all bodies that it is for. One that misses them all says so.
static LitheStatus make_cut(LitheCtx *ctx, LthWorld *world, LitheIndex i) {
  const LthSceneCut *cut = world->scene->cuts + i;
  bool any = false;
  world->cut_done[i] = true;
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (cut->body < 0 || cut->body == b) LITHE_TRY(cut_body(ctx, world, i, b, &any));
  if (any) return LITHE_OK;
  lth_warn(ctx, "%s: it misses %s, and nothing is cut; places are those %s", cut->place,
           cut->body >= 0 ? "its body" : "all bodies",
           cut->at_rest ? "at rest" : "of the moment, `space: rest` gives them at rest");
  LthChangeNote note = note_of(world, i, cut->body < 0 ? 0 : cut->body);
  return lth_world_note(ctx, world, &note);
}

// --- slivers and crumbs ---

/// What counts as a whole element of a level: each division halves it, or makes an eighth of it.
static double whole_volume(const LthBody *body, int level) {
  const LthTopology *t = body->change->topology;
  double share = body->scene->adapt_h.division == LTH_DIVIDE_TWO ? 0.5 : 0.125;
  return t->cell_size * t->cell_size * t->cell_size * pow(share, level);
}

/// Births of a level that are smaller than the mesh asks for (room for all births).
static LitheIndex list_slivers(const LthBody *body, int level, LitheIndex *cells) {
  const LthBodyChange *c = body->change;
  const LthTopology *t = c->topology;
  double volume = body->def->sliver * whole_volume(body, level);
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < t->log.n_births; i++) {
    LitheIndex cell = t->log.births[i].cell;
    if (t->cells[cell].is_live && c->level[cell] == level && t->cells[cell].volume < volume)
      cells[n++] = cell;
  }
  return n;
}

static LitheStatus merge_level(LitheCtx *ctx, LthBody *body, int level, LitheIndex *n_merged) {
  LthTopology *t = body->change->topology;
  LitheIndex *cells = NULL, n_now = 0;
  LITHE_TRY(lth_body_change_inherit(ctx, body));
  LTH_NEW(ctx, cells, t->log.n_births);
  LitheStatus status = LITHE_OK;
  LitheIndex n = list_slivers(body, level, cells);
  if (n > 0 && !body->change->atoms) LITHE_TRY_OR(done, lth_body_change_hold(ctx, body));
  if (n > 0)
    LITHE_TRY_OR(done,
                 lth_topology_merge_slivers(ctx, t, n, cells,
                                            body->def->sliver * whole_volume(body, level), &n_now));
  *n_merged += n_now;
done:
  lth_free(ctx, cells);
  return status;
}

/// Take away crumbs and merge what a body's cuts left below the volume that its mesh asks for; counted in its last note.
static LitheStatus clear_up(LitheCtx *ctx, LthWorld *world, LitheIndex b) {
  LthBody *body = world->bodies[b];
  LitheIndex n_merged = 0, n_removed = 0;
  int n_levels = body->scene->adapt_h.is_on ? body->scene->adapt_h.limit + 1 : 1;
  LITHE_TRY(lth_cut_clear_crumbs(ctx, body, &n_merged, &n_removed));
  for (int level = 0; level < n_levels; level++)
    LITHE_TRY(merge_level(ctx, body, level, &n_merged));
  for (LitheIndex i = world->n_notes; i-- > world->n_settled && n_merged + n_removed > 0;)
    if (world->notes[i].body == b) {
      world->notes[i].n_merged += n_merged;
      world->notes[i].n_removed += n_removed;
      break;
    }
  return LITHE_OK;
}

static LitheStatus clear_up_all(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (lth_body_has_changed(world->bodies[b])) LITHE_TRY(clear_up(ctx, world, b));
  return LITHE_OK;
}

// --- when ---

static bool starts_deformed(const LthSceneBody *def) {
  for (int a = 0; a < 3; a++)
    if (def->initial_displacement[a].eval || def->initial_displacement[a].constant != 0)
      return true;
  return false;
}

/// Can a cut be made before anything is built?
static bool is_first(const LthScene *scene, const LthSceneCut *cut) {
  if (cut->at > 0) return false;
  for (LitheIndex b = 0; b < scene->n_bodies; b++)
    if ((cut->body < 0 || cut->body == b) && !cut->at_rest && starts_deformed(scene->bodies + b))
      return false;
  return true;
}

LitheStatus lth_world_cut_first(LitheCtx *ctx, LthWorld *world) {
  const LthScene *scene = world->scene;
  for (LitheIndex i = 0; i < scene->n_cuts; i++)
    for (LitheIndex b = 0; b < world->n_bodies; b++)
      if ((scene->cuts[i].body < 0 || scene->cuts[i].body == b) && !world->bodies[b]->change)
        LITHE_TRY(lth_body_change_begin(ctx, world->bodies[b]));
  for (LitheIndex i = 0; i < scene->n_cuts; i++)
    if (is_first(scene, scene->cuts + i)) LITHE_TRY(make_cut(ctx, world, i));
  LITHE_TRY(clear_up_all(ctx, world));
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (lth_body_has_changed(world->bodies[b]))
      LITHE_TRY(lth_body_change_mesh(ctx, world->bodies[b]));
  return LITHE_OK;
}

LitheStatus lth_world_cut_due(LitheCtx *ctx, LthWorld *world, double end, bool *changed) {
  const LthScene *scene = world->scene;
  *changed = false;
  lth_world_cost_begin(world);
  for (LitheIndex i = 0; i < scene->n_cuts; i++)
    if (!world->cut_done[i] && scene->cuts[i].at < end - ROUNDING * scene->duration)
      LITHE_TRY(make_cut(ctx, world, i));
  LITHE_TRY(clear_up_all(ctx, world));
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    *changed = *changed || lth_body_has_changed(world->bodies[b]);
  if (!*changed) return lth_world_settle_notes(ctx, world);
  LITHE_TRY(lth_world_renew(ctx, world));
  lth_simulation_settle(world->sim);
  return LITHE_OK;
}
