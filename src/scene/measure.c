/// Figures of the bodies' present state for the result: displacement, stress, volume.
#include "scene/measure_staggered.h"

#include "base/tensor.h"

#include <stdlib.h>

double lth_von_mises(const double s[6]) {
  double a = s[0] - s[1], b = s[1] - s[2], c = s[2] - s[0];
  return sqrt((a * a + b * b + c * c) / 2 + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

/// Largest |u| at the corners of a cell.
static double largest_at_corners(const LthBody *body, LitheIndex cell, const double *u) {
  const LthMesh *mesh = body->mesh;
  double largest = 0;
  for (LitheIndex k = mesh->cell_face_off[cell]; k < mesh->cell_face_off[cell + 1]; k++) {
    LitheIndex f = mesh->cell_face[k];
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         i < mesh->loop_off[mesh->face_loop_off[f + 1]]; i++) {
      double value[3];
      lth_disc_sample(body->disc, cell, u, mesh->points + 3 * (LitheCount)mesh->loop_point[i],
                      value);
      largest = fmax(largest, lth_v3_norm(value));
    }
  }
  return largest;
}

/// max and the integral of the length into `mean`; the volume is returned in `volume`.
static LitheStatus add_displacement(LitheCtx *ctx, const LthBody *body,
                                    LthDisplacementFigures *figures, double *volume) {
  if (body->staggered) {
    *volume += lth_body_volume(body);
    return lth_measure_grid_displacement(ctx, body, &figures->max, &figures->mean);
  }
  const double *u = lth_body_displacement(body);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    LitheIndex n;
    double *points, *weights;
    figures->max = fmax(figures->max, largest_at_corners(body, c, u));
    LITHE_TRY(lth_dg_cell_quadrature(ctx, body->mesh, c, body->disc->cell_degree[c] + 1, &n,
                                     &points, &weights));
    for (LitheIndex q = 0; q < n; q++) {
      double value[3];
      lth_disc_sample(body->disc, c, u, points + 3 * (LitheCount)q, value);
      figures->mean += weights[q] * lth_v3_norm(value);
    }
    *volume += body->mesh->cell_volume[c];
    lth_free(ctx, points);
    lth_free(ctx, weights);
  }
  return LITHE_OK;
}

LitheStatus lth_measure_displacement(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                                     LthDisplacementFigures *figures) {
  double volume = 0;
  *figures = (LthDisplacementFigures){0};
  for (LitheIndex b = 0; b < n; b++) LITHE_TRY(add_displacement(ctx, bodies[b], figures, &volume));
  figures->mean /= volume;
  return LITHE_OK;
}

/// A place where stress was looked at.
typedef struct Sample {
  double von_mises, volume, yield;
  LitheIndex body, cell;
  double at[3];
} Sample;

typedef struct Samples {
  Sample *items;
  LitheCount n, cap;
} Samples;

static LitheStatus add_sample(LitheCtx *ctx, const LthBody *body, LitheIndex number,
                              LitheIndex cell, const double at[3], Samples *samples) {
  double stress[6];
  LTH_RESERVE(ctx, samples->items, samples->cap, samples->n + 1);
  Sample *s = samples->items + samples->n++;
  body->disc->table->stress(body->disc, cell, lth_body_position(body), at, stress);
  *s = (Sample){
      .von_mises = lth_von_mises(stress), .yield = body->yield[cell], .body = number, .cell = cell};
  lth_v3_copy(at, s->at);
  return LITHE_OK;
}

/// Four functions are the linear ones, and have one gradient in a cell.
static bool varies_within(const LthDisc *disc, LitheIndex cell, const double x[3]) {
  LitheIndex func[LTH_DISC_MAX_FUNCS];
  double phi[3 * LTH_DISC_MAX_FUNCS];
  return disc->table->eval(disc, cell, x, func, phi) > 4;
}

