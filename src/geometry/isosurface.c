/// Marching tetrahedra, one layer of lattice cells after the other: memory of two layers only.
#include "geometry/isosurface.h"

#include "base/tensor.h"

#define BISECTIONS 48
#define LATTICE_MAX 2e9   ///< lattice cells that are worth waiting for
#define END_DISTANCE 1e-4 ///< of an edge: how near a point may come to its ends

/// Lattice of cells, each cut into six tetrahedra around the diagonal (0,0,0)-(1,1,1). Edges start at
/// their lower end; edge kind 1 .. 7 is the bit mask of the axes they go along.
typedef struct Lattice {
  LthIsoFunction f;
  LthIsoCrossing crossing; ///< or NULL
  const void *self;
  double origin[3], h[3];
  LitheIndex n[3];     ///< lattice points per axis
  double *value[2];    ///< f of the lower and upper layer                 (n[0] n[1] each)
  LitheIndex *edge[2]; ///< point on each edge that starts in a layer, -1  (7 n[0] n[1] each)
  double *points;
  LitheIndex n_points;
  LitheIndex *ends; ///< lower end i, j, k and kind of each point's edge (n_points x 4)
  LitheCount ends_cap;
  LitheIndex *tris;
  LitheCount tris_cap;
  LitheIndex n_tris;
} Lattice;

static void place(const Lattice *g, LitheIndex i, LitheIndex j, LitheIndex k, double x[3]) {
  x[0] = g->origin[0] + g->h[0] * i;
  x[1] = g->origin[1] + g->h[1] * j;
  x[2] = g->origin[2] + g->h[2] * k;
}

static bool on_border(const Lattice *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  return i == 0 || j == 0 || k == 0 || i == g->n[0] - 1 || j == g->n[1] - 1 || k == g->n[2] - 1;
}

/// f with the border outside; what is not a number counts as outside.
static double lattice_value(const Lattice *g, LitheIndex i, LitheIndex j, LitheIndex k) {
  double x[3];
  if (on_border(g, i, j, k)) return 1;
  place(g, i, j, k, x);
  double value = g->f(g->self, x);
  return isnan(value) ? 1 : value;
}

static void fill_layer(LitheCtx *ctx, const Lattice *g, LitheIndex k, double *value,
                       LitheIndex *edge) {
  LITHE_ASSERT(value && edge);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex j = 0; j < g->n[1]; j++)
    for (LitheIndex i = 0; i < g->n[0]; i++) {
      size_t p = (size_t)j * (size_t)g->n[0] + (size_t)i;
      value[p] = lattice_value(g, i, j, k);
      for (size_t e = 0; e < 7; e++) edge[7 * p + e] = -1;
    }
}

/// A corner of the present cell as a bit mask of axes.
typedef struct Cell {
  LitheIndex i, j, k;
} Cell;

static size_t corner_place(const Lattice *g, const Cell *c, int corner) {
  return (size_t)(c->j + (corner >> 1 & 1)) * (size_t)g->n[0] + (size_t)(c->i + (corner & 1));
}

static bool is_inside(const Lattice *g, const Cell *c, int corner) {
  return g->value[corner >> 2][corner_place(g, c, corner)] <= 0;
}

/// The point on the lattice edge between two corners of a cell, made when it is first asked for.
static LitheStatus edge_point(LitheCtx *ctx, Lattice *g, const Cell *c, int a, int b,
                              LitheIndex *point) {
  int low = a & b, kind = a ^ b; // corners of one tetrahedron are nested masks
  LitheIndex *slot = &g->edge[low >> 2][7 * corner_place(g, c, low) + (size_t)(kind - 1)];
  if (*slot < 0) {
    LTH_RESERVE(ctx, g->ends, g->ends_cap, 4 * ((LitheCount)g->n_points + 1));
    LitheIndex *e = g->ends + 4 * (size_t)g->n_points;
    e[0] = c->i + (low & 1), e[1] = c->j + (low >> 1 & 1), e[2] = c->k + (low >> 2), e[3] = kind;
    *slot = g->n_points++;
  }
  *point = *slot;
  return LITHE_OK;
}

