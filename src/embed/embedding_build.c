/// Building an embedding: cells of the points, rows of weights, averages of the samples.
#include "base/tensor.h"
#include "embed/cell_search.h"
#include "embed/weights.h"

#include <stdlib.h>

/// Rows of a contiguous range of points, made by one thread.
typedef struct Part {
  LitheIndex first, end;
  LthWeightRow all, row; ///< rows one after the other; the present one
  LthMlsScratch scratch;
  LitheStatus status;
} Part;

/// What all parts share.
typedef struct Job {
  LitheCtx *ctx;
  LthEmbedding *e;
  LthSampleSet *samples;
  LthMls mls;
  LthInterpolation interpolation;
  const LitheIndex *point_sample; ///< sample at the point itself, -1; NULL: none (stitched)
  LthKeptRows kept;
  bool keeps; ///< rows are to be taken from before, or remembered for later
  Part *parts;
  int n_parts;
} Job;

static LitheStatus make_row(Job *job, Part *part, LitheIndex p) {
  const double *x = job->e->rest + 3 * (size_t)p;
  LthWeightRow *row = &part->row;
  row->n = 0;
  row->is_plain = false;
  if (job->keeps && job->kept.is_kept[p]) {
    LITHE_TRY(lth_kept_rows_take(job->ctx, &job->kept, p, row));
  } else if (job->interpolation == LTH_EMBED_MLS) {
    LITHE_TRY(lth_mls_weights(job->ctx, &job->mls, &part->scratch, x, job->e->cell[p], row));
  } else if (job->point_sample[p] >= 0) {
    LITHE_TRY(lth_row_add(job->ctx, row, job->point_sample[p], 1));
  } else {
    LITHE_TRY(
        lth_mean_value_weights(job->ctx, job->e->mesh, job->samples, x, job->e->cell[p], row));
  }
  lth_row_sort(row);
  if (job->keeps) lth_kept_rows_note(&job->kept, p, row);
  job->e->off[p + 1] = row->n;
  for (LitheIndex i = 0; i < row->n; i++)
    LITHE_TRY(lth_row_add(job->ctx, &part->all, row->sample[i], row->weight[i]));
  return LITHE_OK;
}

static LitheStatus make_part(Job *job, Part *part) {
  if (job->interpolation == LTH_EMBED_MLS)
    LITHE_TRY(lth_mls_scratch_create(job->ctx, &job->mls, &part->scratch));
  for (LitheIndex p = part->first; p < part->end; p++) {
    if (lth_cancelled(job->ctx)) return LITHE_INTERRUPTED;
    LITHE_TRY(make_row(job, part, p));
  }
  return LITHE_OK;
}

/// Make all rows; off[p + 1] holds the length of row p afterwards.
static LitheStatus make_rows(Job *job) {
  job->n_parts = lth_threads(job->ctx);
  LTH_NEW(job->ctx, job->parts, job->n_parts);
#pragma omp parallel for schedule(static, 1) num_threads(job->n_parts)
  for (int k = 0; k < job->n_parts; k++) {
    Part *part = &job->parts[k];
    part->first = (LitheIndex)((LitheCount)job->e->n_points * k / job->n_parts);
    part->end = (LitheIndex)((LitheCount)job->e->n_points * (k + 1) / job->n_parts);
    part->status = make_part(job, part);
  }
  for (int k = 0; k < job->n_parts; k++) {
    if (job->parts[k].status == LITHE_INTERRUPTED)
      LITHE_FAIL(job->ctx, LITHE_INTERRUPTED, "interrupted while the surface was embedded");
    LITHE_TRY(job->parts[k].status);
  }
  return LITHE_OK;
}

/// Points that found no samples get one of their own: their element's polynomial at their place.
static LitheStatus add_own_samples(Job *job) {
  LthEmbedding *e = job->e;
  for (LitheIndex p = 0; p < e->n_points; p++) {
    if (e->off[p + 1] > 0) continue;
    LITHE_TRY(lth_samples_add(job->ctx, job->samples, e->rest + 3 * (size_t)p, 1, &e->cell[p]));
    e->n_own++;
  }
  return LITHE_OK;
}

/// Put the parts' rows together in the order of the points.
static LitheStatus join_rows(Job *job) {
  LthEmbedding *e = job->e;
  LitheIndex own = job->samples->n - e->n_own;
  LitheCount total = e->n_own;
  for (LitheIndex p = 0; p < e->n_points; p++) total += e->off[p + 1];
  LTH_NEW(job->ctx, e->sample, total);
  LTH_NEW(job->ctx, e->weight, total);
  for (int k = 0; k < job->n_parts; k++) {
    const Part *part = &job->parts[k];
    LitheCount from = 0;
    for (LitheIndex p = part->first; p < part->end; p++) {
      LitheCount n = e->off[p + 1], to = e->off[p];
      for (LitheCount i = 0; i < n; i++) {
        e->sample[to + i] = part->all.sample[from + i];
        e->weight[to + i] = part->all.weight[from + i];
      }
      if (n == 0) e->sample[to] = own++, e->weight[to] = 1;
      from += n;
      e->off[p + 1] = to + (n > 0 ? n : 1);
    }
  }
  return LITHE_OK;
}

