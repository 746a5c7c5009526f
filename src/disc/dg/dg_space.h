/// Discontinuous polynomials on polyhedra: an orthogonal basis per cell, and its evaluation.
#pragma once

#include "geometry/quadrature.h"
#include "mesh/mesh.h"

#define LTH_DG_MAX_DEGREE 4
#define LTH_DG_MAX_FUNCS 35 ///< lth_monomials3(LTH_DG_MAX_DEGREE)

/// Basis of cell K: phi_i = sum_{q <= i} basis[i][q] m_q(xi), xi = axes (x - center), m_q the graded
/// monomials, orthogonalised so that int_K phi_i phi_j = |K| delta_ij and phi_0 = 1. The first four
/// span the linear functions. Axes are those of space, over half edges of the bounding box, or the cell's own
/// where it is flat across them (dg_frame.h). An unknown vector holds, for function i of cell K and component a,
/// x[3 * (func_off[K] + i) + a] [m]: position coefficients (x), displacement (u) or velocity (v).
typedef struct LthDgSpace {
  const LthMesh *mesh; ///< borrowed for life
  LitheIndex n_cells, n_funcs;
  LitheCount n_dofs; ///< 3 n_funcs
  int max_degree;
  uint8_t *degree;        ///< (n_cells)
  LitheIndex *func_off;   ///< (n_cells + 1)
  double *center;         ///< centroid [m]                              (n_cells x 3)
  double *axes;           ///< to local coordinates, row-major [1/m]     (n_cells x 9)
  double **basis;         ///< nb x nb lower-triangular rows of each cell, row-major full squares
  double *basis_block;    ///< memory of these where no store has them, else NULL
  double *mean_gradient;  ///< mean of grad phi_i over the cell [1/m]    (n_funcs x 3)
  double *trace_constant; ///< C_K [1/m]: int_dK p^2 <= C_K int_K p^2, p of degree k - 1 (n_cells)
} LthDgSpace;

/// Build for the same degree everywhere (1 to 4), or `cell_degree` (n_cells) where not NULL.
/// Cost linear in faces; both cores. LITHE_BAD_INPUT: a cell without thickness but for rounding (names it).
LitheStatus lth_dg_space_create(LitheCtx *ctx, const LthMesh *mesh, int degree,
                                const uint8_t *cell_degree, LthDgSpace **space);

/// The same with the bases that records of a topology have in a store (dg_store.h): those it knows are taken from there, others
/// are built and put in. `space` lives no longer than its bases do there.
typedef struct LthDgRecords LthDgRecords;
LitheStatus lth_dg_space_create_kept(LitheCtx *ctx, const LthMesh *mesh, int degree,
                                     const uint8_t *cell_degree, const LthDgRecords *records,
                                     LthDgSpace **space);

/// Cells of two other spaces with the bases they have there: cell i is cell of[i] of spaces[from[i]]. `mesh`
/// (borrowed for life) has these cells.
LitheStatus lth_dg_space_gather(LitheCtx *ctx, const LthMesh *mesh, const LthDgSpace *const *spaces,
                                const uint8_t *from, const LitheIndex *of, LthDgSpace **space);
void lth_dg_space_destroy(LitheCtx *ctx, LthDgSpace **space);

static inline int lth_dg_funcs(const LthDgSpace *s, LitheIndex cell) {
  return s->func_off[cell + 1] - s->func_off[cell];
}

/// Values phi_i(x) of a cell's functions; x may lie outside the cell.
void lth_dg_eval(const LthDgSpace *space, LitheIndex cell, const double x[3], double *phi);

/// Gradients (nb x 3) [1/m].
void lth_dg_eval_gradient(const LthDgSpace *space, LitheIndex cell, const double x[3],
                          double *dphi);

/// Coefficients of the map x -> x (the rest positions X0): four per cell, others zero. (n_dofs)
void lth_dg_rest(const LthDgSpace *space, double *x0);

/// Value of a vector field (position, displacement, velocity) at a point of a cell.
void lth_dg_sample(const LthDgSpace *space, LitheIndex cell, const double *coef, const double x[3],
                   double value[3]);

/// Gradient d value_a / d x_b of a vector field, row-major [a][b].
void lth_dg_sample_gradient(const LthDgSpace *space, LitheIndex cell, const double *coef,
                            const double x[3], double gradient[9]);

/// Mean gradient over the cell (for F-bar), by exact moments.
void lth_dg_mean_gradient(const LthDgSpace *space, LitheIndex cell, const double *coef,
                          double gradient[9]);

/// L2 projection of a field onto the space: sets coef (n_dofs). Exact for polynomials of the degree;
/// quadrature over signed tetrahedra of degree `quad_degree` (at least twice the cell's) otherwise.
/// `field` must be safe to call from many threads.
LitheStatus lth_dg_project(LitheCtx *ctx, const LthDgSpace *space,
                           void (*field)(const void *self, const double x[3], double value[3]),
                           const void *self, int quad_degree, double *coef);

/// Visit the points of a rule over a cell: signed tetrahedra from its centroid to the fans of its faces.
typedef void (*LthDgPointFn)(void *self, const double x[3], double weight);
void lth_dg_visit_cell(const LthSimplexRule *rule, const LthMesh *mesh, LitheIndex cell,
                       LthDgPointFn visit, void *self);

/// Quadrature over a cell: signed tetrahedra from its centroid to its faces' triangles; exact for
/// polynomials of `degree`. Caller frees points (n x 3) and weights (n) [m^3].
LitheStatus lth_dg_cell_quadrature(LitheCtx *ctx, const LthMesh *mesh, LitheIndex cell, int degree,
                                   LitheIndex *n, double **points, double **weights);