/// Add triangle abc, turned so that it faces away from the inside.
static LitheStatus add_tri(LitheCtx *ctx, Lattice *g, LitheIndex a, LitheIndex b, LitheIndex c,
                           bool flip) {
  LTH_RESERVE(ctx, g->tris, g->tris_cap, 3 * ((LitheCount)g->n_tris + 1));
  LitheIndex *t = g->tris + 3 * (size_t)g->n_tris++;
  t[0] = a, t[1] = flip ? c : b, t[2] = flip ? b : c;
  return LITHE_OK;
}

/// The surface's part in one tetrahedron; `odd`: its corners are a left-handed frame.
static LitheStatus march_tetrahedron(LitheCtx *ctx, Lattice *g, const Cell *c, const int corner[4],
                                     bool odd) {
  int in[4], out[4], n_in = 0, n_out = 0, order[4];
  for (int k = 0; k < 4; k++) {
    if (is_inside(g, c, corner[k]))
      in[n_in++] = k;
    else
      out[n_out++] = k;
  }
  if (n_in == 0 || n_out == 0) return LITHE_OK;
  for (int k = 0; k < 4; k++) order[k] = k < n_in ? in[k] : out[k - n_in];
  for (int i = 0; i < 4; i++)
    for (int j = i + 1; j < 4; j++) odd ^= order[i] > order[j];

  LitheIndex p[4];
  int v[4];
  for (int k = 0; k < 4; k++) v[k] = corner[order[k]];
  if (n_in == 2) { // v0 v1 inside: the quadrilateral 02 03 13 12
    LITHE_TRY(edge_point(ctx, g, c, v[0], v[2], &p[0]));
    LITHE_TRY(edge_point(ctx, g, c, v[0], v[3], &p[1]));
    LITHE_TRY(edge_point(ctx, g, c, v[1], v[3], &p[2]));
    LITHE_TRY(edge_point(ctx, g, c, v[1], v[2], &p[3]));
    LITHE_TRY(add_tri(ctx, g, p[0], p[1], p[2], odd));
    return add_tri(ctx, g, p[0], p[2], p[3], odd);
  }
  int lone = n_in == 1 ? 0 : 3;
  for (int k = 0; k < 3; k++)
    LITHE_TRY(edge_point(ctx, g, c, v[lone], v[(lone + 1 + k) % 4], &p[k]));
  return add_tri(ctx, g, p[0], p[1], p[2], odd);
}

static LitheStatus march_layer(LitheCtx *ctx, Lattice *g, LitheIndex k) {
  static const int paths[6][4] = {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7},
                                  {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 4, 6, 7}};
  for (LitheIndex j = 0; j + 1 < g->n[1]; j++)
    for (LitheIndex i = 0; i + 1 < g->n[0]; i++) {
      Cell c = {i, j, k};
      int n_in = 0;
      for (int corner = 0; corner < 8; corner++) n_in += is_inside(g, &c, corner);
      if (n_in == 0 || n_in == 8) continue;
      for (int t = 0; t < 6; t++) LITHE_TRY(march_tetrahedron(ctx, g, &c, paths[t], t >= 3));
    }
  return LITHE_OK;
}

/// Part of the way at which f changes sign, by bisection.
static double bisect(const Lattice *g, const double from[3], const double to[3],
                     bool starts_inside) {
  double low = 0, high = 1, x[3];
  for (int i = 0; i < BISECTIONS; i++) {
    double t = 0.5 * (low + high);
    for (int a = 0; a < 3; a++) x[a] = from[a] + t * (to[a] - from[a]);
    double value = g->f(g->self, x);
    if ((value <= 0) == starts_inside)
      low = t;
    else
      high = t;
  }
  return 0.5 * (low + high);
}

