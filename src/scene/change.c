/// What a body whose elements change has besides its mesh: topology, numbers, degrees, notes.
#include "scene/change.h"
#include "scene/cut_surface.h"

#include <string.h>

static LitheStatus list_records(LitheCtx *ctx, const LthMesh *mesh, LthBodyChange *c) {
  LTH_NEW(ctx, c->cell_record, mesh->n_cells);
  LTH_NEW(ctx, c->face_record, mesh->n_faces);
  for (LitheIndex i = 0; i < mesh->n_cells; i++) c->cell_record[i] = i;
  for (LitheIndex i = 0; i < mesh->n_faces; i++) c->face_record[i] = i;
  return LITHE_OK;
}

/// Cells of the body's mesh by record.
static LitheStatus index_records(LitheCtx *ctx, LitheIndex n_cells, LthBodyChange *c) {
  c->n_records = c->topology->n_cells;
  LTH_RESERVE(ctx, c->record_cell, c->cap_record_cell, c->n_records);
  for (LitheIndex i = 0; i < c->n_records; i++) c->record_cell[i] = -1;
  for (LitheIndex i = 0; i < n_cells; i++) c->record_cell[c->cell_record[i]] = i;
  return LITHE_OK;
}

/// Arrays by record as long as the topology; what is new is zero.
static LitheStatus make_room(LitheCtx *ctx, LthBodyChange *c) {
  LitheCount n = c->topology->n_cells, had_level = c->cap_level, had_degree = c->cap_degree;
  LTH_RESERVE(ctx, c->level, c->cap_level, n);
  LTH_RESERVE(ctx, c->degree, c->cap_degree, n);
  memset(c->level + had_level, 0, (size_t)(c->cap_level - had_level));
  memset(c->degree + had_degree, 0, (size_t)(c->cap_degree - had_degree));
  return LITHE_OK;
}

LitheStatus lth_body_change_begin(LitheCtx *ctx, LthBody *body) {
  if (body->def->method_kind != LTH_METHOD_DG)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "%s.method: cuts and adapt need elements that can be cut, which are those of "
               "`kind: dg`",
               body->def->place);
  LTH_NEW(ctx, body->change, 1);
  LthBodyChange *c = body->change;
  c->first = body->mesh;
  LITHE_TRY(lth_topology_create(ctx, body->mesh, &c->topology));
  LITHE_TRY(lth_dg_store_create(ctx, &c->store));
  LITHE_TRY(list_records(ctx, body->mesh, c));
  LITHE_TRY(index_records(ctx, body->mesh->n_cells, c));
  LITHE_TRY(make_room(ctx, c));
  LITHE_TRY(lth_build_degrees(ctx, body, c->degree));
  return body->scene->n_cuts > 0 ? lth_cut_surface_begin(ctx, body) : LITHE_OK;
}

void lth_body_change_end(LitheCtx *ctx, LthBody *body) {
  LthBodyChange *c = body->change;
  if (!c) return;
  if (c->first != body->mesh) lth_mesh_destroy(ctx, &c->first);
  lth_mesh_destroy(ctx, &c->atoms);
  lth_cut_surface_end(ctx, &c->surface);
  lth_topology_destroy(ctx, &c->topology);
  lth_dg_store_destroy(ctx, &c->store);
  lth_dg_kept_destroy(ctx, &c->kept);
  lth_embedding_rows_destroy(ctx, &c->rows);
  if (c->refinement) lth_refinement_free(ctx, c->refinement);
  lth_free(ctx, c->refinement);
  void *blocks[] = {c->cell_record, c->face_record, c->record_cell, c->level, c->degree,
                    c->atom_record, c->is_open,     c->losses,      c};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  body->change = NULL;
}

LitheStatus lth_body_change_inherit(LitheCtx *ctx, LthBody *body) {
  LthBodyChange *c = body->change;
  const LthTopologyLog *log = &c->topology->log;
  LITHE_TRY(make_room(ctx, c));
  for (LitheIndex i = 0; i < log->n_births; i++) {
    LitheIndex cell = log->births[i].cell, parent = log->births[i].parent;
    if (c->degree[cell] > 0) continue;
    c->degree[cell] = c->degree[parent];
    c->level[cell] = c->level[parent];
  }
  return LITHE_OK;
}

LitheStatus lth_body_change_hold(LitheCtx *ctx, LthBody *body) {
  LthBodyChange *c = body->change;
  LITHE_ASSERT(!c->atoms);
  LITHE_TRY(lth_body_change_inherit(ctx, body));
  const LthTopologyLog *log = &c->topology->log;
  LitheIndex *births = NULL;
  LTH_NEW(ctx, births, log->n_births);
  for (LitheIndex i = 0; i < log->n_births; i++) births[i] = log->births[i].cell;
  LitheStatus status =
      lth_topology_mesh(ctx, c->topology, log->n_births, births, &c->atoms, &c->atom_record, NULL);
  lth_free(ctx, births);
  return status;
}

bool lth_body_has_changed(const LthBody *body) {
  if (!body->change) return false;
  const LthBodyChange *c = body->change;
  const LthTopologyLog *log = &c->topology->log;
  if (log->n_births > 0 || log->n_dead_cells > 0 || log->n_dead_faces > 0) return true;
  for (LitheIndex i = 0; body->space && i < body->mesh->n_cells; i++)
    if (body->space->degree[i] != c->degree[c->cell_record[i]]) return true;
  return false;
}

