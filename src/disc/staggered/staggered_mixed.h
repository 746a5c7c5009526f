/// Displacement and pressure on a hierarchy of staggered grids: operator, smoothers and cycles of the mixed form.
/// Zhu, Sifakis, Teran, Brandt 2010 (distributive smoothing); docs/theory/staggered-mixed.md.
#pragma once

#include "disc/staggered/staggered_hierarchy.h"
#include "la/krylov.h"

#define LTH_MIXED_COLORS 7 ///< of boxes: 5 in 2D, 7 in 3D

/// What the slot of a level carries.
enum {
  LTH_MIXED_FREE = 1,       ///< << axis: the low face's displacement is free
  LTH_MIXED_HELD = 8,       ///< << axis: it is held
  LTH_MIXED_PRESSURE = 64,  ///< the cell has a pressure
  LTH_MIXED_INTERIOR = 128, ///< nothing within two cells is cut, held or of another material
};

/// A vector of a level: dim displacements, then the pressure, each of `stride` values over slots; behind the last slot
/// stands one that is always zero, for neighbours that are not there. Rows are divided by the volume of a cell:
///
///   [ A   B^T ] [ u ]   [ f ]
///   [ B   -C  ] [ p ] = [ g ]
typedef struct LthMixedLevel {
  const LthSparseGrid *grid;
  int dim;
  LitheCount n, stride;   ///< slots; between components of a vector
  double per_h[3];        ///< 1 / h [1/m]
  LitheIndex *next[6];    ///< slot of the neighbour: low x, high x, low y, ...        (n + 1)
  double *mu, *volume;    ///< V mu [Pa], V; 0 where the cell holds nothing             (n + 1)
  double *compliance;     ///< V / lambda [1/Pa]                                        (n + 1)
  double *shear[3];       ///< V mu of edges that count [Pa]                            (n + 1)
  double *mass[3];        ///< of faces, springs included [Pa/m^2], NULL without both   (n + 1)
  float *spring[3];       ///< what contact holds faces with, NULL before the first     (n + 1)
  uint8_t *flags;         ///< (n + 1)
  LitheIndex *face[3][2]; ///< interior faces of an axis by red and black
  LitheIndex n_face[3][2];
  LitheIndex *cell[2]; ///< interior cells by red and black
  LitheIndex n_cell[2];
  LitheIndex *near[2]; ///< cells beside interior ones of the other color
  LitheIndex n_near[2];
  LitheIndex *box; ///< all other cells with a pressure, by color
  LitheIndex box_off[LTH_MIXED_COLORS + 1];
  float *inverse; ///< of a box: faces low x, high x, low y, ..., pressure      (m m each)
  LitheIndex *parent,
      *child;        ///< slots of the next coarser level (n + 1), of the finer one (n + 1 << dim)
  float *weight[3];  ///< 1 / sum of the interpolation's weights that count        (n + 1)
  double *x, *b, *r; ///< vectors
  float *share;      ///< of the coarse cell's pressure: mu over the coarse mu        (n + 1)
} LthMixedLevel;

static inline LitheCount lth_mixed_size(const LthMixedLevel *l) { return (l->dim + 1) * l->stride; }

/// (C u)_face of the momentum row of axis a at a slot, with its diagonal apart: A u + B^T p.
static inline double lth_mixed_momentum(const LthMixedLevel *l, int a, LitheIndex c,
                                        const double *x) {
  const LitheCount stride = l->stride;
  const double *u = x + a * stride, *p = x + l->dim * stride, per_a = l->per_h[a];
  const LitheIndex low = l->next[2 * a][c], high = l->next[2 * a + 1][c];
  double sum = (2 * l->mu[c] * (u[high] - u[c]) - 2 * l->mu[low] * (u[c] - u[low])) * per_a +
               l->volume[c] * p[c] - l->volume[low] * p[low];
  sum *= -per_a;
  for (int b = 0; b < l->dim; b++) {
    if (b == a) continue;
    const double *v = x + b * stride, *shear = l->shear[3 - a - b], per_b = l->per_h[b];
    const LitheIndex below = l->next[2 * b][c], above = l->next[2 * b + 1][c];
    const LitheIndex side = l->next[2 * a][above];
    double g0 = (u[c] - u[below]) * per_b + (v[c] - v[low]) * per_a;
    double g1 = (u[above] - u[c]) * per_b + (v[above] - v[side]) * per_a;
    sum -= (shear[above] * g1 - shear[c] * g0) * per_b;
  }
  return l->mass[a] ? sum + l->mass[a][c] * u[c] : sum;
}

/// Divergence of the displacement in a cell.
static inline double lth_mixed_divergence(const LthMixedLevel *l, LitheIndex c, const double *x) {
  double sum = 0;
  for (int a = 0; a < l->dim; a++)
    sum += (x[a * l->stride + l->next[2 * a + 1][c]] - x[a * l->stride + c]) * l->per_h[a];
  return sum;
}

/// Diagonal of a momentum row.
double lth_mixed_diagonal(const LthMixedLevel *l, int a, LitheIndex c);

/// r = b - A x in all rows of free unknowns, 0 elsewhere; b NULL: r = -A x.
void lth_mixed_residual(const LthMixedLevel *l, int threads, const double *b, const double *x,
                        double *r);

/// A level of cm M + ck K from its coefficients (those of the mixed form), divided by ck.
LitheStatus lth_mixed_level_create(LitheCtx *ctx, const LthStaggeredLevel *from, double cm,
                                   double ck, bool is_coarse, LthMixedLevel *l);
