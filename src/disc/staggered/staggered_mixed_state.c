/// Pressures at nu = 0.5 as a state of the body: multipliers of an augmented Lagrangian (Hestenes 1969, Powell 1969).
///
/// In cells of nu = 0.5 the internal force is that of lambda = LTH_PENALTY mu and of a pressure p that is kept,
///   f_int(x) = K x - f0,  f0 = K rest - B^T p,
/// and p moves with the solutions: by solves of the mixed form to what they find, else by p += lambda tr e at each
/// linearisation. Where tr e = 0 both are in balance with the same p.
#include "disc/staggered/staggered_mixed_state.h"

#include <string.h>

static bool is_stiff(const LthStaggered *s, LitheCount slot) {
  return s->level.volume[slot] > 0 && s->level.compliance[slot] == 0;
}

LitheStatus lth_mixed_state_create(LitheCtx *ctx, LthStaggered *s) {
  LitheCount n = 0;
  if (s->formulation != LTH_FORM_MIXED) return LITHE_OK;
  for (LitheCount slot = 0; slot < s->grid->n_slots; slot++) n += is_stiff(s, slot);
  LTH_NEW(ctx, s->mixed, 1);
  LthMixedState *m = s->mixed;
  if (n == 0) return LITHE_OK;
  LTH_NEW(ctx, m->pressure, s->grid->n_slots);
  LTH_NEW(ctx, m->latest, s->grid->n_slots);
  LTH_NEW(ctx, m->trace, s->grid->n_slots);
  return LITHE_OK;
}

void lth_mixed_state_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  if (!m) return;
  lth_free(ctx, m->pressure);
  lth_free(ctx, m->latest);
  lth_free(ctx, m->trace);
  lth_free(ctx, m);
  s->mixed = NULL;
}

/// Slots of the high faces of a cell.
static void high_faces(const LthStaggered *s, LitheCount slot, LitheCount high[3]) {
  for (int a = 0; a < s->dim; a++) {
    int d[3] = {a == 0, a == 1, a == 2};
    high[a] = lth_sparse_grid_step(s->grid, slot, d);
  }
}

double lth_mixed_trace(const LthStaggered *s, LitheCount slot, const double *x) {
  LitheCount high[3];
  double sum = 0;
  high_faces(s, slot, high);
  for (int a = 0; a < s->dim; a++)
    sum += (x[3 * (LitheCount)s->func[high[a]] + a] - x[3 * (LitheCount)s->func[slot] + a]) /
               s->grid->h[a] -
           1;
  return sum;
}

/// p += lambda tr e, once for each state: to linearise twice at one place changes nothing.
static void update_multipliers(const LthStaggered *s, LthMixedState *m, const double *x) {
  bool moved = false;
  for (LitheCount i = 0; i < s->disc.n_cells; i++) {
    const LitheCount slot = s->cell_slot[i];
    if (!is_stiff(s, slot)) continue;
    double trace = lth_mixed_trace(s, slot, x);
    moved |= trace != m->trace[slot];
    m->trace[slot] = trace;
  }
  for (LitheCount slot = 0; moved && slot < s->grid->n_slots; slot++)
    if (is_stiff(s, slot))
      m->latest[slot] =
          m->pressure[slot] + s->level.lambda[slot] / s->level.volume[slot] * m->trace[slot];
}

void lth_mixed_state_linearise(LthStaggered *s, const double *x) {
  LthMixedState *m = s->mixed;
  if (!x || !m || !m->pressure) return;
  if (!m->is_solved) update_multipliers(s, m, x);
  memcpy(m->pressure, m->latest, sizeof *m->pressure * (size_t)s->grid->n_slots);
}

void lth_mixed_add_force(const LthStaggered *s, double c, double *f) {
  const LthMixedState *m = s->mixed;
  if (!m || !m->pressure) return;
  const double volume = lth_sparse_grid_cell_volume(s->grid);
  for (LitheCount i = 0; i < s->disc.n_cells; i++) {
    const LitheCount slot = s->cell_slot[i];
    LitheCount high[3];
    if (!is_stiff(s, slot)) continue;
    high_faces(s, slot, high);
    for (int a = 0; a < s->dim; a++) {
      double push = c * volume * s->level.volume[slot] * m->pressure[slot] / s->grid->h[a];
      f[3 * (LitheCount)s->func[slot] + a] -= push;
      f[3 * (LitheCount)s->func[high[a]] + a] += push;
    }
  }
}

double lth_mixed_energy(const LthStaggered *s, const double *x) {
  const LthMixedState *m = s->mixed;
  double sum = 0;
  if (!m || !m->pressure) return 0;
  for (LitheCount i = 0; i < s->disc.n_cells; i++) {
    const LitheCount slot = s->cell_slot[i];
    if (is_stiff(s, slot))
      sum += s->level.volume[slot] * m->latest[slot] * lth_mixed_trace(s, slot, x);
  }
  return sum * lth_sparse_grid_cell_volume(s->grid);
}

double lth_mixed_pressure(const LthStaggered *s, LitheCount slot) {
  return s->mixed && s->mixed->latest ? s->mixed->latest[slot] : 0;
}

void lth_mixed_state_archive(LthDisc *disc, LthArchive *a) {
  LthStaggered *s = lth_staggered_of(disc);
  LthMixedState *m = s->mixed;
  if (!m || !m->pressure) return;
  lth_archive_mark(a, "pressures");
  LTH_ARCHIVE(a, m->is_solved);
  LTH_ARCHIVE_ARRAY(a, m->pressure, s->grid->n_slots);
  LTH_ARCHIVE_ARRAY(a, m->latest, s->grid->n_slots);
  LTH_ARCHIVE_ARRAY(a, m->trace, s->grid->n_slots);
}
