/// Elements of a grid: hexahedra or six tetrahedra a cell (Kuhn), of degree 1 or 2.
#include "mesh/element_mesh.h"

#include <string.h>

/// Places of the 27 nodes of a hexahedron in half edges.
static const int8_t hex_place[27][3] = {
    {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
    {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
    {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}, {0, 1, 1},
    {2, 1, 1}, {1, 0, 1}, {1, 2, 1}, {1, 1, 0}, {1, 1, 2}, {1, 1, 1}};

/// Corners at the ends of a tetrahedron's edges.
static const int8_t tet_edge[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// Order of the axes along which the six tetrahedra of a cell go from its low to its high corner; every
/// second one is mirrored.
static const int8_t tet_path[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 2, 0},
                                      {1, 0, 2}, {2, 0, 1}, {2, 1, 0}};

/// What is made: nodes stand on a lattice of `degree` steps a cell.
typedef struct GridElements {
  const LthGrid *grid;
  int degree, per_cell, n_nodes; ///< elements a cell, nodes an element
  LthElementKind kind;
  LitheIndex lattice[3];
  LitheIndex *lattice_node; ///< 1 + node at a place of the lattice, 0: none (lattice product)
  int8_t place[6][LTH_ELEMENT_MAX_NODES][3]; ///< of every element of a cell, in half edges
} GridElements;

static void place_tetrahedra(GridElements *g) {
  for (int t = 0; t < 6; t++) {
    int8_t(*place)[3] = g->place[t], at[3] = {0};
    for (int i = 0; i < 3; i++) {
      // positive volume: corners 1 and 2 of a mirrored one change places
      int corner = t % 2 == 1 && i < 2 ? 2 - i : i + 1;
      at[tet_path[t][i]] = 2;
      memcpy(place[corner], at, sizeof at);
    }
    for (int e = 0; e < 6; e++)
      for (int a = 0; a < 3; a++)
        place[4 + e][a] = (int8_t)((place[tet_edge[e][0]][a] + place[tet_edge[e][1]][a]) / 2);
  }
}

static LitheStatus plan(LitheCtx *ctx, const LthGrid *grid, int degree, bool serendipity,
                        bool tetrahedra, GridElements *g) {
  LitheCount n_lattice = 1, n_cells = 1;
  g->grid = grid;
  g->degree = degree;
  g->per_cell = tetrahedra ? 6 : 1;
  if (tetrahedra)
    g->kind = degree == 1 ? LTH_TET4 : LTH_TET10;
  else
    g->kind = degree == 1 ? LTH_HEX8 : serendipity ? LTH_HEX20 : LTH_HEX27;
  g->n_nodes = lth_element_shape(g->kind)->n_nodes;
  for (int a = 0; a < 3; a++) {
    if (grid->cells[a] < 1 || !(grid->max[a] > grid->min[a]))
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "grid: axis %c runs from %g to %g in %d cells; expected min < max and at least 1 cell",
          "xyz"[a], grid -> min[a], grid -> max[a], grid -> cells[a]);
    n_lattice *= (LitheCount)degree * grid->cells[a] + 1;
    n_cells *= grid->cells[a];
    if (n_lattice > INT32_MAX / 3 || n_cells * g->per_cell * g->n_nodes > INT32_MAX)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "grid: %d x %d x %d cells are more than a mesh can hold",
                 grid->cells[0], grid->cells[1], grid->cells[2]);
    g->lattice[a] = degree * grid->cells[a] + 1;
  }
  if (tetrahedra)
    place_tetrahedra(g);
  else
    memcpy(g->place[0], hex_place, sizeof hex_place);
  LTH_NEW(ctx, g->lattice_node, n_lattice);
  return LITHE_OK;
}

/// Place on the lattice of node i of element t of the cell at `at`.
static LitheIndex lattice_index(const GridElements *g, const LitheIndex at[3], int t, int i) {
  LitheIndex x[3];
  for (int a = 0; a < 3; a++) x[a] = g->degree * at[a] + g->place[t][i][a] * g->degree / 2;
  return x[0] + g->lattice[0] * (x[1] + g->lattice[1] * x[2]);
}

