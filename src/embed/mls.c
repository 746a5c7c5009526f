/// Moving least squares with samples gathered through the faces of elements, ring by ring.
#include "embed/weights.h"

#include "base/eigen.h"
#include "base/tensor.h"
#include "geometry/bvh.h"

#define THETA_END 0.011108996538242306 ///< exp(-4.5): the Gaussian at its radius
#define EIGEN_CUT 1e-6
#define SAMPLES_WANTED 6
#define CONDITION_WANTED 1e3
#define LEVERAGE_WANTED 4 ///< two standard deviations of the samples from their centre
#define LEVERAGE_MAX 100
#define BISECTIONS 4
#define GROWTH 1.5
#define GROWTHS 3
#define MOST_GROWN 3.375 ///< GROWTH to the power of GROWTHS
#define INSIDE 1e-6      ///< of the way to the middle of a cell: off the cut that a place lies on

LitheStatus lth_row_add(LitheCtx *ctx, LthWeightRow *row, LitheIndex sample, double weight) {
  LTH_RESERVE(ctx, row->sample, row->cap, (LitheCount)row->n + 1);
  LTH_RESERVE(ctx, row->weight, row->weight_cap, (LitheCount)row->n + 1);
  row->sample[row->n] = sample;
  row->weight[row->n++] = weight;
  return LITHE_OK;
}

void lth_row_sort(LthWeightRow *row) {
  // insertion sort: rows have a few dozen entries, gathered in nearly rising order
  for (LitheIndex i = 1; i < row->n; i++) {
    LitheIndex sample = row->sample[i], j = i;
    double weight = row->weight[i];
    for (; j > 0 && row->sample[j - 1] > sample; j--)
      row->sample[j] = row->sample[j - 1], row->weight[j] = row->weight[j - 1];
    row->sample[j] = sample, row->weight[j] = weight;
  }
}

/// Cells behind the faces of every cell, each once.
static LitheStatus find_neighbors(LitheCtx *ctx, LthMls *mls) {
  const LthMesh *m = mls->mesh;
  LitheIndex *mark = NULL;
  LitheCount cap = 0;
  LTH_NEW(ctx, mls->neighbor_off, (LitheCount)m->n_cells + 1);
  LTH_NEW(ctx, mark, m->n_cells);
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < m->n_cells; c++) mark[c] = -1;
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    for (LitheIndex i = m->cell_face_off[c]; i < m->cell_face_off[c + 1]; i++) {
      const LitheIndex *side = m->face_cell + 2 * (size_t)m->cell_face[i];
      LitheIndex other = side[0] == c ? side[1] : side[0];
      if (other < 0 || mark[other] == c) continue;
      mark[other] = c;
      LTH_RESERVE_OR(done, ctx, mls->neighbor, cap, (LitheCount)n + 1);
      mls->neighbor[n++] = other;
    }
    mls->neighbor_off[c + 1] = n;
  }
done:
  lth_free(ctx, mark);
  return status;
}

static void move_inside(double x[3], const double middle[3]) {
  lth_v3_scale(1 - INSIDE, x);
  lth_v3_axpy(INSIDE, middle, x);
}

/// What is needed to see around the ends of cuts, where there are any.
static LitheStatus prepare_sight(LitheCtx *ctx, LthMls *mls) {
  const LthMesh *m = mls->mesh;
  const LthSampleSet *set = mls->samples;
  LITHE_TRY(lth_visibility_create(ctx, m, &mls->sight));
  if (mls->sight.n_fronts == 0) return LITHE_OK;
  LTH_NEW(ctx, mls->cell_front, m->n_cells);
  LTH_NEW(ctx, mls->sample_inside, 3 * (LitheCount)set->n);
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    mls->cell_front[c] = lth_visibility_front(&mls->sight, m->cell_box + 6 * (size_t)c);
    mls->largest_radius = fmax(mls->largest_radius, mls->cell_radius[c]);
  }
  for (LitheIndex i = 0; i < set->n; i++) {
    double middle[3] = {0, 0, 0}, share = 1.0 / (double)(set->cell_off[i + 1] - set->cell_off[i]);
    for (LitheCount k = set->cell_off[i]; k < set->cell_off[i + 1]; k++)
      lth_v3_axpy(share, m->cell_centroid + 3 * (size_t)set->cell[k], middle);
    lth_v3_copy(set->point + 3 * (size_t)i, mls->sample_inside + 3 * (size_t)i);
    move_inside(mls->sample_inside + 3 * (size_t)i, middle);
  }
  return LITHE_OK;
}

