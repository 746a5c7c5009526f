/// Parts to elements: in each cell those that hang together by edges; cavities join what is around them.
#include "mesh/slice.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"

#include <math.h>
#include <stdlib.h>

/// A part as one cell sees it: side 2p from the cell it is oriented out of, 2p + 1 from behind.
typedef struct CellSide {
  int64_t cell;
  LitheIndex side;
} CellSide;

/// An undirected edge of a side.
typedef struct SideEdge {
  uint64_t points;
  LitheIndex side;
} SideEdge;

typedef struct Grouping {
  Slicer *s;
  CellSide *list; ///< all sides, cell by cell
  LitheCount n;
  LitheIndex *parent; ///< of sides
  SideEdge *edge;     ///< of one cell
  LitheCount edge_cap;
  bool *has_cap;     ///< of elements
  LitheIndex *first; ///< of elements: first of their sides in a chain over `next`
  LitheIndex *next;  ///< of sides, -1 at the end
} Grouping;

static int compare_sides(const void *a, const void *b) {
  const CellSide *x = a, *y = b;
  if (x->cell != y->cell) return x->cell < y->cell ? -1 : 1;
  return (x->side > y->side) - (x->side < y->side);
}

static int compare_side_edges(const void *a, const void *b) {
  const SideEdge *x = a, *y = b;
  if (x->points != y->points) return x->points < y->points ? -1 : 1;
  return (x->side > y->side) - (x->side < y->side);
}

static int64_t cell_of(const Slicer *s, const LitheIndex slab[3]) {
  return slab[0] + (int64_t)s->cells[0] * (slab[1] + (int64_t)s->cells[1] * slab[2]);
}

static LitheStatus list_sides(Grouping *g) {
  Slicer *s = g->s;
  LTH_NEW(s->ctx, g->list, 2 * s->parts.n);
  for (LitheIndex p = 0; p < s->parts.n; p++) {
    const SlicePiece *piece = s->pieces.piece + s->parts.piece[p];
    LitheIndex slab[3] = {piece->slab[0], piece->slab[1], piece->slab[2]};
    g->list[g->n++] = (CellSide){cell_of(s, slab), 2 * p};
    if (piece->axis == SLICE_BOUNDARY) continue;
    slab[piece->axis]++;
    g->list[g->n++] = (CellSide){cell_of(s, slab), 2 * p + 1};
  }
  qsort(g->list, (size_t)g->n, sizeof *g->list, compare_sides);
  return LITHE_OK;
}

/// Unite the sides of one cell that share an edge.
static LitheStatus unite_cell(Grouping *g, const CellSide *side, LitheCount n) {
  const SliceParts *parts = &g->s->parts;
  LitheCount n_edges = 0;
  for (LitheCount i = 0; i < n; i++) {
    LitheIndex p = side[i].side / 2;
    for (LitheIndex l = parts->loop_off[p]; l < parts->loop_off[p + 1]; l++) {
      LitheIndex first = parts->off[l], last = parts->off[l + 1];
      LTH_RESERVE(g->s->ctx, g->edge, g->edge_cap, n_edges + last - first);
      for (LitheIndex j = first; j < last; j++) {
        LitheIndex a = parts->point[j], b = parts->point[j + 1 < last ? j + 1 : first];
        g->edge[n_edges++] =
            (SideEdge){a < b ? lth_hash_pair(a, b) : lth_hash_pair(b, a), side[i].side};
      }
    }
  }
  qsort(g->edge, (size_t)n_edges, sizeof *g->edge, compare_side_edges);
  for (LitheCount i = 1; i < n_edges; i++)
    if (g->edge[i].points == g->edge[i - 1].points)
      lth_sets_unite(g->parent, g->edge[i].side, g->edge[i - 1].side);
  return LITHE_OK;
}

static LitheStatus unite_all(Grouping *g) {
  LTH_NEW(g->s->ctx, g->parent, 2 * g->s->parts.n);
  lth_sets_reset(g->parent, 2 * g->s->parts.n);
  for (LitheCount i = 0, j; i < g->n; i = j) {
    for (j = i + 1; j < g->n && g->list[j].cell == g->list[i].cell;) j++;
    LITHE_TRY(unite_cell(g, g->list + i, j - i));
  }
  return LITHE_OK;
}