static LitheStatus make_sample_offsets(LitheCtx *ctx, const LthSampleSet *s, LthEmbedding *e) {
  e->n_samples = s->n;
  LTH_NEW(ctx, e->sample_point, 3 * (LitheCount)s->n);
  LTH_NEW(ctx, e->sample_off, (LitheCount)s->n + 1);
  LTH_NEW(ctx, e->sample_row_off, (LitheCount)s->n + 1);
  LTH_NEW(ctx, e->sample_value, 4 * (LitheCount)s->n);
  for (LitheIndex i = 0; i < s->n; i++) {
    LitheCount n = 0;
    for (LitheCount k = s->cell_off[i]; k < s->cell_off[i + 1]; k++)
      n += e->row_func[s->cell[k] + 1] - e->row_func[s->cell[k]];
    lth_v3_copy(s->point + 3 * (size_t)i, e->sample_point + 3 * (size_t)i);
    e->sample_off[i + 1] = e->sample_off[i] + n;
    e->sample_row_off[i + 1] = s->cell_off[i + 1];
  }
  return LITHE_OK;
}

/// Averages of the samples (eq. 30) as rows over basis functions.
static LitheStatus make_averages(LitheCtx *ctx, const LthDgSpace *space, const LthSampleSet *s,
                                 LthEmbedding *e) {
  LITHE_TRY(make_sample_offsets(ctx, s, e));
  LTH_NEW(ctx, e->sample_func, e->sample_off[s->n]);
  LTH_NEW(ctx, e->sample_weight, e->sample_off[s->n]);
  LTH_NEW(ctx, e->sample_row, e->sample_row_off[s->n]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < s->n; i++) {
    LitheCount at = e->sample_off[i], n = s->cell_off[i + 1] - s->cell_off[i];
    for (LitheCount k = s->cell_off[i]; k < s->cell_off[i + 1]; k++) {
      double phi[LTH_DG_MAX_FUNCS];
      LitheIndex cell = e->sample_row[k] = s->cell[k];
      lth_dg_eval(space, cell, s->point + 3 * (size_t)i, phi);
      for (int a = 0; a < lth_dg_funcs(space, cell); a++) {
        e->sample_func[at] = space->func_off[cell] + a;
        e->sample_weight[at++] = phi[a] / (double)n;
      }
    }
  }
  return LITHE_OK;
}

LitheStatus lth_embedding_find_cells(LitheCtx *ctx, LthEmbedding *e, const LitheIndex *point_cell) {
  LthCellSearch *search = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, e->cell, e->n_points);
  LITHE_TRY_OR(done, lth_cell_search_create(ctx, e->mesh, &search));
#pragma omp parallel for schedule(dynamic, 64) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    e->cell[p] = point_cell ? point_cell[p] : -1;
    if (e->cell[p] < 0) e->cell[p] = lth_cell_search_find(search, e->rest + 3 * (size_t)p, NULL);
  }
  for (LitheIndex p = 0; p < e->n_points; p++) {
    const double *x = e->rest + 3 * (size_t)p;
    if (e->cell[p] >= 0) continue;
    status = lth_fail(
        ctx, LITHE_BAD_INPUT,
        "point %d at (%g, %g, %g) m cannot be embedded: no element is at a finite distance", p,
        x[0], x[1], x[2]);
    goto done;
  }
done:
  lth_cell_search_destroy(ctx, &search);
  return status;
}

/// Points equal to a mesh point: those of the sliced surface in its order first, others by search.
typedef struct Keyed {
  double x[3];
  LitheIndex id;
} Keyed;

static int compare_keyed(const void *a, const void *b) {
  const Keyed *p = a, *q = b;
  for (int i = 0; i < 3; i++)
    if (p->x[i] != q->x[i]) return p->x[i] < q->x[i] ? -1 : 1;
  return 0;
}

/// The sample at a place that averages the point's own cell, where a cut has left several there.
static LitheIndex choose_side(const LthSampleSet *s, const Keyed *keys, const Keyed *found,
                              LitheIndex cell) {
  const Keyed *end = keys + s->n;
  while (found > keys && compare_keyed(found - 1, found) == 0) found--;
  if (found + 1 == end || compare_keyed(found, found + 1) != 0) return found->id;
  for (const Keyed *k = found; k < end && compare_keyed(k, found) == 0; k++)
    for (LitheCount e = s->cell_off[k->id]; e < s->cell_off[k->id + 1]; e++)
      if (s->cell[e] == cell) return k->id;
  return -1;
}

