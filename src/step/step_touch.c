/// Contact as a sparse matrix for coarse levels: touches lumped to the block rows that they hang on most.
#include "step/simulation_priv.h"

#include <stdlib.h>
#include <string.h>

/// Pairs of block rows (row, col) as one number each, both ways.
typedef struct Pairs {
  LitheCtx *ctx;
  LitheStatus status;
  uint64_t *list;
  LitheCount n, cap;
} Pairs;

static uint64_t pair_of(LitheIndex row, LitheIndex col) {
  return (uint64_t)row << 32 | (uint32_t)col;
}

static LitheStatus reserve(Pairs *p) {
  LTH_RESERVE(p->ctx, p->list, p->cap, p->n + 2);
  return LITHE_OK;
}

static void list_pair(void *self, int n_ends, const LthContactEnd *end, const double *D) {
  Pairs *p = self;
  (void)D;
  if (n_ends < 2 || end[0].row == end[1].row || p->status != LITHE_OK) return;
  p->status = reserve(p);
  if (p->status != LITHE_OK) return;
  p->list[p->n++] = pair_of(end[0].row, end[1].row);
  p->list[p->n++] = pair_of(end[1].row, end[0].row);
}

static int compare(const void *pa, const void *pb) {
  uint64_t a = *(const uint64_t *)pa, b = *(const uint64_t *)pb;
  return (a > b) - (a < b);
}

static void sort_unique(Pairs *p) {
  LitheCount kept = 0;
  if (p->n > 0) qsort(p->list, (size_t)p->n, sizeof *p->list, compare);
  for (LitheCount i = 0; i < p->n; i++)
    if (i == 0 || p->list[i] != p->list[i - 1]) p->list[kept++] = p->list[i];
  p->n = kept;
}

static bool has_pairs(const LthBlockMatrix *touch, const Pairs *p) {
  for (LitheCount i = 0; i < p->n; i++)
    if (lth_block_matrix_find(touch, (LitheIndex)(p->list[i] >> 32),
                              (LitheIndex)(p->list[i] & 0xffffffff)) < 0)
      return false;
  return true;
}

/// An empty matrix of the diagonal and the pairs, which are sorted.
static LitheStatus create_pattern(LitheCtx *ctx, LthSimulation *s, const Pairs *p) {
  LitheStatus status = LITHE_OK;
  const LitheIndex n = s->A->n_rows;
  LitheCount *off = NULL, at = 0;
  LitheIndex *col = NULL;
  lth_block_matrix_destroy(ctx, &s->touch);
  lth_free(ctx, s->touch_first);
  s->touch_first = NULL;
  LTH_NEW_OR(done, ctx, off, n + 1);
  LTH_NEW_OR(done, ctx, col, n + p->n);
  for (LitheIndex row = 0; row < n; row++) {
    LitheCount end = off[row];
    bool has_diagonal = false;
    for (; at < p->n && (LitheIndex)(p->list[at] >> 32) == row; at++) {
      LitheIndex c = (LitheIndex)(p->list[at] & 0xffffffff);
      if (c > row && !has_diagonal) col[end++] = row, has_diagonal = true;
      col[end++] = c;
    }
    if (!has_diagonal) col[end++] = row;
    off[row + 1] = end;
  }
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, n, s->A->row_off, off, col, &s->touch));
  LTH_NEW_OR(done, ctx, s->touch_first, lth_step_touch_values(s));
done:
  lth_free(ctx, off);
  lth_free(ctx, col);
  return status;
}

/// B (3 na x 3 nb) += a D b^T.
static void add_block(const LthContactEnd *a, const LthContactEnd *b, const double *D, double *B) {
  for (int i = 0; i < a->nb; i++)
    for (int k = 0; k < 3; k++) {
      double *row = B + (3 * i + k) * 3 * b->nb;
      for (int j = 0; j < b->nb; j++)
        for (int l = 0; l < 3; l++) row[3 * j + l] += a->phi[i] * b->phi[j] * D[3 * k + l];
    }
}

