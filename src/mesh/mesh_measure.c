/// Areas, normals, centroids, volumes and boxes of a mesh, by fans of triangles and tetrahedra.
#include "mesh/mesh_measure.h"

#include "base/tensor.h"

/// Up to this many faces, waking threads costs more than it saves.
#define SERIAL 4096

void lth_mesh_area_vector(const LthFaceView *face, double n[3]) {
  const double *o = face->points + 3 * face->loop_point[face->loop_off[0]];
  n[0] = n[1] = n[2] = 0;
  LitheIndex t[3];
  for (LthFan fan = lth_fan(face); lth_fan_next(&fan, t);) {
    double a[3], b[3], c[3];
    lth_v3_sub(face->points + 3 * t[1], o, a);
    lth_v3_sub(face->points + 3 * t[2], o, b);
    lth_v3_cross(a, b, c);
    lth_v3_add(n, c, n);
  }
}

/// Sum over the fan of area times (centroid - first point), times 6.
static void area_moment(const LthFaceView *face, const double normal[3], double m[3]) {
  const double *o = face->points + 3 * face->loop_point[face->loop_off[0]];
  m[0] = m[1] = m[2] = 0;
  LitheIndex t[3];
  for (LthFan fan = lth_fan(face); lth_fan_next(&fan, t);) {
    double a[3], b[3], c[3];
    lth_v3_sub(face->points + 3 * t[1], o, a);
    lth_v3_sub(face->points + 3 * t[2], o, b);
    lth_v3_cross(a, b, c);
    double w = lth_v3_dot(c, normal);
    lth_v3_axpy(w, a, m);
    lth_v3_axpy(w, b, m);
  }
}

LitheStatus lth_mesh_measure_faces(LitheCtx *ctx, LthMesh *m) {
  LTH_NEW(ctx, m->face_normal, 3 * (LitheCount)m->n_faces);
  LTH_NEW(ctx, m->face_area, m->n_faces);
  LTH_NEW(ctx, m->face_centroid, 3 * (LitheCount)m->n_faces);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) if (m->n_faces > SERIAL)
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    LthFaceView face = lth_mesh_face(m, f);
    double *n = m->face_normal + 3 * f, moment[3];
    lth_mesh_area_vector(&face, n);
    double twice = lth_v3_normalize(n);
    m->face_area[f] = twice / 2;
    area_moment(&face, n, moment);
    lth_v3_copy(face.points + 3 * face.loop_point[face.loop_off[0]], m->face_centroid + 3 * f);
    if (twice > 0) lth_v3_axpy(1 / (3 * twice), moment, m->face_centroid + 3 * f);
  }
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (!(m->face_area[f] > 0))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "mesh: face %d of cell %d has no area", f,
                 m->face_cell[2 * f]);
  return LITHE_OK;
}

static void cell_bounds(const LthMesh *m, LitheIndex c, double box[6]) {
  for (int i = 0; i < 3; i++) box[i] = INFINITY, box[3 + i] = -INFINITY;
  for (LitheIndex k = m->cell_face_off[c]; k < m->cell_face_off[c + 1]; k++) {
    LitheIndex f = m->cell_face[k];
    LitheIndex first = m->loop_off[m->face_loop_off[f]],
               last = m->loop_off[m->face_loop_off[f + 1]];
    for (LitheIndex j = first; j < last; j++)
      for (int i = 0; i < 3; i++) {
        double x = m->points[3 * m->loop_point[j] + i];
        if (x < box[i]) box[i] = x;
        if (x > box[3 + i]) box[3 + i] = x;
      }
  }
}

void lth_mesh_add_cone(const LthFaceView *face, double sign, const double o[3], double *volume,
                       double moment[3]) {
  double p[3];
  lth_v3_sub(face->points + 3 * face->loop_point[face->loop_off[0]], o, p);
  for (LitheIndex l = 0; l < face->n_loops; l++) {
    LitheIndex first = face->loop_off[l], last = face->loop_off[l + 1];
    for (LitheIndex i = first; i < last; i++) {
      double a[3], b[3], c[3];
      lth_v3_sub(face->points + 3 * face->loop_point[i], o, a);
      lth_v3_sub(face->points + 3 * face->loop_point[i + 1 < last ? i + 1 : first], o, b);
      lth_v3_cross_sharp(a, b, c);
      double w = sign * lth_v3_dot(p, c);
      *volume += w;
      for (int d = 0; d < 3; d++) moment[d] += w * (p[d] + a[d] + b[d]);
    }
  }
}

LitheStatus lth_mesh_measure_cells(LitheCtx *ctx, LthMesh *m) {
  LTH_NEW(ctx, m->cell_volume, m->n_cells);
  LTH_NEW(ctx, m->cell_centroid, 3 * (LitheCount)m->n_cells);
  LTH_NEW(ctx, m->cell_box, 6 * (LitheCount)m->n_cells);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) if (m->n_faces > SERIAL)
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    double *box = m->cell_box + 6 * c, *x = m->cell_centroid + 3 * c;
    double volume = 0, moment[3] = {0, 0, 0};
    cell_bounds(m, c, box);
    for (int i = 0; i < 3; i++) x[i] = box[i] + 0.5 * (box[3 + i] - box[i]);
    for (LitheIndex k = m->cell_face_off[c]; k < m->cell_face_off[c + 1]; k++) {
      LthFaceView face = lth_mesh_face(m, m->cell_face[k]);
      lth_mesh_add_cone(&face, lth_mesh_side(m, m->cell_face[k], c), x, &volume, moment);
    }
    m->cell_volume[c] = volume / 6;
    if (volume > 0) lth_v3_axpy(1 / (4 * volume), moment, x);
  }
  return LITHE_OK;
}

double lth_mesh_cell_gap(const LthMesh *m, LitheIndex c, double *area) {
  double sum[3] = {0, 0, 0};
  for (LitheIndex k = m->cell_face_off[c]; k < m->cell_face_off[c + 1]; k++) {
    LitheIndex f = m->cell_face[k];
    lth_v3_axpy(lth_mesh_side(m, f, c) * m->face_area[f], m->face_normal + 3 * f, sum);
    *area += m->face_area[f];
  }
  return lth_v3_norm(sum);
}