LitheStatus lth_mls_create(LitheCtx *ctx, const LthMesh *mesh, const LthSampleSet *samples,
                           LthMls *mls) {
  *mls = (LthMls){.mesh = mesh, .samples = samples};
  LITHE_TRY(find_neighbors(ctx, mls));
  LTH_NEW(ctx, mls->cell_radius, mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    for (LitheCount e = samples->of_cell_off[c]; e < samples->of_cell_off[c + 1]; e++)
      mls->cell_radius[c] = fmax(mls->cell_radius[c], samples->radius[samples->of_cell[e]]);
  return prepare_sight(ctx, mls);
}

void lth_mls_free(LitheCtx *ctx, LthMls *mls) {
  lth_free(ctx, mls->neighbor_off);
  lth_free(ctx, mls->neighbor);
  lth_free(ctx, mls->cell_radius);
  lth_visibility_free(ctx, &mls->sight);
  lth_free(ctx, mls->cell_front);
  lth_free(ctx, mls->sample_inside);
}

LitheStatus lth_mls_scratch_create(LitheCtx *ctx, const LthMls *mls, LthMlsScratch *s) {
  *s = (LthMlsScratch){0};
  LTH_NEW(ctx, s->cell_mark, mls->mesh->n_cells);
  LTH_NEW(ctx, s->queue, mls->mesh->n_cells);
  LTH_NEW(ctx, s->sample_mark, mls->samples->n);
  LTH_NEW(ctx, s->candidate, mls->samples->n);
  LTH_NEW(ctx, s->theta, mls->samples->n);
  if (!mls->cell_front) return LITHE_OK;
  LTH_NEW(ctx, s->way, mls->samples->n);
  LTH_NEW(ctx, s->way_limit, mls->samples->n);
  LTH_NEW(ctx, s->way_sample, mls->samples->n);
  for (LitheIndex i = 0; i < mls->samples->n; i++) s->way[i] = -1;
  return LITHE_OK;
}

void lth_mls_scratch_free(LitheCtx *ctx, LthMlsScratch *s) {
  lth_free(ctx, s->cell_mark);
  lth_free(ctx, s->queue);
  lth_free(ctx, s->sample_mark);
  lth_free(ctx, s->candidate);
  lth_free(ctx, s->theta);
  lth_free(ctx, s->way);
  lth_free(ctx, s->way_limit);
  lth_free(ctx, s->way_sample);
  lth_free(ctx, s->sight.outline);
}

/// A Gaussian less its tangent in d^2 at d = 1, so that value and slope vanish there: cut off with a slope, it would
/// leave a kink in the surface wherever a sample's reach ends.
static double weight(double d) { return exp(-4.5 * d * d) - THETA_END * (1 + 4.5 * (1 - d * d)); }

/// Begin with a point: nothing is known of ways from it but what they may lead around.
static LitheStatus begin_ways(LitheCtx *ctx, const LthMls *mls, LthMlsScratch *s, const double x[3],
                              LitheIndex cell) {
  if (!mls->cell_front) return LITHE_OK;
  while (s->n_ways > 0) s->way[s->way_sample[--s->n_ways]] = -1;
  s->front = mls->cell_front[cell];
  s->hiders.n = 0;
  lth_v3_copy(x, s->inside);
  move_inside(s->inside, mls->mesh->cell_centroid + 3 * (size_t)cell);
  double reach = MOST_GROWN * mls->largest_radius;
  if (lth_visibility_has_few(&mls->sight) || s->front >= reach) return LITHE_OK;
  return lth_visibility_look(ctx, &mls->sight, s->inside, reach, &s->sight);
}

/// Distance of a sample from x, `straight` or around the ends of cuts; what is beyond `reach` may have any beyond it. Ways are
/// looked for no farther than that, once more where radii grow.
static double find_way(const LthMls *mls, LthMlsScratch *s, LitheIndex i, double straight,
                       double reach) {
  const LthVisibility *sight = &mls->sight;
  const double *to = mls->sample_inside + 3 * (size_t)i;
  if (!(straight < reach)) return straight;
  if (s->way[i] < 0) {
    s->way_sample[s->n_ways++] = i;
    s->way[i] = lth_visibility_is_hidden(sight, &s->hiders, s->inside, to) ? INFINITY : straight;
    s->way_limit[i] = 0;
  }
  if (s->way[i] < INFINITY || s->front >= reach || s->way_limit[i] >= reach) return s->way[i];
  bool is_few = lth_visibility_has_few(sight);
  s->way_limit[i] = is_few ? MOST_GROWN * mls->samples->radius[i] : reach;
  s->way[i] = fmax(straight, lth_visibility_way(sight, &s->hiders, is_few ? NULL : &s->sight,
                                                s->inside, to, s->way_limit[i]));
  return s->way[i];
}

/// Samples within `grown` times their radius of x, of cells connected to `cell` within reach. Sets
/// candidate and theta; returns their number.
static LitheIndex gather(const LthMls *mls, LthMlsScratch *s, const double x[3], LitheIndex cell,
                         double grown) {
  const LthSampleSet *set = mls->samples;
  LitheIndex head = 0, tail = 0, n = 0;
  bool has_ways = mls->cell_front && mls->cell_front[cell] < grown * mls->largest_radius;
  s->stamp++;
  s->queue[tail++] = cell;
  s->cell_mark[cell] = s->stamp;
  while (head < tail) {
    LitheIndex c = s->queue[head++];
    for (LitheCount e = set->of_cell_off[c]; e < set->of_cell_off[c + 1]; e++) {
      LitheIndex i = set->of_cell[e];
      if (s->sample_mark[i] == s->stamp) continue;
      s->sample_mark[i] = s->stamp;
      double reach = grown * set->radius[i];
      double d = lth_v3_distance(x, set->point + 3 * (size_t)i);
      if (has_ways) d = find_way(mls, s, i, d, reach);
      d /= reach;
      if (!(d < 1)) continue;
      s->theta[n] = weight(d);
      s->candidate[n++] = i;
    }
    for (LitheIndex k = mls->neighbor_off[c]; k < mls->neighbor_off[c + 1]; k++) {
      LitheIndex other = mls->neighbor[k];
      double reach = grown * mls->cell_radius[other];
      if (s->cell_mark[other] == s->stamp) continue;
      s->cell_mark[other] = s->stamp;
      if (lth_box_distance2(mls->mesh->cell_box + 6 * (size_t)other, x) < reach * reach)
        s->queue[tail++] = other;
    }
  }
  return n;
}

double lth_pseudo_solve(const double S[9], const double d[3], double g[3]) {
  double A[9], V[9], value[3];
  memcpy(A, S, sizeof A);
  lth_symmetric_eigen(3, A, value, V);
  g[0] = g[1] = g[2] = 0;
  for (int i = 0; i < 3; i++) {
    double v[3] = {V[i], V[3 + i], V[6 + i]};
    if (value[i] > EIGEN_CUT * value[2]) lth_v3_axpy(lth_v3_dot(v, d) / value[i], v, g);
  }
  return value[0] > EIGEN_CUT * value[2] ? value[2] / value[0] : INFINITY;
}

/// Sum, mean place and covariance of weighted points.
static double find_moments(const LthSampleSet *set, const LitheIndex *sample, const double *weight,
                           LitheIndex n, const double x[3], double center[3], double S[9]) {
  double m0 = 0, c[3] = {0, 0, 0};
  for (LitheIndex i = 0; i < n; i++) {
    double w = fabs(weight[i]), d[3];
    lth_v3_sub(set->point + 3 * (size_t)sample[i], x,
               d); // about x: places far from the origin lose nothing
    lth_v3_axpy(w, d, c);
    m0 += w;
  }
  for (int a = 0; a < 3; a++) center[a] = m0 > 0 ? c[a] / m0 : 0;
  for (int a = 0; a < 9; a++) S[a] = 0;
  for (LitheIndex i = 0; i < n && m0 > 0; i++) {
    double w = fabs(weight[i]) / m0, d[3];
    lth_v3_sub(set->point + 3 * (size_t)sample[i], x, d);
    lth_v3_axpy(-1, center, d);
    for (int a = 0; a < 9; a++) S[a] += w * d[a / 3] * d[a % 3];
  }
  return m0;
}

/// One set of samples around x, and the fit's slope towards x.
typedef struct Fit {
  LitheIndex n;
  double m0, center[3], S[9], g[3];
  double condition,
      leverage; ///< of S; squared distance of x from the centre in units of the spread
} Fit;

static bool fit(const LthMls *mls, LthMlsScratch *s, const double x[3], LitheIndex cell,
                double grown, Fit *f) {
  f->n = gather(mls, s, x, cell, grown);
  f->m0 = find_moments(mls->samples, s->candidate, s->theta, f->n, x, f->center, f->S);
  double to_x[3] = {-f->center[0], -f->center[1], -f->center[2]};
  f->condition = f->n >= 4 ? lth_pseudo_solve(f->S, to_x, f->g) : INFINITY;
  f->leverage = f->condition < INFINITY ? lth_v3_dot(f->g, to_x) : INFINITY;
  return f->n >= SAMPLES_WANTED && f->condition < CONDITION_WANTED && f->leverage < LEVERAGE_WANTED;
}

/// The smallest growth of the radii that gives a good fit, to a few percent: it changes gradually from
/// point to point, and so does the surface. True where they need not grow.
static bool find_fit(const LthMls *mls, LthMlsScratch *s, const double x[3], LitheIndex cell,
                     Fit *f) {
  double high = 1, low = 1;
  bool good = fit(mls, s, x, cell, high, f);
  for (int k = 0; k < GROWTHS && !good; k++) {
    low = high;
    high *= GROWTH;
    good = fit(mls, s, x, cell, high, f);
  }
  if (!good || high == low) return good;
  for (int k = 0; k < BISECTIONS; k++) {
    double middle = sqrt(low * high);
    if (fit(mls, s, x, cell, middle, f))
      high = middle;
    else
      low = middle;
  }
  fit(mls, s, x, cell, high, f);
  return false;
}

/// weight_i += theta_i / m0 (a + g . (x_i - c)) with the a and g that make up for what the weights miss of
/// 1 and x: from zero, the fit itself; a second time, its rounding.
static void add_correction(const LthMls *mls, const LthMlsScratch *s, const double x[3],
                           const Fit *f, double *weight) {
  double missing = 1, moment[3] = {0, 0, 0}, g[3];
  for (LitheIndex i = 0; i < f->n; i++) {
    double d[3];
    lth_v3_sub(mls->samples->point + 3 * (size_t)s->candidate[i], x, d);
    missing -= weight[i];
    lth_v3_axpy(-weight[i], d, moment);
  }
  lth_v3_axpy(-missing, f->center, moment);
  lth_pseudo_solve(f->S, moment, g);
  for (LitheIndex i = 0; i < f->n; i++) {
    double d[3];
    lth_v3_sub(mls->samples->point + 3 * (size_t)s->candidate[i], x, d);
    lth_v3_axpy(-1, f->center, d);
    weight[i] += s->theta[i] / f->m0 * (missing + lth_v3_dot(g, d));
  }
}

LitheStatus lth_mls_weights(LitheCtx *ctx, const LthMls *mls, LthMlsScratch *s, const double x[3],
                            LitheIndex cell, LthWeightRow *row) {
  Fit f;
  row->n = 0;
  LITHE_TRY(begin_ways(ctx, mls, s, x, cell));
  row->is_plain = find_fit(mls, s, x, cell, &f);
  if (!(f.condition < INFINITY) || !(f.leverage < LEVERAGE_MAX)) return LITHE_OK;
  for (LitheIndex i = 0; i < f.n; i++) LITHE_TRY(lth_row_add(ctx, row, s->candidate[i], 0));
  add_correction(mls, s, x, &f, row->weight);
  add_correction(mls, s, x, &f, row->weight);
  return LITHE_OK;
}

void lth_row_make_linear(const LthSampleSet *samples, const double x[3], LthWeightRow *row) {
  double center[3], S[9], g[3], sum = 0, miss[3] = {0, 0, 0};
  for (LitheIndex i = 0; i < row->n; i++) sum += row->weight[i];
  if (!(fabs(sum) > 0)) return;
  for (LitheIndex i = 0; i < row->n; i++) {
    double d[3];
    row->weight[i] /= sum;
    lth_v3_sub(samples->point + 3 * (size_t)row->sample[i], x, d);
    lth_v3_axpy(-row->weight[i], d, miss);
  }
  double m0 = find_moments(samples, row->sample, row->weight, row->n, x, center, S);
  if (!(lth_pseudo_solve(S, miss, g) < INFINITY)) return;
  for (LitheIndex i = 0; i < row->n; i++) {
    double d[3];
    lth_v3_sub(samples->point + 3 * (size_t)row->sample[i], x, d);
    lth_v3_axpy(-1, center, d);
    row->weight[i] += fabs(row->weight[i]) / m0 * lth_v3_dot(g, d);
  }
}
