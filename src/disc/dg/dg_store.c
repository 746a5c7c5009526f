/// Integrals by record: rooms, versions, and what may be taken as it is.
#include "disc/dg/dg_store_priv.h"

#include "base/digest.h"

/// Groups in planes, and with areas, that differ by less are one: a change is much more, and rounding of a small piece less.
#define SAME_GROUP 1e-9

LitheStatus lth_dg_store_create(LitheCtx *ctx, LthDgStore **store) {
  LTH_NEW(ctx, *store, 1);
  (*store)->rooms.fence = LTH_DG_STORE_CHUNK;
  return LITHE_OK;
}

void lth_dg_store_clear(LitheCtx *ctx, LthDgStore *s) {
  for (LitheCount i = 0; i < s->n_chunks; i++) lth_free(ctx, s->chunk[i]);
  for (LitheIndex i = 0; i < s->n_cells; i++) lth_free(ctx, s->cells[i].groups);
  lth_rooms_free(ctx, &s->rooms);
  lth_free(ctx, s->chunk);
  lth_free(ctx, s->cells);
  lth_free(ctx, s->faces);
  lth_free(ctx, s->retired);
  *s = (LthDgStore){.rooms = {.fence = LTH_DG_STORE_CHUNK}};
}

void lth_dg_store_destroy(LitheCtx *ctx, LthDgStore **store) {
  if (!*store) return;
  lth_dg_store_clear(ctx, *store);
  lth_free(ctx, *store);
  *store = NULL;
}

LthDgStoreCount lth_dg_store_count(const LthDgStore *store) { return store->count; }

LitheCount lth_dg_store_bytes(const LthDgStore *store) {
  return (LitheCount)sizeof(double) * store->rooms.used;
}

// --- rooms ---

static double *room_data(const LthDgStore *s, LthDgRoom room) {
  return s->chunk[room.at / LTH_DG_STORE_CHUNK] + room.at % LTH_DG_STORE_CHUNK;
}

static LitheStatus retire(LitheCtx *ctx, LthDgStore *s, LthDgRoom *room) {
  if (room->size == 0) return LITHE_OK;
  LTH_RESERVE(ctx, s->retired, s->retired_cap, s->n_retired + 1);
  s->retired[s->n_retired++] = *room;
  *room = (LthDgRoom){0};
  return LITHE_OK;
}

LitheStatus lth_dg_store_grow(LitheCtx *ctx, LthDgStore *s, LitheCount end) {
  while (s->n_chunks * LTH_DG_STORE_CHUNK < end) {
    LTH_RESERVE(ctx, s->chunk, s->chunk_cap, s->n_chunks + 1);
    LTH_NEW(ctx, s->chunk[s->n_chunks], LTH_DG_STORE_CHUNK);
    s->n_chunks++;
  }
  return LITHE_OK;
}

/// A new room of zeros in the place of another, which is kept until settled.
static LitheStatus renew(LitheCtx *ctx, LthDgStore *s, LitheCount size, LthDgRoom *room) {
  LITHE_TRY(retire(ctx, s, room));
  LthDgRoom made = {lth_rooms_take(&s->rooms, size), size};
  LITHE_TRY(lth_dg_store_grow(ctx, s, s->rooms.end));
  *room = made;
  memset(room_data(s, made), 0, sizeof(double) * (size_t)size);
  return LITHE_OK;
}

static LitheStatus release(LitheCtx *ctx, LthDgStore *s, LthDgRoom room) {
  return room.size > 0 ? lth_rooms_give(ctx, &s->rooms, room.at, room.size) : LITHE_OK;
}