/// Number the elements in the order of their cells, and chain their sides.
static LitheStatus number_elements(Grouping *g) {
  Slicer *s = g->s;
  SliceElements *e = &s->elements;
  LTH_NEW(s->ctx, e->of, 2 * s->parts.n);
  LTH_NEW(s->ctx, g->next, 2 * s->parts.n);
  for (LitheCount i = 0; i < 2 * s->parts.n; i++) e->of[i] = g->next[i] = -1;
  for (LitheCount i = 0; i < g->n; i++) {
    LitheIndex root = lth_sets_root(g->parent, g->list[i].side);
    if (e->of[root] < 0) e->of[root] = e->n++;
    e->of[g->list[i].side] = e->of[root];
  }
  LTH_NEW(s->ctx, g->first, e->n);
  LTH_NEW(s->ctx, g->has_cap, e->n);
  for (LitheIndex i = 0; i < e->n; i++) g->first[i] = -1;
  for (LitheCount i = g->n; i-- > 0;) {
    LitheIndex side = g->list[i].side, element = e->of[side];
    g->next[side] = g->first[element];
    g->first[element] = side;
    g->has_cap[element] |= s->pieces.piece[s->parts.piece[side / 2]].axis != SLICE_BOUNDARY;
  }
  return LITHE_OK;
}

/// Six times the volume of the cone from o over a part.
static double part_cone(const Slicer *s, LitheIndex p, const double o[3]) {
  const SliceParts *parts = &s->parts;
  double apex[3], sum = 0;
  LitheIndex first_loop = parts->loop_off[p];
  lth_v3_sub(s->point + 3 * (LitheCount)parts->point[parts->off[first_loop]], o, apex);
  for (LitheIndex l = first_loop; l < parts->loop_off[p + 1]; l++) {
    double vector[3];
    lth_slice_area_vector(s->point, parts->point + parts->off[l], parts->off[l + 1] - parts->off[l],
                          vector);
    sum += 2 * lth_v3_dot(apex, vector);
  }
  return sum;
}

static LitheStatus measure(Grouping *g) {
  Slicer *s = g->s;
  SliceElements *e = &s->elements;
  LTH_NEW(s->ctx, e->volume, e->n);
  LTH_NEW(s->ctx, e->area, e->n);
  for (LitheIndex i = 0; i < e->n; i++) {
    const SliceParts *parts = &s->parts;
    LitheIndex first = g->first[i] / 2;
    const double *o = s->point + 3 * (LitheCount)parts->point[parts->off[parts->loop_off[first]]];
    for (LitheIndex side = g->first[i]; side >= 0; side = g->next[side]) {
      e->volume[i] += (side % 2 ? -1 : 1) * part_cone(s, side / 2, o) / 6;
      e->area[i] += parts->area[side / 2];
    }
  }
  return LITHE_OK;
}

/// Solid angle of the triangle a b c seen from the origin (van Oosterom and Strackee 1983).
static double solid_angle(const double a[3], const double b[3], const double c[3]) {
  double bc[3], la = lth_v3_norm(a), lb = lth_v3_norm(b), lc = lth_v3_norm(c);
  lth_v3_cross(b, c, bc);
  double down =
      la * lb * lc + lth_v3_dot(a, b) * lc + lth_v3_dot(b, c) * la + lth_v3_dot(c, a) * lb;
  return 2 * atan2(lth_v3_dot(a, bc), down);
}

/// Winding number of an element's surface around x: 1 inside, 0 outside.
static double winding(const Grouping *g, LitheIndex element, const double x[3]) {
  const Slicer *s = g->s;
  const SliceParts *parts = &s->parts;
  double sum = 0;
  for (LitheIndex side = g->first[element]; side >= 0; side = g->next[side]) {
    LitheIndex p = side / 2;
    double apex[3];
    lth_v3_sub(s->point + 3 * (LitheCount)parts->point[parts->off[parts->loop_off[p]]], x, apex);
    for (LitheIndex l = parts->loop_off[p]; l < parts->loop_off[p + 1]; l++)
      for (LitheIndex j = parts->off[l]; j < parts->off[l + 1]; j++) {
        LitheIndex k = j + 1 < parts->off[l + 1] ? j + 1 : parts->off[l];
        double a[3], b[3];
        lth_v3_sub(s->point + 3 * (LitheCount)parts->point[j], x, a);
        lth_v3_sub(s->point + 3 * (LitheCount)parts->point[k], x, b);
        sum += (side % 2 ? -1 : 1) * solid_angle(apex, a, b);
      }
  }
  return sum / (4 * M_PI);
}

