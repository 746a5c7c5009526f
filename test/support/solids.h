/// Closed triangle surfaces for tests: boxes, unions of cubes, spheres, tori, shells, prisms; moved,
/// turned and put together. Free them with solid_free().
#pragma once

#include "base/tensor.h"
#include "check.h"
#include "geometry/surface.h"

#include <string.h>

static inline void solid_free(LitheCtx *ctx, LthSurface **surface) {
  if (!*surface) return;
  void *blocks[] = {(*surface)->points,   (*surface)->tris,       (*surface)->tri_shell,
                    (*surface)->tri_poly, (*surface)->soup_point, *surface};
  for (int i = 0; i < 6; i++) lth_free(ctx, blocks[i]);
  *surface = NULL;
}

/// A surface with room for the given numbers; fill points and tris.
static inline LthSurface *solid_new(LitheCtx *ctx, LitheIndex n_points, LitheIndex n_tris) {
  LthSurface *s = lth_alloc(ctx, 1, sizeof *s);
  s->n_points = s->n_soup_points = n_points;
  s->n_tris = n_tris;
  s->n_shells = 1;
  s->points = lth_alloc(ctx, 3 * (LitheCount)n_points, sizeof *s->points);
  s->tris = lth_alloc(ctx, 3 * (LitheCount)n_tris, sizeof *s->tris);
  s->tri_shell = lth_alloc(ctx, n_tris, sizeof *s->tri_shell);
  s->tri_poly = lth_alloc(ctx, n_tris, sizeof *s->tri_poly);
  s->soup_point = lth_alloc(ctx, n_points, sizeof *s->soup_point);
  for (LitheIndex i = 0; i < n_points; i++) s->soup_point[i] = i;
  for (LitheIndex i = 0; i < n_tris; i++) s->tri_poly[i] = i;
  return s;
}

/// x -> R (scale x) + shift, in place.
static inline LthSurface *solid_move(LthSurface *s, const double R[9], double scale,
                                     const double shift[3]) {
  for (LitheIndex i = 0; i < s->n_points; i++) {
    double x[3], y[3];
    for (int k = 0; k < 3; k++) x[k] = scale * s->points[3 * i + k];
    if (R)
      lth_m3_apply(R, x, y);
    else
      lth_v3_copy(x, y);
    for (int k = 0; k < 3; k++) s->points[3 * i + k] = y[k] + (shift ? shift[k] : 0);
  }
  return s;
}

/// Scale along the axes, in place.
static inline LthSurface *solid_stretch(LthSurface *s, double x, double y, double z) {
  double f[3] = {x, y, z};
  for (LitheIndex i = 0; i < 3 * s->n_points; i++) s->points[i] *= f[i % 3];
  return s;
}

/// Rotation by angle about an axis.
static inline void solid_rotation(double ax, double ay, double az, double angle, double R[9]) {
  double n[3] = {ax, ay, az}, c = cos(angle), s = sin(angle);
  lth_v3_normalize(n);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) R[3 * i + j] = (1 - c) * n[i] * n[j] + (i == j) * c;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    R[3 * k + j] += s * n[i];
    R[3 * j + k] -= s * n[i];
  }
}

static inline LthSurface *solid_flip(LthSurface *s) {
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    LitheIndex swap = s->tris[3 * t];
    s->tris[3 * t] = s->tris[3 * t + 1];
    s->tris[3 * t + 1] = swap;
  }
  return s;
}

/// Both surfaces as one; frees the two.
static inline LthSurface *solid_join(LitheCtx *ctx, LthSurface *a, LthSurface *b) {
  LthSurface *s = solid_new(ctx, a->n_points + b->n_points, a->n_tris + b->n_tris);
  memcpy(s->points, a->points, sizeof(double) * 3 * (size_t)a->n_points);
  memcpy(s->points + 3 * a->n_points, b->points, sizeof(double) * 3 * (size_t)b->n_points);
  memcpy(s->tris, a->tris, sizeof(LitheIndex) * 3 * (size_t)a->n_tris);
  for (LitheIndex i = 0; i < 3 * b->n_tris; i++)
    s->tris[3 * a->n_tris + i] = b->tris[i] + a->n_points;
  s->n_shells = a->n_shells + b->n_shells;
  for (LitheIndex i = 0; i < a->n_tris; i++) s->tri_shell[i] = a->tri_shell[i];
  for (LitheIndex i = 0; i < b->n_tris; i++)
    s->tri_shell[a->n_tris + i] = a->n_shells + b->tri_shell[i];
  solid_free(ctx, &a);
  solid_free(ctx, &b);
  return s;
}

