/// Rows of weights that a change of elements leaves as they are: those of points around which a search finds the same cells with the
/// same samples, in the same order, as it did before.
#include "embed/weights.h"

#include "base/digest.h"
#include "base/tensor.h"

#include <string.h>

struct LthEmbeddingRows {
  LitheIndex n_points, n_cells, n_samples, n_records, n_kept;
  double *rest;       ///< (n_points x 3)
  LitheIndex *record; ///< of the cell of each point                    (n_points)
  bool *is_plain;     ///< rows that can be taken                       (n_points)
  LitheCount *off;    ///< (n_points + 1)
  LitheIndex *sample;
  double *weight;
  LitheIndex *place; ///< cell of each record, -1                      (n_records)
  uint64_t *own,
      *zone; ///< digests of a cell, and of all that its points reach; 0: of none (n_cells)
  LitheCount *of_cell_off;
  LitheIndex *of_cell; ///< as LthSampleSet has them
};

void lth_embedding_rows_destroy(LitheCtx *ctx, LthEmbeddingRows **rows) {
  LthEmbeddingRows *r = rows ? *rows : NULL;
  if (!r) return;
  void *blocks[] = {r->rest,  r->record, r->is_plain, r->off,         r->sample, r->weight,
                    r->place, r->own,    r->zone,     r->of_cell_off, r->of_cell};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, r);
  *rows = NULL;
}

LitheIndex lth_embedding_rows_kept(const LthEmbeddingRows *rows) { return rows->n_kept; }

// ------------------------------------------------------------------ digests

/// Making the digests of one mesh.
typedef struct Digests {
  const LthMls *mls;
  const LitheIndex *record; ///< of cells
  LthEmbeddingRows *to;
  double *box;              ///< of the points of each cell               (n_cells x 6)
  LitheIndex *mark, *queue; ///< (n_cells)
} Digests;

static uint64_t add(const void *data, size_t size, uint64_t digest) {
  return lth_digest(data, size, digest);
}

/// What a search reads of a cell before it enters it.
static uint64_t add_outside(const Digests *d, LitheIndex cell, uint64_t digest) {
  digest = add(d->record + cell, sizeof *d->record, digest);
  digest = add(d->mls->cell_radius + cell, sizeof(double), digest);
  return add(d->mls->mesh->cell_box + 6 * (size_t)cell, 6 * sizeof(double), digest);
}

/// And inside: samples with the cells that they average, and the neighbours.
static uint64_t digest_cell(const Digests *d, LitheIndex cell) {
  const LthSampleSet *set = d->mls->samples;
  uint64_t digest = add_outside(d, cell, 0);
  for (LitheCount e = set->of_cell_off[cell]; e < set->of_cell_off[cell + 1]; e++) {
    LitheIndex i = set->of_cell[e];
    digest = add(set->point + 3 * (size_t)i, 3 * sizeof(double), digest);
    digest = add(set->radius + i, sizeof(double), digest);
    for (LitheCount k = set->cell_off[i]; k < set->cell_off[i + 1]; k++)
      digest = add(d->record + set->cell[k], sizeof *d->record, digest);
  }
  for (LitheIndex k = d->mls->neighbor_off[cell]; k < d->mls->neighbor_off[cell + 1]; k++)
    digest = add_outside(d, d->mls->neighbor[k], digest);
  return digest;
}

static double box_distance2(const double a[6], const double b[6]) {
  double sum = 0;
  for (int i = 0; i < 3; i++) {
    double d = fmax(0, fmax(a[i] - b[3 + i], b[i] - a[3 + i]));
    sum += d * d;
  }
  return sum;
}

/// The cells that a search from any point of a cell can enter, in order. Near the front of a cut it reads more than cells: 0.
static uint64_t digest_zone(Digests *d, LitheIndex cell) {
  const LthMls *mls = d->mls;
  const double *box = d->box + 6 * (size_t)cell;
  LitheIndex head = 0, tail = 0;
  uint64_t digest = 1;
  if (mls->cell_front && mls->cell_front[cell] < mls->largest_radius) return 0;
  d->queue[tail++] = cell;
  d->mark[cell] = cell + 1;
  while (head < tail) {
    LitheIndex c = d->queue[head++];
    digest = add(d->to->own + c, sizeof *d->to->own, digest);
    for (LitheIndex k = mls->neighbor_off[c]; k < mls->neighbor_off[c + 1]; k++) {
      LitheIndex other = mls->neighbor[k];
      double reach = mls->cell_radius[other];
      if (d->mark[other] == cell + 1) continue;
      d->mark[other] = cell + 1;
      if (box_distance2(mls->mesh->cell_box + 6 * (size_t)other, box) < reach * reach)
        d->queue[tail++] = other;
    }
  }
  return digest == 0 ? 1 : digest;
}

