/// Are the elements of a file sound: closed, not flat, not turned inside out?
#include "mesh/element_mesh.h"

#include "base/tensor.h"

#include <stdlib.h>

/// A volume below this share of (largest distance from the first node) cubed counts as none.
#define FLAT 1e-14

/// Six times the volume that the sides of an element enclose; sides that are not planar count as bilinear.
static double six_volumes(const LthElementMesh *m, const LthElementSides *s, LitheIndex e,
                          double *size) {
  double sum = 0, far2 = 0;
  const double *o = m->nodes + 3 * (LitheCount)m->element_node[m->element_off[e]];
  for (LitheIndex f = s->element_side[e]; f < s->element_side[e + 1]; f++) {
    const LitheIndex *v = s->corner + s->corner_off[f];
    LitheIndex n = s->corner_off[f + 1] - s->corner_off[f];
    double mean[3] = {0}, a[3], b[3], cross[3];
    for (LitheIndex i = 0; i < n; i++) {
      lth_v3_sub(m->nodes + 3 * (LitheCount)v[i], o, a);
      lth_v3_axpy(1.0 / n, a, mean);
      far2 = fmax(far2, lth_v3_dot(a, a));
    }
    for (LitheIndex i = 0; i < n; i++) {
      lth_v3_sub(m->nodes + 3 * (LitheCount)v[i], o, a);
      lth_v3_sub(m->nodes + 3 * (LitheCount)v[i + 1 < n ? i + 1 : 0], o, b);
      lth_v3_cross(a, b, cross);
      sum += lth_v3_dot(mean, cross);
    }
  }
  *size = sqrt(far2);
  return sum;
}

typedef struct Edge {
  LitheIndex a, b; ///< a < b
  int side;        ///< +1: run from a to b
} Edge;

static int compare_edges(const void *pa, const void *pb) {
  const Edge *p = pa, *q = pb;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  return (p->b > q->b) - (p->b < q->b);
}

/// An edge that is not run as often forth as back; false where there is none.
static LitheStatus find_open_edge(LitheCtx *ctx, const LthElementSides *s, LitheIndex e,
                                  bool *is_open, LitheIndex at[2]) {
  Edge *edges = NULL;
  LitheIndex first = s->element_side[e], last = s->element_side[e + 1], n = 0;
  LTH_NEW(ctx, edges, s->corner_off[last] - s->corner_off[first]);
  for (LitheIndex f = first; f < last; f++)
    for (LitheIndex i = s->corner_off[f]; i < s->corner_off[f + 1]; i++) {
      LitheIndex p = s->corner[i],
                 q = s->corner[i + 1 < s->corner_off[f + 1] ? i + 1 : s->corner_off[f]];
      edges[n++] = p < q ? (Edge){p, q, 1} : (Edge){q, p, -1};
    }
  qsort(edges, (size_t)n, sizeof *edges, compare_edges);
  *is_open = false;
  for (LitheIndex i = 0, j; i < n && !*is_open; i = j) {
    int sum = 0;
    for (j = i; j < n && compare_edges(edges + i, edges + j) == 0; j++) sum += edges[j].side;
    *is_open = sum != 0;
    at[0] = edges[i].a, at[1] = edges[i].b;
  }
  lth_free(ctx, edges);
  return LITHE_OK;
}

/// Only polyhedra, and elements whose nodes coincide, can fail to be closed.
static bool may_be_open(const LthElementMesh *m, LitheIndex e) {
  const LitheIndex *v = m->element_node + m->element_off[e];
  int n = lth_element_shape(m->kind[e])->n_corners;
  if (m->kind[e] == LTH_POLYHEDRON) return true;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < i; j++)
      if (v[i] == v[j]) return true;
  return false;
}

static LitheStatus check_closed(LitheCtx *ctx, const LthElementMesh *m, const LthElementSides *s,
                                const char *file, LitheIndex e) {
  bool is_open = false;
  LitheIndex at[2] = {0, 0};
  char text[LTH_ELEMENT_TEXT_MAX];
  LITHE_TRY(find_open_edge(ctx, s, e, &is_open, at));
  if (!is_open) return LITHE_OK;
  const double *p = m->nodes + 3 * (LitheCount)at[0], *q = m->nodes + 3 * (LitheCount)at[1];
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s is not closed: an edge from (%g, %g, %g) to (%g, %g, %g) does not lie between two "
             "of its faces that are turned alike",
             lth_element_text(m, file, e, text), p[0], p[1], p[2], q[0], q[1], q[2]);
}

static LitheStatus check_volume(LitheCtx *ctx, const LthElementMesh *m, const LthElementSides *s,
                                const char *file, LitheIndex e) {
  char text[LTH_ELEMENT_TEXT_MAX];
  double size = 0, volume = six_volumes(m, s, e, &size) / 6;
  if (volume > FLAT * size * size * size) return LITHE_OK;
  const double *x = m->nodes + 3 * (LitheCount)m->element_node[m->element_off[e]];
  lth_element_text(m, file, e, text);
  if (volume < -FLAT * size * size * size)
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "%s near (%g, %g, %g) is turned inside out: its volume is %g m^3, expected more than "
        "0; number its nodes the other way round",
        text, x[0], x[1], x[2], volume);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s near (%g, %g, %g) is flat: its volume is %g m^3 at a size of %g m; remove it",
             text, x[0], x[1], x[2], volume, size);
}

// volumes come first: an element turned inside out is then named as such, not as a wrong neighbour
LitheStatus lth_element_mesh_check(LitheCtx *ctx, const LthElementMesh *mesh, const char *file) {
  LthElementSides *sides = NULL;
  LitheStatus status = LITHE_OK;
  if (mesh->n_elements == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: it has no volume elements, expected tetrahedra, hexahedra, "
               "wedges, pyramids or polyhedra",
               file);
  LITHE_TRY_OR(done, lth_element_sides_list(ctx, mesh, &sides));
  for (LitheIndex e = 0; e < mesh->n_elements; e++) {
    if (may_be_open(mesh, e)) LITHE_TRY_OR(done, check_closed(ctx, mesh, sides, file, e));
    LITHE_TRY_OR(done, check_volume(ctx, mesh, sides, file, e));
  }
  status = lth_element_sides_match(ctx, mesh, file, sides);
done:
  lth_element_sides_destroy(ctx, &sides);
  return status;
}
