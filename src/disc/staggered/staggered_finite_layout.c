/// Unknowns and entries of the deformation gradient of a cell: which differences there are, and which of them each
/// part of the cell pairs.
#include "disc/staggered/staggered_finite.h"

#include <string.h>

static int find_node(LthFiniteLayout *l, const int offset[3]) {
  for (int i = 0; i < l->n_nodes; i++)
    if (memcmp(l->offset[i], offset, sizeof l->offset[i]) == 0) return i;
  memcpy(l->offset[l->n_nodes], offset, sizeof l->offset[0]);
  return l->n_nodes++;
}

/// The unknown of component a at an offset.
static int find_dof(LthFiniteLayout *l, int a, const int offset[3]) {
  int node = find_node(l, offset);
  for (int i = 0; i < l->n_dofs; i++)
    if (l->component[i] == a && l->node[i] == node) return i;
  l->component[l->n_dofs] = a;
  l->node[l->n_dofs] = node;
  return l->n_dofs++;
}

static void add_diagonal(LthFiniteLayout *l, int a) {
  int low[3] = {0}, high[3] = {0};
  high[a] = 1;
  LthFiniteEntry *e = &l->entry[l->n_entries];
  *e = (LthFiniteEntry){.a = a,
                        .b = a,
                        .lo = find_dof(l, a, low),
                        .hi = find_dof(l, a, high),
                        .edge = -1,
                        .kin = {l->n_entries},
                        .n_kin = 1,
                        .turned = l->n_entries};
  l->n_entries++;
}

/// d u_a / d x_b at the four edges along the third axis; edge k lies high along a where bit 0 of k is set, along b
/// where bit 1 is.
static void add_edges(LthFiniteLayout *l, int a, int b) {
  int first = l->n_entries;
  for (int k = 0; k < 4; k++) {
    LthFiniteEntry *e = &l->entry[l->n_entries++];
    int low[3] = {0}, high[3] = {0};
    high[a] = low[a] = k & 1;
    high[b] = k >> 1;
    low[b] = high[b] - 1;
    *e = (LthFiniteEntry){.a = a, .b = b, .edge = 3 - a - b, .n_kin = 4};
    e->lo = find_dof(l, a, low);
    e->hi = find_dof(l, a, high);
    memcpy(e->offset, high, sizeof e->offset);
    for (int i = 0; i < 4; i++) e->kin[i] = first + i;
  }
}

static int first_entry(const LthFiniteLayout *l, int a, int b) {
  int i = 0;
  while (l->entry[i].a != a || l->entry[i].b != b) i++;
  return i;
}

void lth_finite_lay_out(int dim, LthFiniteLayout *l) {
  memset(l, 0, sizeof *l);
  l->dim = dim;
  l->n_parts = 1 << dim;
  for (int a = 0; a < dim; a++) add_diagonal(l, a);
  for (int a = 0; a < dim; a++)
    for (int b = 0; b < dim; b++)
      if (a != b) add_edges(l, a, b);
  for (int i = 0; i < l->n_entries; i++)
    l->entry[i].turned = first_entry(l, l->entry[i].b, l->entry[i].a);
  for (int q = 0; q < l->n_parts; q++)
    for (int a = 0; a < dim; a++)
      for (int b = 0; b < dim; b++)
        l->part[q][a * dim + b] =
            a == b ? a : first_entry(l, a, b) + (q >> a & 1) + 2 * (q >> b & 1);
}
