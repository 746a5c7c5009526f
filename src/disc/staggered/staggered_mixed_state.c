/// Pressures at nu = 0.5 as a state of the body: multipliers of an augmented Lagrangian (Hestenes 1969, Powell 1969).
///
/// In cells of nu = 0.5 the internal force is that of lambda = LTH_PENALTY mu and of a pressure p that is kept,
///   f_int(x) = K x - f0,  f0 = K rest - C^T W p,
/// and p moves to what solutions find, which make tr e = 0: those of the mixed form, or of the matrix with pressures
/// as further unknowns (LthDiscVolume).
#include "disc/staggered/staggered_mixed_state.h"

#include <string.h>

void lth_mixed_high_faces(const LthStaggered *s, LitheCount slot, LitheCount high[3]) {
  for (int a = 0; a < s->dim; a++) {
    int d[3] = {a == 0, a == 1, a == 2};
    high[a] = lth_sparse_grid_step(s->grid, slot, d);
  }
}

/// nu = 0.5, and something is left free to keep the volume.
static bool is_stiff(const LthStaggered *s, LitheCount slot) {
  LitheCount high[3];
  bool any = false;
  if (!(s->level.volume[slot] > 0) || s->level.compliance[slot] != 0) return false;
  lth_mixed_high_faces(s, slot, high);
  for (int a = 0; a < s->dim; a++)
    any |= s->level.state[a][slot] == LTH_UNKNOWN_FREE ||
           s->level.state[a][high[a]] == LTH_UNKNOWN_FREE;
  return any;
}

double lth_mixed_trace(const LthStaggered *s, LitheCount slot, const double *u) {
  LitheCount high[3];
  double sum = 0;
  lth_mixed_high_faces(s, slot, high);
  for (int a = 0; a < s->dim; a++)
    sum += (u[3 * (LitheCount)s->func[high[a]] + a] - u[3 * (LitheCount)s->func[slot] + a]) /
           s->grid->h[a];
  return sum;
}

static double volume_of(const LthStaggered *s, LitheCount slot) {
  return lth_level_value(&s->level, s->level.volume, slot);
}

/// f += C^T W q of one cell.
static void push_faces(const LthStaggered *s, LitheCount slot, double q, double *f) {
  const double volume = lth_sparse_grid_cell_volume(s->grid) * volume_of(s, slot);
  LitheCount high[3];
  lth_mixed_high_faces(s, slot, high);
  for (int a = 0; a < s->dim; a++) {
    double push = volume * q / s->grid->h[a];
    f[3 * (LitheCount)s->func[slot] + a] -= push;
    f[3 * (LitheCount)s->func[high[a]] + a] += push;
  }
}

static LitheCount count(const LthDisc *disc) { return lth_staggered_const(disc)->mixed->n_stiff; }

static void scales(const LthDisc *disc, double *volume, double *lambda) {
  const LthStaggered *s = lth_staggered_const(disc);
  for (LitheIndex i = 0; i < s->mixed->n_stiff; i++) {
    const LitheIndex slot = s->mixed->stiff[i];
    volume[i] = lth_sparse_grid_cell_volume(s->grid) * volume_of(s, slot);
    lambda[i] = lth_level_value(&s->level, s->level.lambda, slot) / volume_of(s, slot);
  }
}

static void strain(const LthDisc *disc, int threads, const double *u, double *c) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < s->mixed->n_stiff; i++)
    c[i] = lth_mixed_trace(s, s->mixed->stiff[i], u);
}

static void push(const LthDisc *disc, const double *q, double *f) {
  const LthStaggered *s = lth_staggered_const(disc);
  const LthMixedState *m = s->mixed;
  for (LitheIndex i = 0; i < m->n_stiff; i++)
    push_faces(s, m->stiff[i], q ? q[i] : m->pressure[m->stiff[i]], f);
}

static void push_change(const LthDisc *disc, double *f) {
  const LthStaggered *s = lth_staggered_const(disc);
  const LthMixedState *m = s->mixed;
  for (LitheIndex i = 0; i < m->n_stiff; i++) {
    const LitheIndex slot = m->stiff[i];
    push_faces(s, slot, m->latest[slot] - m->pressure[slot], f);
  }
}

static void keep(LthDisc *disc, const double *q) {
  LthMixedState *m = lth_staggered_of(disc)->mixed;
  for (LitheIndex i = 0; i < m->n_stiff; i++)
    m->latest[m->stiff[i]] = m->pressure[m->stiff[i]] + q[i];
  lth_mixed_center(lth_staggered_const(disc), m->latest);
}

static const LthDiscVolume volume = {.count = count,
                                     .scales = scales,
                                     .strain = strain,
                                     .admit = lth_mixed_admit,
                                     .push = push,
                                     .push_change = push_change,
                                     .keep = keep};

LitheStatus lth_mixed_state_create(LitheCtx *ctx, LthStaggered *s) {
  LitheIndex n = 0;
  if (!s->level.compliance) return LITHE_OK;
  for (LitheIndex i = 0; i < s->disc.n_cells; i++) n += is_stiff(s, s->cell_slot[i]);
  LTH_NEW(ctx, s->mixed, 1);
  LthMixedState *m = s->mixed;
  if (n == 0) return LITHE_OK;
  LTH_NEW(ctx, m->pressure, s->grid->n_slots);
  LTH_NEW(ctx, m->latest, s->grid->n_slots);
  LTH_NEW(ctx, m->stiff, n);
  for (LitheIndex i = 0; i < s->disc.n_cells; i++)
    if (is_stiff(s, s->cell_slot[i])) m->stiff[m->n_stiff++] = (LitheIndex)s->cell_slot[i];
  s->table.volume = &volume;
  return lth_mixed_closed_create(ctx, s);
}

void lth_mixed_state_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  if (!m) return;
  lth_free(ctx, m->pressure);
  lth_free(ctx, m->latest);
  lth_free(ctx, m->stiff);
  lth_mixed_closed_free(ctx, m);
  lth_free(ctx, m);
  s->mixed = NULL;
}

void lth_mixed_state_linearise(LthStaggered *s) {
  LthMixedState *m = s->mixed;
  if (m && m->pressure)
    memcpy(m->pressure, m->latest, sizeof *m->pressure * (size_t)s->grid->n_slots);
}

void lth_mixed_add_force(const LthStaggered *s, double c, double *f) {
  const LthMixedState *m = s->mixed;
  for (LitheIndex i = 0; m && i < m->n_stiff; i++)
    push_faces(s, m->stiff[i], c * m->pressure[m->stiff[i]], f);
}

double lth_mixed_energy(const LthStaggered *s, const double *x) {
  const LthMixedState *m = s->mixed;
  double sum = 0;
  for (LitheIndex i = 0; m && i < m->n_stiff; i++) {
    const LitheIndex slot = m->stiff[i];
    sum += volume_of(s, slot) * m->latest[slot] * (lth_mixed_trace(s, slot, x) - s->dim);
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
  LTH_ARCHIVE_ARRAY(a, m->pressure, s->grid->n_slots);
  LTH_ARCHIVE_ARRAY(a, m->latest, s->grid->n_slots);
}