static void find_boxes(const LthEmbedding *e, LitheIndex n_cells, double *box) {
  for (LitheIndex c = 0; c < n_cells; c++)
    for (int a = 0; a < 3; a++)
      box[6 * (size_t)c + a] = INFINITY, box[6 * (size_t)c + 3 + a] = -INFINITY;
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double *b = box + 6 * (size_t)e->cell[p];
    for (int a = 0; a < 3; a++) {
      b[a] = fmin(b[a], e->rest[3 * (size_t)p + a]);
      b[3 + a] = fmax(b[3 + a], e->rest[3 * (size_t)p + a]);
    }
  }
}

static LitheStatus make_digests(LitheCtx *ctx, const LthMls *mls, const LthEmbedding *e,
                                const LitheIndex *cell_record, LthEmbeddingRows *to) {
  LitheStatus status = LITHE_OK;
  Digests d = {.mls = mls, .record = cell_record, .to = to};
  LitheIndex n = mls->mesh->n_cells;
  LTH_NEW_OR(done, ctx, to->own, n);
  LTH_NEW_OR(done, ctx, to->zone, n);
  LTH_NEW_OR(done, ctx, d.box, 6 * (LitheCount)n);
  LTH_NEW_OR(done, ctx, d.mark, n);
  LTH_NEW_OR(done, ctx, d.queue, n);
  find_boxes(e, n, d.box);
  for (LitheIndex c = 0; c < n; c++) to->own[c] = digest_cell(&d, c);
  for (LitheIndex c = 0; c < n; c++)
    if (d.box[6 * (size_t)c] <= d.box[6 * (size_t)c + 3]) to->zone[c] = digest_zone(&d, c);
done:
  lth_free(ctx, d.box);
  lth_free(ctx, d.mark);
  lth_free(ctx, d.queue);
  return status;
}

// ------------------------------------------------------------------ what is kept

static LitheStatus copy_samples(LitheCtx *ctx, const LthMls *mls, LthEmbeddingRows *to) {
  const LthSampleSet *set = mls->samples;
  LitheIndex n = mls->mesh->n_cells;
  LitheCount total = set->of_cell_off[n];
  LTH_NEW(ctx, to->of_cell_off, (LitheCount)n + 1);
  LTH_NEW(ctx, to->of_cell, total);
  memcpy(to->of_cell_off, set->of_cell_off, sizeof *to->of_cell_off * ((size_t)n + 1));
  if (total > 0) memcpy(to->of_cell, set->of_cell, sizeof *to->of_cell * (size_t)total);
  to->n_cells = n;
  to->n_samples = set->n;
  return LITHE_OK;
}

static LitheStatus copy_points(LitheCtx *ctx, const LthEmbedding *e, const LitheIndex *cell_record,
                               LthEmbeddingRows *to) {
  LitheIndex n = e->n_points;
  LTH_NEW(ctx, to->rest, 3 * (LitheCount)n);
  LTH_NEW(ctx, to->record, n);
  LTH_NEW(ctx, to->is_plain, n);
  memcpy(to->rest, e->rest, 3 * sizeof *to->rest * (size_t)n);
  for (LitheIndex p = 0; p < n; p++) to->record[p] = cell_record[e->cell[p]];
  to->n_points = n;
  for (LitheIndex c = 0; c < to->n_cells; c++)
    if (cell_record[c] >= to->n_records) to->n_records = cell_record[c] + 1;
  LTH_NEW(ctx, to->place, to->n_records);
  for (LitheIndex i = 0; i < to->n_records; i++) to->place[i] = -1;
  for (LitheIndex c = 0; c < to->n_cells; c++) to->place[cell_record[c]] = c;
  return LITHE_OK;
}