static LitheStatus forget_cell(LitheCtx *ctx, LthDgStore *s, LitheIndex record) {
  if (record >= s->n_cells) return LITHE_OK;
  LthDgStoreCell *cell = s->cells + record;
  LITHE_TRY(retire(ctx, s, &cell->basis));
  LITHE_TRY(retire(ctx, s, &cell->slope));
  LITHE_TRY(retire(ctx, s, &cell->matrix));
  for (LitheIndex i = 0; i < cell->n_groups; i++) LITHE_TRY(retire(ctx, s, &cell->groups[i].room));
  lth_free(ctx, cell->groups);
  *cell = (LthDgStoreCell){0};
  return LITHE_OK;
}

static LitheStatus forget_face(LitheCtx *ctx, LthDgStore *s, LitheIndex record) {
  if (record >= s->n_faces) return LITHE_OK;
  LITHE_TRY(retire(ctx, s, &s->faces[record].room));
  s->faces[record] = (LthDgStoreFace){0};
  return LITHE_OK;
}

LitheStatus lth_dg_store_forget(LitheCtx *ctx, LthDgStore *s, const LthTopology *t) {
  for (LitheIndex i = 0; i < t->log.n_dead_cells; i++)
    LITHE_TRY(forget_cell(ctx, s, t->log.dead_cells[i]));
  for (LitheIndex i = 0; i < t->log.n_dead_faces; i++)
    LITHE_TRY(forget_face(ctx, s, t->log.dead_faces[i]));
  return LITHE_OK;
}

LitheStatus lth_dg_store_settle(LitheCtx *ctx, LthDgStore *s) {
  for (LitheCount i = 0; i < s->n_retired; i++) LITHE_TRY(release(ctx, s, s->retired[i]));
  s->n_retired = 0;
  return LITHE_OK;
}

/// Records up to the highest of the mesh.
static LitheStatus make_places(LitheCtx *ctx, const LthDgRecords *r, const LthMesh *mesh) {
  LthDgStore *s = r->store;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    if (r->cell[c] < s->n_cells) continue;
    LTH_RESERVE(ctx, s->cells, s->cells_cap, (LitheCount)r->cell[c] + 1);
    while (s->n_cells <= r->cell[c]) s->cells[s->n_cells++] = (LthDgStoreCell){0};
  }
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (r->face[f] < s->n_faces) continue;
    LTH_RESERVE(ctx, s->faces, s->faces_cap, (LitheCount)r->face[f] + 1);
    while (s->n_faces <= r->face[f]) s->faces[s->n_faces++] = (LthDgStoreFace){0};
  }
  return LITHE_OK;
}

static LthDgStoreCell *entry_of(const LthDgRecords *r, LitheIndex cell) {
  return r->store->cells + r->cell[cell];
}

static LthDgStoreFace *face_entry(const LthDgRecords *r, const LthDgFace *face) {
  return r->store->faces + r->face[face->face];
}

static bool same_bits(double a, double b) { return memcmp(&a, &b, sizeof a) == 0; }

// --- bases ---

static void take_basis(const LthDgStore *s, const LthDgStoreCell *entry, LthDgSpace *space,
                       LitheIndex c) {
  int nb = lth_dg_funcs(space, c);
  memcpy(space->center + 3 * (size_t)c, entry->center, sizeof entry->center);
  memcpy(space->axes + 9 * (size_t)c, entry->axes, sizeof entry->axes);
  memcpy(space->mean_gradient + 3 * (size_t)space->func_off[c],
         room_data(s, entry->basis) + nb * nb, 3 * sizeof(double) * (size_t)nb);
  space->trace_constant[c] = entry->trace_constant;
}

LitheStatus lth_dg_store_lend_bases(LitheCtx *ctx, const LthDgRecords *r, LthDgSpace *space,
                                    uint8_t *is_known) {
  LITHE_TRY(make_places(ctx, r, space->mesh));
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    LthDgStoreCell *entry = entry_of(r, c);
    LitheCount nb = lth_dg_funcs(space, c);
    is_known[c] = entry->version > 0 && entry->degree == space->degree[c];
    if (!is_known[c]) {
      entry->version = 0;
      entry->degree = space->degree[c];
      LITHE_TRY(renew(ctx, r->store, nb * nb + 3 * nb, &entry->basis));
    }
    space->basis[c] = room_data(r->store, entry->basis);
    if (is_known[c]) take_basis(r->store, entry, space, c);
  }
  return LITHE_OK;
}

