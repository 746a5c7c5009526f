/// Rigid clusters: the motions of each.
#include "disc/staggered/staggered_clusters.h"

#include <math.h>
#include <string.h>

// A motion that the others leave so small a part of (squared) is none of its own.
#define DEPENDENT 1e-6

/// Calls for every free unknown of a block: its cluster, component and place.
#define EACH_UNKNOWN(C, block, k, a, x)                                                            \
  for (LitheCount at_ = 0; at_ < (C)->level->grid->dim * (C)->level->grid->block_cells; at_++)     \
    if ((k = lth_cluster_at(C, block, at_)) >= 0 && (a = place_at(C, block, at_, x)) >= 0)

static int place_at(const LthStaggeredClusters *C, LitheIndex block, LitheCount at, double x[3]) {
  const LthSparseGrid *g = C->level->grid;
  int a = (int)(at / g->block_cells);
  lth_cluster_place(g, a, (LitheCount)block * g->block_cells + at % g->block_cells, x);
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
  LITHE_TRY(lth_staggered_clusters_split(ctx, C));
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
