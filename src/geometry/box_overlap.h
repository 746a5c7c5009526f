/// How much of a box is inside a shape for which there is a closed form, or nearly so.
#pragma once

#include "geometry/shape.h"

/// Volume of the box from low to high that is inside a shape without children [m^3]. Exact to rounding for boxes,
/// else to 1e-12 of small boxes, 1e-9 of those a tenth as large as the radius. False: there is no such form.
bool lth_box_overlap(const LthShape *shape, const double low[3], const double high[3],
                     double *volume);

/// Share of a box with half lengths `half` below the plane at the signed distance d from its middle, with unit
/// normal n (inside is where the normal does not point).
double lth_box_overlap_plane(const double half[3], const double n[3], double d);
