/// Renewal of a world whose bodies have other elements than before.
#include "scene/renew.h"
#include "scene/cut_surface.h"

#include <string.h>

void lth_renewal_free(LitheCtx *ctx, LthRenewal *r) {
  lth_body_parts_destroy(ctx, &r->parts);
  lth_free(ctx, r->touch_point);
  lth_embedding_destroy(ctx, &r->touch_embedding);
  lth_surface_destroy(ctx, &r->touch);
  if (r->old.def) lth_body_free_on_mesh(ctx, &r->old);
  if (r->old.mesh != r->first) lth_mesh_destroy(ctx, &r->old.mesh);
  lth_mesh_destroy(ctx, &r->atoms);
  lth_free(ctx, r->same);
  lth_free(ctx, r->from_cell);
  lth_free(ctx, r->to_cell);
  lth_free(ctx, r->atom);
  *r = (LthRenewal){0};
}

// --- what old and new cells have in common ---

static LitheStatus add_atom(LitheCtx *ctx, LthRenewal *r, LitheIndex atom, LitheIndex from,
                            LitheIndex to) {
  LITHE_ASSERT(from >= 0); // merges come after lth_body_change_hold()
  LTH_RESERVE(ctx, r->from_cell, r->cap_from, (LitheCount)r->n_atoms + 1);
  LTH_RESERVE(ctx, r->to_cell, r->cap_to, (LitheCount)r->n_atoms + 1);
  LTH_RESERVE(ctx, r->atom, r->cap_atom, (LitheCount)r->n_atoms + 1);
  r->atom[r->n_atoms] = atom;
  r->from_cell[r->n_atoms] = from;
  r->to_cell[r->n_atoms++] = to;
  return LITHE_OK;
}

/// Cells that are what they were, and those of which the degree alone is another.
static LitheStatus find_same(LitheCtx *ctx, const LthBody *body, const LitheIndex *cell_record,
                             LthRenewal *r) {
  const LthBodyChange *c = body->change;
  LTH_NEW(ctx, r->same, body->mesh->n_cells);
  for (LitheIndex i = 0; i < body->mesh->n_cells; i++) {
    const bool is_new = c->topology->cells[cell_record[i]].is_new;
    LitheIndex from = is_new ? -1 : c->record_cell[cell_record[i]];
    const bool is_same = from >= 0 && r->old.space->degree[from] == c->degree[cell_record[i]];
    r->same[i] = is_same ? from : -1;
    if (!is_new && !is_same) LITHE_TRY(add_atom(ctx, r, -1, from, i));
  }
  return LITHE_OK;
}

/// Without merges births are parts of old cells.
static LitheStatus find_parts(LitheCtx *ctx, const LthBody *body, const LitheIndex *cell_record,
                              LthRenewal *r) {
  const LthBodyChange *c = body->change;
  for (LitheIndex i = 0; i < body->mesh->n_cells; i++)
    if (c->topology->cells[cell_record[i]].is_new)
      LITHE_TRY(
          add_atom(ctx, r, i, c->record_cell[lth_topology_before(c->topology, cell_record[i])], i));
  return LITHE_OK;
}

/// With merges they are made of births before these, and of old cells.
static LitheStatus find_merged(LitheCtx *ctx, const LthBody *body, const LitheIndex *cell_record,
                               LthRenewal *r) {
  const LthBodyChange *c = body->change;
  const LthTopology *t = c->topology;
  LitheIndex *place = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, place, t->n_cells);
  for (LitheIndex i = 0; i < body->mesh->n_cells; i++) place[cell_record[i]] = i;
  for (LitheIndex i = 0; i < r->atoms->n_cells; i++) {
    LitheIndex now = lth_topology_now(t, c->atom_record[i]);
    LitheIndex before = lth_topology_before(t, c->atom_record[i]);
    LITHE_TRY_OR(done, add_atom(ctx, r, i, c->record_cell[before], now >= 0 ? place[now] : -1));
  }
  for (LitheIndex i = 0; i < t->log.n_dead_cells; i++) {
    LitheIndex cell = t->log.dead_cells[i], now = lth_topology_now(t, cell);
    if (!t->cells[cell].is_new && now >= 0)
      LITHE_TRY_OR(done, add_atom(ctx, r, -1, c->record_cell[cell], place[now]));
  }
done:
  lth_free(ctx, place);
  return status;
}