static void add_lump(void *self, int n_ends, const LthContactEnd *end, const double *D) {
  LthBlockMatrix *touch = self;
  for (int a = 0; a < n_ends; a++)
    for (int b = 0; b < n_ends; b++) {
      LitheCount block = lth_block_matrix_find(touch, end[a].row, end[b].row);
      if (block >= 0) add_block(end + a, end + b, D, touch->values + touch->value_off[block]);
    }
}

/// Block diagonals of a contact that cannot be lumped.
static void add_diagonals(const LthSimulation *s, const LthContact *contact) {
  LthBlockMatrix *T = s->touch;
  const double *from = s->extra;
  memset(s->extra, 0, sizeof *s->extra * (size_t)s->n_extra);
  lth_contact_add_diagonal(contact, s->extra);
  for (LitheIndex row = 0; row < T->n_rows; row++) {
    const LitheCount at = T->value_off[T->diagonal[row]];
    const LitheCount n = T->value_off[T->diagonal[row] + 1] - at;
    for (LitheCount i = 0; i < n; i++) T->values[at + i] += from[i];
    from += n;
  }
}

/// Held unknowns feel nothing.
static void mask_held(const LthSimulation *s) {
  const LthBlockMatrix *T = s->touch;
  const uint8_t *held = s->system->held;
  for (LitheIndex row = 0; held && row < T->n_rows; row++)
    for (LitheCount e = T->block_off[row]; e < T->block_off[row + 1]; e++) {
      LitheIndex col = T->block_col[e];
      LitheCount n = T->row_off[col + 1] - T->row_off[col];
      if (!s->system->row_held[row] && !s->system->row_held[col]) continue;
      for (LitheCount i = T->value_off[e]; i < T->value_off[e + 1]; i++)
        if (held[T->row_off[row] + (i - T->value_off[e]) / n] ||
            held[T->row_off[col] + (i - T->value_off[e]) % n])
          T->values[i] = 0;
    }
}

LitheCount lth_step_touch_values(const LthSimulation *s) {
  return s->touch ? s->touch->value_off[s->touch->block_off[s->touch->n_rows]] : 0;
}

void lth_step_clear_touch(LthSimulation *s) {
  memset(s->touch->values, 0, sizeof *s->touch->values * (size_t)lth_step_touch_values(s));
}

LitheStatus lth_step_lump_contact(LitheCtx *ctx, LthSimulation *s, bool *fits) {
  const LthSystem *system = s->system;
  Pairs p = {.ctx = ctx};
  for (LitheIndex c = 0; c < system->n_contacts; c++)
    lth_contact_visit_lumps(system->contacts[c], false, list_pair, &p);
  LitheStatus status = p.status;
  sort_unique(&p);
  *fits = s->touch && has_pairs(s->touch, &p);
  if (status == LITHE_OK && !*fits) {
    // more than what touches now: what is near may touch before long
    for (LitheIndex c = 0; c < system->n_contacts; c++)
      lth_contact_visit_lumps(system->contacts[c], true, list_pair, &p);
    sort_unique(&p);
    status = p.status == LITHE_OK ? create_pattern(ctx, s, &p) : p.status;
  }
  lth_free(ctx, p.list);
  LITHE_TRY(status);
  lth_step_clear_touch(s);
  for (LitheIndex c = 0; c < system->n_contacts; c++)
    if (!lth_contact_visit_lumps(system->contacts[c], false, add_lump, s->touch))
      add_diagonals(s, system->contacts[c]);
  mask_held(s);
  return LITHE_OK;
}

// --- whether it will do ---

#define OUTGROWN 1.25 // times as stiff as what the levels know

/// Traces of the diagonal blocks that contact has now, and whether its pairs are in the pattern.
typedef struct Weighing {
  const LthBlockMatrix *touch;
  double *trace; // (n_rows)
  bool fits;
} Weighing;

static void weigh(void *self, int n_ends, const LthContactEnd *end, const double *D) {
  Weighing *w = self;
  const double stiffness = D[0] + D[4] + D[8];
  for (int e = 0; e < n_ends; e++)
    for (int j = 0; j < end[e].nb; j++)
      w->trace[end[e].row] += stiffness * end[e].phi[j] * end[e].phi[j];
  if (n_ends == 2 && w->fits)
    w->fits = lth_block_matrix_find(w->touch, end[0].row, end[1].row) >= 0;
}

