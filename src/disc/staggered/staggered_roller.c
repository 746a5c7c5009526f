/// Rollers that are not along an axis: what their points read, and their share of matrix, energy and reactions.
/// Nitsche 1971; docs/theory/staggered.md, "Rollers that are not along an axis".
#include "disc/staggered/staggered_roller.h"
#include "disc/staggered/staggered_mixed_state.h"

#include <stdlib.h>

#define FACTOR 10    // of k: bodies are definite from 3 on, see the theory page
#define FILLED 0.5   // of a cell whose stress is read
#define PRESENT 0.02 // of one around which m is read, and of those beside what it reads
#define DEPTH 1.5    // cells along the normal in which both are sought
#define STEP 0.25    // of that

/// Slot of the live cell at a place, or -1.
static LitheCount slot_at(const LthStaggered *s, const double x[3]) {
  LitheIndex at[3] = {0};
  for (int a = 0; a < s->dim; a++)
    at[a] = (LitheIndex)floor((x[a] - s->grid->origin[a]) / s->grid->h[a]);
  LitheCount slot = lth_sparse_grid_slot(s->grid, at[0], at[1], at[2]);
  return lth_level_is_live(&s->level, slot) ? slot : -1;
}

/// The first cell inwards that is filled so far, or the one nearby that is filled most; -1 where there is none.
static LitheCount slot_within(const LthStaggered *s, const LthRollerPoint *p, double filled) {
  LitheCount best = -1;
  double most = 0, step = 0;
  for (int a = 0; a < s->dim; a++) step = fmax(step, fabs(p->normal[a]) / s->grid->h[a]);
  step = STEP / step;
  for (int i = 0; i <= DEPTH / STEP && most < filled; i++) {
    double x[3];
    lth_v3_copy(p->x, x);
    lth_v3_axpy(-i * step, p->normal, x);
    LitheCount slot = slot_at(s, x);
    double V = lth_level_value(&s->level, s->level.volume, slot);
    if (slot >= 0 && V > most) most = V, best = slot;
  }
  return best;
}

/// A term of the point for a function, new or the one that is there.
static LitheStatus find_term(LitheCtx *ctx, LthStaggeredRollers *r, LthRollerPoint *p,
                             LitheIndex func, LitheCount *term) {
  LitheCount at = p->first;
  while (at < r->n_terms && r->func[at] < func) at++;
  *term = at;
  if (at < r->n_terms && r->func[at] == func) return LITHE_OK;
  LTH_RESERVE(ctx, r->func, r->cap_func, r->n_terms + 1);
  LTH_RESERVE(ctx, r->move, r->cap_move, 3 * (r->n_terms + 1));
  LTH_RESERVE(ctx, r->push, r->cap_push, 3 * (r->n_terms + 1));
  size_t behind = (size_t)(r->n_terms - at);
  memmove(r->func + at + 1, r->func + at, behind * sizeof *r->func);
  memmove(r->move + 3 * (at + 1), r->move + 3 * at, 3 * behind * sizeof *r->move);
  memmove(r->push + 3 * (at + 1), r->push + 3 * at, 3 * behind * sizeof *r->push);
  r->func[at] = func;
  memset(r->move + 3 * at, 0, 3 * sizeof *r->move);
  memset(r->push + 3 * at, 0, 3 * sizeof *r->push);
  r->n_terms++;
  p->n++;
  return LITHE_OK;
}

/// m at a point, by what is around a cell.
static LitheStatus add_move(LitheCtx *ctx, const LthStaggered *s, LitheCount slot,
                            LthStaggeredRollers *r, LthRollerPoint *p) {
  for (int a = 0; a < s->dim; a++) {
    LthStencil t;
    lth_staggered_stencil(s, slot, a, p->x, PRESENT, &t);
    for (int i = 0; i < t.n; i++) {
      LitheCount term;
      LITHE_TRY(find_term(ctx, r, p, s->func[t.slot[i]], &term));
      r->move[3 * term + a] += p->normal[a] * t.w[i];
    }
  }
  return LITHE_OK;
}

/// s in a cell, and k.
static LitheStatus add_push(LitheCtx *ctx, const LthStaggered *s, LitheCount slot,
                            LthStaggeredRollers *r, LthRollerPoint *p) {
  const LitheCount at = lth_level_at(&s->level, slot);
  const double V = s->level.volume[at], *n = p->normal;
  const double lambda = s->level.lambda[at] / V, mu = s->level.mu[at] / V;
  double per_h = 0;
  for (int a = 0; a < s->dim; a++) per_h += fabs(n[a]) / s->grid->h[a];
  p->stiffness = FACTOR * (2 * mu + lambda) * per_h;
  for (int a = 0; a < s->dim; a++) {
    LthStencil t;
    lth_staggered_mean_stencil(s, slot, a, PRESENT, &t);
    for (int i = 0; i < t.n; i++) {
      LitheCount term;
      LITHE_TRY(find_term(ctx, r, p, s->func[t.slot[i]], &term));
      r->push[3 * term + a] += lambda * t.dw[i][a] + 2 * mu * n[a] * lth_v3_dot(n, t.dw[i]);
    }
  }
  return LITHE_OK;
}

