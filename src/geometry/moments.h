/// Exact moments of monomials over planar polygons and polyhedra by the divergence theorem.
/// Kaufmann et al. 2009, section 5 and Appendix A; here as a recursion on homogeneous degree
/// (docs/theory/integration.md).
#pragma once

#include "base/ctx.h"

#define LTH_MOMENT_MAX_DEGREE 12

/// Number of monomials of degree <= p in 3 and 2 variables.
static inline int lth_monomials3(int p) { return (p + 1) * (p + 2) * (p + 3) / 6; }
static inline int lth_monomials2(int p) { return (p + 1) * (p + 2) / 2; }

/// Exponents of monomial q in graded order: degree 0, then 1 (x, y, z), then 2 (xx, xy, xz, yy, yz, zz) ...
/// Rows of three, valid for every degree up to LTH_MOMENT_MAX_DEGREE.
const int (*lth_monomial3_exponents(void))[3];
/// Graded order in two variables: 1, s, t, ss, st, tt, ...
const int (*lth_monomial2_exponents(void))[2];
/// Position of an exponent in those orders.
int lth_monomial3_index(int a, int b, int c);
int lth_monomial2_index(int a, int b);

/// Values of the monomials at xi in that order (lth_monomials3(p)).
void lth_monomials3_eval(int p, const double xi[3], double *values);

/// A planar face as loops of points: outer loops counter-clockwise about `normal`, holes clockwise.
typedef struct LthFaceView {
  const double *points;       ///< (any x 3)
  const LitheIndex *loop_off; ///< (n_loops + 1) starts in loop_point
  const LitheIndex *loop_point;
  LitheIndex n_loops;
  const double *normal; ///< unit
} LthFaceView;

/// The fan of triangles of a face about its first point. Signed about the normal they add up to the face, also
/// where it is not convex or has holes; edges that touch the first point have no triangle.
typedef struct LthFan {
  const LthFaceView *face;
  LitheIndex loop, edge;
} LthFan;

static inline LthFan lth_fan(const LthFaceView *face) {
  return (LthFan){face, 0, face->loop_off[0]};
}

/// Corners of the next triangle, as rows of `points`; false at the end.
static inline bool lth_fan_next(LthFan *fan, LitheIndex corner[3]) {
  const LthFaceView *face = fan->face;
  corner[0] = face->loop_point[face->loop_off[0]];
  for (; fan->loop < face->n_loops; fan->loop++)
    while (fan->edge < face->loop_off[fan->loop + 1]) {
      LitheIndex k = fan->edge++;
      corner[1] = face->loop_point[k];
      corner[2] =
          face->loop_point[fan->edge < face->loop_off[fan->loop + 1] ? fan->edge
                                                                     : face->loop_off[fan->loop]];
      if (corner[1] != corner[0] && corner[2] != corner[0]) return true;
    }
  return false;
}

/// Add to `moments` (lth_monomials3(p)) the contribution sign * this face to the moments
/// int_K xi^alpha dV, xi_i = (x_i - center_i) / scale_i, of the polyhedron it bounds; sign +1 where
/// `normal` points out of K. Summed over all faces of a closed K: exact to rounding, [m^3].
void lth_moments_add_face(int p, const double center[3], const double scale[3],
                          const LthFaceView *face, double sign, double *moments);

/// Add the moments int_f xi^alpha dA of a face in the same coordinates, [m^2] (lth_monomials3(p)).
void lth_moments_add_face_area(int p, const double center[3], const double scale[3],
                               const LthFaceView *face, double *moments);

/// Orthonormal frame of a face: t1, t2 with t1 x t2 = normal.
void lth_face_frame(const double normal[3], double t1[3], double t2[3]);

/// Area [m^2] and centroid of a face (area about its first point; holes subtract).
double lth_face_area_centroid(const LthFaceView *face, double centroid[3]);

/// Moments int_f s^i t^j dA (lth_monomials2(p), [m^2]), x = origin + h (s t1 + t t2).
void lth_face_moments(int p, const double origin[3], const double t1[3], const double t2[3],
                      double h, const LthFaceView *face, double *moments);

/// Squared distance from x to a face: to its plane where x lies above it, else to its edges [m^2].
double lth_face_distance2(const LthFaceView *face, const double x[3]);