static double trace_of(const LthBlockMatrix *T, LitheIndex row) {
  const LitheCount m = T->row_off[row + 1] - T->row_off[row];
  const double *B = T->values + T->value_off[T->diagonal[row]];
  double sum = 0;
  for (LitheCount i = 0; i < m; i++) sum += B[i * (m + 1)];
  return sum;
}

static void weigh_diagonals(LthSimulation *s, const LthContact *contact, double *trace) {
  const double *block = s->extra;
  memset(s->extra, 0, sizeof *s->extra * (size_t)s->n_extra);
  lth_contact_add_diagonal(contact, s->extra);
  for (LitheIndex row = 0; row < s->A->n_rows; row++) {
    const LitheCount m = s->A->row_off[row + 1] - s->A->row_off[row];
    for (LitheCount i = 0; i < m; i++) trace[row] += block[i * (m + 1)];
    block += m * m;
  }
}

// Levels that are softer than contact overshoot in the residuals that it makes; stiffer ones only take longer.
bool lth_step_outgrows_levels(LthSimulation *s) {
  const LthSystem *system = s->system;
  Weighing w = {.touch = s->touch, .trace = s->scratch, .fits = true};
  if (!s->touch) return true;
  memset(w.trace, 0, sizeof *w.trace * (size_t)s->A->n_rows);
  for (LitheIndex c = 0; c < system->n_contacts; c++)
    if (!lth_contact_visit_lumps(system->contacts[c], false, weigh, &w))
      weigh_diagonals(s, system->contacts[c], w.trace);
  for (LitheIndex row = 0; row < s->A->n_rows && w.fits; row++)
    w.fits = (system->row_held && system->row_held[row]) ||
             w.trace[row] <= OUTGROWN * trace_of(s->touch, row);
  return !w.fits;
}

// --- in an archive ---

/// Blocks that are not zero.
static void walk_values(const LthBlockMatrix *T, double *values, LthArchive *a) {
  for (LitheCount e = 0; e < T->block_off[T->n_rows] && a->status == LITHE_OK; e++) {
    LitheCount first = T->value_off[e], n = T->value_off[e + 1] - first;
    bool any = false;
    for (LitheCount i = 0; i < n; i++) any |= values[first + i] != 0;
    LTH_ARCHIVE(a, any);
    if (any) lth_archive_array(a, values + first, n, sizeof *values);
  }
}

static void walk_pattern(LthSimulation *s, LthArchive *a, Pairs *p) {
  const LthBlockMatrix *T = s->touch;
  for (LitheIndex row = 0; T && row < T->n_rows && p->status == LITHE_OK; row++)
    for (LitheCount e = T->block_off[row]; e < T->block_off[row + 1]; e++) {
      if (T->block_col[e] == row) continue;
      p->status = reserve(p);
      if (p->status == LITHE_OK) p->list[p->n++] = pair_of(row, T->block_col[e]);
    }
  if (p->status != LITHE_OK) a->status = p->status;
  lth_archive_count(a, &p->n);
  if (a->is_reading && a->status == LITHE_OK && p->n > p->cap)
    a->status = lth_reserve_(a->ctx, (void **)&p->list, &p->cap, p->n, sizeof *p->list);
  LTH_ARCHIVE_ARRAY(a, p->list, p->n);
}

void lth_step_touch_archive(LthSimulation *s, LthArchive *a) {
  Pairs p = {.ctx = a->ctx};
  bool exists = s->touch != NULL;
  LTH_ARCHIVE(a, exists);
  if (!exists || a->status != LITHE_OK) return;
  if (a->is_reading) lth_block_matrix_destroy(a->ctx, &s->touch);
  walk_pattern(s, a, &p);
  if (a->is_reading && a->status == LITHE_OK) a->status = create_pattern(a->ctx, s, &p);
  lth_free(a->ctx, p.list);
  if (a->status != LITHE_OK) return;
  walk_values(s->touch, s->touch->values, a);
  walk_values(s->touch, s->touch_first, a);
}
