/// Where a discontinuous field is sampled, which elements each sample averages, and how far it acts.
#include "embed/samples.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "embed/around.h"

#include <stdlib.h>

#define COARSE_RANK 2   ///< grid planes through a coarse node
#define RADIUS_FACTOR 2 ///< radius over the local spacing
#define COVER_MIN 0.6   ///< of an element's box along each axis: what its nodes must reach over
#define SPAN_MIN 0.05 ///< smallest variance of an element's nodes over its box's half edge squared

void lth_samples_destroy(LitheCtx *ctx, LthSampleSet **set) {
  if (!set || !*set) return;
  LthSampleSet *s = *set;
  lth_free(ctx, s->point);
  lth_free(ctx, s->radius);
  lth_free(ctx, s->cell_off);
  lth_free(ctx, s->cell);
  lth_free(ctx, s->of_cell_off);
  lth_free(ctx, s->of_cell);
  lth_free(ctx, s->of_point);
  lth_free(ctx, s->is_parted);
  lth_free(ctx, s);
  *set = NULL;
}

LitheStatus lth_samples_add(LitheCtx *ctx, LthSampleSet *s, const double x[3], LitheIndex n_cells,
                            const LitheIndex *cells) {
  LitheCount end = s->n > 0 ? s->cell_off[s->n] : 0;
  LTH_RESERVE(ctx, s->point, s->point_cap, 3 * ((LitheCount)s->n + 1));
  LTH_RESERVE(ctx, s->cell_off, s->cell_off_cap, (LitheCount)s->n + 2);
  LTH_RESERVE(ctx, s->cell, s->cell_cap, end + n_cells);
  lth_v3_copy(x, s->point + 3 * (size_t)s->n);
  memcpy(s->cell + end, cells, sizeof *cells * (size_t)n_cells);
  s->cell_off[++s->n] = end + n_cells;
  return LITHE_OK;
}

/// Samples at all mesh points of at least `rank` that an element uses, one for each part of the cells around.
static LitheStatus add_points(LitheCtx *ctx, const LthMesh *m, int rank, LthSampleSet *s) {
  LthAround at = {0};
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, s->of_point, m->n_points);
  LTH_NEW_OR(done, ctx, s->is_parted, m->n_points);
  LITHE_TRY_OR(done, lth_around_create(ctx, m, &at));
  for (LitheIndex p = 0; p < m->n_points; p++) {
    s->of_point[p] = -1;
    if (at.off[p] == at.off[p + 1] || m->point_rank[p] < rank) continue;
    s->of_point[p] = s->n;
    for (LitheCount i = at.off[p], end; i < at.off[p + 1]; i = end) {
      end = lth_around_end(&at, p, i);
      s->is_parted[p] = s->is_parted[p] || end < at.off[p + 1];
      LITHE_TRY_OR(done, lth_samples_add(ctx, s, m->points + 3 * (size_t)p, (LitheIndex)(end - i),
                                         at.cell + i));
    }
  }
done:
  lth_around_free(ctx, &at);
  return status;
}

static bool has_cell(const LthSampleSet *s, LitheIndex sample, LitheIndex cell) {
  for (LitheCount i = s->cell_off[sample]; i < s->cell_off[sample + 1]; i++)
    if (s->cell[i] == cell) return true;
  return false;
}

LitheIndex lth_samples_at(const LthSampleSet *s, LitheIndex point, LitheIndex cell) {
  LitheIndex sample = s->of_point[point];
  if (sample < 0 || !s->is_parted[point]) return sample;
  while (!has_cell(s, sample, cell)) sample++; // the parts of a point follow each other
  return sample;
}

/// An edge between two coarse nodes as one of its cells sees it; by samples, low < high. `across`: the cell behind a
/// face at the edge, -1 beyond the boundary.
typedef struct Edge {
  LitheIndex low, high, cell, across;
} Edge;

static int compare_edges(const void *a, const void *b) {
  const Edge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  if (p->cell != q->cell) return p->cell < q->cell ? -1 : 1;
  return (p->across > q->across) - (p->across < q->across);
}

static bool same_edge(const Edge *a, const Edge *b) {
  return a->low == b->low && a->high == b->high;
}