/// Terms of all points; those that are far from all that the grid holds go.
static LitheStatus add_terms(LitheCtx *ctx, const LthStaggered *s, LthStaggeredRollers *r) {
  LitheCount kept = 0;
  for (LitheCount i = 0; i < r->n_points; i++) {
    LthRollerPoint *p = r->point + kept;
    *p = r->point[i];
    p->first = r->n_terms;
    LitheCount slot = slot_within(s, p, FILLED);
    if (slot < 0) continue;
    LITHE_TRY(add_move(ctx, s, slot_within(s, p, PRESENT), r, p));
    LITHE_TRY(add_push(ctx, s, slot, r, p));
    kept++;
  }
  r->n_points = kept;
  return LITHE_OK;
}

// --- the matrix ---

static int compare(const void *pa, const void *pb) {
  const LitheIndex *a = pa, *b = pb;
  return *a < *b ? -1 : *a > *b;
}

/// Functions that a function meets, with repetitions: counted, or listed at `near`.
static void visit_pairs(const LthStaggeredRollers *r, LitheCount *count, LitheIndex *near) {
  for (LitheCount i = 0; i < r->n_points; i++) {
    const LthRollerPoint *p = r->point + i;
    for (int j = 0; j < p->n; j++) {
      LitheCount *at = count + r->func[p->first + j];
      if (near) memcpy(near + *at, r->func + p->first, sizeof *near * (size_t)p->n);
      *at += p->n;
    }
  }
}

/// Each list ascending and without repetitions.
static void settle(LitheIndex n_funcs, LthStaggeredRollers *r) {
  LitheCount kept = 0, first = 0;
  for (LitheIndex f = 0; f < n_funcs; f++) {
    LitheCount n = r->near_off[f + 1] - first;
    LitheIndex *list = r->near + first;
    first = r->near_off[f + 1];
    if (n > 0) qsort(list, (size_t)n, sizeof *list, compare);
    for (LitheCount i = 0; i < n; i++)
      if (i == 0 || list[i] != list[i - 1]) r->near[kept++] = list[i];
    r->near_off[f + 1] = kept;
  }
}

static LitheStatus find_near(LitheCtx *ctx, const LthStaggered *s, LthStaggeredRollers *r) {
  LitheStatus status = LITHE_OK;
  const LitheIndex n = s->disc.n_funcs;
  LitheCount *at = NULL;
  LTH_NEW_OR(done, ctx, r->near_off, (LitheCount)n + 1);
  LTH_NEW_OR(done, ctx, at, (LitheCount)n + 1);
  visit_pairs(r, r->near_off + 1, NULL);
  for (LitheIndex f = 0; f < n; f++) at[f + 1] = r->near_off[f + 1] += r->near_off[f];
  LTH_NEW_OR(done, ctx, r->near, r->near_off[n]);
  visit_pairs(r, at, r->near);
  settle(n, r);
done:
  lth_free(ctx, at);
  return status;
}

LitheCount lth_rollers_near(const LthStaggered *s, LitheIndex func, const LitheIndex **near) {
  const LthStaggeredRollers *r = s->rollers;
  *near = r ? r->near + r->near_off[func] : NULL;
  return r ? r->near_off[func + 1] - r->near_off[func] : 0;
}

/// Block of two terms of a point.
static void add_block(const LthStaggeredRollers *r, const LthRollerPoint *p, int i, int j,
                      double *block) {
  const double *mi = r->move + 3 * (p->first + i), *mj = r->move + 3 * (p->first + j);
  const double *si = r->push + 3 * (p->first + i), *sj = r->push + 3 * (p->first + j);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      block[3 * a + b] +=
          p->area * (p->stiffness * mi[a] * mj[b] - (si[a] * mj[b] + mi[a] * sj[b]));
}

void lth_rollers_add_matrix(const LthStaggered *s, LthBlockMatrix *K) {
  const LthStaggeredRollers *r = s->rollers;
  for (LitheCount k = 0; r && k < r->n_points; k++) {
    const LthRollerPoint *p = r->point + k;
    for (int i = 0; i < p->n; i++)
      for (int j = 0; j < p->n; j++) {
        LitheCount e = lth_block_matrix_find(K, r->func[p->first + i], r->func[p->first + j]);
        add_block(r, p, i, j, K->values + K->value_off[e]);
      }
  }
}

