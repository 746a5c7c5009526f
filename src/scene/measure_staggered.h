/// Figures of staggered bodies, cell by cell, for measure.c and measure_error.c.
#pragma once

#include "scene/measure.h"
#include "scene/staggered_body.h"

/// Largest |u| at middles of cells and at their corners in the material into *max; += its integral.
LitheStatus lth_measure_grid_displacement(LitheCtx *ctx, const LthBody *body, double *max,
                                          double *integral);

/// von Mises stress at the middle of each cell that is at least half full (of each, where none is), NaN at others.
/// (n_cells), freed by the caller.
LitheStatus lth_measure_grid_stress(LitheCtx *ctx, const LthBody *body, double **von_mises);

/// reaction (n_constraints x 3) += forces of the constraints on the body, from the imbalance of all forces [N].
LitheStatus lth_add_grid_reactions(LitheCtx *ctx, const LthBody *body, const double *imbalance,
                                   double *reaction);

/// Fraction of a cell as the shape fills it: 0 on held sides beyond the surface.
double lth_grid_cell_fraction(const LthBody *body, LitheIndex cell);

/// Add the sums and maxima of one body: displacements at free unknowns inside the shape, each component for itself,
/// gradients and stresses at middles of cells.
void lth_measure_grid_error(const LthBody *body, LthErrorFigures *sum);

// measure_error.c

/// The scene's exact displacement at a place and time, and its gradient [a][b] by central differences over `h`.
void lth_exact_displacement(const LthScene *scene, const double x[3], double t, double u[3]);
void lth_exact_gradient(const LthScene *scene, const double x[3], double t, double h, double g[9]);

/// Square of the norm of stress (xx yy zz yz zx xy) less the scene's exact one; in 2D of its components in the plane.
double lth_stress_error2(const LthScene *scene, const double x[3], double t,
                         const double stress[6]);
