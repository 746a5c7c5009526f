/// Which elements are divided, merged, raised and lowered: thresholds with hysteresis.
#include "scene/adapt.h"

#include <math.h>

/// Where an element may be divided and raised alike: fall-off of its polynomial below which it counts as smooth.
#define SMOOTH 0.3
/// A whole element's turn to its neighbours, and the error of one degree less, are foreseen to be so many times larger.
#define TURN_RISE 2
#define ERROR_RISE 10

static bool is_finer(const LthSceneAdapt *rule, const double *value, LitheIndex cell) {
  return rule->is_on && value && value[cell] > rule->threshold;
}

/// Divide or raise where both are asked for: smooth solutions gain more from the degree.
static LthMark choose(const LthBody *body, LitheIndex cell) {
  if (body->space->degree[cell] == 1) return LTH_RAISE; // too little is known to tell
  return lth_dg_roughness(body->op, cell, lth_body_position(body)) < SMOOTH ? LTH_RAISE
                                                                            : LTH_DIVIDE;
}

static LthMark mark_finer(const LthBody *body, const LthAdaptValues *values, LitheIndex cell) {
  const LthSceneAdapt *h = &body->scene->adapt_h, *p = &body->scene->adapt_p;
  LitheIndex record = body->change->cell_record[cell];
  bool divide = is_finer(h, values->h, cell) && body->change->level[record] < h->limit;
  bool raise = is_finer(p, values->p, cell) && body->space->degree[cell] < p->limit;
  if (divide && raise) return choose(body, cell);
  return divide ? LTH_DIVIDE : raise ? LTH_RAISE : LTH_KEEP;
}

/// Is one degree less foreseen to stay below the coarsening threshold?
static bool is_lower(const LthBody *body, const LthAdaptBody *state, const double *value,
                     LitheIndex cell) {
  const LthSceneAdapt *p = &body->scene->adapt_p;
  const LthTopology *t = body->change->topology;
  if (!p->is_on || !value) return false;
  LitheIndex source = t->cells[body->change->cell_record[cell]].source;
  double rise = p->criterion == LTH_BY_ERROR ? ERROR_RISE : 1;
  return body->space->degree[cell] > state->first_degree[source] &&
         rise * value[cell] < p->coarsen * p->threshold;
}

/// What the whole element is foreseen to have.
static double foresee(const LthBody *body, const double *value, const LitheIndex *records,
                      LitheIndex n) {
  LthCriterion criterion = body->scene->adapt_h.criterion;
  double most = 0, sum = 0;
  int degree = 1;
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex cell = body->change->record_cell[records[i]];
    most = fmax(most, value[cell]);
    sum += value[cell] * value[cell];
    if (body->space->degree[cell] > degree) degree = body->space->degree[cell];
  }
  if (criterion == LTH_BY_ERROR) return ldexp(sqrt(sum), degree);
  return criterion == LTH_BY_TURN ? TURN_RISE * most : most;
}

/// Mark the parts of a family if none of them asks for more and the whole is foreseen to need no division.
static LitheStatus mark_family(LitheCtx *ctx, const LthBody *body, const double *value,
                               const LitheIndex *records, LitheIndex n, LthMark *mark) {
  const LthSceneAdapt *h = &body->scene->adapt_h;
  const LthBodyChange *c = body->change;
  bool may;
  for (LitheIndex i = 0; i < n; i++) {
    LthMark m = mark[c->record_cell[records[i]]];
    if (m == LTH_DIVIDE || m == LTH_RAISE) return LITHE_OK;
  }
  if (n == 0 || !(foresee(body, value, records, n) < h->coarsen * h->threshold)) return LITHE_OK;
  LITHE_TRY(lth_refinement_may_merge(ctx, c->refinement, c->topology, records, n, &may));
  for (LitheIndex i = 0; may && i < n; i++) mark[c->record_cell[records[i]]] = LTH_MERGE;
  return LITHE_OK;
}

static LitheStatus mark_families(LitheCtx *ctx, const LthBody *body, const double *value,
                                 LthMark *mark) {
  const LthBodyChange *c = body->change;
  LitheIndex *off = NULL, *list = NULL;
  LitheStatus status = lth_refinement_list(ctx, c->refinement, c->topology, &off, &list);
  for (LitheIndex f = 0; status == LITHE_OK && f < c->refinement->n_families; f++)
    status = mark_family(ctx, body, value, list + off[f], off[f + 1] - off[f], mark);
  lth_free(ctx, off);
  lth_free(ctx, list);
  return status;
}

LitheStatus lth_adapt_mark(LitheCtx *ctx, const LthBody *body, const LthAdaptBody *state,
                           const LthAdaptValues *values, bool may_undo, LthMark *mark) {
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    mark[c] = mark_finer(body, values, c);
    if (mark[c] == LTH_KEEP && may_undo && is_lower(body, state, values->p, c)) mark[c] = LTH_LOWER;
  }
  if (!may_undo || !values->h) return LITHE_OK;
  return mark_families(ctx, body, values->h, mark);
}
