/// A surface that follows a discontinuous body: sparse weights from coefficients to points.
/// Kaufmann et al. 2009, section 7, eqs (30) to (32), with docs/theory/embedding.md.
#pragma once

#include "disc/dg/dg_space.h"

typedef enum LthInterpolation { LTH_EMBED_MLS, LTH_EMBED_STITCHED } LthInterpolation;
typedef enum LthSamples { LTH_SAMPLE_NODES, LTH_SAMPLE_EDGES, LTH_SAMPLE_FACES, LTH_SAMPLE_CELLS } LthSamples;

/// displacement(v) = sum over e in [off[v], off[v + 1]) of weight[e] * u[func[e]]  (eq. 32, W_a)
typedef struct LthEmbedding {
  LitheIndex n_points;
  double *rest;       ///< rest positions [m]                     (n_points x 3)
  LitheCount *off;    ///< (n_points + 1)
  LitheIndex *func;   ///< basis function of the space, ascending per point
  double *weight;     ///< [-]
  LitheIndex *cell;   ///< cell that holds (or is nearest to) the point (n_points)
  double *area;       ///< share of the surface's area of each point [m^2], or NULL (n_points)
} LthEmbedding;

/// Embed points (n x 3) [m]. `point_cell` (n) gives the cell of a point where known, -1 or NULL: it is
/// searched (the nearest cell if none contains the point). Weights reproduce linear fields to rounding;
/// no point is left without support. Nodes act only on cells connected to theirs through faces.
LitheStatus lth_embedding_create(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                                 const double *points, const LitheIndex *point_cell,
                                 LthInterpolation interpolation, LthSamples samples,
                                 LthEmbedding **embedding);
void lth_embedding_destroy(LitheCtx *ctx, LthEmbedding **embedding);

/// Deformed positions (n_points x 3) = rest + W (x - X0); all cores, same bits for any number.
/// `u` is x - X0 as coefficients.
void lth_embedding_apply(const LthEmbedding *e, int threads, const double *u, double *positions);

/// Value W u of one point (displacement or velocity).
void lth_embedding_point(const LthEmbedding *e, LitheIndex point, const double *u, double value[3]);

/// f += W^T force of one point.
void lth_embedding_add_force(const LthEmbedding *e, LitheIndex point, const double force[3], double *f);

/// The cell that contains a point, or the nearest one; `inside` may be NULL.
LitheStatus lth_find_cell(LitheCtx *ctx, const LthMesh *mesh, const double x[3], LitheIndex *cell,
                          bool *inside);

/// Cell of each surface point of a sliced mesh (n_surface_points), from the boundary faces around it.
LitheStatus lth_surface_point_cells(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *cells);