// --- what is prescribed, energy, reactions ---

static double value_of(const LthStaggered *s, const LthRollerPoint *p, double t) {
  return lth_value_at(&s->roller[p->roller].value, p->x, t);
}

void lth_rollers_add_load(const LthStaggered *s, double t, double *f0) {
  const LthStaggeredRollers *r = s->rollers;
  for (LitheCount k = 0; r && k < r->n_points; k++) {
    const LthRollerPoint *p = r->point + k;
    const double force = p->area * value_of(s, p, t);
    for (LitheCount i = 3 * p->first; force != 0 && i < 3 * (p->first + p->n); i++)
      f0[3 * (LitheCount)r->func[i / 3] + i % 3] +=
          force * (p->stiffness * r->move[i] - r->push[i]);
  }
}

/// m - g and s at a point, from positions.
static void read_point(const LthStaggered *s, const LthRollerPoint *p, double t, const double *x,
                       double *gap, double *stress) {
  const LthStaggeredRollers *r = s->rollers;
  *gap = -value_of(s, p, t);
  *stress = 0;
  for (LitheCount i = p->first; i < p->first + p->n; i++)
    for (int a = 0; a < s->dim; a++) {
      double at[3];
      lth_staggered_place(s, r->func[i], a, at);
      double u = x[3 * (LitheCount)r->func[i] + a] - at[a];
      *gap += r->move[3 * i + a] * u;
      *stress += r->push[3 * i + a] * u;
    }
}

double lth_rollers_energy(const LthStaggered *s, double t, const double *x) {
  const LthStaggeredRollers *r = s->rollers;
  double sum = 0;
  for (LitheCount k = 0; r && k < r->n_points; k++) {
    double gap, stress;
    read_point(s, r->point + k, t, x, &gap, &stress);
    sum += r->point[k].area * gap * (0.5 * r->point[k].stiffness * gap - stress);
  }
  return sum;
}

void lth_rollers_reactions(LthDisc *disc, double t, const double *x, double *reaction) {
  const LthStaggered *s = lth_staggered_const(disc);
  const LthStaggeredRollers *r = s->rollers;
  memset(reaction, 0, sizeof *reaction * 3 * (size_t)disc->n_weak);
  for (LitheCount k = 0; r && k < r->n_points; k++) {
    const LthRollerPoint *p = r->point + k;
    double gap, stress;
    read_point(s, p, t, x, &gap, &stress);
    lth_v3_axpy(p->area * (stress - p->stiffness * gap), p->normal,
                reaction + 3 * (LitheCount)p->roller);
  }
}

bool lth_rollers_act(const LthStaggered *s) { return s->rollers && s->rollers->n_points > 0; }

bool lth_staggered_roller_acts(const LthDisc *disc, LitheIndex roller) {
  const LthStaggeredRollers *r = lth_staggered_const(disc)->rollers;
  for (LitheCount k = 0; r && k < r->n_points; k++)
    if (r->point[k].roller == roller) return true;
  return false;
}

// --- life ---

/// Rollers as weak constraints of the discretisation.
static LitheStatus tell(LitheCtx *ctx, LthStaggered *s) {
  LTH_NEW(ctx, s->weak, s->n_rollers);
  for (LitheIndex k = 0; k < s->n_rollers; k++) {
    s->weak[k] = (LthWeakConstraint){.normal_only = true, .moves = s->roller[k].moves};
    s->weak[k].value[0] = s->roller[k].value;
  }
  s->disc.weak = s->weak;
  s->disc.n_weak = s->n_rollers;
  return LITHE_OK;
}

LitheStatus lth_rollers_create(LitheCtx *ctx, LthStaggered *s) {
  if (s->n_rollers == 0) return LITHE_OK;
  LTH_NEW(ctx, s->rollers, 1);
  LITHE_TRY(tell(ctx, s));
  LITHE_TRY(lth_rollers_place(ctx, s, s->rollers));
  LITHE_TRY(add_terms(ctx, s, s->rollers));
  if (s->mixed && s->mixed->pressure && s->rollers->n_points > 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "rollers that are not along an axis do not keep volumes: expected a Poisson's ratio "
               "below 0.5, a boundary along an axis, or method dg");
  return find_near(ctx, s, s->rollers);
}

void lth_rollers_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthStaggeredRollers *r = s->rollers;
  lth_free(ctx, s->weak);
  if (!r) return;
  void *blocks[] = {r->point, r->func, r->move, r->push, r->near_off, r->near, r};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}
