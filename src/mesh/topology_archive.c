/// A topology as bytes.
#include "mesh/topology_priv.h"

/// An array that grows: its length is known on both sides by now.
#define WALK(archive, items, cap, n)                                                               \
  walk_items((archive), (void **)&(items), &(cap), (n), sizeof *(items))

static void walk_items(LthArchive *a, void **items, LitheCount *cap, LitheCount n, size_t size) {
  if (a->status == LITHE_OK && a->is_reading) a->status = lth_reserve_(a->ctx, items, cap, n, size);
  lth_archive_array(a, *items, n, size);
}

/// A length of int32, checked when it is read.
static void walk_length(LthArchive *a, LitheIndex *n) {
  LitheCount count = *n;
  lth_archive_count(a, &count);
  *n = (LitheIndex)count;
}

static void walk_figures(LthArchive *a, LthTopology *t) {
  LTH_ARCHIVE(a, t->n_surface_points);
  LTH_ARCHIVE(a, t->n_live_faces);
  LTH_ARCHIVE(a, t->n_live_cells);
  LTH_ARCHIVE(a, t->n_waste);
  LTH_ARCHIVE(a, t->origin);
  LTH_ARCHIVE(a, t->rounding);
  LTH_ARCHIVE(a, t->off_plane);
  LTH_ARCHIVE(a, t->cell_size);
  LTH_ARCHIVE(a, t->volume);
  LTH_ARCHIVE(a, t->area);
}

static void walk_free(LthArchive *a, LthTopologyWork *w) {
  lth_archive_count(a, &w->n_free_faces);
  WALK(a, w->free_faces, w->free_faces_cap, w->n_free_faces);
  lth_archive_count(a, &w->n_free_cells);
  WALK(a, w->free_cells, w->free_cells_cap, w->n_free_cells);
  lth_archive_count(a, &w->n_free_points);
  WALK(a, w->free_points, w->free_points_cap, w->n_free_points);
}

void lth_topology_archive(LthTopology *t, LthArchive *a) {
  LITHE_ASSERT(t->log.n_births == 0 && t->log.n_dead_cells == 0 && t->work->n_loose_points == 0);
  lth_archive_mark(a, "topology");
  walk_length(a, &t->n_points);
  WALK(a, t->points, t->points_cap, 3 * (LitheCount)t->n_points);
  WALK(a, t->point_rank, t->point_rank_cap, t->n_points);
  WALK(a, t->point_use, t->point_use_cap, t->n_points);
  walk_length(a, &t->n_faces);
  WALK(a, t->faces, t->faces_cap, t->n_faces);
  walk_length(a, &t->n_cells);
  WALK(a, t->cells, t->cells_cap, t->n_cells);
  lth_archive_count(a, &t->n_pool);
  WALK(a, t->pool, t->pool_cap, t->n_pool);
  walk_figures(a, t);
  walk_free(a, t->work);
}