static LitheStatus add_loop_edges(LitheCtx *ctx, const LthMesh *m, const LthSampleSet *s,
                                  LitheIndex face, LitheIndex loop, Edge **edges, LitheCount *n,
                                  LitheCount *cap) {
  LitheIndex first = m->loop_off[loop], end = m->loop_off[loop + 1];
  for (LitheIndex i = first; i < end; i++) {
    LitheIndex p = m->loop_point[i], q = m->loop_point[i + 1 < end ? i + 1 : first];
    if (s->of_point[p] < 0 || s->of_point[q] < 0 || p == q) continue;
    for (int side = 0; side < 2; side++) {
      LitheIndex cell = m->face_cell[2 * (size_t)face + (size_t)side];
      if (cell < 0) continue;
      LitheIndex a = lth_samples_at(s, p, cell), b = lth_samples_at(s, q, cell);
      LTH_RESERVE(ctx, *edges, *cap, *n + 1);
      (*edges)[(*n)++] = (Edge){a < b ? a : b, a < b ? b : a, cell,
                                m->face_cell[2 * (size_t)face + (size_t)!side]};
    }
  }
  return LITHE_OK;
}

/// All edges between coarse nodes with their cells and those behind faces, sorted, each once.
static LitheStatus find_edges(LitheCtx *ctx, const LthMesh *m, const LthSampleSet *s, Edge **edges,
                              LitheCount *n) {
  LitheCount cap = 0, kept = 0;
  *edges = NULL, *n = 0;
  for (LitheIndex f = 0; f < m->n_faces; f++)
    for (LitheIndex l = m->face_loop_off[f]; l < m->face_loop_off[f + 1]; l++)
      LITHE_TRY(add_loop_edges(ctx, m, s, f, l, edges, n, &cap));
  if (*n > 0) qsort(*edges, (size_t)*n, sizeof **edges, compare_edges);
  for (LitheCount i = 0; i < *n; i++)
    if (kept == 0 || compare_edges(&(*edges)[kept - 1], &(*edges)[i]) != 0)
      (*edges)[kept++] = (*edges)[i];
  *n = kept;
  return LITHE_OK;
}

/// Mean length of the edges at each node, 0 where there are none. (n_nodes)
static LitheStatus find_one_rings(LitheCtx *ctx, const LthSampleSet *s, const Edge *edges,
                                  LitheCount n, double **length) {
  LitheIndex *count = NULL;
  LTH_NEW(ctx, *length, s->n);
  LTH_NEW(ctx, count, s->n);
  for (LitheCount i = 0; i < n; i++) {
    if (i > 0 && same_edge(edges + i, edges + i - 1)) continue;
    LitheIndex end[2] = {edges[i].low, edges[i].high};
    double d = lth_v3_distance(s->point + 3 * (size_t)end[0], s->point + 3 * (size_t)end[1]);
    for (int k = 0; k < 2; k++) (*length)[end[k]] += d, count[end[k]]++;
  }
  for (LitheIndex i = 0; i < s->n; i++)
    if (count[i] > 0) (*length)[i] /= count[i];
  lth_free(ctx, count);
  return LITHE_OK;
}

/// Cells of an edge, ascending, and for each the lowest that it hangs together with by faces at the edge.
typedef struct EdgeCells {
  LitheIndex *cell, *root, *part;
  LitheIndex n;
  LitheCount cell_cap, root_cap, part_cap;
} EdgeCells;

static LitheIndex find_cell(const EdgeCells *c, LitheIndex cell) {
  for (LitheIndex i = 0; i < c->n; i++)
    if (c->cell[i] == cell) return i;
  return -1;
}

static LitheStatus find_edge_cells(LitheCtx *ctx, const Edge *edges, LitheCount n, EdgeCells *c) {
  LTH_RESERVE(ctx, c->cell, c->cell_cap, n);
  LTH_RESERVE(ctx, c->root, c->root_cap, n);
  LTH_RESERVE(ctx, c->part, c->part_cap, n);
  c->n = 0;
  for (LitheCount k = 0; k < n; k++)
    if (k == 0 || edges[k].cell != edges[k - 1].cell) c->cell[c->n++] = edges[k].cell;
  lth_sets_reset(c->root, c->n);
  for (LitheCount k = 0; k < n; k++) {
    LitheIndex a = find_cell(c, edges[k].cell),
               b = edges[k].across >= 0 ? find_cell(c, edges[k].across) : -1;
    if (b >= 0) lth_sets_unite(c->root, a, b);
  }
  return LITHE_OK;
}

/// One sample in the middle of an edge for each part of the cells around it.
static LitheStatus add_middle(LitheCtx *ctx, LthSampleSet *s, const Edge *edge, EdgeCells *c) {
  double x[3];
  lth_v3_add(s->point + 3 * (size_t)edge->low, s->point + 3 * (size_t)edge->high, x);
  lth_v3_scale(0.5, x);
  for (LitheIndex first = 0; first < c->n; first++) {
    LitheIndex n = 0;
    if (c->root[first] != first) continue;
    for (LitheIndex i = first; i < c->n; i++)
      if (lth_sets_root(c->root, i) == first) c->part[n++] = c->cell[i];
    LITHE_TRY(lth_samples_add(ctx, s, x, n, c->part));
  }
  return LITHE_OK;
}

