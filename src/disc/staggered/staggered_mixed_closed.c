/// Parts of a body with nu = 0.5 that are held on all sides: nothing fixes their mean pressure, and their volume is what
/// the prescribed displacement makes it.
///
/// Cells hang together through free faces. A part is closed where all of these have such a cell on both sides: then
/// V p may rise by a constant without any force, and the sum of tr e is that of its held faces.
#include "base/disjoint_sets.h"
#include "disc/staggered/staggered_mixed_state.h"

#include <math.h>

#define CURVED 1e-2 // of the flow through held faces, that places on the grid may not balance

static bool is_free(const LthStaggered *s, int a, LitheCount slot) {
  return s->level.state[a][slot] == LTH_UNKNOWN_FREE;
}

/// Join the cells on both sides of free faces; those beside a face with one such cell alone join cell n, which is not
/// closed.
static void join(const LthStaggered *s, const LitheIndex *number, LitheIndex *set) {
  const LthMixedState *m = s->mixed;
  for (LitheIndex i = 0; i < m->n_stiff; i++) {
    LitheCount high[3];
    lth_mixed_high_faces(s, m->stiff[i], high);
    for (int a = 0; a < s->dim; a++) {
      const int d[3] = {-(a == 0), -(a == 1), -(a == 2)};
      const LitheCount low = lth_sparse_grid_step(s->grid, m->stiff[i], d);
      if (is_free(s, a, m->stiff[i]))
        lth_sets_unite(set, i, low >= 0 && number[low] >= 0 ? number[low] : m->n_stiff);
      if (is_free(s, a, high[a]))
        lth_sets_unite(set, i, number[high[a]] >= 0 ? number[high[a]] : m->n_stiff);
    }
  }
}

/// Number the sets other than that of cell n.
static LitheStatus number_parts(LitheCtx *ctx, LthMixedState *m, LitheIndex *set) {
  const LitheIndex open = lth_sets_root(set, m->n_stiff);
  for (LitheIndex i = 0; i < m->n_stiff; i++)
    m->n_closed += lth_sets_root(set, i) == i && i != open;
  if (m->n_closed == 0) return LITHE_OK;
  LTH_NEW(ctx, m->closed, m->n_stiff);
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < m->n_stiff; i++)
    if (lth_sets_root(set, i) == i) m->closed[i] = i == open ? -1 : n++;
  for (LitheIndex i = 0; i < m->n_stiff; i++) {
    const LitheIndex root = lth_sets_root(set, i);
    m->closed[i] = root == open ? -1 : m->closed[root];
  }
  return LITHE_OK;
}

LitheStatus lth_mixed_closed_create(LitheCtx *ctx, const LthStaggered *s) {
  LitheStatus status = LITHE_OK;
  LthMixedState *m = s->mixed;
  LitheIndex *number = NULL, *set = NULL;
  LTH_NEW_OR(done, ctx, number, s->grid->n_slots);
  LTH_NEW_OR(done, ctx, set, (LitheCount)m->n_stiff + 1);
  for (LitheCount slot = 0; slot < s->grid->n_slots; slot++) number[slot] = -1;
  for (LitheIndex i = 0; i < m->n_stiff; i++) number[m->stiff[i]] = i;
  lth_sets_reset(set, m->n_stiff + 1);
  join(s, number, set);
  LITHE_TRY_OR(done, number_parts(ctx, m, set));
done:
  lth_free(ctx, number);
  lth_free(ctx, set);
  return status;
}

void lth_mixed_closed_free(LitheCtx *ctx, LthMixedState *m) { lth_free(ctx, m->closed); }

/// What flows through the held faces of a cell, either way, over its volume.
static double flow_of(const LthStaggered *s, LitheCount slot, const double *u) {
  LitheCount high[3];
  double sum = 0;
  lth_mixed_high_faces(s, slot, high);
  for (int a = 0; a < s->dim; a++) {
    if (!is_free(s, a, slot)) sum += fabs(u[3 * (LitheCount)s->func[slot] + a]) / s->grid->h[a];
    if (!is_free(s, a, high[a]))
      sum += fabs(u[3 * (LitheCount)s->func[high[a]] + a]) / s->grid->h[a];
  }
  return sum;
}

LitheStatus lth_mixed_admit(LitheCtx *ctx, const LthDisc *disc, const double *u, double *c) {
  const LthStaggered *s = lth_staggered_const(disc);
  const LthMixedState *m = s->mixed;
  for (LitheIndex k = 0; k < m->n_closed; k++) {
    LitheIndex n = 0;
    double net = 0, flow = 0;
    for (LitheIndex i = 0; i < m->n_stiff; i++) {
      if (m->closed[i] != k) continue;
      n++;
      net += c[i];
      flow += flow_of(s, m->stiff[i], u);
    }
    if (fabs(net) > CURVED * flow)
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "what does not shrink (poisson_ratio 0.5) is held on all sides, and the prescribed "
          "displacements change its volume by %.3g %%: expected displacements that keep it; "
          "or leave a side free, or take a smaller ratio",
          100 * net / n);
    for (LitheIndex i = 0; i < m->n_stiff; i++)
      if (m->closed[i] == k) c[i] -= net / n;
  }
  return LITHE_OK;
}

void lth_mixed_center(const LthStaggered *s, double *pressure) {
  const LthMixedState *m = s->mixed;
  const LthStaggeredLevel *l = &s->level;
  for (LitheIndex k = 0; k < m->n_closed; k++) {
    LitheIndex n = 0;
    double sum = 0;
    for (LitheIndex i = 0; i < m->n_stiff; i++)
      if (m->closed[i] == k)
        n++, sum += lth_level_value(l, l->volume, m->stiff[i]) * pressure[m->stiff[i]];
    for (LitheIndex i = 0; i < m->n_stiff; i++)
      if (m->closed[i] == k)
        pressure[m->stiff[i]] -= sum / n / lth_level_value(l, l->volume, m->stiff[i]);
  }
}