void lth_dg_store_keep_bases(const LthDgRecords *r, const LthDgSpace *space,
                             const uint8_t *is_known) {
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    LthDgStoreCell *entry = entry_of(r, c);
    int nb = lth_dg_funcs(space, c);
    if (is_known[c]) continue;
    memcpy(entry->center, space->center + 3 * (size_t)c, sizeof entry->center);
    memcpy(entry->axes, space->axes + 9 * (size_t)c, sizeof entry->axes);
    memcpy(space->basis[c] + nb * nb, space->mean_gradient + 3 * (size_t)space->func_off[c],
           3 * sizeof(double) * (size_t)nb);
    entry->trace_constant = space->trace_constant[c];
    entry->version = ++r->store->last_version;
    r->store->count.bases++;
  }
}

// --- operators ---

/// A new stamp where basis, material or holding are not as they were.
static void stamp_cell(const LthDgRecords *r, const LthDgOperator *op, LitheIndex c) {
  LthDgStoreCell *entry = entry_of(r, c);
  bool is_rigid = lth_dg_is_rigid(op, c);
  if (entry->stamp > 0 && entry->stamp_of == entry->version && entry->is_rigid == is_rigid &&
      same_bits(entry->lambda, op->lambda[c]) && same_bits(entry->mu, op->mu[c]))
    return;
  entry->lambda = op->lambda[c];
  entry->mu = op->mu[c];
  entry->is_rigid = is_rigid;
  entry->stamp_of = entry->version;
  entry->stamp = ++r->store->last_version;
}

LitheStatus lth_dg_store_lend_slopes(LitheCtx *ctx, const LthDgRecords *r, LthDgOperator *op,
                                     uint8_t *is_known) {
  for (LitheIndex c = 0; c < op->space->n_cells; c++) {
    LthDgStoreCell *entry = entry_of(r, c);
    stamp_cell(r, op, c);
    is_known[c] = entry->slope_of == entry->version;
    if (!is_known[c]) {
      LitheCount size = 3 * (LitheCount)lth_dg_funcs(op->space, c) * lth_dg_lower(op->space, c);
      LITHE_TRY(renew(ctx, r->store, size, &entry->slope));
      entry->slope_of = entry->version;
    }
    op->slope[c] = room_data(r->store, entry->slope);
  }
  return LITHE_OK;
}

LitheStatus lth_dg_store_lend_faces(LitheCtx *ctx, const LthDgRecords *r, LthDgOperator *op,
                                    uint8_t *is_known) {
  for (LitheIndex f = 0; f < op->n_faces; f++) {
    LthDgFace *face = op->faces + f, here = *face;
    LthDgStoreFace *entry = face_entry(r, face);
    uint64_t stamp[2] = {entry_of(r, face->cell[0])->stamp, entry_of(r, face->cell[1])->stamp};
    is_known[f] = entry->version > 0 && entry->stamp[0] == stamp[0] && entry->stamp[1] == stamp[1];
    if (is_known[f]) {
      *face = entry->face;
      face->face = here.face, face->cell[0] = here.cell[0], face->cell[1] = here.cell[1];
    } else {
      entry->version = 0;
      entry->stamp[0] = stamp[0], entry->stamp[1] = stamp[1];
      LITHE_TRY(renew(ctx, r->store, lth_dg_face_doubles(op, face), &entry->room));
    }
    face->table = room_data(r->store, entry->room);
  }
  return LITHE_OK;
}