static LitheStatus add_edge_middles(LitheCtx *ctx, LthSampleSet *s, const Edge *edges,
                                    LitheCount n) {
  LitheStatus status = LITHE_OK;
  EdgeCells cells = {0};
  for (LitheCount i = 0, j; i < n; i = j) {
    for (j = i; j < n && same_edge(edges + j, edges + i);) j++;
    LITHE_TRY_OR(done, find_edge_cells(ctx, edges + i, j - i, &cells));
    LITHE_TRY_OR(done, add_middle(ctx, s, edges + i, &cells));
  }
done:
  lth_free(ctx, cells.cell);
  lth_free(ctx, cells.root);
  lth_free(ctx, cells.part);
  return status;
}

static LitheStatus add_middles(LitheCtx *ctx, const LthMesh *m, LthSamples samples,
                               const Edge *edges, LitheCount n_edges, LthSampleSet *s) {
  if (samples >= LTH_SAMPLE_EDGES) LITHE_TRY(add_edge_middles(ctx, s, edges, n_edges));
  for (LitheIndex f = 0; samples >= LTH_SAMPLE_FACES && f < m->n_faces; f++)
    if (m->face_cell[2 * (size_t)f + 1] >= 0)
      LITHE_TRY(lth_samples_add(ctx, s, m->face_centroid + 3 * (size_t)f, 2,
                                m->face_cell + 2 * (size_t)f));
  for (LitheIndex c = 0; samples >= LTH_SAMPLE_CELLS && c < m->n_cells; c++)
    LITHE_TRY(lth_samples_add(ctx, s, m->cell_centroid + 3 * (size_t)c, 1, &c));
  return LITHE_OK;
}

/// Fill of_cell from cell.
static LitheStatus list_by_cell(LitheCtx *ctx, const LthMesh *m, LthSampleSet *s) {
  lth_free(ctx, s->of_cell_off);
  lth_free(ctx, s->of_cell);
  s->of_cell = NULL;
  LTH_NEW(ctx, s->of_cell_off, (LitheCount)m->n_cells + 2);
  LitheCount total = s->n > 0 ? s->cell_off[s->n] : 0;
  for (LitheCount e = 0; e < total; e++) s->of_cell_off[s->cell[e] + 2]++;
  for (LitheIndex c = 0; c < m->n_cells; c++) s->of_cell_off[c + 2] += s->of_cell_off[c + 1];
  LTH_NEW(ctx, s->of_cell, total);
  for (LitheIndex i = 0; i < s->n; i++)
    for (LitheCount e = s->cell_off[i]; e < s->cell_off[i + 1]; e++)
      s->of_cell[s->of_cell_off[s->cell[e] + 1]++] = i;
  return LITHE_OK;
}

/// True where the samples of a cell reach over most of its box and vary along every direction: the
/// covariance of their places in the box, less SPAN_MIN, is positive definite.
static bool spans_space(const LthMesh *m, const LthSampleSet *s, LitheIndex cell) {
  const double *box = m->cell_box + 6 * (size_t)cell;
  LitheCount begin = s->of_cell_off[cell], end = s->of_cell_off[cell + 1];
  double mean[3] = {0, 0, 0}, C[9] = {0};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  if (end - begin < 4) return false;
  for (LitheCount e = begin; e < end; e++)
    for (int i = 0; i < 3; i++) {
      double x = s->point[3 * (size_t)s->of_cell[e] + (size_t)i];
      low[i] = fmin(low[i], x);
      high[i] = fmax(high[i], x);
    }
  for (LitheCount e = begin; e < end; e++)
    lth_v3_axpy(1.0 / (double)(end - begin), s->point + 3 * (size_t)s->of_cell[e], mean);
  for (LitheCount e = begin; e < end; e++) {
    double d[3];
    for (int i = 0; i < 3; i++)
      d[i] =
          2 * (s->point[3 * (size_t)s->of_cell[e] + (size_t)i] - mean[i]) / (box[3 + i] - box[i]);
    for (int i = 0; i < 9; i++) C[i] += d[i / 3] * d[i % 3] / (double)(end - begin);
  }
  for (int i = 0; i < 3; i++)
    if (high[i] - low[i] < COVER_MIN * (box[3 + i] - box[i])) return false;
  for (int i = 0; i < 3; i++) C[4 * i] -= SPAN_MIN;
  return C[0] > 0 && C[0] * C[4] - C[1] * C[3] > 0 && lth_m3_det(C) > 0;
}

