/// Unknowns that constraints hold, what they follow, and the forces that hold them.
#include "disc/staggered/staggered_priv.h"

/// The first constraint that holds component a at x, or -1.
static LitheIndex find_hold(const LthStaggered *s, int a, const double x[3]) {
  for (LitheIndex k = 0; k < s->n_holds; k++) {
    const LthStaggeredHold *hold = &s->holds[k];
    if (hold->fixed[a] && hold->selects(hold->self, x)) return k;
  }
  return -1;
}

/// A cell or a shear sample that holds material reads the unknown of component a.
static bool is_read(const LthStaggeredLevel *level, const LitheCount *slot, const int stride[3],
                    int a) {
  if (lth_level_is_live(level, slot[0]) || lth_level_is_live(level, slot[-stride[a]])) return true;
  for (int b = 0; b < level->grid->dim; b++) {
    if (b == a) continue;
    const double *shear = level->shear[3 - a - b];
    LitheCount high = slot[stride[b]];
    if (shear[slot[0]] > 0 || (high >= 0 && shear[high] > 0)) return true;
  }
  return false;
}

static void mark_slot(LthStaggered *s, const LitheCount *slot, const int stride[3]) {
  for (int a = 0; a < s->dim; a++) {
    double x[3];
    if (!is_read(&s->level, slot, stride, a)) continue;
    lth_staggered_slot_place(s, *slot, a, x);
    if (find_hold(s, a, x) >= 0) s->level.state[a][*slot] = LTH_UNKNOWN_HELD;
  }
}

static void drop_slot(LthStaggered *s, const LitheCount *slot, const int stride[3]) {
  for (int a = 0; a < s->dim; a++) {
    uint8_t *state = &s->level.state[a][*slot];
    if (*state == LTH_UNKNOWN_HELD && !is_read(&s->level, slot, stride, a))
      *state = LTH_UNKNOWN_DEAD;
    if (*state == LTH_UNKNOWN_DEAD) s->level.mass[a][*slot] = 0;
    double full = s->own ? lth_staggered_face_fraction(s, slot, stride, a) : 0;
    if (full > 0) s->level.mass[a][*slot] *= lth_staggered_own_fraction(s, slot, stride, a) / full;
  }
}

static void visit_slots(LthStaggered *s, void (*visit)(LthStaggered *s, const LitheCount *slot,
                                                       const int stride[3])) {
  const LthSparseGrid *g = s->grid;
  if (s->n_holds == 0) return;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++)
      visit(s, halo.slot + lth_halo_at(g, &halo, local), halo.stride);
  }
}

void lth_staggered_mark_held(LthStaggered *s) { visit_slots(s, mark_slot); }
void lth_staggered_drop_unread(LthStaggered *s) { visit_slots(s, drop_slot); }

LitheStatus lth_staggered_build_holds(LitheCtx *ctx, LthStaggered *s) {
  LTH_NEW(ctx, s->held, s->disc.n_dofs);
  if (s->n_holds > INT16_MAX)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "%d constraints are too many for one body: %d at most",
               s->n_holds, INT16_MAX);
  LTH_NEW(ctx, s->hold, s->disc.n_dofs);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < 3; a++) {
      LitheCount k = 3 * (LitheCount)i + a;
      int state = a < s->dim ? s->level.state[a][s->slot[i]] : LTH_UNKNOWN_DEAD;
      double x[3];
      s->held[k] = state == LTH_UNKNOWN_FREE   ? LTH_NOT_HELD
                   : state == LTH_UNKNOWN_HELD ? LTH_HELD
                                               : LTH_ABSENT;
      s->hold[k] = -1;
      if (state != LTH_UNKNOWN_HELD) continue;
      lth_staggered_place(s, i, a, x);
      s->hold[k] = (int16_t)find_hold(s, a, x);
    }
  return LITHE_OK;
}

const uint8_t *lth_staggered_held(const LthDisc *disc) { return lth_staggered_const(disc)->held; }

LitheStatus lth_staggered_prescribe(const void *disc, double t, double *x) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheCount k = 0; k < s->disc.n_dofs; k++) {
    if (!s->held[k]) continue;
    int a = (int)(k % 3);
    double at[3];
    lth_staggered_place(s, (LitheIndex)(k / 3), a, at);
    x[k] = at[a];
    if (s->hold[k] < 0) continue;
    const LthStaggeredHold *hold = &s->holds[s->hold[k]];
    double value = lth_value_at(&hold->value[a], at, t);
    x[k] = hold->is_position ? value : at[a] + value;
  }
  return LITHE_OK;
}

void lth_staggered_add_reactions(const LthDisc *disc, const double *imbalance, double *reaction) {
  const LthStaggered *s = lth_staggered_const(disc);
  for (LitheCount k = 0; k < disc->n_dofs; k++)
    if (s->hold[k] >= 0) reaction[3 * (LitheCount)s->hold[k] + k % 3] -= imbalance[k];
}
