/// Mean value coordinates of polyhedra (Ju, Schaefer and Warren 2005), every face a signed fan.
#include "base/tensor.h"
#include "embed/weights.h"
#include "geometry/bvh.h"

#define ON_POINT 1e-12 ///< of the cell's size: x is the point itself
#define FLAT 1e-10     ///< sine below which x lies in a triangle's plane

/// x against one triangle: unit directions and distances to its corners.
typedef struct View {
  double u[3][3], r[3];
} View;

/// Weights of a triangle's corners: w with sum w_k (p_k - x) = the mean of directions over the solid
/// angle it takes (so that over a closed surface sum w (p - x) = 0). False where x lies in its plane.
static bool triangle_weights(const View *v, double w[3]) {
  double mean[3] = {0, 0, 0}, normal[3][3];
  for (int k = 0; k < 3; k++) {
    const double *a = v->u[(k + 1) % 3], *b = v->u[(k + 2) % 3];
    lth_v3_cross(a, b, normal[k]);
    double sine = lth_v3_normalize(normal[k]), angle = atan2(sine, lth_v3_dot(a, b));
    lth_v3_axpy(0.5 * angle, normal[k], mean);
    if (!(sine > FLAT)) return false;
  }
  for (int k = 0; k < 3; k++) {
    double height = lth_v3_dot(normal[k], v->u[k]);
    if (!(fabs(height) > FLAT)) return false;
    w[k] = lth_v3_dot(normal[k], mean) / (height * v->r[k]);
  }
  return true;
}

/// Where x lies on the triangle itself: its barycentric coordinates there.
static bool on_triangle(const double *p[3], const double x[3], double size, double w[3]) {
  double closest[3], n[3], t[3], a[3], b[3];
  lth_closest_on_triangle(p[0], p[1], p[2], x, closest);
  if (!(lth_v3_distance(closest, x) <= ON_POINT * size)) return false;
  lth_v3_sub(p[1], p[0], a);
  lth_v3_sub(p[2], p[0], b);
  lth_v3_cross(a, b, n);
  double nn = lth_v3_dot(n, n);
  if (!(nn > 0)) return false;
  for (int k = 0; k < 3; k++) {
    lth_v3_sub(p[(k + 1) % 3], closest, a);
    lth_v3_sub(p[(k + 2) % 3], closest, b);
    lth_v3_cross(a, b, t);
    w[k] = lth_v3_dot(t, n) / nn;
  }
  return true;
}

/// Sort a row and sum the weights of equal samples.
static void merge_row(LthWeightRow *row) {
  LitheIndex n = 0;
  lth_row_sort(row);
  for (LitheIndex i = 0; i < row->n; i++) {
    if (n > 0 && row->sample[n - 1] == row->sample[i]) {
      row->weight[n - 1] += row->weight[i];
    } else {
      row->sample[n] = row->sample[i];
      row->weight[n++] = row->weight[i];
    }
  }
  row->n = n;
}

/// Add one triangle of a face; `done` where x lies on it and the row is complete.
static LitheStatus add_triangle(LitheCtx *ctx, const LthMesh *m, const LthSampleSet *s,
                                const LitheIndex tri[3], LitheIndex cell, double side,
                                const double x[3], double size, LthWeightRow *row, bool *done) {
  const double *p[3];
  double w[3];
  View v;
  for (int k = 0; k < 3; k++) {
    p[k] = m->points + 3 * (size_t)tri[k];
    lth_v3_sub(p[k], x, v.u[k]);
    v.r[k] = lth_v3_normalize(v.u[k]);
  }
  *done = on_triangle(p, x, size, w);
  if (*done) row->n = 0, side = 1;
  if (!*done && !triangle_weights(&v, w)) return LITHE_OK;
  for (int k = 0; k < 3; k++)
    LITHE_TRY(lth_row_add(ctx, row, lth_samples_at(s, tri[k], cell), side * w[k]));
  return LITHE_OK;
}

static LitheStatus add_face(LitheCtx *ctx, const LthMesh *m, const LthSampleSet *s, LitheIndex face,
                            LitheIndex cell, double side, const double x[3], double size,
                            LthWeightRow *row, bool *done) {
  for (LitheIndex l = m->face_loop_off[face]; l < m->face_loop_off[face + 1]; l++)
    for (LitheIndex i = m->loop_off[l] + 1; i + 1 < m->loop_off[l + 1] && !*done; i++) {
      LitheIndex tri[3] = {m->loop_point[m->loop_off[l]], m->loop_point[i], m->loop_point[i + 1]};
      LITHE_TRY(add_triangle(ctx, m, s, tri, cell, side, x, size, row, done));
    }
  return LITHE_OK;
}

LitheStatus lth_mean_value_weights(LitheCtx *ctx, const LthMesh *m, const LthSampleSet *s,
                                   const double x[3], LitheIndex cell, LthWeightRow *row) {
  const double *box = m->cell_box + 6 * (size_t)cell;
  double size = fmax(box[3] - box[0], fmax(box[4] - box[1], box[5] - box[2])), sum = 0;
  bool done = false;
  row->n = 0;
  for (LitheIndex i = m->cell_face_off[cell]; i < m->cell_face_off[cell + 1] && !done; i++) {
    LitheIndex face = m->cell_face[i];
    LITHE_TRY(add_face(ctx, m, s, face, cell, lth_mesh_side(m, face, cell), x, size, row, &done));
  }
  merge_row(row);
  for (LitheIndex i = 0; i < row->n; i++) sum += row->weight[i];
  if (!(fabs(sum) > 0)) row->n = 0;
  if (done) return LITHE_OK;
  lth_row_make_linear(s, x, row);
  return LITHE_OK;
}
