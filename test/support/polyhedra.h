/// Small polyhedra with known moments for tests, and an independent integrator for them.
#pragma once

#include "base/tensor.h"
#include "geometry/moments.h"

#include <math.h>
#include <string.h>

#define TEST_SOLID_POINTS 64
#define TEST_SOLID_LOOPS 64
#define TEST_SOLID_CORNERS 256

/// A closed solid as faces of loops, all of which are seen counter-clockwise from outside (holes cw).
typedef struct TestSolid {
  int n_points, n_faces;
  double points[3 * TEST_SOLID_POINTS];
  LitheIndex face_loop_off[TEST_SOLID_LOOPS + 1];
  LitheIndex loop_off[TEST_SOLID_LOOPS + 1];
  LitheIndex loop_point[TEST_SOLID_CORNERS];
  double normal[3 * TEST_SOLID_LOOPS];
} TestSolid;

static inline int test_add_point(TestSolid *s, double x, double y, double z) {
  double p[3] = {x, y, z};
  memcpy(s->points + 3 * s->n_points, p, sizeof p);
  return s->n_points++;
}

/// Add a loop to the last face, or start a new face with it.
static inline void test_add_loop(TestSolid *s, bool new_face, int n, const int *corners) {
  if (new_face) {
    s->face_loop_off[s->n_faces + 1] = s->face_loop_off[s->n_faces];
    s->n_faces++;
  }
  LitheIndex loop = s->face_loop_off[s->n_faces]++;
  for (int k = 0; k < n; k++) s->loop_point[s->loop_off[loop] + k] = corners[k];
  s->loop_off[loop + 1] = s->loop_off[loop] + n;
}

static inline LthFaceView test_face(const TestSolid *s, int f) {
  LitheIndex first = s->face_loop_off[f];
  return (LthFaceView){.points = s->points,
                       .loop_off = s->loop_off + first,
                       .loop_point = s->loop_point,
                       .n_loops = s->face_loop_off[f + 1] - first,
                       .normal = s->normal + 3 * f};
}

/// Normals from vector areas; call once the solid is complete or has moved.
static inline void test_finish(TestSolid *s) {
  for (int f = 0; f < s->n_faces; f++) {
    LthFaceView face = test_face(s, f);
    const double *x0 = s->points + 3 * face.loop_point[face.loop_off[0]];
    double area[3] = {0};
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++) {
        LitheIndex next = k + 1 < face.loop_off[l + 1] ? k + 1 : face.loop_off[l];
        double u[3], v[3], w[3];
        lth_v3_sub(s->points + 3 * face.loop_point[k], x0, u);
        lth_v3_sub(s->points + 3 * face.loop_point[next], x0, v);
        lth_v3_cross(u, v, w);
        lth_v3_add(area, w, area);
      }
    lth_v3_normalize(area);
    memcpy(s->normal + 3 * f, area, sizeof area);
  }
}

/// The prism of a polygon (n x 2, ccw) with optional hole (m x 2, ccw) between z0 and z1.
static inline void test_prism(TestSolid *s, int n, const double *polygon, int m, const double *hole,
                              double z0, double z1) {
  memset(s, 0, sizeof *s);
  for (int k = 0; k < n; k++) test_add_point(s, polygon[2 * k], polygon[2 * k + 1], z0);
  for (int k = 0; k < n; k++) test_add_point(s, polygon[2 * k], polygon[2 * k + 1], z1);
  for (int k = 0; k < m; k++) test_add_point(s, hole[2 * k], hole[2 * k + 1], z0);
  for (int k = 0; k < m; k++) test_add_point(s, hole[2 * k], hole[2 * k + 1], z1);
  int top[32], bottom[32];
  for (int k = 0; k < n; k++) bottom[k] = n - 1 - k, top[k] = n + k;
  test_add_loop(s, true, n, bottom);
  for (int k = 0; k < m; k++) bottom[k] = 2 * n + k;
  if (m) test_add_loop(s, false, m, bottom);
  test_add_loop(s, true, n, top);
  for (int k = 0; k < m; k++) top[k] = 2 * n + 2 * m - 1 - k;
  if (m) test_add_loop(s, false, m, top);
  for (int k = 0; k < n; k++) {
    int next = (k + 1) % n, side[4] = {k, next, n + next, n + k};
    test_add_loop(s, true, 4, side);
  }
  for (int k = 0; k < m; k++) {
    int next = (k + 1) % m, a = 2 * n;
    int side[4] = {a + next, a + k, a + m + k, a + m + next};
    test_add_loop(s, true, 4, side);
  }
  test_finish(s);
}