static LitheStatus find_atoms(LitheCtx *ctx, const LthBody *body, const LitheIndex *cell_record,
                              LthRenewal *r) {
  r->atoms = body->change->atoms;
  body->change->atoms = NULL;
  LITHE_TRY(find_same(ctx, body, cell_record, r));
  return r->atoms ? find_merged(ctx, body, cell_record, r) : find_parts(ctx, body, cell_record, r);
}

// --- material ---

/// A cell that is (a part of) one old cell has its constants to the bit; merged ones have means by volume, so that
/// mass is kept, and the entry of their largest part.
static LitheStatus inherit_material(LitheCtx *ctx, LthBody *body, const LthRenewal *r) {
  const LthMesh *atoms = lth_renewal_atoms(r, body);
  LitheIndex n = body->mesh->n_cells;
  double *volume = NULL, *largest = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, body->label, n);
  LTH_NEW_OR(done, ctx, body->young, n);
  LTH_NEW_OR(done, ctx, body->poisson, n);
  LTH_NEW_OR(done, ctx, body->density, n);
  LTH_NEW_OR(done, ctx, body->yield, n);
  LTH_NEW_OR(done, ctx, volume, n);
  LTH_NEW_OR(done, ctx, largest, n);
  for (LitheIndex c = 0; c < n; c++) {
    LitheIndex from = r->same[c];
    if (from < 0) continue;
    body->young[c] = r->old.young[from];
    body->poisson[c] = r->old.poisson[from];
    body->density[c] = r->old.density[from];
    body->label[c] = r->old.label[from];
    body->yield[c] = r->old.yield[from];
  }
  for (LitheIndex i = 0; i < r->n_atoms; i++) {
    LitheIndex from = r->from_cell[i], to = r->to_cell[i];
    if (to < 0) continue;
    double v = r->atom[i] < 0 ? r->old.mesh->cell_volume[from] : atoms->cell_volume[r->atom[i]];
    double share = volume[to] > 0 ? v / (volume[to] + v) : 1;
    volume[to] += v;
    body->young[to] += share * (r->old.young[from] - body->young[to]);
    body->poisson[to] += share * (r->old.poisson[from] - body->poisson[to]);
    body->density[to] += share * (r->old.density[from] - body->density[to]);
    if (v <= largest[to]) continue;
    largest[to] = v;
    body->label[to] = r->old.label[from];
    body->yield[to] = r->old.yield[from];
  }
  body->mass = 0;
  for (LitheIndex c = 0; c < n; c++) body->mass += body->density[c] * body->mesh->cell_volume[c];
done:
  lth_free(ctx, volume);
  lth_free(ctx, largest);
  return status;
}

// --- a body ---

void lth_renewal_take_parts(LthBody *body, LthRenewal *r) {
  r->old = *body;
  r->first = body->change ? body->change->first : NULL;
  body->space = NULL;
  body->label = NULL;
  body->young = body->poisson = body->density = body->yield = NULL;
  body->patches = NULL;
  body->weak = NULL;
  body->weak_of = NULL;
  body->strong = NULL;
  body->loads = NULL;
  body->places = NULL;
  body->n_patches = body->cap_patches = body->cap_weak = body->cap_weak_of = body->cap_loads = 0;
  body->n_weak = body->n_loads = 0;
  body->op = NULL;
  body->disc = NULL;
  body->embedding = body->nodes = NULL;
  body->contact = NULL;
}