static LitheStatus add_own_samples(LitheCtx *ctx, const LthMesh *m, LitheIndex cell,
                                   LthSampleSet *s) {
  const double *box = m->cell_box + 6 * (size_t)cell, *center = m->cell_centroid + 3 * (size_t)cell;
  LITHE_TRY(lth_samples_add(ctx, s, center, 1, &cell));
  for (int k = 0; k < 6; k++) {
    double x[3];
    lth_v3_copy(center, x);
    x[k / 2] += (k % 2 ? 0.25 : -0.25) * (box[3 + k / 2] - box[k / 2]);
    LITHE_TRY(lth_samples_add(ctx, s, x, 1, &cell));
  }
  return LITHE_OK;
}

/// Mean edge of the boxes of a sample's elements [m].
static double mean_box_edge(const LthMesh *m, const LthSampleSet *s, LitheIndex i) {
  double sum = 0;
  for (LitheCount e = s->cell_off[i]; e < s->cell_off[i + 1]; e++) {
    const double *box = m->cell_box + 6 * (size_t)s->cell[e];
    sum += (box[3] - box[0] + box[4] - box[1] + box[5] - box[2]) / 3;
  }
  return sum / (double)(s->cell_off[i + 1] - s->cell_off[i]);
}

/// Radii: twice the spacing, which is the greater of the mean one-ring edge and the elements' mean edge (a
/// node that lies close to another one would else hardly act), less where samples are denser than nodes.
static LitheStatus set_radii(LitheCtx *ctx, const LthMesh *m, LthSamples samples,
                             const double *one_ring, LitheIndex n_nodes, LthSampleSet *s) {
  // cube root of the nodes' share of all samples of a regular grid: 1/1, 1/4, 1/7, 1/8
  static const double denser[] = {1, 0.63, 0.523, 0.5};
  LTH_NEW(ctx, s->radius, s->n);
  for (LitheIndex i = 0; i < s->n; i++) {
    double spacing = mean_box_edge(m, s, i);
    if (i < n_nodes) spacing = fmax(spacing, one_ring[i]);
    s->radius[i] = RADIUS_FACTOR * denser[samples] * spacing;
  }
  return LITHE_OK;
}

static LitheStatus build_samples(LitheCtx *ctx, const LthMesh *m, LthSamples samples,
                                 LthSampleSet *s) {
  LitheStatus status = LITHE_OK;
  Edge *edges = NULL;
  double *one_ring = NULL;
  LitheCount n_edges = 0;
  LITHE_TRY_OR(done, add_points(ctx, m, COARSE_RANK, s));
  LITHE_TRY_OR(done, find_edges(ctx, m, s, &edges, &n_edges));
  LITHE_TRY_OR(done, find_one_rings(ctx, s, edges, n_edges, &one_ring));
  LitheIndex n_nodes = s->n;
  LITHE_TRY_OR(done, add_middles(ctx, m, samples, edges, n_edges, s));
  LITHE_TRY_OR(done, list_by_cell(ctx, m, s));
  for (LitheIndex c = 0; c < m->n_cells; c++)
    if (!spans_space(m, s, c)) LITHE_TRY_OR(done, add_own_samples(ctx, m, c, s));
  LITHE_TRY_OR(done, list_by_cell(ctx, m, s));
  LITHE_TRY_OR(done, set_radii(ctx, m, samples, one_ring, n_nodes, s));
done:
  lth_free(ctx, edges);
  lth_free(ctx, one_ring);
  return status;
}

LitheStatus lth_samples_create(LitheCtx *ctx, const LthMesh *mesh, LthSamples samples,
                               LthSampleSet **set) {
  LitheStatus status = LITHE_OK;
  *set = NULL;
  LTH_NEW(ctx, *set, 1);
  LITHE_TRY_OR(done, build_samples(ctx, mesh, samples, *set));
done:
  if (status != LITHE_OK) lth_samples_destroy(ctx, set);
  return status;
}

LitheStatus lth_samples_create_points(LitheCtx *ctx, const LthMesh *mesh, LthSampleSet **set) {
  LitheStatus status = LITHE_OK;
  *set = NULL;
  LTH_NEW(ctx, *set, 1);
  LITHE_TRY_OR(done, add_points(ctx, mesh, 0, *set));
  LITHE_TRY_OR(done, list_by_cell(ctx, mesh, *set));
done:
  if (status != LITHE_OK) lth_samples_destroy(ctx, set);
  return status;
}
