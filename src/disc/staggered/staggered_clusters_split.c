/// Rigid clusters: which unknowns move together.
#include "disc/staggered/staggered_clusters.h"
#include "disc/staggered/staggered_entries.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define BOX_BITS 2 // a box has four cells a side
#define STRONG 0.1 // of the strongest coupling of both rows
#define MOST_UNKNOWNS (3 * LTH_BLOCK_SIDE_3D * LTH_BLOCK_SIDE_3D * LTH_BLOCK_SIDE_3D)

/// Coupling of two unknowns of one box, by their places in the block's vectors.
typedef struct Link {
  int from, to;
  double size;
} Link;

/// Scratch for one block.
typedef struct Forest {
  int parent[MOST_UNKNOWNS], size[MOST_UNKNOWNS], better[MOST_UNKNOWNS];
  double strongest[MOST_UNKNOWNS], stiffest[MOST_UNKNOWNS], best[MOST_UNKNOWNS];
  Link link[MOST_UNKNOWNS * LTH_STAGGERED_ROW];
  int n_links;
} Forest;

static int root_of(Forest *f, int i) {
  while (f->parent[i] != i) i = f->parent[i] = f->parent[f->parent[i]];
  return i;
}

/// Number of the box that holds a cell of the block.
static int box_of(const LthSparseGrid *g, LitheIndex cell_in_block) {
  int bits = lth_sparse_grid_bits(g), mask = (1 << bits) - 1, more = bits - BOX_BITS;
  int x = (cell_in_block & mask) >> BOX_BITS, y = (cell_in_block >> bits & mask) >> BOX_BITS;
  int z = g->dim == 3 ? (cell_in_block >> (2 * bits)) >> BOX_BITS : 0;
  return x + (((z << more) + y) << more);
}

/// Links inside boxes, and every free row's strongest coupling.
static void list_links(const LthStaggeredLevel *l, LitheIndex block, Forest *f) {
  const LitheIndex n = l->grid->block_cells;
  f->n_links = 0;
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheIndex i = 0; i < n; i++) {
      LthStaggeredEntry entry[LTH_STAGGERED_ROW];
      const LitheCount slot = (LitheCount)block * n + i;
      const int from = a * n + i;
      f->parent[from] = from;
      f->strongest[from] = 0;
      if (l->state[a][slot] != LTH_UNKNOWN_FREE) continue;
      int count = lth_staggered_row(l, 0, 1, a, slot, entry);
      for (int e = 1; e < count; e++) {
        if (l->state[entry[e].b][entry[e].slot] != LTH_UNKNOWN_FREE) continue;
        double size = fabs(entry[e].value);
        f->strongest[from] = fmax(f->strongest[from], size);
        if (entry[e].slot / n != block) continue;
        LitheIndex cell = (LitheIndex)(entry[e].slot % n);
        if (box_of(l->grid, cell) != box_of(l->grid, i)) continue;
        f->link[f->n_links++] = (Link){from, entry[e].b * n + cell, size};
      }
    }
}

static void join_strong(Forest *f) {
  for (int k = 0; k < f->n_links; k++) {
    const Link *link = &f->link[k];
    double least = STRONG * fmax(f->strongest[link->from], f->strongest[link->to]);
    if (link->size > 0 && link->size >= least)
      f->parent[root_of(f, link->from)] = root_of(f, link->to);
  }
}

/// Pieces of less than `enough` unknowns follow the stiffer one that they hang on most; true where one does.
static bool join_small(Forest *f, int n, int enough) {
  for (int i = 0; i < n; i++) f->size[i] = 0, f->better[i] = -1, f->best[i] = f->stiffest[i] = 0;
  for (int i = 0; i < n; i++) {
    int root = root_of(f, i);
    f->size[root]++;
    f->stiffest[root] = fmax(f->stiffest[root], f->strongest[i]);
  }
  for (int k = 0; k < f->n_links; k++) {
    int from = root_of(f, f->link[k].from), to = root_of(f, f->link[k].to);
    if (from == to || f->size[from] >= enough || f->link[k].size <= f->best[from]) continue;
    if (f->stiffest[to] < f->stiffest[from] ||
        (f->stiffest[to] == f->stiffest[from] && f->size[to] < f->size[from]))
      continue;
    f->best[from] = f->link[k].size;
    f->better[from] = to;
  }
  bool any = false;
  for (int i = 0; i < n; i++) {
    if (f->better[i] < 0) continue;
    int to = root_of(f, f->better[i]);
    if (to == i) continue;
    f->parent[i] = to;
    any = true;
  }
  return any;
}

/// Clusters of a block: `local` and their number.
static LitheIndex split_block(const LthFastLevel *L, LitheIndex block, Forest *f, uint16_t *local) {
  const LthStaggeredLevel *l = L->level;
  const LitheIndex n = l->grid->block_cells, size = l->grid->dim * n;
  list_links(l, block, f);
  join_strong(f);
  for (int pass = 0; pass < 4 && join_small(f, size, l->grid->dim == 3 ? 8 : 4); pass++) continue;
  LitheIndex count = 0;
  int *number = f->size;
  for (LitheIndex i = 0; i < size; i++) number[i] = -1;
  for (LitheIndex i = 0; i < size; i++) {
    const LitheCount slot = (LitheCount)block * n + i % n;
    if (l->state[i / n][slot] != LTH_UNKNOWN_FREE) continue;
    int root = root_of(f, i);
    if (number[root] < 0) number[root] = count++;
    local[lth_fast_place(L, slot, i / n)] = (uint16_t)number[root];
  }
  return count;
}

LitheStatus lth_staggered_clusters_split(LitheCtx *ctx, LthStaggeredClusters *C) {
  const LthSparseGrid *g = C->level->grid;
  const LitheCount size = C->level->n_rows * (LitheCount)lth_fast_width(C->level);
  Forest *forest = NULL;
  LTH_NEW(ctx, C->first, g->n_blocks + 1);
  LTH_NEW(ctx, C->local, size);
  memset(C->local, 0xff, sizeof *C->local * (size_t)size); // LTH_CLUSTER_NONE
  LTH_NEW(ctx, forest, lth_threads(ctx));
#pragma omp parallel num_threads(lth_threads(ctx))
  {
    Forest *own = forest + omp_get_thread_num();
#pragma omp for schedule(static)
    for (LitheIndex b = 0; b < g->n_blocks; b++)
      C->first[b + 1] = split_block(C->level, b, own, C->local);
  }
  lth_free(ctx, forest);
  for (LitheIndex b = 0; b < g->n_blocks; b++) C->first[b + 1] += C->first[b];
  C->n = C->first[g->n_blocks];
  return LITHE_OK;
}