/// Sample at each embedded point that is a mesh point, bit for bit; -1 elsewhere.
static LitheStatus match_points(LitheCtx *ctx, const LthEmbedding *e, const LthSampleSet *s,
                                LitheIndex **match) {
  Keyed *keys = NULL;
  LTH_NEW(ctx, *match, e->n_points);
  LTH_NEW(ctx, keys, s->n);
  for (LitheIndex i = 0; i < s->n; i++) {
    keys[i].id = i;
    for (int a = 0; a < 3; a++) keys[i].x[a] = s->point[3 * (size_t)i + (size_t)a] + 0.0; // -0 is 0
  }
  qsort(keys, (size_t)s->n, sizeof *keys, compare_keyed);
  for (LitheIndex p = 0; p < e->n_points; p++) {
    Keyed key = {.id = -1};
    lth_v3_copy(e->rest + 3 * (size_t)p, key.x);
    const Keyed *found = bsearch(&key, keys, (size_t)s->n, sizeof *keys, compare_keyed);
    (*match)[p] = found ? choose_side(s, keys, found, e->cell[p]) : -1;
  }
  lth_free(ctx, keys);
  return LITHE_OK;
}

static void free_job(Job *job, LitheIndex *point_sample) {
  for (int k = 0; job->parts && k < job->n_parts; k++) {
    Part *part = &job->parts[k];
    lth_free(job->ctx, part->all.sample);
    lth_free(job->ctx, part->all.weight);
    lth_free(job->ctx, part->row.sample);
    lth_free(job->ctx, part->row.weight);
    lth_mls_scratch_free(job->ctx, &part->scratch);
  }
  lth_free(job->ctx, job->parts);
  lth_free(job->ctx, point_sample);
  lth_kept_rows_free(job->ctx, &job->kept);
  lth_mls_free(job->ctx, &job->mls);
  lth_samples_destroy(job->ctx, &job->samples);
}

static LitheStatus build(LitheCtx *ctx, const LthDgSpace *space, LthEmbedding *e,
                         LthInterpolation interpolation, LthSamples samples,
                         const LitheIndex *cell_record, LthEmbeddingRows **rows) {
  LitheStatus status = LITHE_OK;
  LitheIndex *point_sample = NULL;
  Job job = {.ctx = ctx, .e = e, .interpolation = interpolation};
  const LthMesh *mesh = e->mesh;
  job.keeps = rows && interpolation == LTH_EMBED_MLS;
  if (interpolation == LTH_EMBED_MLS) {
    LITHE_TRY_OR(done, lth_samples_create(ctx, mesh, samples, &job.samples));
    LITHE_TRY_OR(done, lth_mls_create(ctx, mesh, job.samples, &job.mls));
  } else {
    LITHE_TRY_OR(done, lth_samples_create_points(ctx, mesh, &job.samples));
    LITHE_TRY_OR(done, match_points(ctx, e, job.samples, &point_sample));
    job.point_sample = point_sample;
  }
  if (job.keeps)
    LITHE_TRY_OR(done, lth_kept_rows_find(ctx, &job.mls, e, cell_record, *rows, &job.kept));
  LITHE_TRY_OR(done, make_rows(&job));
  LITHE_TRY_OR(done, add_own_samples(&job));
  LITHE_TRY_OR(done, join_rows(&job));
  LITHE_TRY_OR(done, make_averages(ctx, space, job.samples, e));
  if (job.keeps) LITHE_TRY_OR(done, lth_kept_rows_finish(ctx, &job.kept, e, rows));
done:
  free_job(&job, point_sample);
  return status;
}

static LitheStatus create(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                          const double *points, const LitheIndex *point_cell,
                          LthInterpolation interpolation, LthSamples samples,
                          const LitheIndex *cell_record, LthEmbeddingRows **rows,
                          LthEmbedding **embedding) {
  LitheStatus status = LITHE_OK;
  LthEmbedding *e = NULL;
  *embedding = NULL;
  LTH_NEW(ctx, e, 1);
  e->mesh = space->mesh;
  e->sample_width = 1;
  e->n_funcs = space->n_funcs;
  e->n_rows = space->n_cells;
  e->row_func = space->func_off;
  e->n_points = n;
  LTH_NEW_OR(done, ctx, e->rest, 3 * (LitheCount)n);
  LTH_NEW_OR(done, ctx, e->off, (LitheCount)n + 1);
  memcpy(e->rest, points, sizeof *points * 3 * (size_t)n);
  LITHE_TRY_OR(done, lth_embedding_find_cells(ctx, e, point_cell));
  LITHE_TRY_OR(done, build(ctx, space, e, interpolation, samples, cell_record, rows));
done:
  if (status != LITHE_OK) lth_embedding_destroy(ctx, &e);
  *embedding = e;
  return status;
}

LitheStatus lth_embedding_create(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                                 const double *points, const LitheIndex *point_cell,
                                 LthInterpolation interpolation, LthSamples samples,
                                 LthEmbedding **embedding) {
  return create(ctx, space, n, points, point_cell, interpolation, samples, NULL, NULL, embedding);
}

LitheStatus lth_embedding_renew(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n,
                                const double *points, const LitheIndex *point_cell,
                                LthInterpolation interpolation, LthSamples samples,
                                const LitheIndex *cell_record, LthEmbeddingRows **rows,
                                LthEmbedding **embedding) {
  return create(ctx, space, n, points, point_cell, interpolation, samples, cell_record, rows,
                embedding);
}