/// Where f changes sign along an edge.
static void find_crossing(const Lattice *g, const LitheIndex e[4], double x[3]) {
  LitheIndex b[3] = {e[0] + (e[3] & 1), e[1] + (e[3] >> 1 & 1), e[2] + (e[3] >> 2)};
  double from[3], to[3];
  place(g, e[0], e[1], e[2], from);
  place(g, b[0], b[1], b[2], to);
  bool starts_inside = lattice_value(g, e[0], e[1], e[2]) <= 0;
  double t = g->crossing ? g->crossing(g->self, from, to, starts_inside)
                         : bisect(g, from, to, starts_inside);
  t = fmin(fmax(t, END_DISTANCE), 1 - END_DISTANCE);
  for (int a = 0; a < 3; a++) x[a] = from[a] + t * (to[a] - from[a]);
}

static LitheStatus march(LitheCtx *ctx, Lattice *g) {
  fill_layer(ctx, g, 0, g->value[0], g->edge[0]);
  for (LitheIndex k = 0; k + 1 < g->n[2]; k++) {
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted while tessellating");
    fill_layer(ctx, g, k + 1, g->value[1], g->edge[1]);
    LITHE_TRY(march_layer(ctx, g, k));
    double *value = g->value[0];
    LitheIndex *edge = g->edge[0];
    g->value[0] = g->value[1], g->edge[0] = g->edge[1];
    g->value[1] = value, g->edge[1] = edge;
  }
  return LITHE_OK;
}

/// Lattice that covers the box with a margin of more than a cell. The uneven shift keeps its planes off
/// the planes that shapes like to end at.
static LitheStatus lay_out(LitheCtx *ctx, Lattice *g, const double min[3], const double max[3],
                           double resolution) {
  double all = 1;
  for (int a = 0; a < 3; a++) {
    double cells = ceil((max[a] - min[a]) / resolution) + 3;
    all *= cells;
    if (!(all < LATTICE_MAX))
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "a shape of size %g m cannot be tessellated at a resolution of %g m; give a coarser "
          "resolution",
          max[a] - min[a], resolution);
    g->n[a] = (LitheIndex)cells + 1;
    g->h[a] = resolution;
    g->origin[a] = min[a] - (1.37 + 0.02 * a) * resolution;
  }
  size_t layer = (size_t)g->n[0] * (size_t)g->n[1];
  for (int side = 0; side < 2; side++) {
    LTH_NEW(ctx, g->value[side], (LitheCount)layer);
    LTH_NEW(ctx, g->edge[side], 7 * (LitheCount)layer);
  }
  return LITHE_OK;
}

LitheStatus lth_isosurface(LitheCtx *ctx, LthIsoFunction f, LthIsoCrossing crossing,
                           const void *self, const double min[3], const double max[3],
                           double resolution, LitheIndex *n_points, double **points,
                           LitheIndex *n_tris, LitheIndex **tris) {
  LitheStatus status = LITHE_OK;
  Lattice g = {.f = f, .crossing = crossing, .self = self};
  *points = NULL, *tris = NULL, *n_points = 0, *n_tris = 0;
  LITHE_TRY_OR(done, lay_out(ctx, &g, min, max, resolution));
  LITHE_TRY_OR(done, march(ctx, &g));
  LTH_NEW_OR(done, ctx, g.points, 3 * (LitheCount)g.n_points);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < g.n_points; p++)
    find_crossing(&g, g.ends + 4 * (size_t)p, g.points + 3 * (size_t)p);
  *points = g.points, *tris = g.tris, *n_points = g.n_points, *n_tris = g.n_tris;
  g.points = NULL, g.tris = NULL;
done:
  for (int side = 0; side < 2; side++) lth_free(ctx, g.value[side]), lth_free(ctx, g.edge[side]);
  lth_free(ctx, g.ends);
  lth_free(ctx, g.points);
  lth_free(ctx, g.tris);
  return status;
}
