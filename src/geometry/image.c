/// From a volume to a level function whose negative part is the solid.
#include "geometry/image.h"

#include "base/tensor.h"

#include <stdio.h>

/// --- selecting ---

static void value_range(const LthVolume *v, double *low, double *high) {
  *low = INFINITY, *high = -INFINITY;
  for (LitheCount p = 0; p < lth_volume_size(v); p++) {
    *low = fmin(*low, (double)v->values[p]);
    *high = fmax(*high, (double)v->values[p]);
  }
}

static bool is_among(double value, const double *labels, LitheIndex n_labels) {
  for (LitheIndex l = 0; l < n_labels; l++)
    if (value == labels[l]) return true;
  return false;
}

/// Threshold minus value; 1/2 minus the indicator of the labels. What is no number is outside.
static void fill_level(LitheCtx *ctx, LthImage *m, double threshold, const double *labels,
                       LitheIndex n_labels) {
  LitheCount n = lth_volume_size(m->volume);
  const float *values = m->volume->values;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount p = 0; p < n; p++) {
    double value = (double)values[p];
    if (labels)
      m->level[p] = is_among(value, labels, n_labels) ? -0.5f : 0.5f;
    else
      m->level[p] = isnan(value) ? INFINITY : (float)(threshold - value);
  }
}

/// Infinite levels cannot be interpolated: the largest finite one stands for them.
static void bound_level(LthImage *m) {
  LitheCount n = lth_volume_size(m->volume);
  float largest = 0;
  for (LitheCount p = 0; p < n; p++)
    if (isfinite(m->level[p])) largest = fmaxf(largest, fabsf(m->level[p]));
  if (!(largest > 0)) largest = 1;
  for (LitheCount p = 0; p < n; p++)
    if (!isfinite(m->level[p])) m->level[p] = m->level[p] > 0 ? largest : -largest;
}

static LitheStatus fail_empty(LitheCtx *ctx, const LthVolume *v, double threshold,
                              const double *labels, LitheIndex n_labels) {
  double low, high;
  value_range(v, &low, &high);
  if (low > high) LITHE_FAIL(ctx, LITHE_BAD_INPUT, "no voxel has a value that is a number");
  if (!labels)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "no voxel is above the threshold of %g: values are from %g to %g", threshold, low,
               high);
  if (n_labels == 1)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "no voxel has the label %g: values are from %g to %g",
               labels[0], low, high);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT, "no voxel has one of the %d labels: values are from %g to %g",
             n_labels, low, high);
}

/// --- islands ---

/// Voxels of the island that starts at `seed`, over faces; returns their number.
static LitheCount flood(LthImage *m, LitheCount seed, LitheIndex island, LitheCount *stack) {
  const LthVolume *v = m->volume;
  LitheCount top = 0, count = 0, step[3] = {1, v->n[0], (LitheCount)v->n[0] * v->n[1]};
  m->island[seed] = island;
  stack[top++] = seed;
  while (top > 0) {
    LitheCount p = stack[--top];
    count++;
    for (int axis = 0; axis < 3; axis++) {
      LitheIndex at = (LitheIndex)(p / step[axis] % v->n[axis]);
      for (int side = -1; side <= 1; side += 2) {
        if (at + side < 0 || at + side >= v->n[axis]) continue;
        LitheCount q = p + side * step[axis];
        if (!(m->level[q] < 0) || m->island[q] >= 0) continue;
        m->island[q] = island;
        stack[top++] = q;
      }
    }
  }
  return count;
}

static LitheStatus find_islands(LitheCtx *ctx, LthImage *m) {
  LitheStatus status = LITHE_OK;
  LitheCount n = lth_volume_size(m->volume), cap = 0, *stack = NULL;
  LTH_NEW_OR(done, ctx, m->island, n);
  LTH_NEW_OR(done, ctx, stack, n);
  for (LitheCount p = 0; p < n; p++) m->island[p] = -1;
  for (LitheCount p = 0; p < n; p++) {
    if (!(m->level[p] < 0) || m->island[p] >= 0) continue;
    LTH_RESERVE_OR(done, ctx, m->island_size, cap, (LitheCount)m->n_islands + 1);
    m->island_size[m->n_islands] = flood(m, p, m->n_islands, stack);
    m->n_islands++;
  }
done:
  lth_free(ctx, stack);
  return status;
}

void lth_image_drop(LthImage *m, const bool *keep) {
  LitheCount n = lth_volume_size(m->volume);
  for (LitheCount p = 0; p < n; p++)
    if (m->island[p] >= 0 && !keep[m->island[p]]) {
      m->level[p] = fabsf(m->level[p]);
      m->island[p] = -1;
    }
}

/// --- all of it ---

