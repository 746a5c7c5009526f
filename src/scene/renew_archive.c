/// Changed elements in a checkpoint: the topology, and what a run has found for its cells. The rest follows from them.
#include "scene/cut_surface.h"
#include "scene/renew.h"

/// What does not follow from the mesh alone: integrals are those of when a record was new, constants of cells those of the cells
/// that they were parts of.
static void walk_cells(LthArchive *a, LthBody *body) {
  LitheCount n = body->mesh->n_cells;
  lth_dg_store_archive(body->change->store, a);
  LTH_ARCHIVE_ARRAY(a, body->label, n);
  LTH_ARCHIVE_ARRAY(a, body->young, n);
  LTH_ARCHIVE_ARRAY(a, body->poisson, n);
  LTH_ARCHIVE_ARRAY(a, body->density, n);
  LTH_ARCHIVE_ARRAY(a, body->yield, n);
  LTH_ARCHIVE(a, body->mass);
}

static LitheStatus make_room(LitheCtx *ctx, LthBodyChange *c) {
  LTH_RESERVE(ctx, c->is_open, c->cap_open, c->n_cuts);
  LTH_RESERVE(ctx, c->level, c->cap_level, c->topology->n_cells);
  LTH_RESERVE(ctx, c->degree, c->cap_degree, c->topology->n_cells);
  return LITHE_OK;
}

static void walk_topology(LthArchive *a, LthBodyChange *c) {
  LTH_ARCHIVE(a, c->n_cuts);
  lth_topology_archive(c->topology, a);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room(a->ctx, c);
  LTH_ARCHIVE_ARRAY(a, c->is_open, c->n_cuts);
  lth_losses_archive(c, a);
  LTH_ARCHIVE_ARRAY(a, c->level, c->topology->n_cells);
  LTH_ARCHIVE_ARRAY(a, c->degree, c->topology->n_cells);
}

/// Room for what walk_cells() reads.
static LitheStatus begin_cells(LitheCtx *ctx, LthBody *body) {
  LitheIndex n = body->mesh->n_cells;
  LTH_NEW(ctx, body->label, n);
  LTH_NEW(ctx, body->young, n);
  LTH_NEW(ctx, body->poisson, n);
  LTH_NEW(ctx, body->density, n);
  LTH_NEW(ctx, body->yield, n);
  return LITHE_OK;
}

static LitheStatus read_body(LitheCtx *ctx, LthArchive *a, LthBody *body, LthRenewal *r) {
  LthMesh *mesh = NULL;
  LitheIndex *cell_record = NULL, *face_record = NULL;
  LitheStatus status = LITHE_OK;
  body->change->is_running = true;
  lth_dg_kept_destroy(ctx, &body->change->kept); // its records are those of before
  walk_topology(a, body->change);
  LITHE_TRY(a->status);
  LITHE_TRY_OR(done, lth_body_present_mesh(ctx, body, &mesh, &cell_record, &face_record));
  lth_renewal_take_parts(body, r);
  body->mesh = mesh;
  mesh = NULL;
  body->mesh->n_merged = r->old.mesh->n_merged;
  status = lth_body_change_number(ctx, body, cell_record, face_record);
  cell_record = face_record = NULL;
  LITHE_TRY_OR(done, status);
  LITHE_TRY_OR(done, begin_cells(ctx, body));
  walk_cells(a, body);
  lth_cut_surface_archive(body, a);
  LITHE_TRY_OR(done, a->status);
  LITHE_TRY_OR(done, lth_body_build_space(ctx, body));
  LITHE_TRY_OR(done, lth_body_build_on_mesh(ctx, body));
done:
  lth_mesh_destroy(ctx, &mesh);
  lth_free(ctx, cell_record);
  lth_free(ctx, face_record);
  return status;
}

static LitheStatus read_bodies(LitheCtx *ctx, LthArchive *a, LthWorld *world) {
  LitheStatus status = LITHE_OK;
  LthWorld old;
  LthRenewal *renewals = NULL;
  LTH_NEW(ctx, renewals, world->n_bodies);
  lth_world_take(world, renewals, &old);
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (world->bodies[b]->change)
      LITHE_TRY_OR(done, read_body(ctx, a, world->bodies[b], renewals + b));
  LITHE_TRY_OR(done, lth_world_join(ctx, world));
done:
  lth_world_free_taken(ctx, &old);
  for (LitheIndex b = 0; b < world->n_bodies; b++) lth_renewal_free(ctx, renewals + b);
  lth_free(ctx, renewals);
  return status;
}

static LitheStatus make_room_for_notes(LitheCtx *ctx, LthWorld *world, LitheCount n) {
  LTH_RESERVE(ctx, world->notes, world->cap_notes, n);
  return LITHE_OK;
}

static void walk_notes(LthArchive *a, LthWorld *world) {
  LitheCount n = world->n_notes;
  LTH_ARCHIVE_ARRAY(a, world->cut_done, world->scene->n_cuts);
  lth_archive_count(a, &n);
  if (a->status == LITHE_OK && a->is_reading) a->status = make_room_for_notes(a->ctx, world, n);
  if (a->status != LITHE_OK) return;
  world->n_notes = world->n_settled = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(a, world->notes, n);
}

void lth_world_change_archive(LthWorld *world, LthArchive *a) {
  lth_archive_mark(a, "changes");
  walk_notes(a, world);
  LTH_ARCHIVE(a, world->n_renewals);
  if (world->n_renewals == 0 || a->status != LITHE_OK) return;
  if (a->is_reading) {
    a->status = read_bodies(a->ctx, a, world);
    return;
  }
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthBody *body = world->bodies[b];
    if (!body->change) continue;
    walk_topology(a, body->change);
    walk_cells(a, body);
    lth_cut_surface_archive(body, a);
  }
}
