/// Shape functions of all element kinds on their reference elements, and rules to integrate them.
#pragma once

#include "mesh/element_mesh.h"

/// The kind of an element with the places of its nodes, in VTK's order. Reference elements: hexahedra
/// [-1, 1]^3, tetrahedra r, s, t >= 0, r + s + t <= 1, wedges such a triangle times [-1, 1], pyramids |r|,
/// |s| <= 1 - t, 0 <= t <= 1.
typedef struct LthCgKind {
  LthElementKind kind;
  const LthElementShape *shape;
  int n;                                 ///< nodes
  double node[LTH_ELEMENT_MAX_NODES][3]; ///< reference coordinates
  double center[3];
} LthCgKind;

void lth_cg_kind_init(LthElementKind kind, LthCgKind *out);

/// Values (n) and gradients with respect to the reference coordinates (n x 3) of all shape functions at xi.
void lth_cg_shape(const LthCgKind *kind, const double xi[3], double *phi, double *dphi);

/// Move xi to the nearest place of the reference element along the coordinates; true where it was outside.
bool lth_cg_clamp(const LthCgKind *kind, double xi[3]);

#define LTH_CG_MAX_POINTS 64

/// A quadrature rule on a reference element.
typedef struct LthCgRule {
  int n;
  double xi[LTH_CG_MAX_POINTS][3], weight[LTH_CG_MAX_POINTS];
} LthCgRule;

/// The rule that the stiffness of a kind is known by: tet4 1, tet10 4, hex8 2x2x2, hex20 and hex27 3x3x3,
/// wedge6 3x2, wedge15 3x3, wedge18 3x3x3, pyramid5 2x2x2, pyramid13 and 14 3x3x3 points. `reduced`: hex20
/// 2x2x2 and wedge6 2 points, which have zero-energy modes of their own; hex8 keeps its points.
void lth_cg_stiffness_rule(LthElementKind kind, bool reduced, LthCgRule *rule);

/// A rule that is exact for products of two shape functions on affine elements.
void lth_cg_mass_rule(LthElementKind kind, LthCgRule *rule);

/// Points of the unit square [0, 1]^2 or of the triangle a, b >= 0, a + b <= 1.
typedef struct LthCgPlaneRule {
  int n;
  double at[LTH_CG_MAX_POINTS][2], weight[LTH_CG_MAX_POINTS];
} LthCgPlaneRule;

/// Gauss points, `order` a direction, at most 8; the triangle (3 corners) in collapsed coordinates.
void lth_cg_plane_rule(int n_corners, int order, LthCgPlaneRule *rule);

/// A rule on a face: places in the reference element, and the edge vectors there of the face's own
/// coordinates a, b; mapped to space their cross product is the outward area vector.
typedef struct LthCgFaceRule {
  int n;
  double xi[LTH_CG_MAX_POINTS][3], a[LTH_CG_MAX_POINTS][3], b[LTH_CG_MAX_POINTS][3],
      weight[LTH_CG_MAX_POINTS];
} LthCgFaceRule;

/// `corner` (n_corners of them, 3 or 4) are corner nodes of one face, counter-clockwise from outside: the
/// whole face, or three of a quadrilateral that is split.
void lth_cg_face_rule(const LthCgKind *kind, int n_corners, const int8_t *corner,
                      const LthCgPlaneRule *plane, LthCgFaceRule *rule);