/// Places on the lattice of all elements of the kept cells into element_node; marks them as used.
static void list_elements(GridElements *g, const uint8_t *keep, LthElementMesh *m) {
  const LitheIndex *n = g->grid->cells;
  LitheIndex at[3], cell = 0, k = 0;
  for (at[2] = 0; at[2] < n[2]; at[2]++)
    for (at[1] = 0; at[1] < n[1]; at[1]++)
      for (at[0] = 0; at[0] < n[0]; at[0]++, cell++) {
        if (keep && !keep[cell]) continue;
        for (int t = 0; t < g->per_cell; t++)
          for (int i = 0; i < g->n_nodes; i++) {
            LitheIndex l = lattice_index(g, at, t, i);
            m->element_node[k++] = l;
            g->lattice_node[l] = 1;
          }
      }
}

/// A plane of the lattice: a plane of the grid or the middle between two.
static double lattice_plane(const GridElements *g, int axis, LitheIndex k) {
  LitheIndex cell = k / g->degree;
  double low = lth_grid_plane(g->grid, axis, cell);
  return k % g->degree == 0 ? low : 0.5 * (low + lth_grid_plane(g->grid, axis, cell + 1));
}

/// Number the used places, x fastest, and give them coordinates.
static LitheStatus number_nodes(LitheCtx *ctx, GridElements *g, LthElementMesh *m) {
  LitheIndex n_lattice = g->lattice[0] * g->lattice[1] * g->lattice[2];
  for (LitheIndex l = 0; l < n_lattice; l++)
    if (g->lattice_node[l]) g->lattice_node[l] = ++m->n_nodes;
  LTH_NEW(ctx, m->nodes, 3 * (LitheCount)m->n_nodes);
  for (LitheIndex l = 0; l < n_lattice; l++) {
    if (!g->lattice_node[l]) continue;
    double *x = m->nodes + 3 * (LitheCount)(g->lattice_node[l] - 1);
    x[0] = lattice_plane(g, 0, l % g->lattice[0]);
    x[1] = lattice_plane(g, 1, l / g->lattice[0] % g->lattice[1]);
    x[2] = lattice_plane(g, 2, l / g->lattice[0] / g->lattice[1]);
  }
  for (LitheIndex k = 0; k < m->element_off[m->n_elements]; k++)
    m->element_node[k] = g->lattice_node[m->element_node[k]] - 1;
  return LITHE_OK;
}

static LitheStatus fill(LitheCtx *ctx, GridElements *g, const uint8_t *keep, LthElementMesh *m) {
  const LitheIndex *n = g->grid->cells;
  LitheIndex n_cells = n[0] * n[1] * n[2], n_kept = 0;
  for (LitheIndex c = 0; c < n_cells; c++) n_kept += !keep || keep[c];
  if (n_kept == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "grid: none of its %d x %d x %d cells is part of the body",
               n[0], n[1], n[2]);
  m->n_elements = n_kept * g->per_cell;
  LTH_NEW(ctx, m->kind, m->n_elements);
  LTH_NEW(ctx, m->element_off, m->n_elements + 1);
  LTH_NEW(ctx, m->element_node, (LitheCount)m->n_elements * g->n_nodes);
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    m->kind[e] = (uint8_t)g->kind;
    m->element_off[e + 1] = (e + 1) * g->n_nodes;
  }
  list_elements(g, keep, m);
  return number_nodes(ctx, g, m);
}

LitheStatus lth_element_mesh_grid(LitheCtx *ctx, const LthGrid *grid, int degree, bool serendipity,
                                  bool tetrahedra, const uint8_t *keep, LthElementMesh **mesh) {
  LitheStatus status = LITHE_OK;
  GridElements g = {0};
  LthElementMesh *made = NULL;
  *mesh = NULL;
  LITHE_TRY_OR(done, plan(ctx, grid, degree, serendipity, tetrahedra, &g));
  LTH_NEW_OR(done, ctx, made, 1);
  LITHE_TRY_OR(done, fill(ctx, &g, keep, made));
  *mesh = made;
  made = NULL;
done:
  lth_element_mesh_destroy(ctx, &made);
  lth_free(ctx, g.lattice_node);
  return status;
}