/// The boundary of the cubes [i, i+1] x [j, j+1] x [k, k+1] where full[i + nx (j + ny k)]; faces of
/// neighbouring cubes vanish, corners are shared, quads are split along alternating diagonals.
static inline LthSurface *solid_cubes(LitheCtx *ctx, const char *full, int nx, int ny, int nz) {
  int n[3] = {nx, ny, nz};
  LitheIndex n_corners = (nx + 1) * (ny + 1) * (nz + 1), n_points = 0, n_tris = 0;
  LitheIndex *index = calloc((size_t)n_corners, sizeof *index);
  LitheIndex *tris = calloc((size_t)(36 * nx * ny * nz), sizeof *tris);
  for (LitheIndex i = 0; i < n_corners; i++) index[i] = -1;
  for (int c = 0; c < nx * ny * nz; c++) {
    int at[3] = {c % nx, c / nx % ny, c / nx / ny};
    if (!full[c]) continue;
    for (int f = 0; f < 6; f++) {
      int axis = f / 2, up = f % 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
      int next[3] = {at[0], at[1], at[2]};
      next[axis] += up ? 1 : -1;
      bool is_in = next[axis] >= 0 && next[axis] < n[axis];
      if (is_in && full[next[0] + nx * (next[1] + ny * next[2])]) continue;
      LitheIndex q[4];
      for (int i = 0; i < 4; i++) {
        int x[3] = {at[0], at[1], at[2]};
        x[axis] += up;
        x[u] += i == 1 || i == 2;
        x[v] += i >= 2;
        q[up ? i : 3 - i] = x[0] + (nx + 1) * (x[1] + (ny + 1) * x[2]);
      }
      int d = (at[0] + at[1] + at[2]) % 2;
      LitheIndex six[6] = {q[d], q[1 + d], q[2 + d], q[d], q[2 + d], q[(3 + d) % 4]};
      memcpy(tris + 3 * n_tris, six, sizeof six);
      n_tris += 2;
    }
  }
  for (LitheIndex i = 0; i < 3 * n_tris; i++)
    if (index[tris[i]] < 0) index[tris[i]] = n_points++;
  LthSurface *s = solid_new(ctx, n_points, n_tris);
  for (LitheIndex i = 0; i < n_corners; i++) {
    if (index[i] < 0) continue;
    double x[3] = {i % (nx + 1), (double)(i / (nx + 1) % (ny + 1)),
                   (double)(i / (nx + 1) / (ny + 1))};
    lth_v3_copy(x, s->points + 3 * index[i]);
  }
  for (LitheIndex i = 0; i < 3 * n_tris; i++) s->tris[i] = index[tris[i]];
  free(index);
  free(tris);
  return s;
}

static inline LthSurface *solid_box(LitheCtx *ctx, const double min[3], const double max[3]) {
  LthSurface *s = solid_cubes(ctx, "\1", 1, 1, 1);
  for (LitheIndex i = 0; i < 3 * s->n_points; i++)
    s->points[i] = s->points[i] > 0 ? max[i % 3] : min[i % 3];
  return s;
}

/// Unit sphere from an octahedron whose faces are divided into n x n triangles.
static inline LthSurface *solid_sphere(LitheCtx *ctx, int n) {
  LitheIndex n_points = 4 * n * n + 2;
  LthSurface *s = solid_new(ctx, n_points, 8 * n * n);
  // rings from the north pole down; ring r has 4 min(r, 2n - r) points, the poles one
  LitheIndex *ring = calloc((size_t)(2 * n + 2), sizeof *ring), t = 0;
  for (int r = 0; r <= 2 * n; r++) {
    int m = r < n ? r : 2 * n - r, count = m > 0 ? 4 * m : 1;
    ring[r + 1] = ring[r] + count;
    for (int i = 0; i < count; i++) {
      int side = m > 0 ? i / m : 0, k = m > 0 ? i % m : 0;
      double a = m - k, b = k, x[3] = {0, 0, n - r};
      double c[4][2] = {{a, b}, {-b, a}, {-a, -b}, {b, -a}};
      x[0] = c[side][0], x[1] = c[side][1];
      lth_v3_normalize(x);
      lth_v3_copy(x, s->points + 3 * (ring[r] + i));
    }
  }
  for (int r = 0; r < 2 * n; r++) {
    int a = r < n ? r : 2 * n - r, b = r + 1 < n ? r + 1 : 2 * n - r - 1;
    int na = a > 0 ? 4 * a : 1, nb = b > 0 ? 4 * b : 1, big = a > b ? a : b;
    for (int side = 0; side < 4; side++)
      for (int k = 0; k < big; k++) {
        LitheIndex p = ring[r] + (side * a + k) % na, p1 = ring[r] + (side * a + k + 1) % na;
        LitheIndex q = ring[r + 1] + (side * b + k) % nb,
                   q1 = ring[r + 1] + (side * b + k + 1) % nb;
        if (b > a) {
          LitheIndex tri[3] = {p, q, q1};
          memcpy(s->tris + 3 * t++, tri, sizeof tri);
          if (k < a) {
            LitheIndex more[3] = {p, q1, p1};
            memcpy(s->tris + 3 * t++, more, sizeof more);
          }
        } else {
          LitheIndex tri[3] = {p, q, p1};
          memcpy(s->tris + 3 * t++, tri, sizeof tri);
          if (k < b) {
            LitheIndex more[3] = {q, q1, p1};
            memcpy(s->tris + 3 * t++, more, sizeof more);
          }
        }
      }
  }
  free(ring);
  return s;
}