/// Samples of cells that are what they were, one by one.
static void match_samples(const LthEmbeddingRows *from, const LthEmbeddingRows *to,
                          const LitheIndex *cell_record, LitheIndex *sample) {
  for (LitheIndex i = 0; i < from->n_samples; i++) sample[i] = -1;
  for (LitheIndex c = 0; c < to->n_cells; c++) {
    LitheIndex old = cell_record[c] < from->n_records ? from->place[cell_record[c]] : -1;
    if (old < 0 || from->own[old] != to->own[c]) continue;
    LitheCount n = to->of_cell_off[c + 1] - to->of_cell_off[c];
    for (LitheCount k = 0; k < n; k++)
      sample[from->of_cell[from->of_cell_off[old] + k]] = to->of_cell[to->of_cell_off[c] + k];
  }
}

static bool is_same(const LthKeptRows *kept, const LthEmbedding *e, LitheIndex p) {
  const LthEmbeddingRows *from = kept->from, *to = kept->to;
  if (p >= from->n_points || !from->is_plain[p] || from->record[p] != to->record[p]) return false;
  uint64_t before = from->zone[from->place[from->record[p]]], now = to->zone[e->cell[p]];
  return now != 0 && now == before &&
         memcmp(e->rest + 3 * (size_t)p, from->rest + 3 * (size_t)p, 3 * sizeof *e->rest) == 0;
}

LitheStatus lth_kept_rows_find(LitheCtx *ctx, const LthMls *mls, const LthEmbedding *e,
                               const LitheIndex *cell_record, const LthEmbeddingRows *rows,
                               LthKeptRows *kept) {
  *kept = (LthKeptRows){.from = rows};
  LTH_NEW(ctx, kept->to, 1);
  LTH_NEW(ctx, kept->is_kept, e->n_points);
  LITHE_TRY(copy_samples(ctx, mls, kept->to));
  LITHE_TRY(copy_points(ctx, e, cell_record, kept->to));
  LITHE_TRY(make_digests(ctx, mls, e, cell_record, kept->to));
  if (!rows) return LITHE_OK;
  LTH_NEW(ctx, kept->sample, rows->n_samples);
  match_samples(rows, kept->to, cell_record, kept->sample);
  for (LitheIndex p = 0; p < e->n_points; p++) {
    kept->is_kept[p] = is_same(kept, e, p);
    kept->to->n_kept += kept->is_kept[p];
  }
  return LITHE_OK;
}

LitheStatus lth_kept_rows_take(LitheCtx *ctx, const LthKeptRows *kept, LitheIndex p,
                               LthWeightRow *row) {
  const LthEmbeddingRows *from = kept->from;
  for (LitheCount i = from->off[p]; i < from->off[p + 1]; i++) {
    LITHE_ASSERT(kept->sample[from->sample[i]] >= 0);
    LITHE_TRY(lth_row_add(ctx, row, kept->sample[from->sample[i]], from->weight[i]));
  }
  row->is_plain = true;
  return LITHE_OK;
}

void lth_kept_rows_note(LthKeptRows *kept, LitheIndex p, const LthWeightRow *row) {
  kept->to->is_plain[p] = row->is_plain && row->n > 0;
}

LitheStatus lth_kept_rows_finish(LitheCtx *ctx, LthKeptRows *kept, const LthEmbedding *e,
                                 LthEmbeddingRows **rows) {
  LthEmbeddingRows *to = kept->to;
  LitheCount total = e->off[e->n_points];
  LTH_NEW(ctx, to->off, (LitheCount)e->n_points + 1);
  LTH_NEW(ctx, to->sample, total);
  LTH_NEW(ctx, to->weight, total);
  memcpy(to->off, e->off, sizeof *to->off * ((size_t)e->n_points + 1));
  if (total > 0) memcpy(to->sample, e->sample, sizeof *to->sample * (size_t)total);
  if (total > 0) memcpy(to->weight, e->weight, sizeof *to->weight * (size_t)total);
  lth_embedding_rows_destroy(ctx, rows);
  *rows = to;
  kept->to = NULL;
  return LITHE_OK;
}

void lth_kept_rows_free(LitheCtx *ctx, LthKeptRows *kept) {
  lth_embedding_rows_destroy(ctx, &kept->to);
  lth_free(ctx, kept->sample);
  lth_free(ctx, kept->is_kept);
}