/// Other masses, and what depends on them.
void lth_mixed_level_update(LitheCtx *ctx, const LthStaggeredLevel *from, double cm, double ck,
                            bool is_coarse, LthMixedLevel *l);
/// Inverses of the boxes, anew: of all, or of those with a face that is marked (per component over slots).
void lth_mixed_invert_boxes(LitheCtx *ctx, LthMixedLevel *l, const double *mark);
/// Springs of a level from l->r, where those that differ are marked then. *changed: some do.
LitheStatus lth_mixed_level_stiffen(LitheCtx *ctx, const LthStaggeredLevel *from, double inertia,
                                    bool is_coarse, LthMixedLevel *l, bool *changed);
/// Who is whose parent, and weights of the interpolation.
LitheStatus lth_mixed_link(LitheCtx *ctx, LthMixedLevel *fine, LthMixedLevel *coarse);
/// Arrays of a level over its grid's slots, with neighbours.
LitheStatus lth_mixed_level_allocate(LitheCtx *ctx, LthMixedLevel *l, bool has_mass);
/// What the smoother needs: who is interior, colors, boxes.
LitheStatus lth_mixed_level_sort(LitheCtx *ctx, LthMixedLevel *l);
void lth_mixed_level_free(LitheCtx *ctx, LthMixedLevel *l);

/// Weights of the interpolation from a coarse level.
void lth_mixed_weigh(LthMixedLevel *fine, const LthMixedLevel *coarse);

/// One sweep over l->x with right-hand side l->b; l->r is scratch.
void lth_mixed_smooth(LthMixedLevel *l, int threads);

/// coarse->b = what is left of the fine level's residual (in fine->r, which is overwritten).
void lth_mixed_restrict(LthMixedLevel *fine, LthMixedLevel *coarse, int threads);
/// fine->x += interpolation of coarse->x.
void lth_mixed_prolong(LthMixedLevel *fine, const LthMixedLevel *coarse, int threads);

/// A direct solver of the coarsest level: l->x from l->b. Too large a level is smoothed.
typedef struct LthMixedCoarse LthMixedCoarse;
LitheStatus lth_mixed_coarse_create(LitheCtx *ctx, const LthMixedLevel *l, LthMixedCoarse **coarse);
LitheStatus lth_mixed_coarse_update(LitheCtx *ctx, LthMixedCoarse *coarse, const LthMixedLevel *l);
void lth_mixed_coarse_destroy(LitheCtx *ctx, LthMixedCoarse **coarse);
LitheStatus lth_mixed_coarse_solve(LitheCtx *ctx, LthMixedCoarse *coarse, LthMixedLevel *l);

typedef struct LthMixedGrid {
  int n_levels;
  LthStaggeredHierarchy *hierarchy;
  LthMixedLevel level[LTH_STAGGERED_MAX_LEVELS];
  int pre, post; ///< sweeps
  LthMixedCoarse *coarse;
} LthMixedGrid;

/// The hierarchy for cm M + ck K.
LitheStatus lth_mixed_grid_create(LitheCtx *ctx, const LthStaggeredLevel *from, double cm,
                                  double ck, LthMixedGrid **grid);
/// The same for other factors; allocates nothing. Where cm is not 0 it must not have been 0 at first.
LitheStatus lth_mixed_grid_update(LitheCtx *ctx, LthMixedGrid *grid, double cm, double ck);
void lth_mixed_grid_destroy(LitheCtx *ctx, LthMixedGrid **grid);
/// Springs on the faces of level 0, from its r [Pa/m^2], and what they make of coarser levels.
LitheStatus lth_mixed_grid_stiffen(LitheCtx *ctx, LthMixedGrid *grid, double inertia);
LitheCount lth_mixed_grid_bytes(const LthMixedGrid *grid);

/// level 0: x = one V-cycle from 0 (or full multigrid) for its b.
LitheStatus lth_mixed_cycle(LitheCtx *ctx, LthMixedGrid *grid, bool full);

/// A part of the operator that the levels do not know (contact): r -= extra x, in rows of free displacements.
typedef struct LthMixedExtra {
  void (*subtract)(const void *self, int threads, const double *x, double *r);
  const void *self;
} LthMixedExtra;

/// When a solve ends: |r| <= tolerance size.
typedef struct LthMixedStop {
  double tolerance, size;
  LitheIndex max_iterations;
  bool full; ///< full multigrid first
  bool
      primal; ///< r is that of the displacements alone, with the pressures that their divergence makes; else of all
              ///< rows, those of the constraint times mu / (V h)
  double stiff; ///< with `primal`: lambda over mu that weighs the divergence where nu = 0.5
} LthMixedStop;

/// Vectors of a solve, those of unknowns and right-hand side among them (as the level's: lth_mixed_size()).
typedef struct LthMixedKrylov LthMixedKrylov;
LitheStatus lth_mixed_krylov_create(LitheCtx *ctx, const LthMixedLevel *l, LthMixedKrylov **krylov);
void lth_mixed_krylov_destroy(LitheCtx *ctx, LthMixedKrylov **krylov);
LitheCount lth_mixed_krylov_bytes(const LthMixedKrylov *krylov);
double *lth_mixed_krylov_x(LthMixedKrylov *krylov);
double *lth_mixed_krylov_b(LthMixedKrylov *krylov);

/// Solve from the x that stands there; allocates at the first `extra` alone, which may be NULL.
LitheStatus lth_mixed_krylov_solve(LitheCtx *ctx, LthMixedKrylov *krylov, LthMixedGrid *grid,
                                   const LthMixedExtra *extra, const LthMixedStop *stop,
                                   LthSolveReport *report);
