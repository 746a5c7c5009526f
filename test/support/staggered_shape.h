/// Staggered levels of sampled shapes, for tests: fractions from one lattice, rule A, materials, held sides.
#pragma once

#include "check.h"
#include "disc/staggered/staggered_hierarchy.h"

#include <math.h>

typedef struct ShapeDef {
  int dim, n; ///< cells along the unit box
  bool (*inside)(const double x[3]);
  bool (*held)(const double x[3]); ///< NULL: nothing
  bool (*axis)(const double x[3],
               int a);                ///< of what is held: whether component a is; NULL: all are
  double (*young)(const double x[3]); ///< NULL: 1
  double nu, rho, least;              ///< least: fraction of rule A; 0: 1e-4
  int samples;                        ///< along a part; 0: 2
  double stretch;                     ///< h_y / h_x - 1
} ShapeDef;

typedef struct ShapeLevel {
  LitheCtx *ctx;
  LthSparseGrid *grid;
  LthStaggeredLevel level;
} ShapeLevel;

static double shape_part(const ShapeDef *d, const LthSparseGrid *g, const LitheIndex cell[3],
                         int q) {
  int m = d->samples ? d->samples : 2, count = 0, total = 0;
  for (int k = 0; k < (d->dim == 3 ? m : 1); k++)
    for (int j = 0; j < m; j++)
      for (int i = 0; i < m; i++) {
        double at[3] = {((q & 1) + (i + 0.5) / m) / 2, ((q >> 1 & 1) + (j + 0.5) / m) / 2,
                        d->dim == 3 ? ((q >> 2) + (k + 0.5) / m) / 2 : 0.5};
        double x[3];
        lth_sparse_grid_place(g, cell, at, x);
        count += d->inside(x);
        total++;
      }
  return (double)count / total;
}

/// Mean over parts of the box around offset `from` (in parts) of a cell: 0 a cell, -1 a shift to its low side.
static double shape_box(const ShapeDef *d, const LthSparseGrid *g, const float *part,
                        const LitheIndex cell[3], int shifted) {
  int n_parts = d->dim == 3 ? 8 : 4;
  double sum = 0;
  for (int q = 0; q < n_parts; q++) {
    LitheIndex c[3];
    int p = 0;
    for (int a = 0; a < 3; a++) {
      int at = (q >> a & 1) - (shifted >> a & 1); // -1, 0 or 1
      c[a] = cell[a] + (at < 0 ? -1 : 0);
      p |= (at & 1) << a;
    }
    LitheCount s = lth_sparse_grid_slot(g, c[0], c[1], c[2]);
    if (s >= 0) sum += part[s * n_parts + p];
  }
  return sum / n_parts;
}

static double shape_young(const ShapeDef *d, const LthSparseGrid *g, const LitheIndex cell[3],
                          const double at[3]) {
  double x[3];
  lth_sparse_grid_place(g, cell, at, x);
  return d->young ? d->young(x) : 1;
}

/// Harmonic mean of the four cells around an edge, as bodies have it: an edge of a stiff part's rim is soft.
static double shape_edge_young(const ShapeDef *d, const LthSparseGrid *g, const LitheIndex cell[3],
                               int e) {
  double soft = 0;
  for (int q = 0; q < 4; q++) {
    double at[3] = {0.5, 0.5, 0.5};
    at[(e + 1) % 3] -= q & 1;
    at[(e + 2) % 3] -= q >> 1;
    soft += 0.25 / shape_young(d, g, cell, at);
  }
  return 1 / soft;
}

/// Blocks with material and those around them.
static void shape_blocks(const ShapeDef *d, const double h[3], const LitheIndex n[3],
                         uint8_t *wanted) {
  LitheIndex nb[3];
  int side = d->dim == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D;
  for (int a = 0; a < 3; a++) nb[a] = lth_sparse_grid_blocks(d->dim, a, n[a]);
  for (LitheIndex k = -1; k <= n[2]; k++)
    for (LitheIndex j = -1; j <= n[1]; j++)
      for (LitheIndex i = -1; i <= n[0]; i++) {
        bool any = false;
        for (int q = 0; q < 8 && !any; q++) {
          double x[3] = {(i - 1 + 0.25 + 0.5 * (q & 1)) * h[0],
                         (j - 1 + 0.25 + 0.5 * (q >> 1 & 1)) * h[1],
                         d->dim == 3 ? (k - 1 + 0.25 + 0.5 * (q >> 2)) * h[2] : 0};
          any = d->inside(x) || (d->held && d->held(x));
        }
        if (!any) continue;
        for (LitheIndex dk = -1; dk <= 1; dk++)
          for (LitheIndex dj = -1; dj <= 1; dj++)
            for (LitheIndex di = -1; di <= 1; di++) {
              LitheIndex b[3] = {(i + di) / side, (j + dj) / side,
                                 d->dim == 3 ? (k + dk) / side : 0};
              if (i + di < 0 || j + dj < 0 || (d->dim == 3 && k + dk < 0)) continue;
              if (b[0] >= nb[0] || b[1] >= nb[1] || b[2] >= nb[2]) continue;
              wanted[b[0] + nb[0] * (b[1] + nb[1] * b[2])] = 1;
            }
      }
}

