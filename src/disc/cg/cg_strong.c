/// Strong constraints: a list of held unknowns and what they follow.
#include "disc/cg/cg_strong.h"

#include <string.h>

typedef struct HeldUnknown {
  LitheCount unknown;
  LitheIndex motion;
  double rest[3]; ///< of the node
} HeldUnknown;

struct LthCgStrong {
  LthCgMotion *motions;
  uint8_t *held; ///< (n_dofs)
  HeldUnknown *list;
  LitheCount n;
};

void lth_cg_strong_destroy(LitheCtx *ctx, LthCgStrong **strong) {
  if (!strong || !*strong) return;
  lth_free(ctx, (*strong)->motions);
  lth_free(ctx, (*strong)->held);
  lth_free(ctx, (*strong)->list);
  lth_free(ctx, *strong);
  *strong = NULL;
}

static LitheStatus fill(LitheCtx *ctx, const LthDisc *disc, const LitheIndex *motion_of,
                        LthCgStrong *strong) {
  LitheStatus status = LITHE_OK;
  double *rest = NULL;
  for (LitheCount i = 0; i < disc->n_dofs; i++) strong->n += motion_of[i] >= 0;
  LTH_NEW_OR(done, ctx, strong->held, disc->n_dofs);
  LTH_NEW_OR(done, ctx, strong->list, strong->n);
  LTH_NEW_OR(done, ctx, rest, disc->n_dofs);
  disc->table->rest(disc, rest);
  strong->n = 0;
  for (LitheCount i = 0; i < disc->n_dofs; i++) {
    if (motion_of[i] < 0) continue;
    HeldUnknown *held = &strong->list[strong->n++];
    *held = (HeldUnknown){.unknown = i, .motion = motion_of[i]};
    memcpy(held->rest, rest + i / 3 * 3, sizeof held->rest);
    strong->held[i] = 1;
  }
done:
  lth_free(ctx, rest);
  return status;
}

LitheStatus lth_cg_strong_create(LitheCtx *ctx, const LthDisc *disc, const LitheIndex *motion_of,
                                 LitheIndex n_motions, const LthCgMotion *motions,
                                 LthCgStrong **strong) {
  LitheStatus status = LITHE_OK;
  *strong = NULL;
  LTH_NEW(ctx, *strong, 1);
  LTH_NEW_OR(done, ctx, (*strong)->motions, n_motions);
  for (LitheIndex i = 0; i < n_motions; i++) (*strong)->motions[i] = motions[i];
  LITHE_TRY_OR(done, fill(ctx, disc, motion_of, *strong));
done:
  if (status != LITHE_OK) lth_cg_strong_destroy(ctx, strong);
  return status;
}

const uint8_t *lth_cg_strong_held(const LthCgStrong *strong) { return strong->held; }

LitheStatus lth_cg_strong_prescribe(const void *self, double t, double *x) {
  const LthCgStrong *strong = self;
  for (LitheCount k = 0; k < strong->n; k++) {
    const HeldUnknown *held = &strong->list[k];
    const LthCgMotion *motion = &strong->motions[held->motion];
    int a = (int)(held->unknown % 3);
    double value = lth_value_at(&motion->value[a], held->rest, t);
    x[held->unknown] = motion->is_position ? value : held->rest[a] + motion->factor[a] * value;
  }
  return LITHE_OK;
}

void lth_cg_strong_add_reactions(const LthCgStrong *strong, const double *imbalance,
                                 double *reaction) {
  for (LitheCount k = 0; k < strong->n; k++) {
    const HeldUnknown *held = &strong->list[k];
    LitheIndex constraint = strong->motions[held->motion].constraint;
    reaction[3 * (LitheCount)constraint + held->unknown % 3] -= imbalance[held->unknown];
  }
}
