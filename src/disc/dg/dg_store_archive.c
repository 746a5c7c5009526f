/// A store as bytes.
#include "disc/dg/dg_store_priv.h"

/// A length of int32, checked when it is read.
static void walk_length(LthArchive *a, LitheIndex *n) {
  LitheCount count = *n;
  lth_archive_count(a, &count);
  *n = (LitheIndex)count;
}

/// An array that grows.
static void walk_items(LthArchive *a, void **items, LitheCount *cap, LitheCount n, size_t size) {
  if (a->status == LITHE_OK && a->is_reading) a->status = lth_reserve_(a->ctx, items, cap, n, size);
  lth_archive_array(a, *items, n, size);
}

static void walk_rooms(LthArchive *a, LthRooms *rooms) {
  LTH_ARCHIVE(a, rooms->end);
  LTH_ARCHIVE(a, rooms->used);
  LitheIndex n = rooms->n_sizes;
  walk_length(a, &n);
  if (a->is_reading && a->status == LITHE_OK)
    a->status =
        lth_reserve_(a->ctx, (void **)&rooms->sizes, &rooms->sizes_cap, n, sizeof *rooms->sizes);
  for (LitheIndex i = 0; i < n && a->status == LITHE_OK; i++) {
    LthRoomSize *size = rooms->sizes + i;
    if (a->is_reading) *size = (LthRoomSize){0};
    rooms->n_sizes = a->is_reading ? i + 1 : n;
    LTH_ARCHIVE(a, size->size);
    lth_archive_count(a, &size->n_free);
    walk_items(a, (void **)&size->free, &size->cap, size->n_free, sizeof *size->free);
  }
}

/// Groups lie beside the array of cells.
static void walk_groups(LthArchive *a, LthDgStoreCell *cell) {
  if (a->is_reading) cell->groups = NULL, cell->groups_cap = 0;
  walk_items(a, (void **)&cell->groups, &cell->groups_cap, cell->n_groups, sizeof *cell->groups);
}

static void walk_cells(LthArchive *a, LthDgStore *s) {
  LitheIndex n = s->n_cells;
  walk_length(a, &n);
  if (a->is_reading && a->status == LITHE_OK)
    a->status = lth_reserve_(a->ctx, (void **)&s->cells, &s->cells_cap, n, sizeof *s->cells);
  for (LitheIndex i = 0; i < n && a->status == LITHE_OK; i++) {
    LthDgStoreCell cell = s->cells[i];
    cell.groups = NULL;
    cell.groups_cap = 0;
    LTH_ARCHIVE(a, cell);
    if (a->status != LITHE_OK) return;
    if (a->is_reading) s->cells[i] = cell, s->n_cells = i + 1;
    if (cell.n_groups > 0) walk_groups(a, s->cells + i);
  }
}

static void walk_chunks(LthArchive *a, LthDgStore *s) {
  LitheCount n = s->n_chunks;
  lth_archive_count(a, &n);
  for (LitheCount i = 0; i < n && a->status == LITHE_OK; i++) {
    if (a->is_reading) a->status = lth_dg_store_grow(a->ctx, s, (i + 1) * LTH_DG_STORE_CHUNK);
    if (a->status == LITHE_OK) LTH_ARCHIVE_ARRAY(a, s->chunk[i], LTH_DG_STORE_CHUNK);
  }
}

void lth_dg_store_archive(LthDgStore *s, LthArchive *a) {
  LITHE_ASSERT(s->n_retired == 0);
  if (a->is_reading) lth_dg_store_clear(a->ctx, s);
  lth_archive_mark(a, "integrals");
  walk_cells(a, s);
  walk_length(a, &s->n_faces);
  walk_items(a, (void **)&s->faces, &s->faces_cap, s->n_faces, sizeof *s->faces);
  walk_rooms(a, &s->rooms);
  walk_chunks(a, s);
  LTH_ARCHIVE(a, s->last_version);
}
