/// Samples of a discontinuous field: points where the elements around them are averaged (eq. 30).
#pragma once

#include "embed/embedding.h"

typedef struct LthSampleSet {
  LitheIndex n;
  double *point;        ///< [m]                                        (n x 3)
  double *radius;       ///< of the weight function [m]                 (n)
  LitheCount *cell_off; ///< (n + 1)
  LitheIndex *
      cell; ///< N(i): elements whose closure holds the sample and that hang together there, ascending
  LitheCount *of_cell_off; ///< (n_cells + 1) samples of each element, ascending
  LitheIndex *of_cell;
  LitheIndex *of_point; ///< (first) sample of a mesh point, -1: none   (mesh->n_points)
  bool *is_parted; ///< a cut runs through the point: it has a sample for each side (mesh->n_points)
  LitheCount point_cap, cell_off_cap, cell_cap;
} LthSampleSet;

/// Coarse nodes, and what `samples` adds; elements whose nodes do not span space get seven of their own
/// (centroid, and the centroid moved by half the box along each axis).
LitheStatus lth_samples_create(LitheCtx *ctx, const LthMesh *mesh, LthSamples samples,
                               LthSampleSet **set);

/// All mesh points, for interpolation inside elements.
LitheStatus lth_samples_create_points(LitheCtx *ctx, const LthMesh *mesh, LthSampleSet **set);

/// Sample at a mesh point of the side of a cut that `cell`, one around the point, is on; -1: none.
LitheIndex lth_samples_at(const LthSampleSet *set, LitheIndex point, LitheIndex cell);

/// Add a sample that averages `cells` (ascending); of_cell and radius are not kept up.
LitheStatus lth_samples_add(LitheCtx *ctx, LthSampleSet *set, const double x[3], LitheIndex n_cells,
                            const LitheIndex *cells);

void lth_samples_destroy(LitheCtx *ctx, LthSampleSet **set);
