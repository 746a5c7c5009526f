/// What has to be true of every sliced mesh, checked without the slicer's own sums.
#pragma once

#include "mesh/mesh.h"
#include "solids.h"

/// Cubic cells of size / n about the middle of the surface.
static inline LthGrid cubic_grid(const LthSurface *s, int n) {
  LthGrid g;
  double lo[3], hi[3], h = 0;
  solid_bounds(s, lo, hi);
  for (int a = 0; a < 3; a++) h = fmax(h, (hi[a] - lo[a]) / n);
  for (int a = 0; a < 3; a++) {
    g.cells[a] = (LitheIndex)ceil((hi[a] - lo[a]) / h - 1e-9);
    g.min[a] = (lo[a] + hi[a] - h * g.cells[a]) / 2;
    g.max[a] = g.min[a] + h * g.cells[a];
  }
  return g;
}

/// Keep the part of a convex polygon with x[axis] < value; returns its number of points.
static inline int clip_below(double (*poly)[3], int n, int axis, double value) {
  double out[16][3];
  int m = 0;
  for (int i = 0; i < n; i++) {
    const double *a = poly[i], *b = poly[(i + 1) % n];
    if (a[axis] < value) memcpy(out[m++], a, sizeof out[0]);
    if ((a[axis] < value) == (b[axis] < value)) continue;
    double t = (value - a[axis]) / (b[axis] - a[axis]);
    for (int k = 0; k < 3; k++) out[m][k] = a[k] + t * (b[k] - a[k]);
    out[m++][axis] = value;
  }
  memcpy(poly, out, (size_t)m * sizeof out[0]);
  return m;
}

/// Volume of the solid below a corner in all three coordinates: cones from that corner over the clipped
/// triangles. The three planes pass through it, so what closes the solid there adds nothing.
static inline double octant_volume(const LthSurface *s, const double corner[3]) {
  double sum = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double poly[16][3];
    int n = 3;
    for (int i = 0; i < 3; i++) lth_v3_sub(s->points + 3 * s->tris[3 * t + i], corner, poly[i]);
    for (int k = 0; k < 3 && n > 0; k++) n = clip_below(poly, n, k, 0);
    for (int i = 1; i + 1 < n; i++) {
      double c[3];
      lth_v3_cross(poly[i], poly[i + 1], c);
      sum += lth_v3_dot(poly[0], c) / 6;
    }
  }
  return sum;
}

/// The elements below every grid corner hold exactly the solid below it. `tolerance` is a share of the
/// volume; the cones' own rounding, that of the cube of their length, comes on top.
static inline void check_cell_volumes(const LthSurface *s, const LthGrid *g, const LthMesh *m,
                                      double tolerance) {
  double lo[3], hi[3], whole = solid_volume(s);
  solid_bounds(s, lo, hi);
  for (LitheIndex k = 1; k <= g->cells[2]; k++)
    for (LitheIndex j = 1; j <= g->cells[1]; j++)
      for (LitheIndex i = 1; i <= g->cells[0]; i++) {
        LitheIndex at[3] = {i, j, k};
        double corner[3], sum = 0;
        for (int a = 0; a < 3; a++)
          corner[a] = at[a] < g->cells[a]
                          ? lth_grid_plane(g, a, at[a])
                          : fmax(lth_grid_plane(g, a, at[a]), hi[a] + (hi[a] - lo[a]));
        for (LitheIndex c = 0; c < m->n_cells; c++) {
          bool is_below = true;
          for (int a = 0; a < 3; a++) is_below &= m->cell_centroid[3 * c + a] < corner[a];
          if (is_below) sum += m->cell_volume[c];
        }
        double reach = fmax(lth_v3_distance(corner, lo), lth_v3_distance(corner, hi));
        CHECK_NEAR(sum, octant_volume(s, corner), tolerance * whole + 1e-15 * pow(reach, 3));
      }
}

/// Every face of the lists once, every inner face in exactly the lists of its two cells.
static inline void check_ownership(const LthMesh *m) {
  LitheIndex *seen = calloc((size_t)m->n_faces + 1, sizeof *seen);
  for (LitheIndex c = 0; c < m->n_cells; c++)
    for (LitheIndex i = m->cell_face_off[c]; i < m->cell_face_off[c + 1]; i++) {
      LitheIndex f = m->cell_face[i];
      assert_true(m->face_cell[2 * f] == c || m->face_cell[2 * f + 1] == c);
      if (i > m->cell_face_off[c]) assert_true(f > m->cell_face[i - 1]);
      seen[f]++;
    }
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    bool is_inner = m->face_cell[2 * f + 1] >= 0;
    assert_int_equal(seen[f], 1 + is_inner);
    assert_true(!is_inner || m->face_cell[2 * f] < m->face_cell[2 * f + 1]);
    assert_true(is_inner == (m->face_tag[f] < 0));
  }
  free(seen);
}

/// Boundary faces have the normal of their triangle, up to rounding over their own area.
static inline void check_tags(const LthSurface *s, const LthMesh *m, double tolerance) {
  double scale = 0;
  for (LitheIndex f = 0; f < m->n_faces; f++) scale = fmax(scale, m->face_area[f]);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_tag[f] < 0) continue;
    const LitheIndex *t = s->tris + 3 * m->face_tag[f];
    double b[3], c[3], n[3];
    lth_v3_sub(s->points + 3 * t[1], s->points + 3 * t[0], b);
    lth_v3_sub(s->points + 3 * t[2], s->points + 3 * t[0], c);
    lth_v3_cross(b, c, n);
    lth_v3_normalize(n);
    CHECK_AT_MOST(m->face_area[f] * (1 - lth_v3_dot(n, m->face_normal + 3 * f)), tolerance * scale);
  }
}

/// All of it. `rounding` is 1 for a solid about the origin, its distance over its size otherwise:
/// coordinates of new points are rounded to the distance's last digits. The volume of a solid that is
/// thin in two directions is known to the rounding of its length cubed.
static inline void check_sliced(LitheCtx *ctx, const LthSurface *s, const LthMesh *m,
                                double rounding) {
  LthMeshQuality q;
  double volume = solid_volume(s), area = solid_area(s), tolerance = 1e-12 * rounding, lo[3], hi[3];
  solid_bounds(s, lo, hi);
  CHECK_OK(ctx, lth_mesh_quality(ctx, m, &q));
  CHECK_NEAR(q.volume, volume,
             tolerance * volume + 1e-15 * rounding * pow(lth_v3_distance(lo, hi), 3));
  CHECK_NEAR(q.surface_area, area, tolerance * area);
  CHECK_AT_MOST(q.max_gap, 1e-12);
  assert_true(q.min_volume > 0);
  check_ownership(m);
  check_tags(s, m, tolerance);
  assert_int_equal(m->n_surface_points, s->n_points);
  assert_memory_equal(m->points, s->points, sizeof(double) * 3 * (size_t)s->n_points);
}
