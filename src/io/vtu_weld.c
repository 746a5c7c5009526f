/// Points that are the same but for rounding, found by a hash over small cubes.
#include "base/hash.h"
#include "io/vtu_file.h"

#include "base/tensor.h"

/// Cubes have this many tolerances to a side, so that a point has to look into few neighbours.
#define CUBE 16

typedef struct Weld {
  const double *x;
  double tolerance, side;
  LthHash cubes;    ///< the last point of a cube
  LitheIndex *next; ///< the point before in the same cube, -1
} Weld;

static void key_of(const int64_t cube[3], uint64_t key[2]) {
  key[0] = (uint64_t)cube[0] * 0x9E3779B97F4A7C15u ^ (uint64_t)cube[1];
  key[1] = (uint64_t)cube[1] * 0xD6E8FEB86659FD93u ^ (uint64_t)cube[2];
}

static LitheIndex find_in(const Weld *w, const int64_t cube[3], LitheIndex i) {
  uint64_t key[2];
  key_of(cube, key);
  for (LitheIndex k = lth_hash_find(&w->cubes, key[0], key[1]); k >= 0; k = w->next[k])
    if (lth_v3_distance(w->x + 3 * (LitheCount)k, w->x + 3 * (LitheCount)i) <= w->tolerance)
      return k;
  return -1;
}

/// A point entered before within the tolerance, -1.
static LitheIndex find_near(const Weld *w, LitheIndex i, int64_t own[3]) {
  int64_t low[3], high[3], cube[3];
  for (int a = 0; a < 3; a++) {
    double x = w->x[3 * (LitheCount)i + a];
    own[a] = (int64_t)floor(x / w->side);
    low[a] = (int64_t)floor((x - w->tolerance) / w->side);
    high[a] = (int64_t)floor((x + w->tolerance) / w->side);
  }
  for (cube[0] = low[0]; cube[0] <= high[0]; cube[0]++)
    for (cube[1] = low[1]; cube[1] <= high[1]; cube[1]++)
      for (cube[2] = low[2]; cube[2] <= high[2]; cube[2]++) {
        LitheIndex found = find_in(w, cube, i);
        if (found >= 0) return found;
      }
  return -1;
}

/// Make point i the head of its cube's list.
static LitheStatus enter(LitheCtx *ctx, Weld *w, const int64_t cube[3], LitheIndex i) {
  uint64_t key[2];
  LitheIndex head = 0;
  key_of(cube, key);
  LITHE_TRY(lth_hash_insert(ctx, &w->cubes, key[0], key[1], i, &head));
  // the table keeps the first point, so the list goes on behind it
  w->next[i] = -1;
  if (head == i) return LITHE_OK;
  w->next[i] = w->next[head];
  w->next[head] = i;
  return LITHE_OK;
}

LitheStatus lth_vtu_weld(LitheCtx *ctx, LitheIndex n, const double *x, double tolerance,
                         LitheIndex *same) {
  LitheStatus status = LITHE_OK;
  Weld w = {.x = x, .tolerance = tolerance, .side = CUBE * tolerance};
  LTH_NEW_OR(done, ctx, w.next, n);
  for (LitheIndex i = 0; i < n; i++) {
    int64_t cube[3];
    LitheIndex found = find_near(&w, i, cube);
    same[i] = found < 0 ? i : found;
    if (found < 0) LITHE_TRY_OR(done, enter(ctx, &w, cube, i));
  }
done:
  lth_hash_free(ctx, &w.cubes);
  lth_free(ctx, w.next);
  return status;
}
