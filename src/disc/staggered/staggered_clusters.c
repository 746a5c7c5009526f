/// Rigid clusters: which unknowns move together, and the motions of each.
#include "disc/staggered/staggered_clusters.h"
#include "disc/staggered/staggered_entries.h"
#include "disc/staggered/staggered_slot.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define BOX_BITS 2 // a box has four cells a side
#define STRONG 0.1 // of the strongest coupling of both rows
#define DEPENDENT                                                                                  \
  1e-6 // a motion that the others leave so small a part of (squared) is none of its own
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
  int bits = lth_side_bits(g), mask = (1 << bits) - 1, more = bits - BOX_BITS;
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

static LitheStatus split_all(LitheCtx *ctx, LthStaggeredClusters *C) {
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

/// Calls for every free unknown of a block: its cluster, component and place.
#define EACH_UNKNOWN(C, block, k, a, x)                                                            \
  for (LitheCount at_ = 0; at_ < (C)->level->grid->dim * (C)->level->grid->block_cells; at_++)     \
    if ((k = lth_cluster_at(C, block, at_)) >= 0 && (a = place_at(C, block, at_, x)) >= 0)

static int place_at(const LthStaggeredClusters *C, LitheIndex block, LitheCount at, double x[3]) {
  const LthSparseGrid *g = C->level->grid;
  LitheIndex cell[3];
  int a = (int)(at / g->block_cells);
  lth_cell_of(g, (LitheCount)block * g->block_cells + at % g->block_cells, cell);
  lth_cluster_place(g, a, cell, x);
  return a;
}

static void find_centres(LthStaggeredClusters *C, LitheIndex block) {
  double x[3];
  int a;
  LitheIndex k;
  for (k = C->first[block]; k < C->first[block + 1]; k++) C->T[36 * (LitheCount)k] = 0;
  EACH_UNKNOWN(C, block, k, a, x) {
    C->T[36 * (LitheCount)k] += 1;
    for (int b = 0; b < 3; b++) C->centre[3 * (LitheCount)k + b] += x[b];
  }
  for (k = C->first[block]; k < C->first[block + 1]; k++)
    for (int b = 0; b < 3; b++) C->centre[3 * (LitheCount)k + b] /= C->T[36 * (LitheCount)k];
}

/// u . G v
static double product(const double G[36], const double u[6], const double v[6]) {
  double sum = 0;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) sum += u[i] * G[6 * i + j] * v[j];
  return sum;
}

/// Columns T with T^T G T = 1; returns how many.
static int orthonormalise(const double G[36], double T[36]) {
  double column[6][6];
  int rank = 0;
  for (int d = 0; d < 6; d++) {
    double v[6] = {0};
    v[d] = 1;
    for (int pass = 0; pass < 2; pass++)
      for (int c = 0; c < rank; c++) {
        double part = product(G, column[c], v);
        for (int i = 0; i < 6; i++) v[i] -= part * column[c][i];
      }
    double norm = product(G, v, v);
    if (!(norm > DEPENDENT * G[7 * d])) continue;
    for (int i = 0; i < 6; i++) column[rank][i] = v[i] / sqrt(norm);
    rank++;
  }
  for (int i = 0; i < 6; i++)
    for (int c = 0; c < 6; c++) T[6 * i + c] = c < rank ? column[c][i] : 0;
  return rank;
}

/// Motions of the body about `middle`, over its `size`, in those of a cluster: S, row-major.
static void body_motions(const double centre[3], double unit, const double middle[3], double size,
                         double S[36]) {
  double d[3];
  memset(S, 0, 36 * sizeof *S);
  for (int b = 0; b < 3; b++) d[b] = (centre[b] - middle[b]) / size;
  for (int a = 0; a < 3; a++) {
    int p = (a + 1) % 3, q = (a + 2) % 3;
    S[6 * a + a] = 1;
    S[6 * (3 + a) + 3 + a] = unit / size;
    S[6 * a + 3 + p] = d[q];
    S[6 * a + 3 + q] = -d[p];
  }
}

/// near = T^T G S, rank rows of six, padded to six.
static void project(const double G[36], const double T[36], const double S[36], double near[36]) {
  double GS[36];
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) {
      GS[6 * i + j] = 0;
      for (int k = 0; k < 6; k++) GS[6 * i + j] += G[6 * i + k] * S[6 * k + j];
    }
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) {
      near[6 * i + j] = 0;
      for (int k = 0; k < 6; k++) near[6 * i + j] += T[6 * k + i] * GS[6 * k + j];
    }
}