static inline void test_box(TestSolid *s, const double min[3], const double max[3]) {
  double square[8] = {min[0], min[1], max[0], min[1], max[0], max[1], min[0], max[1]};
  test_prism(s, 4, square, 0, NULL, min[2], max[2]);
}

/// A tetrahedron of four points, positive where 3 sees 0 1 2 clockwise (the unit simplex is).
static inline void test_tetrahedron(TestSolid *s, const double points[12]) {
  static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  memset(s, 0, sizeof *s);
  for (int k = 0; k < 4; k++)
    test_add_point(s, points[3 * k], points[3 * k + 1], points[3 * k + 2]);
  for (int f = 0; f < 4; f++) test_add_loop(s, true, 3, faces[f]);
  test_finish(s);
}

/// x -> A x + b for all points.
static inline void test_transform(TestSolid *s, const double A[9], const double b[3]) {
  for (int k = 0; k < s->n_points; k++) {
    double y[3];
    lth_m3_apply(A, s->points + 3 * k, y);
    lth_v3_add(y, b, s->points + 3 * k);
  }
  test_finish(s);
}

/// A rotation by `angle` about a (not unit) axis.
static inline void test_axis_rotation(const double axis[3], double angle, double R[9]) {
  double n[3] = {axis[0], axis[1], axis[2]};
  lth_v3_normalize(n);
  double c = cos(angle), s = sin(angle);
  double cross[9] = {0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      R[3 * i + j] = (i == j) * c + (1 - c) * n[i] * n[j] + s * cross[3 * i + j];
}

/// All moments of a solid.
static inline void test_moments(const TestSolid *s, int p, const double center[3],
                                const double scale[3], double *moments) {
  memset(moments, 0, sizeof(double) * (size_t)lth_monomials3(p));
  for (int f = 0; f < s->n_faces; f++) {
    LthFaceView face = test_face(s, f);
    lth_moments_add_face(p, center, scale, &face, 1, moments);
  }
}

/// Gauss-Legendre points on [0, 1] in long double by Newton's method.
static inline void test_gauss(int n, long double *x, long double *w) {
  for (int k = 0; k < n; k++) {
    long double t = cosl(3.14159265358979323846L * (k + 0.75L) / (n + 0.5L)), d = 1;
    for (int it = 0; it < 20; it++) {
      long double p0 = 1, p1 = t;
      for (int j = 2; j <= n; j++) {
        long double p2 = ((2 * j - 1) * t * p1 - (j - 1) * p0) / j;
        p0 = p1, p1 = p2;
      }
      d = n * (t * p1 - p0) / (t * t - 1);
      t -= p1 / d;
    }
    x[k] = (1 - t) / 2;
    w[k] = 1 / ((1 - t * t) * d * d);
  }
}

/// int over a solid of xi^e by signed tetrahedra from `center` and a conical Gauss rule, all in long
/// double: nothing in common with the recursion. Exact up to degree 13.
static inline double test_oracle(const TestSolid *s, const double center[3], const double scale[3],
                                 const int e[3]) {
  enum { N = 8 };
  long double x[N], w[N], total = 0;
  test_gauss(N, x, w);
  for (int f = 0; f < s->n_faces; f++) {
    LthFaceView face = test_face(s, f);
    LitheIndex base = face.loop_point[face.loop_off[0]];
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++) {
        LitheIndex next = k + 1 < face.loop_off[l + 1] ? k + 1 : face.loop_off[l];
        LitheIndex corner[3] = {base, face.loop_point[k], face.loop_point[next]};
        long double v[3][3];
        for (int c = 0; c < 3; c++)
          for (int i = 0; i < 3; i++)
            v[c][i] = ((long double)s->points[3 * corner[c] + i] - center[i]) / scale[i];
        long double det = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) -
                          v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                          v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        long double part = 0;
        for (int a = 0; a < N; a++)
          for (int b = 0; b < N; b++)
            for (int c = 0; c < N; c++) {
              long double r = x[a], t = x[b], value = w[a] * w[b] * w[c] * r * r * t;
              long double l1 = r * t * (1 - x[c]), l2 = r * t * x[c], l0 = r * (1 - t);
              for (int i = 0; i < 3; i++)
                for (int j = 0; j < e[i]; j++) value *= l0 * v[0][i] + l1 * v[1][i] + l2 * v[2][i];
              part += value;
            }
        total += det * part;
      }
  }
  return (double)(total * scale[0] * scale[1] * scale[2]);
}
