/// A surface that follows a discontinuous body: sparse weights from coefficients to points.
/// Kaufmann et al. 2009, section 7, eqs (30) to (32), with docs/theory/embedding.md.
#pragma once

#include "disc/dg/dg_space.h"
#include "disc/disc.h"

typedef enum LthInterpolation { LTH_EMBED_MLS, LTH_EMBED_STITCHED } LthInterpolation;
typedef enum LthSamples {
  LTH_SAMPLE_NODES, ///< mesh points on two or three grid planes
  LTH_SAMPLE_EDGES, ///< and middles of the edges between them
  LTH_SAMPLE_FACES, ///< and centroids of inner faces
  LTH_SAMPLE_CELLS  ///< and centroids of elements
} LthSamples;

/// displacement(v) = sum over e in [off[v], off[v + 1]) of weight[e] * s(sample[e]), where
/// s(i) = sum over e in [sample_off[i], sample_off[i + 1]) of sample_weight[e] * u[sample_func[e]]
/// is the average (eq. 30) of the elements around sample i. The product of the two is W of eq. 32; kept
/// apart they take a quarter to a tenth of its memory and time. Immutable but for the scratch of lth_embedding_apply().
typedef struct LthEmbedding {
  const LthMesh *mesh; ///< borrowed for life
  LitheIndex n_funcs, n_rows;
  const LitheIndex *row_func; ///< of the discretisation, borrowed for life      (n_rows + 1)
  LitheIndex n_points, n_samples;
  double *rest;               ///< rest positions [m]                     (n_points x 3)
  LitheCount *off;            ///< (n_points + 1)
  LitheIndex *sample;         ///< ascending per point
  double *weight;             ///< [-]
  double *sample_point;       ///< [m]                                    (n_samples x 3)
  LitheCount *sample_off;     ///< (n_samples + 1)
  LitheIndex *sample_func;    ///< functions of the discretisation, ascending per sample
  double *sample_weight;      ///< [-]; sample_width for each function
  int sample_width;           ///< 1, or 3: components have weights of their own
  LitheCount *sample_row_off; ///< (n_samples + 1)
  LitheIndex *sample_row;     ///< block rows whose functions a sample reads, all of them, ascending
  LitheIndex *cell;           ///< cell that holds (or is nearest to) the point (n_points)
  double *area;         ///< share of the surface's area of each point [m^2], or NULL (n_points)
  double *sample_value; ///< scratch of lth_embedding_apply()       (n_samples x 4)
  LitheIndex n_own;     ///< points that follow their element's own polynomial for want of samples
} LthEmbedding;

/// Embed points (n x 3) [m]. `point_cell` (n) gives the cell of a point where known, -1 or NULL: it is
/// searched (the nearest cell if none contains the point). Weights reproduce linear fields to rounding;
/// no point is left without support. Samples act only on cells connected to theirs through faces.
LitheStatus lth_embedding_create(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                                 const double *points, const LitheIndex *point_cell,
                                 LthInterpolation interpolation, LthSamples samples,
                                 LthEmbedding **embedding);
void lth_embedding_destroy(LitheCtx *ctx, LthEmbedding **embedding);

/// What the rows of an embedding were made from, kept to find those that a change of elements leaves as they are.
typedef struct LthEmbeddingRows LthEmbeddingRows;

/// The same after a change of elements, bit by bit, but rows of points whose surroundings are what they were are taken from
/// `*rows`. That is NULL the first time, and from then on what this call leaves; the caller frees it. `cell_record`
/// (n_cells): numbers of cells that stay the same from one mesh to the next, unless the cell is another one. Points
/// keep their numbers; new ones come behind.
LitheStatus lth_embedding_renew(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                                const double *points, const LitheIndex *point_cell,
                                LthInterpolation interpolation, LthSamples samples,
                                const LitheIndex *cell_record, LthEmbeddingRows **rows,
                                LthEmbedding **embedding);
void lth_embedding_rows_destroy(LitheCtx *ctx, LthEmbeddingRows **rows);