/// Orthonormal motions of a block's clusters; T serves as Gram matrix first.
static void find_motions(LthStaggeredClusters *C, LitheIndex block, int *rank) {
  const LthSparseGrid *g = C->level->grid;
  double x[3], value[3], middle[3], size = 0;
  int a, index[3];
  LitheIndex k;
  for (int b = 0; b < 3; b++) {
    middle[b] = b < g->dim ? 0.5 * g->n[b] * g->h[b] : 0;
    size = fmax(size, middle[b]);
  }
  for (k = C->first[block]; k < C->first[block + 1]; k++) C->T[36 * (LitheCount)k] = 0;
  EACH_UNKNOWN(C, block, k, a, x) {
    double *G = C->T + 36 * (LitheCount)k;
    lth_cluster_row(g->h[0], a, x, C->centre + 3 * (LitheCount)k, index, value);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) G[6 * index[i] + index[j]] += value[i] * value[j];
  }
  for (k = C->first[block]; k < C->first[block + 1]; k++) {
    double G[36], S[36], *T = C->T + 36 * (LitheCount)k;
    memcpy(G, T, sizeof G);
    rank[k] = orthonormalise(G, T);
    body_motions(C->centre + 3 * (LitheCount)k, g->h[0], middle, size, S);
    project(G, T, S, C->near + 36 * (LitheCount)k);
  }
}

/// Rows of `near` that count, one after the other.
static LitheStatus pack_near(LitheCtx *ctx, LthStaggeredClusters *C, const int *rank) {
  LitheCount to = 0;
  double *packed;
  for (LitheIndex k = 0; k < C->n; k++) {
    memmove(C->near + to, C->near + 36 * (LitheCount)k, sizeof *C->near * (size_t)(6 * rank[k]));
    to += 6 * rank[k];
  }
  LTH_NEW(ctx, packed, to);
  memcpy(packed, C->near, sizeof *packed * (size_t)to);
  lth_free(ctx, C->near);
  C->near = packed;
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, LthStaggeredClusters *C, LitheCount factored) {
  LitheStatus status = LITHE_OK;
  int *rank = NULL;
  const LitheIndex n_blocks = C->level->grid->n_blocks;
  C->threads = lth_threads(ctx);
  LITHE_TRY(split_all(ctx, C));
  LTH_NEW(ctx, C->centre, 3 * (LitheCount)C->n);
  LTH_NEW(ctx, C->T, 36 * (LitheCount)C->n);
  LTH_NEW(ctx, C->near, 36 * (LitheCount)C->n);
  LTH_NEW(ctx, C->motion, 6 * (LitheCount)C->n);
  LTH_NEW(ctx, rank, C->n);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < n_blocks; b++) {
    find_centres(C, b);
    find_motions(C, b, rank);
  }
  LITHE_TRY_OR(done, pack_near(ctx, C, rank));
  LITHE_TRY_OR(done, lth_staggered_clusters_pattern(ctx, C, rank));
  LTH_NEW_OR(done, ctx, C->b, C->A->n);
  LTH_NEW_OR(done, ctx, C->x, C->A->n);
  LTH_NEW_OR(done, ctx, C->r, C->A->n);
  LTH_NEW_OR(done, ctx, C->z, C->A->n);
  LTH_NEW_OR(done, ctx, C->p, C->A->n);
  C->engine = lth_engine_find("cholesky");
  if (C->engine && C->A->n <= factored)
    LITHE_TRY_OR(done, C->engine->analyse(ctx, C->A, &C->factor));
done:
  lth_free(ctx, rank);
  return status;
}

LitheStatus lth_staggered_clusters_create(LitheCtx *ctx, const LthFastLevel *level,
                                          LitheCount factored, LthStaggeredClusters **clusters) {
  LTH_NEW(ctx, *clusters, 1);
  (*clusters)->level = level;
  LitheStatus status = build(ctx, *clusters, factored);
  if (status != LITHE_OK) lth_staggered_clusters_destroy(ctx, clusters);
  return status;
}

void lth_staggered_clusters_destroy(LitheCtx *ctx, LthStaggeredClusters **clusters) {
  LthStaggeredClusters *C = *clusters;
  if (!C) return;
  if (C->factor) C->engine->destroy(ctx, &C->factor);
  lth_multilevel_destroy(ctx, &C->levels);
  lth_block_matrix_destroy(ctx, &C->A);
  void *blocks[] = {C->first, C->local, C->centre, C->T, C->near, C->motion,
                    C->b,     C->x,     C->r,      C->z, C->p,    C->scratch};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, C);
  *clusters = NULL;
}