void lth_dg_store_keep_faces(const LthDgRecords *r, const LthDgOperator *op,
                             const uint8_t *is_known) {
  for (LitheIndex f = 0; f < op->n_faces; f++) {
    LthDgStoreFace *entry = face_entry(r, op->faces + f);
    if (is_known[f]) continue;
    entry->face = op->faces[f];
    entry->face.table = NULL; // which is where the room is
    entry->version = ++r->store->last_version;
    r->store->count.faces++;
  }
}

// --- holds ---

/// The group of an element that one of an operator is, or NULL.
static LthDgStoreGroup *find_stored(const LthDgStoreCell *entry, LitheIndex constraint,
                                    const LthDgGroup *group) {
  for (LitheIndex i = 0; i < entry->n_groups; i++) {
    LthDgStoreGroup *g = entry->groups + i;
    if (g->constraint == constraint && g->stamp == entry->stamp &&
        lth_v3_distance(g->group.normal, group->normal) < SAME_GROUP &&
        fabs(g->group.area - group->area) <= SAME_GROUP * group->area)
      return g;
  }
  return NULL;
}

static size_t group_bytes(const LthDgOperator *op, LitheIndex cell) {
  size_t nb = (size_t)lth_dg_funcs(op->space, cell);
  return sizeof(double) * (nb * nb + 3 * nb);
}

void lth_dg_store_lend_groups(const LthDgRecords *r, LthDgOperator *op, uint8_t *is_known) {
  for (LitheIndex h = 0; h < op->n_holds; h++) {
    const LthDgHold *hold = op->holds + h;
    for (LitheIndex g = hold->first_group; g < hold->first_group + hold->n_groups; g++) {
      LthDgGroup *group = op->groups + g, here = *group;
      const LthDgStoreGroup *stored = find_stored(entry_of(r, hold->cell), hold->constraint, group);
      is_known[g] = stored != NULL;
      if (!stored) continue;
      *group = stored->group;
      group->table = here.table, group->first_point = here.first_point;
      group->n_points = here.n_points;
      memcpy(op->group_data + group->table, room_data(r->store, stored->room),
             group_bytes(op, hold->cell));
    }
  }
}

/// Add a group of an element.
static LitheStatus add_group(LitheCtx *ctx, const LthDgRecords *r, const LthDgOperator *op,
                             const LthDgHold *hold, const LthDgGroup *group) {
  LthDgStoreCell *entry = entry_of(r, hold->cell);
  LTH_RESERVE(ctx, entry->groups, entry->groups_cap, (LitheCount)entry->n_groups + 1);
  LthDgStoreGroup *stored = entry->groups + entry->n_groups++;
  *stored = (LthDgStoreGroup){
      .constraint = hold->constraint, .stamp = entry->stamp, .group = *group, .is_seen = true};
  size_t bytes = group_bytes(op, hold->cell);
  LITHE_TRY(renew(ctx, r->store, (LitheCount)(bytes / sizeof(double)), &stored->room));
  memcpy(room_data(r->store, stored->room), op->group_data + group->table, bytes);
  return LITHE_OK;
}

/// Groups that were not seen are gone.
static LitheStatus drop_groups(LitheCtx *ctx, LthDgStore *s, LthDgStoreCell *entry) {
  LitheIndex kept = 0;
  for (LitheIndex i = 0; i < entry->n_groups; i++) {
    LthDgStoreGroup group = entry->groups[i];
    if (!group.is_seen) LITHE_TRY(release(ctx, s, group.room));
    group.is_seen = false;
    if (entry->groups[i].is_seen) entry->groups[kept++] = group;
  }
  entry->n_groups = kept;
  return LITHE_OK;
}