static LitheStatus renew_body(LitheCtx *ctx, LthWorld *world, LthBody *body, LthRenewal *r) {
  LitheStatus status = LITHE_OK;
  LthMesh *mesh = NULL;
  LitheIndex *cell_record = NULL, *face_record = NULL;
  double integrated = lth_dg_store_count(body->change->store).seconds;
  body->change->is_running = true;
  LITHE_TRY(lth_body_change_inherit(ctx, body));
  LITHE_TRY_OR(done, lth_body_present_mesh(ctx, body, &mesh, &cell_record, &face_record));
  lth_world_cost_add(world, LTH_COST_MESH);
  LITHE_TRY_OR(done, lth_cut_surface_follow(ctx, body, mesh, cell_record));
  lth_world_cost_add(world, LTH_COST_SURFACE);
  lth_renewal_take_parts(body, r);
  body->mesh = mesh;
  mesh = NULL;
  body->mesh->n_merged = r->old.mesh->n_merged;
  LITHE_TRY_OR(done, find_atoms(ctx, body, cell_record, r));
  lth_body_change_take(ctx, body, cell_record, face_record);
  cell_record = face_record = NULL;
  lth_world_cost_add(world, LTH_COST_MESH);
  LITHE_TRY_OR(done, lth_body_build_space(ctx, body));
  LITHE_TRY_OR(done, inherit_material(ctx, body, r));
  LITHE_TRY_OR(done, lth_body_build_conditions(ctx, body));
  lth_world_cost_add(world, LTH_COST_LISTS);
  lth_world_cost_move(world, LTH_COST_LISTS, LTH_COST_INTEGRATION,
                      lth_dg_store_count(body->change->store).seconds - integrated);
  LITHE_TRY_OR(done, lth_body_keep_matrix(ctx, body));
  lth_world_cost_add(world, LTH_COST_ASSEMBLY);
  LITHE_TRY_OR(done, lth_build_embedding(ctx, body));
  lth_world_cost_add(world, LTH_COST_EMBEDDING);
  LITHE_TRY_OR(done, lth_build_contact(ctx, body));
  lth_world_cost_add(world, LTH_COST_CONTACT);
  LITHE_TRY_OR(done, lth_body_change_number(ctx, body, body->change->cell_record,
                                            body->change->face_record));
done:
  lth_mesh_destroy(ctx, &mesh);
  lth_free(ctx, cell_record);
  lth_free(ctx, face_record);
  return status;
}

// --- all bodies ---

/// Coefficients of all bodies from the old system to the new one.
typedef struct Move {
  const LthWorld *world;
  const LthSystem *from;
  const LthRenewal *renewals; ///< (n_bodies); `same` NULL: the body is what it was
} Move;

static LthDgTransfer transfer_of(const LthRenewal *r, const LthBody *body) {
  return (LthDgTransfer){.from = r->old.space,
                         .to = body->space,
                         .atoms = lth_renewal_atoms(r, body),
                         .n_atoms = r->n_atoms,
                         .from_cell = r->from_cell,
                         .to_cell = r->to_cell,
                         .atom = r->atom,
                         .same = r->same};
}

static LitheStatus move_field(LitheCtx *ctx, const void *self, const double *from, double *to) {
  const Move *m = self;
  for (LitheIndex b = 0; b < m->world->n_bodies; b++) {
    const LthRenewal *r = m->renewals + b;
    const LthBody *body = m->world->bodies[b];
    const double *x = from + m->from->dof_first[b];
    double *y = to + m->world->system->dof_first[b];
    if (!r->same) {
      memcpy(y, x, sizeof *y * (size_t)body->disc->n_dofs);
      continue;
    }
    const LthDgTransfer transfer = transfer_of(r, body);
    LITHE_TRY(lth_dg_transfer(ctx, &transfer, x, y));
  }
  return LITHE_OK;
}

static LitheStatus move_motion(LitheCtx *ctx, const void *self, const double *x_from,
                               const double *v_from, const double *x, double *v) {
  const Move *m = self;
  for (LitheIndex b = 0; b < m->world->n_bodies; b++) {
    const LthRenewal *r = m->renewals + b;
    const LitheCount was = m->from->dof_first[b], is = m->world->system->dof_first[b];
    if (!r->same) continue;
    const LthDgTransfer transfer = transfer_of(r, m->world->bodies[b]);
    const LthDgMotion motion = {.transfer = &transfer,
                                .density_from = r->old.density,
                                .x_from = x_from + was,
                                .v_from = v_from + was,
                                .x_to = x + is,
                                .v_to = v + is};
    LITHE_TRY(lth_dg_keep_motion(ctx, &motion));
  }
  return LITHE_OK;
}

/// Energies of the present state.
static void measure(LitheCtx *ctx, LthWorld *world, int when) {
  if (world->n_settled == world->n_notes) return;
  lth_simulation_measure(ctx, world->sim);
  const LthStepReport *report = lth_simulation_report(world->sim);
  for (LitheIndex i = world->n_settled; i < world->n_notes; i++) {
    LthChangeNote *note = world->notes + i;
    const LthBody *body = world->bodies[note->body];
    note->strain[when] = report->strain_energy;
    note->kinetic[when] = report->kinetic_energy;
    if (body->op)
      note->jump[when] =
          lth_dg_jump_energy(body->op, lth_simulation_time(world->sim), lth_body_position(body));
  }
}

