/// Memory of a level's samples: a row for every row of slots while it is built, then those that differ alone.
#include "disc/staggered/staggered_level.h"
#include "disc/staggered/staggered_walls.h"

#include <string.h>

#define MAX_SAMPLES 10
#define SEEN_BITS 14 // of the table of rows met last

LitheStatus lth_staggered_level_alloc(LitheCtx *ctx, const LthSparseGrid *grid,
                                      LthStaggeredLevel *l) {
  LitheStatus status = LITHE_OK;
  const LitheCount n = grid->n_slots + grid->side;
  *l = (LthStaggeredLevel){.grid = grid, .n_rows = (LitheIndex)(grid->n_slots / grid->side)};
  LTH_NEW_OR(done, ctx, l->row, l->n_rows);
  for (LitheIndex r = 0; r < l->n_rows; r++) l->row[r] = r;
  LTH_NEW_OR(done, ctx, l->lambda, n);
  LTH_NEW_OR(done, ctx, l->mu, n);
  for (int a = 0; a < 3; a++) {
    if (grid->dim == 3 || a == 2) LTH_NEW_OR(done, ctx, l->shear[a], n);
    if (a == grid->dim) continue;
    LTH_NEW_OR(done, ctx, l->mass[a], n);
    LTH_NEW_OR(done, ctx, l->state[a], grid->n_slots);
  }
done:
  if (status != LITHE_OK) lth_staggered_level_free(ctx, l);
  return status;
}

void lth_staggered_level_free(LitheCtx *ctx, LthStaggeredLevel *l) {
  lth_free(ctx, l->row);
  lth_free(ctx, l->lambda);
  lth_free(ctx, l->mu);
  lth_free(ctx, l->volume);
  lth_free(ctx, l->compliance);
  lth_staggered_walls_destroy(ctx, &l->walls);
  for (int a = 0; a < 3; a++) {
    lth_free(ctx, l->shear[a]);
    lth_free(ctx, l->mass[a]);
    lth_free(ctx, l->state[a]);
  }
  *l = (LthStaggeredLevel){.grid = l->grid};
}

/// All samples that a level has.
static int samples_of(LthStaggeredLevel *l, double **sample[MAX_SAMPLES]) {
  double **all[MAX_SAMPLES] = {&l->lambda,   &l->mu,        &l->shear[0], &l->shear[1],
                               &l->shear[2], &l->mass[0],   &l->mass[1],  &l->mass[2],
                               &l->volume,   &l->compliance};
  int n = 0;
  for (int i = 0; i < MAX_SAMPLES; i++)
    if (*all[i]) sample[n++] = all[i];
  return n;
}

static uint64_t hash_row(double **const *sample, int n, LitheCount at, int side) {
  uint64_t h = 0;
  for (int v = 0; v < n; v++)
    for (int i = 0; i < side; i++) {
      uint64_t bits;
      memcpy(&bits, *sample[v] + at + i, sizeof bits);
      h = (h ^ bits) * 0x9E3779B97F4A7C15u;
      h ^= h >> 32;
    }
  return h;
}

static bool are_alike(double **const *sample, int n, LitheCount a, LitheCount b, int side) {
  for (int v = 0; v < n; v++)
    if (memcmp(*sample[v] + a, *sample[v] + b, sizeof(double) * (size_t)side) != 0) return false;
  return true;
}

/// Move rows that were not met lately to the front; returns how many.
static LitheIndex gather_rows(LthStaggeredLevel *l, double **const *sample, int n_samples,
                              LitheIndex *seen) {
  const int side = l->grid->side;
  LitheIndex n = 0;
  for (LitheIndex r = 0; r < l->n_rows; r++) {
    const LitheCount from = (LitheCount)r * side, to = (LitheCount)n * side;
    LitheIndex *known = &seen[hash_row(sample, n_samples, from, side) >> (64 - SEEN_BITS)];
    if (*known > 0 && are_alike(sample, n_samples, from, (LitheCount)(*known - 1) * side, side)) {
      l->row[r] = *known - 1;
      continue;
    }
    for (int v = 0; v < n_samples && from != to; v++)
      memcpy(*sample[v] + to, *sample[v] + from, sizeof(double) * (size_t)side);
    l->row[r] = n++;
    *known = n;
  }
  return n;
}

LitheStatus lth_staggered_level_pack(LitheCtx *ctx, LthStaggeredLevel *l) {
  double **sample[MAX_SAMPLES];
  const int n_samples = samples_of(l, sample), side = l->grid->side;
  LitheIndex *seen;
  LTH_NEW(ctx, seen, (LitheCount)1 << SEEN_BITS);
  l->n_rows = gather_rows(l, sample, n_samples, seen);
  lth_free(ctx, seen);
  for (int v = 0; v < n_samples; v++) {
    double *kept;
    LTH_NEW(ctx, kept, ((LitheCount)l->n_rows + 1) * side);
    memcpy(kept, *sample[v], sizeof(double) * (size_t)l->n_rows * (size_t)side);
    lth_free(ctx, *sample[v]);
    *sample[v] = kept;
  }
  return LITHE_OK;
}

LitheCount lth_staggered_level_bytes(const LthStaggeredLevel *l) {
  const LthSparseGrid *g = l->grid;
  LitheCount samples = 2 + (l->volume != NULL) + (l->compliance != NULL);
  for (int a = 0; a < 3; a++) samples += (l->shear[a] != NULL) + (l->mass[a] != NULL);
  return samples * 8 * ((LitheCount)l->n_rows + 1) * g->side + g->dim * g->n_slots +
         4 * g->n_slots / g->side;
}