LitheStatus lth_dg_store_keep_groups(LitheCtx *ctx, const LthDgRecords *r, const LthDgOperator *op,
                                     const uint8_t *is_known) {
  for (LitheIndex h = 0; h < op->n_holds; h++) {
    const LthDgHold *hold = op->holds + h;
    for (LitheIndex g = hold->first_group; g < hold->first_group + hold->n_groups; g++) {
      const LthDgGroup *group = op->groups + g;
      if (is_known[g])
        find_stored(entry_of(r, hold->cell), hold->constraint, group)->is_seen = true;
      else
        LITHE_TRY(add_group(ctx, r, op, hold, group));
    }
  }
  for (LitheIndex c = 0; c < op->space->n_cells; c++)
    LITHE_TRY(drop_groups(ctx, r->store, entry_of(r, c)));
  return LITHE_OK;
}

// --- matrices of elements ---

/// Numbers that follow each other go far apart, so that their sum tells sets from each other.
static uint64_t mix(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

/// What the matrix of an element is made of: basis, material, faces, holds.
static uint64_t digest_cell(const LthDgRecords *r, const LthDgOperator *op, LitheIndex cell) {
  size_t nb = (size_t)lth_dg_funcs(op->space, cell);
  uint64_t sum = mix(entry_of(r, cell)->stamp);
  for (LitheIndex s = op->side_off[cell]; s < op->side_off[cell + 1]; s++)
    sum += mix(2 * face_entry(r, op->faces + op->sides[s].face)->version +
               (uint64_t)op->sides[s].side);
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++) {
    const LthDgHold *hold = op->holds + h;
    sum = lth_digest(hold->P, sizeof hold->P, sum + hold->whole);
    for (LitheIndex g = hold->first_group; g < hold->first_group + hold->n_groups; g++) {
      sum = lth_digest(op->groups[g].normal, sizeof op->groups[g].normal, sum);
      sum = lth_digest(&op->groups[g].area, sizeof op->groups[g].area, sum);
      sum = lth_digest(&op->groups[g].penalty, sizeof op->groups[g].penalty, sum);
      sum = lth_digest(op->group_data + op->groups[g].table, sizeof(double) * nb * nb, sum);
    }
  }
  return sum;
}

uint64_t lth_dg_store_pair_digest(const LthDgRecords *r, const LthDgOperator *op, LitheIndex f) {
  uint64_t sum = 0;
  LitheIndex other = op->faces[f].cell[1], end = op->own_face_off[op->faces[f].cell[0] + 1];
  for (; f < end && op->faces[f].cell[1] == other; f++)
    sum += mix(face_entry(r, op->faces + f)->version);
  return sum;
}

LitheStatus lth_dg_store_lend_cells(LitheCtx *ctx, const LthDgRecords *r, LthDgOperator *op,
                                    uint8_t *is_known) {
  for (LitheIndex c = 0; c < op->space->n_cells; c++) {
    LthDgStoreCell *entry = entry_of(r, c);
    LitheCount nb = lth_dg_funcs(op->space, c);
    is_known[c] = r->is_rim && r->is_rim[c];
    if (is_known[c]) continue;
    uint64_t made_of = digest_cell(r, op, c);
    is_known[c] = entry->matrix.size > 0 && entry->made_of == made_of;
    if (!is_known[c]) LITHE_TRY(renew(ctx, r->store, 9 * nb * nb + 3 * nb, &entry->matrix));
    entry->made_of = made_of;
    op->cell_data[c] = room_data(r->store, entry->matrix);
    if (is_known[c])
      memcpy(op->cell_load + 3 * (size_t)op->space->func_off[c], op->cell_data[c] + 9 * nb * nb,
             3 * sizeof(double) * (size_t)nb);
  }
  return LITHE_OK;
}

void lth_dg_store_keep_cells(const LthDgRecords *r, const LthDgOperator *op,
                             const uint8_t *is_known) {
  for (LitheIndex c = 0; c < op->space->n_cells; c++) {
    int nb = lth_dg_funcs(op->space, c);
    if (is_known[c]) continue;
    memcpy(op->cell_data[c] + 9 * nb * nb, op->cell_load + 3 * (size_t)op->space->func_off[c],
           3 * sizeof(double) * (size_t)nb);
    r->store->count.matrices++;
  }
}
