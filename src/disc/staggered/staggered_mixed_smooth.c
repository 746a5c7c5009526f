/// Smoothing of the mixed form: distributive Gauss-Seidel where the operator is that of a homogeneous solid, and
/// boxes - the faces and the pressure of one cell, solved together - elsewhere.
///
/// Interior: with u = w - grad q, p = -mu div w + (2 mu lap - s) q (s: inertia) the momentum rows become
/// -mu lap w + s w, and those of the constraint -(1 + 2 mu / lambda) lap q + s q / lambda + ... w: each is relaxed by
/// itself. Zhu et al. 2010, section 3; boxes as Vanka 1986. All loops run by colors whose members do not touch each
/// other, so the order within a color does not matter.
#include "disc/staggered/staggered_mixed.h"

static void relax_faces(LthMixedLevel *l, int threads, int a, int color) {
  const double per_a = l->per_h[a];
  double *u = l->x + a * l->stride, *p = l->x + l->dim * l->stride;
  const double *b = l->b + a * l->stride;
  double lap = 0;
  for (int k = 0; k < l->dim; k++) lap += 2 * l->per_h[k] * l->per_h[k];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < l->n_face[a][color]; i++) {
    const LitheIndex c = l->face[a][color][i];
    const double mu = l->mu[c], s = l->mass[a] ? l->mass[a][c] : 0;
    double d = (b[c] - lth_mixed_momentum(l, a, c, l->x)) / (mu * lap + s);
    u[c] += d;
    p[c] += mu * per_a * d;
    p[l->next[2 * a][c]] -= mu * per_a * d;
  }
}

/// q of one color's cells, into the residual's pressure part.
static void find_potentials(LthMixedLevel *l, int threads, int color) {
  const LitheCount pressure = l->dim * l->stride;
  double lap = 0;
  for (int k = 0; k < l->dim; k++) lap += 2 * l->per_h[k] * l->per_h[k];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < l->n_cell[color]; i++) {
    const LitheIndex c = l->cell[color][i];
    const double C = l->compliance[c], s = l->mass[0] ? l->mass[0][c] : 0;
    double r = l->b[pressure + c] - lth_mixed_divergence(l, c, l->x) + C * l->x[pressure + c];
    l->r[pressure + c] = r / ((1 + 2 * C * l->mu[c]) * lap + C * s);
  }
}

static void relax_cells(LthMixedLevel *l, int threads, int color) {
  const LitheCount pressure = l->dim * l->stride;
  double lap = 0;
  for (int k = 0; k < l->dim; k++) lap += 2 * l->per_h[k] * l->per_h[k];
  double *p = l->x + pressure;
  const double *q = l->r + pressure;
  find_potentials(l, threads, color);
  // every face lies between two colors, so one cell alone moves it
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < l->n_cell[color]; i++) {
    const LitheIndex c = l->cell[color][i];
    for (int a = 0; a < l->dim; a++) {
      l->x[a * l->stride + c] -= l->per_h[a] * q[c];
      l->x[a * l->stride + l->next[2 * a + 1][c]] += l->per_h[a] * q[c];
    }
    p[c] -= (2 * l->mu[c] * lap + (l->mass[0] ? l->mass[0][c] : 0)) * q[c];
  }
}

/// The part of p += 2 mu lap q that falls on neighbours: gathered, as two cells may share one.
static void spread_potentials(LthMixedLevel *l, int threads, int color) {
  double *p = l->x + l->dim * l->stride;
  const double *q = l->r + l->dim * l->stride;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < l->n_near[!color]; i++) {
    const LitheIndex c = l->near[!color][i];
    double sum = 0;
    for (int k = 0; k < 2 * l->dim; k++) {
      const LitheIndex to = l->next[k][c];
      if (l->flags[to] & LTH_MIXED_INTERIOR)
        sum += 2 * l->mu[to] * l->per_h[k / 2] * l->per_h[k / 2] * q[to];
    }
    p[c] += sum;
  }
}

static void relax_box(LthMixedLevel *l, LitheIndex c, const float *inverse) {
  const int dim = l->dim, m = 2 * dim + 1;
  LitheCount at[7];
  double r[7];
  for (int a = 0; a < dim; a++)
    for (int side = 0; side < 2; side++) {
      const LitheIndex f = side ? l->next[2 * a + 1][c] : c;
      at[2 * a + side] = a * l->stride + f;
      r[2 * a + side] = l->flags[f] & LTH_MIXED_FREE << a
                            ? l->b[a * l->stride + f] - lth_mixed_momentum(l, a, f, l->x)
                            : 0;
    }
  at[2 * dim] = dim * l->stride + c;
  r[2 * dim] = l->b[at[2 * dim]] - l->volume[c] * lth_mixed_divergence(l, c, l->x) +
               l->compliance[c] * l->x[at[2 * dim]];
  for (int i = 0; i < m; i++) {
    double sum = 0;
    for (int k = 0; k < m; k++) sum += (double)inverse[i * m + k] * r[k];
    if (sum != 0) l->x[at[i]] += sum; // faces that are not there stand at one place for all boxes
  }
}

static void relax_boxes(LthMixedLevel *l, int threads) {
  const int m = 2 * l->dim + 1;
  for (int color = 0; color < LTH_MIXED_COLORS; color++) {
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheIndex i = l->box_off[color]; i < l->box_off[color + 1]; i++)
      relax_box(l, l->box[i], l->inverse + (LitheCount)i * m * m);
  }
}

/// Boxes once before and once after the interior: most of what slows a cycle stands at the boundary.
void lth_mixed_smooth(LthMixedLevel *l, int threads) {
  relax_boxes(l, threads);
  for (int a = 0; a < l->dim; a++)
    for (int color = 0; color < 2; color++) relax_faces(l, threads, a, color);
  for (int color = 0; color < 2; color++) {
    relax_cells(l, threads, color);
    spread_potentials(l, threads, color);
  }
  relax_boxes(l, threads);
}