static LitheStatus sample_cell(LitheCtx *ctx, const LthBody *body, LitheIndex number,
                               LitheIndex cell, Samples *samples) {
  const LthMesh *mesh = body->mesh;
  const double *centroid = mesh->cell_centroid + 3 * (LitheCount)cell;
  LitheCount first = samples->n;
  LITHE_TRY(add_sample(ctx, body, number, cell, centroid, samples));
  bool varies = varies_within(body->disc, cell, centroid);
  for (LitheIndex k = mesh->cell_face_off[cell]; varies && k < mesh->cell_face_off[cell + 1]; k++) {
    LitheIndex f = mesh->cell_face[k];
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         i < mesh->loop_off[mesh->face_loop_off[f + 1]]; i++)
      LITHE_TRY(add_sample(ctx, body, number, cell,
                           mesh->points + 3 * (LitheCount)mesh->loop_point[i], samples));
  }
  for (LitheCount i = first; i < samples->n; i++)
    samples->items[i].volume = mesh->cell_volume[cell] / (double)(samples->n - first);
  return LITHE_OK;
}

/// One sample a cell.
static LitheStatus sample_grid(LitheCtx *ctx, const LthBody *body, LitheIndex number,
                               Samples *samples) {
  double *von_mises = NULL;
  LITHE_TRY(lth_measure_grid_stress(ctx, body, &von_mises));
  LitheStatus status = lth_reserve_(ctx, (void **)&samples->items, &samples->cap,
                                    samples->n + body->disc->n_cells, sizeof *samples->items);
  for (LitheIndex c = 0; c < body->disc->n_cells && status == LITHE_OK; c++) {
    if (!isfinite(von_mises[c])) continue;
    Sample *s = samples->items + samples->n++;
    *s = (Sample){.von_mises = von_mises[c],
                  .volume = lth_body_cell_volume(body, c),
                  .yield = lth_body_yield(body, c),
                  .body = number,
                  .cell = c};
    lth_body_cell_center(body, c, s->at);
  }
  lth_free(ctx, von_mises);
  return status;
}

static LitheStatus sample_body(LitheCtx *ctx, const LthBody *body, LitheIndex number,
                               Samples *samples) {
  if (body->staggered) return sample_grid(ctx, body, number, samples);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++)
    LITHE_TRY(sample_cell(ctx, body, number, c, samples));
  return LITHE_OK;
}

/// By stress, then by body, cell and place, so that equal values come in one order.
static int compare_samples(const void *left, const void *right) {
  const Sample *a = left, *b = right;
  if (a->von_mises != b->von_mises) return a->von_mises < b->von_mises ? -1 : 1;
  if (a->body != b->body) return a->body < b->body ? -1 : 1;
  if (a->cell != b->cell) return a->cell < b->cell ? -1 : 1;
  for (int i = 0; i < 3; i++)
    if (a->at[i] != b->at[i]) return a->at[i] < b->at[i] ? -1 : 1;
  return 0;
}

static void read_figures(Samples *samples, LthStressFigures *figures) {
  double volume = 0, below = 0;
  if (samples->n == 0) return;
  qsort(samples->items, (size_t)samples->n, sizeof *samples->items, compare_samples);
  for (LitheCount i = 0; i < samples->n; i++) {
    const Sample *s = samples->items + i;
    volume += s->volume;
    if (s->yield > 0) figures->safety = fmin(figures->safety, s->yield / s->von_mises);
  }
  const Sample *last = samples->items + samples->n - 1;
  figures->von_mises_max = last->von_mises;
  lth_v3_copy(last->at, figures->at);
  for (LitheCount i = 0; i < samples->n && below < 0.99 * volume; i++) {
    below += samples->items[i].volume;
    figures->p99 = samples->items[i].von_mises;
  }
  if (figures->safety == HUGE_VAL) figures->safety = NAN;
}

LitheStatus lth_measure_stress(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                               LthStressFigures *figures) {
  LitheStatus status = LITHE_OK;
  Samples samples = {0};
  *figures = (LthStressFigures){.safety = HUGE_VAL};
  for (LitheIndex b = 0; b < n; b++) LITHE_TRY_OR(done, sample_body(ctx, bodies[b], b, &samples));
  read_figures(&samples, figures);

done:
  lth_free(ctx, samples.items);
  return status;
}

double lth_measure_volume(LitheIndex n, LthBody *const *bodies) {
  double volume = 0;
  for (LitheIndex b = 0; b < n; b++) {
    const LthBody *body = bodies[b];
    const double *u = lth_body_displacement(body);
    for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
      double F[9];
      lth_disc_mean_gradient(body->disc, c, u, F);
      for (int a = 0; a < 3; a++) F[4 * a] += 1;
      volume += lth_body_cell_volume(body, c) * lth_m3_det(F);
    }
  }
  return volume;
}