/// Middle of an element's largest part, a convex piece of a triangle: where shells touch each other, they
/// do so in points and edges, never there.
static void probe_point(const Grouping *g, LitheIndex element, double x[3]) {
  const SliceParts *parts = &g->s->parts;
  LitheIndex best = g->first[element] / 2;
  for (LitheIndex side = g->first[element]; side >= 0; side = g->next[side])
    if (parts->area[side / 2] > parts->area[best]) best = side / 2;
  LitheIndex loop = parts->loop_off[best], first = parts->off[loop],
             n = parts->off[loop + 1] - first;
  const double *o = g->s->point + 3 * (LitheCount)parts->point[first];
  lth_v3_copy(o, x);
  for (LitheIndex i = first; i < first + n; i++) {
    double d[3];
    lth_v3_sub(g->s->point + 3 * (LitheCount)parts->point[i], o, d);
    lth_v3_axpy(1.0 / n, d, x);
  }
}

/// The smallest of a cell's elements [first, last) around the cavity; -1 if there is none.
static LitheIndex find_container(const Grouping *g, LitheIndex cavity, LitheIndex first,
                                 LitheIndex last) {
  const double *volume = g->s->elements.volume;
  LitheIndex best = -1;
  double x[3];
  probe_point(g, cavity, x);
  for (LitheIndex i = first; i < last; i++) {
    if (!(volume[i] > -volume[cavity])) continue;
    if (best >= 0 && volume[i] >= volume[best]) continue;
    if (winding(g, i, x) > 0.5) best = i;
  }
  return best;
}

static void move_sides(Grouping *g, LitheIndex from, LitheIndex to) {
  SliceElements *e = &g->s->elements;
  LitheIndex last = g->first[from];
  for (LitheIndex side = last; side >= 0; side = g->next[side]) {
    e->of[side] = to;
    last = side;
  }
  g->next[last] = g->first[to];
  g->first[to] = g->first[from];
  g->first[from] = -1;
  e->volume[to] += e->volume[from];
  e->area[to] += e->area[from];
  e->volume[from] = e->area[from] = 0;
}

/// Whole shells of negative volume are cavities: give them to the element around them. Containers are
/// measured without their cavities until all are found, so that the smallest is the innermost.
static LitheStatus attach_cavities(Grouping *g) {
  SliceElements *e = &g->s->elements;
  LitheIndex *container = NULL;
  LTH_NEW(g->s->ctx, container, e->n);
  for (LitheIndex i = 0; i < e->n; i++) container[i] = -1;
  for (LitheCount i = 0, j; i < g->n; i = j) {
    LitheIndex first = INT32_MAX, last = -1;
    for (j = i; j < g->n && g->list[j].cell == g->list[i].cell; j++) {
      LitheIndex element = e->of[g->list[j].side];
      if (element < first) first = element;
      if (element > last) last = element;
    }
    for (LitheIndex k = first; k <= last; k++)
      if (e->volume[k] < 0 && !g->has_cap[k]) container[k] = find_container(g, k, first, last + 1);
  }
  for (LitheIndex i = 0; i < e->n; i++)
    if (container[i] >= 0) move_sides(g, i, container[i]);
  lth_free(g->s->ctx, container);
  return LITHE_OK;
}

LitheStatus lth_slice_make_elements(Slicer *s) {
  Grouping g = {.s = s};
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, list_sides(&g));
  LITHE_TRY_OR(done, unite_all(&g));
  LITHE_TRY_OR(done, number_elements(&g));
  LITHE_TRY_OR(done, measure(&g));
  LITHE_TRY_OR(done, attach_cavities(&g));
done:
  lth_free(s->ctx, g.list);
  lth_free(s->ctx, g.parent);
  lth_free(s->ctx, g.edge);
  lth_free(s->ctx, g.first);
  lth_free(s->ctx, g.next);
  lth_free(s->ctx, g.has_cap);
  return status;
}