/// Torus about the z axis with radii R and r, n x m quads.
static inline LthSurface *solid_torus(LitheCtx *ctx, double R, double r, int n, int m) {
  LthSurface *s = solid_new(ctx, n * m, 2 * n * m);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < m; j++) {
      double a = 2 * M_PI * i / n, b = 2 * M_PI * j / m, *x = s->points + 3 * (i * m + j);
      x[0] = (R + r * cos(b)) * cos(a);
      x[1] = (R + r * cos(b)) * sin(a);
      x[2] = r * sin(b);
      LitheIndex p = i * m + j, q = (i + 1) % n * m + j, p1 = i * m + (j + 1) % m,
                 q1 = (i + 1) % n * m + (j + 1) % m;
      LitheIndex six[6] = {p, q, q1, p, q1, p1};
      memcpy(s->tris + 6 * (i * m + j), six, sizeof six);
    }
  return s;
}

/// Prism of height h over a polygon (n x 2) that is star-shaped about the origin, counter-clockwise;
/// its ends are fans about the axis.
static inline LthSurface *solid_prism(LitheCtx *ctx, const double *polygon, int n, double h) {
  LthSurface *s = solid_new(ctx, 2 * n + 2, 4 * n);
  for (int i = 0; i < 2 * n; i++) {
    s->points[3 * i] = polygon[2 * (i % n)];
    s->points[3 * i + 1] = polygon[2 * (i % n) + 1];
    s->points[3 * i + 2] = i < n ? 0 : h;
  }
  s->points[3 * (2 * n + 1) + 2] = h;
  for (int i = 0; i < n; i++) {
    LitheIndex a = i, b = (i + 1) % n, c = a + n, d = b + n;
    LitheIndex tris[12] = {a, b, d, a, d, c, b, a, 2 * n, c, d, 2 * n + 1};
    memcpy(s->tris + 12 * i, tris, sizeof tris);
  }
  return s;
}

/// Prism over a star with n spikes between the radii inner and outer.
static inline LthSurface *solid_star(LitheCtx *ctx, int n, double inner, double outer, double h) {
  double polygon[256];
  for (int i = 0; i < 2 * n; i++) {
    double r = i % 2 ? inner : outer;
    polygon[2 * i] = r * cos(M_PI * i / n);
    polygon[2 * i + 1] = r * sin(M_PI * i / n);
  }
  return solid_prism(ctx, polygon, 2 * n, h);
}

/// Volume (about the first point) and area by plain sums.
static inline double solid_volume(const LthSurface *s) {
  double sum = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double a[3], b[3], c[3], n[3];
    lth_v3_sub(s->points + 3 * s->tris[3 * t], s->points, a);
    lth_v3_sub(s->points + 3 * s->tris[3 * t + 1], s->points, b);
    lth_v3_sub(s->points + 3 * s->tris[3 * t + 2], s->points, c);
    lth_v3_cross(b, c, n);
    sum += lth_v3_dot(a, n) / 6;
  }
  return sum;
}

static inline double solid_area(const LthSurface *s) {
  double sum = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double b[3], c[3], n[3];
    lth_v3_sub(s->points + 3 * s->tris[3 * t + 1], s->points + 3 * s->tris[3 * t], b);
    lth_v3_sub(s->points + 3 * s->tris[3 * t + 2], s->points + 3 * s->tris[3 * t], c);
    lth_v3_cross(b, c, n);
    sum += lth_v3_norm(n) / 2;
  }
  return sum;
}

static inline void solid_bounds(const LthSurface *s, double min[3], double max[3]) {
  for (int k = 0; k < 3; k++) min[k] = INFINITY, max[k] = -INFINITY;
  for (LitheIndex i = 0; i < 3 * s->n_points; i++) {
    min[i % 3] = fmin(min[i % 3], s->points[i]);
    max[i % 3] = fmax(max[i % 3], s->points[i]);
  }
}
