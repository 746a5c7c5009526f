/// Volumes: placed, sampled, smoothed.
#include "geometry/volume.h"

#include "base/tensor.h"

#define GAUSS_REACH 3.0 ///< standard deviations of the filter that are kept

/// Inverse of a 3x4 map; false where it has none.
static bool invert(const double A[12], double B[12]) {
  double m[9], scale = 1;
  for (int i = 0; i < 3; i++) {
    double column = 0;
    for (int j = 0; j < 3; j++) m[3 * i + j] = A[4 * i + j], column += A[4 * j + i] * A[4 * j + i];
    scale *= sqrt(column);
  }
  double det = lth_m3_det(m);
  if (!isfinite(det) || !(fabs(det) > 1e-9 * scale) || !(scale > 0)) return false;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      B[4 * i + j] = (m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c]) / det;
    }
  for (int i = 0; i < 3; i++) {
    B[4 * i + 3] = 0;
    for (int j = 0; j < 3; j++) B[4 * i + 3] -= B[4 * i + j] * A[4 * j + 3];
    if (!isfinite(B[4 * i + 3])) return false;
  }
  return true;
}

LitheStatus lth_volume_place(LitheCtx *ctx, LthVolume *v, const double to_world[12]) {
  memcpy(v->to_world, to_world, sizeof v->to_world);
  if (!invert(to_world, v->to_voxel))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "the axes of its voxels, (%g, %g, %g), (%g, %g, %g) and (%g, %g, %g) m, do not span "
               "space",
               to_world[0], to_world[4], to_world[8], to_world[1], to_world[5], to_world[9],
               to_world[2], to_world[6], to_world[10]);
  return LITHE_OK;
}

LitheStatus lth_volume_create(LitheCtx *ctx, const LitheIndex n[3], const double to_world[12],
                              LthVolume **volume) {
  LitheStatus status = LITHE_OK;
  LthVolume *v = NULL;
  *volume = NULL;
  if (n[0] < 1 || n[1] < 1 || n[2] < 1 || (double)n[0] * n[1] * n[2] > LTH_VOXELS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%d x %d x %d voxels, expected from 1 to %d in all", n[0],
               n[1], n[2], LTH_VOXELS_MAX);
  LTH_NEW_OR(done, ctx, v, 1);
  for (int i = 0; i < 3; i++) v->n[i] = n[i];
  LITHE_TRY_OR(done, lth_volume_place(ctx, v, to_world));
  memcpy(v->of_file, to_world, sizeof v->of_file);
  LTH_NEW_OR(done, ctx, v->values, lth_volume_size(v));
done:
  if (status != LITHE_OK) lth_volume_destroy(ctx, &v);
  *volume = v;
  return status;
}

void lth_volume_destroy(LitheCtx *ctx, LthVolume **volume) {
  if (!volume || !*volume) return;
  lth_free(ctx, (*volume)->values);
  lth_free(ctx, *volume);
  *volume = NULL;
}

void lth_volume_locate(const LthVolume *v, const double x[3], double voxel[3]) {
  const double *B = v->to_voxel;
  for (int i = 0; i < 3; i++)
    voxel[i] = B[4 * i] * x[0] + B[4 * i + 1] * x[1] + B[4 * i + 2] * x[2] + B[4 * i + 3];
}

double lth_volume_sample(const LthVolume *v, const float *values, const double x[3]) {
  LitheIndex low[3], high[3];
  double t[3], sum = 0;
  lth_volume_locate(v, x, t);
  for (int i = 0; i < 3; i++) {
    double inside = fmin(fmax(t[i], 0), v->n[i] - 1); // also where it is no number
    low[i] = (LitheIndex)inside;
    high[i] = low[i] + 1 < v->n[i] ? low[i] + 1 : low[i];
    t[i] = inside - low[i];
  }
  for (int corner = 0; corner < 8; corner++) {
    double weight = (corner & 1 ? t[0] : 1 - t[0]) * (corner & 2 ? t[1] : 1 - t[1]) *
                    (corner & 4 ? t[2] : 1 - t[2]);
    if (weight == 0) continue;
    sum +=
        weight *
        (double)
            values[lth_volume_index(v, corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                                    corner & 4 ? high[2] : low[2])];
  }
  return sum;
}

double lth_volume_value(const LthVolume *v, const double x[3]) {
  return lth_volume_sample(v, v->values, x);
}

/// Length of the step from voxel to voxel along an axis [m].
static double voxel_step(const LthVolume *v, int axis) {
  double s = 0;
  for (int i = 0; i < 3; i++) s += v->to_world[4 * i + axis] * v->to_world[4 * i + axis];
  return sqrt(s);
}

/// One line of n values that are `stride` apart, by a kernel of weights 0 .. reach.
static void smooth_line(float *line, LitheIndex n, LitheCount stride, const double *kernel,
                        LitheIndex reach, float *copy) {
  for (LitheIndex i = 0; i < n; i++) copy[i] = line[i * stride];
  for (LitheIndex i = 0; i < n; i++) {
    double sum = kernel[0] * (double)copy[i];
    for (LitheIndex k = 1; k <= reach; k++) {
      LitheIndex low = i > k ? i - k : 0, high = i + k < n ? i + k : n - 1;
      sum += kernel[k] * ((double)copy[low] + (double)copy[high]);
    }
    line[i * stride] = (float)sum;
  }
}

static LitheStatus smooth_axis(LitheCtx *ctx, const LthVolume *v, int axis, double sigma,
                               float *values) {
  LitheStatus status = LITHE_OK;
  double *kernel = NULL, sum = 0;
  float *copies = NULL;
  double s = sigma / voxel_step(v, axis);
  LitheIndex n = v->n[axis], reach = (LitheIndex)fmin(ceil(GAUSS_REACH * s), n);
  LitheCount stride = axis == 0 ? 1 : axis == 1 ? v->n[0] : (LitheCount)v->n[0] * v->n[1];
  LitheCount n_lines = lth_volume_size(v) / n;
  if (!(s > 0.05) || n == 1) return LITHE_OK; // nothing that a voxel would show
  LTH_NEW_OR(done, ctx, kernel, (LitheCount)reach + 1);
  LTH_NEW_OR(done, ctx, copies, (LitheCount)n * lth_threads(ctx));
  for (LitheIndex k = 0; k <= reach; k++) {
    kernel[k] = exp(-0.5 * k * k / (s * s));
    sum += k == 0 ? kernel[k] : 2 * kernel[k];
  }
  for (LitheIndex k = 0; k <= reach; k++) kernel[k] /= sum;
  int n_threads = lth_threads(ctx);
#pragma omp parallel for schedule(static) num_threads(n_threads)
  for (int thread = 0; thread < n_threads; thread++)
    for (LitheCount line = n_lines * thread / n_threads; line < n_lines * (thread + 1) / n_threads;
         line++)
      smooth_line(values + line / stride * stride * n + line % stride, n, stride, kernel, reach,
                  copies + (LitheCount)n * thread);
done:
  lth_free(ctx, kernel);
  lth_free(ctx, copies);
  return status;
}

LitheStatus lth_volume_smooth(LitheCtx *ctx, const LthVolume *v, double sigma, float *values) {
  for (int axis = 0; axis < 3 && sigma > 0; axis++)
    LITHE_TRY(smooth_axis(ctx, v, axis, sigma, values));
  return LITHE_OK;
}
