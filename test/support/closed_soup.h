/// Whether surfaces are closed, and parts of topologies, for tests.
#pragma once

#include "base/disjoint_sets.h"
#include "check.h"
#include "geometry/surface.h"
#include "mesh/topology.h"

#include <stdlib.h>

typedef struct SoupEdge {
  LitheIndex low, high, sum;
} SoupEdge;

static inline int compare_soup_edges(const void *a, const void *b) {
  const SoupEdge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  return (p->high > q->high) - (p->high < q->high);
}

/// Is every edge of the polygons there as often in one direction as in the other? If not, `open` is the first that is not.
static inline bool soup_is_closed(const LthSoup *s, LitheIndex open[2]) {
  LitheIndex n = s->poly_off[s->n_polys], k = 0;
  bool is_closed = true;
  SoupEdge *edge = calloc((size_t)n, sizeof *edge);
  for (LitheIndex p = 0; p < s->n_polys; p++)
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++) {
      LitheIndex a = s->poly_point[i],
                 c = s->poly_point[i + 1 < s->poly_off[p + 1] ? i + 1 : s->poly_off[p]];
      assert_true(a >= 0 && a < s->n_points && a != c);
      edge[k++] = a < c ? (SoupEdge){a, c, 1} : (SoupEdge){c, a, -1};
    }
  qsort(edge, (size_t)n, sizeof *edge, compare_soup_edges);
  for (LitheIndex i = 0, j; is_closed && i < n; i = j) {
    LitheIndex sum = 0;
    for (j = i; j < n && compare_soup_edges(edge + i, edge + j) == 0; j++) sum += edge[j].sum;
    is_closed = sum == 0;
    open[0] = edge[i].low, open[1] = edge[i].high;
  }
  free(edge);
  return is_closed;
}

/// Has every edge two polygons? If not, `other` is the first that has not.
static inline bool soup_is_manifold(const LthSoup *s, LitheIndex other[2]) {
  LitheIndex n = s->poly_off[s->n_polys], k = 0;
  bool is_manifold = true;
  SoupEdge *edge = calloc((size_t)n, sizeof *edge);
  for (LitheIndex p = 0; p < s->n_polys; p++)
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++) {
      LitheIndex a = s->poly_point[i],
                 c = s->poly_point[i + 1 < s->poly_off[p + 1] ? i + 1 : s->poly_off[p]];
      edge[k++] = a < c ? (SoupEdge){a, c, 1} : (SoupEdge){c, a, 1};
    }
  qsort(edge, (size_t)n, sizeof *edge, compare_soup_edges);
  for (LitheIndex i = 0, j; is_manifold && i < n; i = j) {
    for (j = i; j < n && compare_soup_edges(edge + i, edge + j) == 0;) j++;
    is_manifold = j - i == 2;
    other[0] = edge[i].low, other[1] = edge[i].high;
  }
  free(edge);
  return is_manifold;
}

/// Parts of the body that hang together: lowest cell of each cell's part.
static inline LitheIndex *find_parts(const LthTopology *t) {
  LitheIndex *part = calloc((size_t)t->n_cells, sizeof *part);
  lth_sets_reset(part, t->n_cells);
  for (LitheIndex f = 0; f < t->n_faces; f++)
    if (t->faces[f].is_live && t->faces[f].cell[1] >= 0)
      lth_sets_unite(part, t->faces[f].cell[0], t->faces[f].cell[1]);
  for (LitheIndex c = 0; c < t->n_cells; c++) part[c] = lth_sets_root(part, c);
  return part;
}