LitheStatus lth_body_count_cut(LitheCtx *ctx, LthBody *body, bool is_open) {
  LthBodyChange *c = body->change;
  LTH_RESERVE(ctx, c->is_open, c->cap_open, (LitheCount)c->n_cuts + 1);
  c->is_open[c->n_cuts++] = is_open;
  return LITHE_OK;
}

/// Records that are free from now on have neither level nor degree.
static void clear_dead(LthBodyChange *c) {
  const LthTopologyLog *log = &c->topology->log;
  for (LitheIndex i = 0; i < log->n_dead_cells; i++)
    c->level[log->dead_cells[i]] = c->degree[log->dead_cells[i]] = 0;
}

void lth_body_change_take(LitheCtx *ctx, LthBody *body, LitheIndex *cell_record,
                          LitheIndex *face_record) {
  LthBodyChange *c = body->change;
  if (c->cell_record == cell_record) return;
  lth_free(ctx, c->cell_record);
  lth_free(ctx, c->face_record);
  c->cell_record = cell_record;
  c->face_record = face_record;
}

LthDgRecords lth_body_records(const LthBody *body) {
  const LthBodyChange *c = body->change;
  return (LthDgRecords){c->store, c->cell_record, c->face_record, NULL};
}

LitheStatus lth_body_change_number(LitheCtx *ctx, LthBody *body, LitheIndex *cell_record,
                                   LitheIndex *face_record) {
  LthBodyChange *c = body->change;
  lth_body_change_take(ctx, body, cell_record, face_record);
  clear_dead(c);
  LITHE_TRY(lth_dg_store_forget(ctx, c->store, c->topology));
  lth_mesh_destroy(ctx, &c->atoms);
  lth_free(ctx, c->atom_record);
  c->atom_record = NULL;
  if (c->refinement) LITHE_TRY(lth_refinement_follow(ctx, c->refinement, c->topology));
  LITHE_TRY(lth_topology_forget(ctx, c->topology));
  return index_records(ctx, body->mesh->n_cells, c);
}

LitheStatus lth_body_present_mesh(LitheCtx *ctx, const LthBody *body, LthMesh **mesh,
                                  LitheIndex **cell_record, LitheIndex **face_record) {
  const LthBodyChange *c = body->change;
  LITHE_TRY(lth_topology_mesh(ctx, c->topology, 0, NULL, mesh, cell_record, face_record));
  for (LitheIndex f = 0; f < (*mesh)->n_faces; f++) {
    LitheIndex *tag = (*mesh)->face_tag + f;
    if (*tag <= LTH_TAG_CUT && c->is_open[LTH_TAG_CUT - *tag]) *tag = -1;
  }
  return lth_topology_groups(ctx, c->topology, c->first, *cell_record, *face_record, *mesh);
}

LitheStatus lth_body_change_mesh(LitheCtx *ctx, LthBody *body) {
  LthBodyChange *c = body->change;
  LthMesh *mesh = NULL;
  LitheIndex *cell_record = NULL, *face_record = NULL;
  LITHE_TRY(lth_body_change_inherit(ctx, body));
  LitheStatus status = lth_body_present_mesh(ctx, body, &mesh, &cell_record, &face_record);
  if (status == LITHE_OK) status = lth_cut_surface_follow(ctx, body, mesh, cell_record);
  if (status != LITHE_OK) {
    lth_mesh_destroy(ctx, &mesh);
    lth_free(ctx, cell_record);
    lth_free(ctx, face_record);
    return status;
  }
  mesh->n_merged += body->mesh->n_merged;
  if (body->mesh != c->first) lth_mesh_destroy(ctx, &body->mesh);
  body->mesh = mesh;
  return lth_body_change_number(ctx, body, cell_record, face_record);
}

const char *lth_cost_name(LthCostPart part) {
  static const char *const names[LTH_COST_COUNT] = {
      "geometry", "mesh",   "surface",  "lists",   "integration", "assembly", "embedding",
      "contact",  "system", "transfer", "measure", "output",      "solver"};
  return names[part];
}

void lth_world_cost_begin(LthWorld *world) {
  world->cost = (LthCost){.last = lth_processor_time(), .n_told = world->n_settled};
}

void lth_world_cost_add(LthWorld *world, LthCostPart part) {
  double now = lth_processor_time();
  world->cost.seconds[part] += now - world->cost.last;
  world->cost.last = now;
}

void lth_world_cost_move(LthWorld *world, LthCostPart from, LthCostPart to, double seconds) {
  world->cost.seconds[from] -= seconds;
  world->cost.seconds[to] += seconds;
}

void lth_world_cost_tell(LthWorld *world, double factor) {
  LthCost *cost = &world->cost;
  if (!cost->waits) return;
  cost->seconds[LTH_COST_SOLVER] = factor;
  for (LitheIndex i = cost->n_told; i < world->n_notes; i++)
    memcpy(world->notes[i].seconds, cost->seconds, sizeof cost->seconds);
  cost->waits = false;
}

LitheStatus lth_world_note(LitheCtx *ctx, LthWorld *world, const LthChangeNote *note) {
  LTH_RESERVE(ctx, world->notes, world->cap_notes, (LitheCount)world->n_notes + 1);
  world->notes[world->n_notes++] = *note;
  return LITHE_OK;
}
