/// Frames of flat cells, from their second moments, and moments in them.
///
/// Along a box, a plate of thickness t is a sum of moments that cancel to t^2, and to t^2k for degree k. In a frame
/// whose axes are those of the plate nothing cancels. Its second moments come out to rounding of the frame that they
/// are taken in, and so the frame is found in a few passes, each of which gains six digits: first with the corners, for the
/// volume of a needle is rounding until the frame is nearly its own.
#include "disc/dg/dg_frame.h"

#include "base/eigen.h"
#include "base/tensor.h"

#define PASSES 8
/// Smallest variance over the largest that a pass believes in.
#define BELIEF 1e-13

static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

static void to_frame(const double *x, const double center[3], const double axes[9], double xi[3]) {
  double d[3];
  lth_v3_sub(x, center, d);
  lth_m3_apply(axes, d, xi);
}

/// A triangle in a frame.
typedef struct FrameTriangle {
  double xi[9], normal[3];
  double stretch; ///< area in space over that in the frame
} FrameTriangle;

static double twice_area(const double *a, const double *b, const double *c, double normal[3]) {
  double u[3], v[3];
  lth_v3_sub(b, a, u);
  lth_v3_sub(c, a, v);
  lth_v3_cross(u, v, normal);
  return lth_v3_norm(normal);
}

static FrameTriangle triangle_of(const LthFaceView *face, const LitheIndex corner[3],
                                 const double center[3], const double axes[9]) {
  FrameTriangle t;
  const double *x[3];
  double w[3];
  for (int i = 0; i < 3; i++) {
    x[i] = face->points + 3 * (LitheCount)corner[i];
    to_frame(x[i], center, axes, t.xi + 3 * i);
  }
  double area = twice_area(x[0], x[1], x[2], w);
  double local = twice_area(t.xi, t.xi + 3, t.xi + 6, t.normal);
  t.stretch = local > 0 ? copysign(area / local, lth_v3_dot(w, face->normal)) : 0;
  lth_v3_normalize(t.normal);
  return t;
}

static LthFaceView view_of(const FrameTriangle *t) {
  static const LitheIndex loop_off[2] = {0, 3}, loop_point[3] = {0, 1, 2};
  return (LthFaceView){t->xi, loop_off, loop_point, 1, t->normal};
}

void lth_dg_frame_moments(const LthMesh *mesh, LitheIndex cell, int p, const double center[3],
                          const double axes[9], double *moments) {
  double volume = 1 / fabs(lth_m3_det(axes)), turn = copysign(1, lth_m3_det(axes));
  int n = lth_monomials3(p);
  memset(moments, 0, sizeof *moments * (size_t)n);
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    double side = turn * lth_mesh_side(mesh, mesh->cell_face[c], cell);
    LitheIndex corner[3];
    for (LthFan fan = lth_fan(&face); lth_fan_next(&fan, corner);) {
      FrameTriangle t = triangle_of(&face, corner, center, axes);
      LthFaceView view = view_of(&t);
      lth_moments_add_face(p, zero, one, &view, side, moments);
    }
  }
  for (int q = 0; q < n; q++) moments[q] *= volume;
}

void lth_dg_frame_area_moments(const LthMesh *mesh, LitheIndex cell, int p, const double center[3],
                               const double axes[9], double *moments) {
  int n = lth_monomials3(p);
  memset(moments, 0, sizeof *moments * (size_t)n);
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    LitheIndex corner[3];
    for (LthFan fan = lth_fan(&face); lth_fan_next(&fan, corner);) {
      double part[(LTH_MOMENT_MAX_DEGREE + 1) * (LTH_MOMENT_MAX_DEGREE + 2) *
                  (LTH_MOMENT_MAX_DEGREE + 3) / 6] = {0};
      FrameTriangle t = triangle_of(&face, corner, center, axes);
      LthFaceView view = view_of(&t);
      lth_moments_add_face_area(p, zero, one, &view, part);
      for (int q = 0; q < n; q++) moments[q] += t.stretch * part[q];
    }
  }
}

/// Middle and covariance of the corners in a frame. It is a sum of squares, which no needle makes negative.
static bool measure_corners(const LthMesh *mesh, LitheIndex cell, const double center[3],
                            const double axes[9], double mean[3], double C[9]) {
  double n = 0, sum[3] = {0}, square[9] = {0};
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    for (LitheIndex i = face.loop_off[0]; i < face.loop_off[face.n_loops]; i++, n++) {
      double xi[3];
      to_frame(face.points + 3 * (LitheCount)face.loop_point[i], center, axes, xi);
      lth_v3_add(sum, xi, sum);
      for (int k = 0; k < 9; k++) square[k] += xi[k / 3] * xi[k % 3];
    }
  }
  for (int i = 0; i < 3; i++) mean[i] = sum[i] / n;
  for (int i = 0; i < 9; i++) C[i] = square[i] / n - mean[i / 3] * mean[i % 3];
  return true;
}

/// Centroid and covariance of the cell; false where there is no volume.
static bool measure_cell(const LthMesh *mesh, LitheIndex cell, const double center[3],
                         const double axes[9], double mean[3], double C[9]) {
  static const int second[9] = {4, 5, 6, 5, 7, 8, 6, 8, 9};
  double moment[10];
  lth_dg_frame_moments(mesh, cell, 2, center, axes, moment);
  if (!(moment[0] > 0)) return false;
  for (int i = 0; i < 3; i++) mean[i] = moment[1 + i] / moment[0];
  for (int i = 0; i < 9; i++) C[i] = moment[second[i]] / moment[0] - mean[i / 3] * mean[i % 3];
  return true;
}

static void move_center(const double axes[9], const double mean[3], double center[3]) {
  double inverse[9], shift[3];
  lth_m3_inverse(axes, inverse);
  lth_m3_apply(inverse, mean, shift);
  lth_v3_add(center, shift, center);
}

/// Axes along the vectors V (columns), so that variances become those of a box of half edges 1: 1/3.
static void turn_axes(const double variance[3], const double V[9], double axes[9]) {
  double turned[9] = {0};
  for (int j = 0; j < 3; j++) {
    double size = sqrt(3 * fmax(variance[j], BELIEF * variance[2]));
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++) turned[3 * j + i] += V[3 * k + j] * axes[3 * k + i] / size;
  }
  memcpy(axes, turned, sizeof turned);
}

typedef bool (*MeasureFn)(const LthMesh *mesh, LitheIndex cell, const double center[3],
                          const double axes[9], double mean[3], double C[9]);

/// Turn and stretch until a measure's second moments are balanced; false where they never are.
static bool balance(const LthMesh *mesh, LitheIndex cell, MeasureFn measure, double center[3],
                    double axes[9]) {
  for (int pass = 0; pass < PASSES; pass++) {
    double mean[3], C[9], variance[3], V[9];
    if (!measure(mesh, cell, center, axes, mean, C)) return false;
    move_center(axes, mean, center);
    lth_symmetric_eigen(3, C, variance, V);
    if (!(variance[2] > 0)) return false;
    bool is_balanced = variance[0] * LTH_DG_FRAME_BALANCE >= variance[2];
    if (is_balanced && lth_v3_norm(mean) < 0.1) return true;
    turn_axes(variance, V, axes);
  }
  return false;
}

bool lth_dg_frame_fit(const LthMesh *mesh, LitheIndex cell, double center[3], double axes[9]) {
  return balance(mesh, cell, measure_corners, center, axes) &&
         balance(mesh, cell, measure_cell, center, axes);
}