static void place_of(const LthVolume *v, const double voxel[3], double x[3]) {
  const double *A = v->to_world;
  for (int i = 0; i < 3; i++)
    x[i] = A[4 * i] * voxel[0] + A[4 * i + 1] * voxel[1] + A[4 * i + 2] * voxel[2] + A[4 * i + 3];
}

/// Box around the voxels inside and half a voxel of their surroundings.
static void find_box(LthImage *m) {
  const LthVolume *v = m->volume;
  LitheIndex low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {-1, -1, -1};
  for (LitheCount p = 0; p < lth_volume_size(v); p++) {
    if (!(m->level[p] < 0)) continue;
    LitheIndex at[3] = {(LitheIndex)(p % v->n[0]), (LitheIndex)(p / v->n[0] % v->n[1]),
                        (LitheIndex)(p / v->n[0] / v->n[1])};
    for (int i = 0; i < 3; i++) {
      if (at[i] < low[i]) low[i] = at[i];
      if (at[i] > high[i]) high[i] = at[i];
    }
  }
  for (int i = 0; i < 3; i++) m->box[i] = INFINITY, m->box[3 + i] = -INFINITY;
  for (int corner = 0; corner < 8; corner++) {
    double voxel[3], x[3];
    for (int i = 0; i < 3; i++) voxel[i] = corner >> i & 1 ? high[i] + 0.5 : low[i] - 0.5;
    place_of(v, voxel, x);
    for (int i = 0; i < 3; i++) {
      m->box[i] = fmin(m->box[i], x[i]);
      m->box[3 + i] = fmax(m->box[3 + i], x[i]);
    }
  }
}

LitheStatus lth_image_create(LitheCtx *ctx, const LthVolume *volume, double threshold,
                             const double *labels, LitheIndex n_labels, double width,
                             LthImage **image) {
  LitheStatus status = LITHE_OK;
  LthImage *m = NULL;
  *image = NULL;
  LTH_NEW_OR(done, ctx, m, 1);
  m->volume = volume;
  m->is_smoothed = width > 0;
  LTH_NEW_OR(done, ctx, m->level, lth_volume_size(volume));
  fill_level(ctx, m, threshold, labels, n_labels);
  bound_level(m);
  LITHE_TRY_OR(done, lth_volume_smooth(ctx, volume, width / 2, m->level));
  LITHE_TRY_OR(done, find_islands(ctx, m));
  if (m->n_islands == 0) LITHE_TRY_OR(done, fail_empty(ctx, volume, threshold, labels, n_labels));
  find_box(m);
  *image = m;
  m = NULL;
done:
  lth_image_destroy(ctx, &m);
  return status;
}

void lth_image_destroy(LitheCtx *ctx, LthImage **image) {
  if (!image || !*image) return;
  lth_free(ctx, (*image)->level);
  lth_free(ctx, (*image)->island);
  lth_free(ctx, (*image)->island_size);
  lth_free(ctx, *image);
  *image = NULL;
}

double lth_image_value(const LthImage *m, const double x[3]) {
  const LthVolume *v = m->volume;
  double voxel[3], beyond = 0;
  lth_volume_locate(v, x, voxel);
  // half a voxel beyond the outermost centres the volume ends
  for (int i = 0; i < 3; i++)
    beyond = fmax(beyond, fmax(-0.5 - voxel[i], voxel[i] - (v->n[i] - 0.5)));
  double level = lth_volume_sample(v, m->level, x);
  return beyond > 0 ? fabs(level) + beyond : level;
}

double lth_image_label(const LthImage *m, const double x[3]) {
  const LthVolume *v = m->volume;
  LitheIndex at[3];
  double voxel[3], nearest = INFINITY;
  lth_volume_locate(v, x, voxel);
  for (int i = 0; i < 3; i++) at[i] = (LitheIndex)fmin(fmax(floor(voxel[i] + 0.5), 0), v->n[i] - 1);
  LitheCount best = lth_volume_index(v, at[0], at[1], at[2]);
  if (m->level[best] < 0) return (double)v->values[best];
  for (int side = 0; side < 27; side++) {
    LitheIndex q[3] = {at[0] + side % 3 - 1, at[1] + side / 3 % 3 - 1, at[2] + side / 9 - 1};
    double d2 = 0;
    bool is_there = true;
    for (int i = 0; i < 3; i++) {
      is_there = is_there && q[i] >= 0 && q[i] < v->n[i];
      d2 += (q[i] - voxel[i]) * (q[i] - voxel[i]);
    }
    if (!is_there || !(d2 < nearest)) continue;
    LitheCount p = lth_volume_index(v, q[0], q[1], q[2]);
    if (m->level[p] < 0) nearest = d2, best = p;
  }
  return (double)v->values[best];
}
