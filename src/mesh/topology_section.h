/// Where a plane passes through a cell: outlines to choose cells by, not to build with.
#pragma once

#include "mesh/topology.h"

/// Segments in which the faces of a cell meet a plane, in no order. Zero-initialised it is empty and usable.
typedef struct LthSection {
  LitheIndex n;
  double *ends;  ///< both ends of each [m]                                (n x 6)
  double *along; ///< scratch
  LitheCount ends_cap, along_cap;
} LthSection;

void lth_section_free(LitheCtx *ctx, LthSection *section);

/// Corners in the plane count as above it: a face in the plane has no segments.
LitheStatus lth_topology_section(LitheCtx *ctx, const LthTopology *topology, LitheIndex cell,
                                 const LthPlane *plane, LthSection *section);

/// A point inside a cell: its centroid where that is, else one near a face.
void lth_topology_inner_point(const LthTopology *topology, LitheIndex cell, double x[3]);
