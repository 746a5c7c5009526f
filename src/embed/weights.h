/// Weights of samples at embedded points, by moving least squares or mean value coordinates.
#pragma once

#include "embed/samples.h"
#include "embed/visibility.h"

/// A row under construction: samples and weights, in any order until it is sorted.
typedef struct LthWeightRow {
  LitheIndex *sample;
  double *weight;
  LitheCount cap, weight_cap;
  LitheIndex n;
  bool is_plain; ///< by moving least squares with the radii that the samples have
} LthWeightRow;

LitheStatus lth_row_add(LitheCtx *ctx, LthWeightRow *row, LitheIndex sample, double weight);

/// Sort a row by sample; equal samples keep their order.
void lth_row_sort(LthWeightRow *row);

/// What the rows of all points share; read by many threads.
typedef struct LthMls {
  const LthMesh *mesh;
  const LthSampleSet *samples;
  LitheIndex *neighbor_off, *neighbor; ///< cells behind the faces of a cell  (n_cells + 1)
  double *cell_radius;                 ///< largest radius of a cell's samples (n_cells)
  // where cuts end inside the body; else empty
  LthVisibility sight;
  double *cell_front;    ///< distance of a cell's box to the nearest front, or less (n_cells)
  double *sample_inside; ///< places of the samples, a little to the middle of their cells (n x 3)
  double largest_radius; ///< of all samples
} LthMls;

LitheStatus lth_mls_create(LitheCtx *ctx, const LthMesh *mesh, const LthSampleSet *samples,
                           LthMls *mls);
void lth_mls_free(LitheCtx *ctx, LthMls *mls);

/// Scratch of one thread.
typedef struct LthMlsScratch {
  LitheIndex *cell_mark, *sample_mark, *queue, *candidate;
  double *theta;
  LitheIndex stamp;
  // of the point in hand, where a front is near
  double inside[3];  ///< the point, a little to the middle of its cell
  double front;      ///< how far the nearest front is, or less
  LthHiders hiders;  ///< seen from the point
  LthSight sight;    ///< from the point, where edges are not few
  double *way;       ///< to samples; negative: not looked for, INFINITY: none below way_limit (n)
  double *way_limit; ///< up to what a way was looked for that is not straight                 (n)
  LitheIndex *way_sample, n_ways; ///< which of them have been looked for
} LthMlsScratch;

LitheStatus lth_mls_scratch_create(LitheCtx *ctx, const LthMls *mls, LthMlsScratch *scratch);
void lth_mls_scratch_free(LitheCtx *ctx, LthMlsScratch *scratch);

/// Moving least squares weights at x of the samples that can be reached from `cell` through faces within
/// their radii, around the ends of cuts (eq. 31). Empty row: no set of samples that spans space, however far the radii were grown.
LitheStatus lth_mls_weights(LitheCtx *ctx, const LthMls *mls, LthMlsScratch *scratch,
                            const double x[3], LitheIndex cell, LthWeightRow *row);

/// Rows to be taken from an embedding of before (embedding_rows.c).
typedef struct LthKeptRows {
  const LthEmbeddingRows *from;
  LthEmbeddingRows *to;
  LitheIndex *sample; ///< of now for each of before, -1
  bool *is_kept;      ///< (n_points)
} LthKeptRows;

/// Which rows of `e`, that has its points and their cells, are those of *rows (NULL: none of before).
LitheStatus lth_kept_rows_find(LitheCtx *ctx, const LthMls *mls, const LthEmbedding *e,
                               const LitheIndex *cell_record, const LthEmbeddingRows *rows,
                               LthKeptRows *kept);
LitheStatus lth_kept_rows_take(LitheCtx *ctx, const LthKeptRows *kept, LitheIndex point,
                               LthWeightRow *row);
void lth_kept_rows_note(LthKeptRows *kept, LitheIndex point, const LthWeightRow *row);
/// Remember the rows of a finished embedding, in the place of *rows.
LitheStatus lth_kept_rows_finish(LitheCtx *ctx, LthKeptRows *kept, const LthEmbedding *e,
                                 LthEmbeddingRows **rows);
void lth_kept_rows_free(LitheCtx *ctx, LthKeptRows *kept);

/// Mean value coordinates at x of the points of `cell` (Ju, Schaefer, Warren 2005) with every face as a
/// signed fan; corrected to linear precision. Empty row: none found.
LitheStatus lth_mean_value_weights(LitheCtx *ctx, const LthMesh *mesh, const LthSampleSet *points,
                                   const double x[3], LitheIndex cell, LthWeightRow *row);

/// Affine correction: weights *= 1 + g . (x_i - c), so that sum w_i = 1 and sum w_i x_i = x to rounding,
/// the moments taken with |w_i|. Does nothing where the samples do not span space.
void lth_row_make_linear(const LthSampleSet *samples, const double x[3], LthWeightRow *row);

/// Cell of every point of an embedding that has its rest places: as given, or searched where that is negative.
LitheStatus lth_embedding_find_cells(LitheCtx *ctx, LthEmbedding *e, const LitheIndex *point_cell);

/// Solution of S g = d by eigenvalues of the symmetric S, those below 1e-6 of the largest cut off. Returns
/// the ratio of the largest to the smallest, INFINITY where one was cut.
double lth_pseudo_solve(const double S[9], const double d[3], double g[3]);
