/// Cuts of a scene: when they are due, and plane ones.
#include "scene/cut.h"

#include "base/tensor.h"
#include "disc/dg/dg_transfer.h"

#include <math.h>

#define ROUNDING 1e-9 ///< of a time: two that differ by less are the same
#define NEAR 0.5      ///< of a cell's box: planes that close to it may part it from a neighbour

/// Cells of a body that a cut looks at, with the plane in rest space of each.
typedef struct Cells {
  LitheIndex n;
  LitheIndex *record;
  LthPlane *plane;
} Cells;

/// A body's positions at this moment, NULL while they are those at rest.
static const double *positions(const LthWorld *world, const LthBody *body) {
  return world->sim ? lth_body_position(body) : NULL;
}

/// The cut's plane as a cell sees it at rest; false where the cell is too flat to have one.
static bool plane_at_rest(const LthBody *body, const LthSceneCut *cut, const double *x,
                          LitheIndex record, LthPlane *plane) {
  const LthBodyChange *c = body->change;
  *plane = cut->plane;
  if (cut->at_rest || !x) return true;
  LitheIndex cell = c->record_cell[lth_topology_before(c->topology, record)];
  return lth_dg_plane_to_rest(body->space, cell, x, &cut->plane, plane);
}

/// Does the plane pass a cell's box, made larger by a part of itself?
static bool is_near(const LthTopologyCell *cell, const LthPlane *plane) {
  double reach = 0, height = 0;
  for (int a = 0; a < 3; a++) {
    double half = 0.5 * (cell->box[3 + a] - cell->box[a]);
    height += plane->normal[a] * (cell->box[a] + half - plane->point[a]);
    reach += (1 + NEAR) * half * fabs(plane->normal[a]);
  }
  return fabs(height) <= reach;
}

static void free_cells(LitheCtx *ctx, Cells *cells) {
  lth_free(ctx, cells->record);
  lth_free(ctx, cells->plane);
}

static LitheStatus find_cells(LitheCtx *ctx, const LthBody *body, const LthSceneCut *cut,
                              const double *x, Cells *cells) {
  const LthTopology *t = body->change->topology;
  LTH_NEW(ctx, cells->record, t->n_live_cells);
  LTH_NEW(ctx, cells->plane, t->n_live_cells);
  for (LitheIndex i = 0; i < t->n_cells; i++) {
    LthPlane *plane = cells->plane + cells->n;
    if (!t->cells[i].is_live || !plane_at_rest(body, cut, x, i, plane)) continue;
    if (!is_near(t->cells + i, plane)) continue;
    cells->record[cells->n++] = i;
  }
  return LITHE_OK;
}

static bool has_tag(const LthTopology *t, LitheIndex cell, LitheIndex tag) {
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++)
    if (t->faces[lth_topology_cell_faces(t, cell)[i]].tag == tag) return true;
  return false;
}

/// Note the planes of cells that were split, or parted from a neighbour.
static LitheStatus note_planes(LitheCtx *ctx, LthBody *body, const Cells *cells, LitheIndex tag) {
  const LthTopology *t = body->change->topology;
  for (LitheIndex i = 0; i < cells->n; i++) {
    LthCutPlane plane = {tag, cells->record[i], cells->plane[i]};
    if (!t->cells[plane.cell].is_live || has_tag(t, plane.cell, tag))
      LITHE_TRY(lth_body_note_plane(ctx, body, &plane));
  }
  return LITHE_OK;
}

static LitheStatus cut_plane(LitheCtx *ctx, LthBody *body, const LthSceneCut *cut, const double *x,
                             LthChangeNote *note) {
  LthBodyChange *c = body->change;
  LitheStatus status = LITHE_OK;
  LitheIndex tag = LTH_TAG_CUT - c->n_cuts;
  Cells cells = {0};
  LthCut done = {0};
  LITHE_TRY_OR(done, find_cells(ctx, body, cut, x, &cells));
  bool is_one = cut->at_rest || !x;
  if (cells.n > 0)
    LITHE_TRY_OR(done, lth_topology_cut(ctx, c->topology, cells.n, cells.record,
                                        is_one ? 1 : cells.n, cells.plane, tag, &done));
  LITHE_TRY_OR(done, note_planes(ctx, body, &cells, tag));
  note->n_split = done.n_split;
  note->n_separated = done.n_separated;
  note->area = done.area;
done:
  free_cells(ctx, &cells);
  return status;
}

/// One cut of one body.
static LitheStatus cut_body(LitheCtx *ctx, LthWorld *world, LitheIndex i, LitheIndex b, bool *any) {
  const LthSceneCut *cut = world->scene->cuts + i;
  LthBody *body = world->bodies[b];
  LthChangeNote note = {.kind = LTH_CHANGE_PLANE,
                        .t = world->sim ? lth_simulation_time(world->sim) : 0,
                        .body = b,
                        .cut = i};
  LITHE_TRY(cut_plane(ctx, body, cut, positions(world, body), &note));
  if (note.n_split + note.n_separated == 0) return LITHE_OK;
  *any = true;
  body->change->n_cuts++;
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
  LthChangeNote note = {.kind = LTH_CHANGE_PLANE,
                        .t = world->sim ? lth_simulation_time(world->sim) : 0,
                        .body = cut->body < 0 ? 0 : cut->body,
                        .cut = i};
  return lth_world_note(ctx, world, &note);
}

// --- slivers ---

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

/// Merge what a body's cuts left below the volume that its mesh asks for; counted in its last note.
static LitheStatus merge_slivers(LitheCtx *ctx, LthWorld *world, LitheIndex b) {
  LthBody *body = world->bodies[b];
  LitheIndex n_merged = 0;
  int n_levels = body->scene->adapt_h.is_on ? body->scene->adapt_h.limit + 1 : 1;
  for (int level = 0; level < n_levels; level++)
    LITHE_TRY(merge_level(ctx, body, level, &n_merged));
  for (LitheIndex i = world->n_notes; i-- > world->n_settled && n_merged > 0;)
    if (world->notes[i].body == b) {
      world->notes[i].n_merged += n_merged;
      break;
    }
  return LITHE_OK;
}

static LitheStatus merge_all(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (lth_body_has_changed(world->bodies[b])) LITHE_TRY(merge_slivers(ctx, world, b));
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
  LITHE_TRY(merge_all(ctx, world));
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (lth_body_has_changed(world->bodies[b]))
      LITHE_TRY(lth_body_change_mesh(ctx, world->bodies[b]));
  return LITHE_OK;
}

LitheStatus lth_world_cut_due(LitheCtx *ctx, LthWorld *world, double end, bool *changed) {
  const LthScene *scene = world->scene;
  *changed = false;
  for (LitheIndex i = 0; i < scene->n_cuts; i++)
    if (!world->cut_done[i] && scene->cuts[i].at < end - ROUNDING * scene->duration)
      LITHE_TRY(make_cut(ctx, world, i));
  LITHE_TRY(merge_all(ctx, world));
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    *changed = *changed || lth_body_has_changed(world->bodies[b]);
  return *changed ? lth_world_renew(ctx, world) : lth_world_settle_notes(ctx, world);
}