/// Rows of the last lth_embedding_renew() that were taken from before.
LitheIndex lth_embedding_rows_kept(const LthEmbeddingRows *rows);

/// Weights of entry e of a sample: v[a] += weight of component a times u[a].
static inline void lth_sample_add(const LthEmbedding *e, LitheCount entry, const double u[3],
                                  double v[3]) {
  const double *w = e->sample_weight + entry * e->sample_width;
  const int step = e->sample_width == 3;
  v[0] += w[0] * u[0];
  v[1] += w[step] * u[1];
  v[2] += w[2 * step] * u[2];
}

/// Embed points in a continuous discretisation: they follow the functions of their cell, in the notation
/// above with one sample for every function, or, where components have functions of their own, one for every point.
LitheStatus lth_embedding_create_direct(LitheCtx *ctx, const LthDisc *disc, LitheIndex n,
                                        const double *points, const LitheIndex *point_cell,
                                        LthEmbedding **embedding);

/// Embed points of a dg body that follow the mean of the given cells, ascending: those of point p are
/// cells[cell_off[p]] up to cell_off[p + 1]. Nothing else acts on them.
LitheStatus lth_embedding_create_average(LitheCtx *ctx, const LthDisc *disc,
                                         const LthDgSpace *space, LitheIndex n,
                                         const double *points, const LitheIndex *cell_off,
                                         const LitheIndex *cells, LthEmbedding **embedding);

/// Embed the coarse nodes of the boundary, points of the mesh on two or three grid planes, each with its
/// share of the boundary's area. The points of `surface` (with areas; NULL: none) follow behind; each kind
/// then stands for half of the area. `space`: of a dg body; NULL: the points follow `disc` directly.
LitheStatus lth_embedding_create_nodes(LitheCtx *ctx, const LthDisc *disc, const LthDgSpace *space,
                                       const LthEmbedding *surface, LthEmbedding **embedding);

/// Share the rest area of polygons of embedded points evenly among the points of each: what contact
/// multiplies its stiffness by. Polygon i is poly_point[poly_off[i]] up to poly_off[i + 1].
LitheStatus lth_embedding_set_area(LitheCtx *ctx, LthEmbedding *e, LitheIndex n_polys,
                                   const LitheIndex *poly_off, const LitheIndex *poly_point);

/// Deformed positions (n_points x 3) = rest + W (x - X0); all cores, same bits for any number.
/// `u` is x - X0 as coefficients. One call at a time on an embedding.
void lth_embedding_apply(const LthEmbedding *e, int threads, const double *u, double *positions);

/// Averages of a field (coefficients) at the samples, rows of four: x, y, z, 0.  (n_samples x 4)
void lth_embedding_sample(const LthEmbedding *e, int threads, const double *coef, double *values);

/// Value at a point from the averages of lth_embedding_sample().
void lth_embedding_from_samples(const LthEmbedding *e, LitheIndex point, const double *values,
                                double value[3]);

/// Value W u of one point (displacement or velocity).
void lth_embedding_point(const LthEmbedding *e, LitheIndex point, const double *u, double value[3]);

/// f += W^T force of one point.
void lth_embedding_add_force(const LthEmbedding *e, LitheIndex point, const double force[3],
                             double *f);

/// W of one point, as in eq. 32, of the first component: weights (n_funcs), zero where the point does not reach.
void lth_embedding_weights(const LthEmbedding *e, LitheIndex point, double *weights);

/// The cell that contains a point, or the nearest one; `inside` may be NULL. Looks at every cell: for
/// many points make an LthCellSearch.
LitheStatus lth_find_cell(LitheCtx *ctx, const LthMesh *mesh, const double x[3], LitheIndex *cell,
                          bool *inside);

/// The same of a discretisation, which may have cells of its own.
LitheStatus lth_disc_find_cell(LitheCtx *ctx, const LthDisc *disc, const double x[3],
                               LitheIndex *cell, bool *inside);

/// Cell of each surface point of a sliced mesh (n_surface_points), from the boundary faces around it;
/// the lowest of several, -1 where no face has the point.
LitheStatus lth_surface_point_cells(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *cells);