static inline void shape_fill(ShapeLevel *S, const ShapeDef *d, const float *part) {
  LthStaggeredLevel *l = &S->level;
  const LthSparseGrid *g = S->grid;
  double least = d->least > 0 ? d->least : 1e-4;
  int flat = d->dim == 2 ? 4 : 0;
  for (LitheCount s = 0; s < g->n_slots; s++) {
    LitheIndex c[3];
    lth_sparse_grid_cell(g, s, c);
    double V = shape_box(d, g, part, c, 0), E = shape_young(d, g, c, (double[]){0.5, 0.5, 0.5});
    if (V > least) {
      if (l->volume) l->volume[s] = V;
      l->mu[s] = V * E / (2 * (1 + d->nu));
      l->lambda[s] = V * E * d->nu / ((1 + d->nu) * (1 - 2 * d->nu));
    }
    for (int e = 0; e < 3; e++) {
      if (!l->shear[e]) continue;
      l->shear[e][s] = shape_box(d, g, part, c, 7 & ~(1 << e) & ~flat) *
                       shape_edge_young(d, g, c, e) / (2 * (1 + d->nu));
    }
    for (int a = 0; a < d->dim; a++) {
      double at[3] = {0.5, 0.5, 0.5}, x[3];
      at[a] = 0;
      lth_sparse_grid_place(g, c, at, x);
      if (d->dim == 2) x[2] = 0;
      l->mass[a][s] = d->rho * shape_box(d, g, part, c, 1 << a);
      bool held = d->held && d->held(x) && (!d->axis || d->axis(x, a));
      l->state[a][s] = held ? LTH_UNKNOWN_HELD : LTH_UNKNOWN_DEAD;
    }
  }
  lth_staggered_rule_a(S->ctx, l);
}

/// The level of a shape in the box [-1, n + 1] h; places are such that the unit box is [0, 1]^dim.
static inline ShapeLevel shape_level(LitheCtx *ctx, const ShapeDef *d) {
  ShapeLevel S = {.ctx = ctx};
  double h[3], origin[3];
  LitheIndex n[3];
  for (int a = 0; a < 3; a++) {
    h[a] = 1.0 / d->n * (a == 1 ? 1 + d->stretch : 1);
    origin[a] = -h[a];
    n[a] = d->dim == 2 && a == 2 ? 1 : d->n + 2;
  }
  LitheCount n_blocks = 1;
  for (int a = 0; a < 3; a++) n_blocks *= lth_sparse_grid_blocks(d->dim, a, n[a]);
  uint8_t *wanted = lth_alloc(ctx, n_blocks, 1);
  shape_blocks(d, h, n, wanted);
  CHECK_OK(ctx, lth_sparse_grid_create(ctx, d->dim, origin, h, n, wanted, &S.grid));
  CHECK_OK(ctx, lth_staggered_level_alloc(ctx, S.grid, &S.level));
  S.level.volume = lth_alloc(ctx, S.grid->n_slots, sizeof(double));
  int n_parts = d->dim == 3 ? 8 : 4;
  float *part = lth_alloc(ctx, S.grid->n_slots * n_parts, sizeof *part);
#pragma omp parallel for
  for (LitheCount s = 0; s < S.grid->n_slots; s++) {
    LitheIndex c[3];
    lth_sparse_grid_cell(S.grid, s, c);
    bool beyond = c[0] >= n[0] || c[1] >= n[1] || c[2] >= n[2];
    for (int q = 0; q < n_parts && !beyond; q++)
      part[s * n_parts + q] = (float)shape_part(d, S.grid, c, q);
  }
  shape_fill(&S, d, part);
  lth_free(ctx, part);
  lth_free(ctx, wanted);
  return S;
}

static inline void shape_free(ShapeLevel *S) {
  lth_staggered_level_free(S->ctx, &S->level);
  lth_sparse_grid_destroy(S->ctx, &S->grid);
}

/// The annulus of the convergence tests: held inside of r = 0.325, free at r = 0.8; centre (1/2, 1/2), halved.
static inline bool ring_inside(const double x[3]) { return hypot(x[0] - 0.5, x[1] - 0.5) < 0.4; }
static inline bool ring_held(const double x[3]) { return hypot(x[0] - 0.5, x[1] - 0.5) <= 0.1625; }
static inline double ball_radius(const double x[3]) {
  return sqrt((x[0] - 0.5) * (x[0] - 0.5) + (x[1] - 0.5) * (x[1] - 0.5) +
              (x[2] - 0.5) * (x[2] - 0.5));
}
static inline bool ball_inside(const double x[3]) { return ball_radius(x) < 0.45; }
static inline bool ball_held(const double x[3]) { return ball_radius(x) <= 0.2; }

/// Three vectors over slots.
static inline void shape_vectors(const ShapeLevel *S, const LthSparseGrid *g, double *v[3]) {
  for (int a = 0; a < 3; a++) v[a] = a < g->dim ? lth_alloc(S->ctx, g->n_slots, sizeof **v) : NULL;
}
static inline void shape_vectors_free(const ShapeLevel *S, double *v[3]) {
  for (int a = 0; a < 3; a++) lth_free(S->ctx, v[a]);
}