LitheStatus lth_world_settle_notes(LitheCtx *ctx, LthWorld *world) {
  for (; world->n_settled < world->n_notes; world->n_settled++) {
    LthChangeNote *note = world->notes + world->n_settled;
    LthMeshQuality quality;
    const LthBody *body = world->bodies[note->body];
    LITHE_TRY(lth_mesh_quality(ctx, body->mesh, &quality));
    note->volume = quality.volume;
    note->elements = quality.n_elements;
    note->pieces = quality.n_components;
    note->unknowns = body->disc->n_dofs;
  }
  return LITHE_OK;
}

/// The surfaces by which bodies touch go with the pairs, also those of bodies that have not changed.
static void take_touch(LthBody *body, LthRenewal *r) {
  r->touch = body->touch;
  r->touch_embedding = body->touch_embedding;
  r->touch_point = body->touch_point;
  r->parts = body->parts;
  body->parts = NULL;
  body->touch = NULL;
  body->touch_embedding = NULL;
  body->touch_point = NULL;
}

void lth_world_take(LthWorld *world, LthRenewal *renewals, LthWorld *old) {
  *old = *world;
  for (LitheIndex b = 0; b < world->n_bodies; b++) take_touch(world->bodies[b], renewals + b);
  world->ties = NULL;
  world->pairs = NULL;
  world->n_ties = world->n_pairs = 0;
  world->system = NULL;
  world->sim = NULL;
}

void lth_world_free_taken(LitheCtx *ctx, LthWorld *old) {
  lth_simulation_destroy(ctx, &old->sim);
  lth_system_destroy(ctx, &old->system);
  lth_world_free_pairs(ctx, old);
  lth_world_free_ties(ctx, old);
}

LitheStatus lth_world_join(LitheCtx *ctx, LthWorld *world) {
  LITHE_TRY(lth_world_build_ties(ctx, world));
  LITHE_TRY(lth_world_build_pairs(ctx, world));
  lth_world_cost_add(world, LTH_COST_CONTACT);
  LITHE_TRY(lth_world_build_system(ctx, world));
  LITHE_TRY(lth_world_create_simulation(ctx, world));
  lth_world_cost_add(world, LTH_COST_SYSTEM);
  return LITHE_OK;
}

static LitheStatus rebuild(LitheCtx *ctx, LthWorld *world, const LthWorld *old,
                           LthRenewal *renewals) {
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthBody *body = world->bodies[b];
    if (!lth_body_has_changed(body)) continue;
#ifdef LITHE_ASSERTS
    LITHE_TRY(lth_topology_check(ctx, body->change->topology, 0, NULL));
#endif
    LITHE_TRY(renew_body(ctx, world, body, renewals + b));
  }
  LITHE_TRY(lth_world_join(ctx, world));
  const Move fields = {world, old->system, renewals};
  const LthStateMove move = {&fields, move_field, move_motion};
  LITHE_TRY(lth_simulation_inherit(ctx, world->sim, old->sim, &move));
  LITHE_TRY(lth_world_carry_contacts(ctx, world, old, renewals));
  lth_world_cost_add(world, LTH_COST_TRANSFER);
  return LITHE_OK;
}

/// The spaces and operators of before are gone.
static LitheStatus settle_stores(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (world->bodies[b]->change)
      LITHE_TRY(lth_dg_store_settle(ctx, world->bodies[b]->change->store));
  return LITHE_OK;
}

LitheStatus lth_world_renew(LitheCtx *ctx, LthWorld *world) {
  LitheStatus status = LITHE_OK;
  LthWorld old;
  LthRenewal *renewals = NULL;
  LTH_NEW(ctx, renewals, world->n_bodies);
  lth_world_cost_add(world, LTH_COST_GEOMETRY);
  measure(ctx, world, 0);
  lth_world_cost_add(world, LTH_COST_MEASURE);
  lth_world_take(world, renewals, &old);
  lth_simulation_free_solvers(ctx, old.sim); // the new matrix takes its place
  LITHE_TRY_OR(done, rebuild(ctx, world, &old, renewals));
  measure(ctx, world, 1);
  LITHE_TRY_OR(done, lth_world_settle_notes(ctx, world));
  world->n_renewals++;
  world->cost.waits = true;
  lth_world_cost_add(world, LTH_COST_MEASURE);
done:
  lth_world_free_taken(ctx, &old);
  for (LitheIndex b = 0; b < world->n_bodies; b++) lth_renewal_free(ctx, renewals + b);
  lth_free(ctx, renewals);
  lth_age_spares(ctx);
  return status == LITHE_OK ? settle_stores(ctx, world) : status;
}
