/// Contact's part in the linear system: who hangs on which sample, products, right-hand side, preconditioner.
#include "base/tensor.h"
#include "embed/contact_priv.h"

/// Entries of a touch in the index of a side.
static LitheCount count_entries(const LthTouch *touch, int side, const LthEmbedding *e) {
  LitheCount n = 0;
  for (int l = 0; l < touch->n_legs; l++)
    if (touch->leg[l].side == side)
      n += e->off[touch->leg[l].point + 1] - e->off[touch->leg[l].point];
  return n;
}

LitheStatus lth_contact_reserve(LitheCtx *ctx, LthContact *c) {
  LTH_RESERVE(ctx, c->active, c->active_cap, c->n_touch);
  LTH_RESERVE(ctx, c->force_of, c->force_of_cap, 3 * (LitheCount)c->n_touch);
  LTH_RESERVE(ctx, c->active_D, c->active_D_cap, 9 * (LitheCount)c->n_touch);
  for (int k = 0; k < c->n_sides; k++) {
    LthContactSide *s = &c->side[k];
    LitheCount total = 0;
    for (LitheIndex i = 0; i < c->n_touch; i++) total += count_entries(&c->touch[i], k, s->points);
    LitheCount samples = total < s->points->n_samples ? total : s->points->n_samples;
    LTH_RESERVE(ctx, s->touched, s->touched_cap, samples);
    LTH_RESERVE(ctx, s->slot_off, s->slot_off_cap, samples + 2);
    LTH_RESERVE(ctx, s->slot_active, s->slot_active_cap, total);
    LTH_RESERVE(ctx, s->slot_weight, s->slot_weight_cap, total);
    LTH_RESERVE(ctx, s->active_off, s->active_off_cap, (LitheCount)c->n_touch + 1);
    LTH_RESERVE(ctx, s->active_sample, s->active_sample_cap, total);
    LTH_RESERVE(ctx, s->active_weight, s->active_weight_cap, total);
  }
  return LITHE_OK;
}

/// The samples that any active point of a side hangs on.
static void list_samples(const LthContact *c, int side, LthContactSide *s) {
  const LthEmbedding *e = s->points;
  for (LitheIndex i = 0; i < s->n_touched; i++) s->sample_slot[s->touched[i]] = -1;
  s->n_touched = 0;
  for (LitheIndex i = 0; i < c->n_active; i++) {
    const LthTouch *touch = &c->touch[c->active[i]];
    for (int l = 0; l < touch->n_legs; l++) {
      if (touch->leg[l].side != side) continue;
      LitheIndex p = touch->leg[l].point;
      for (LitheCount k = e->off[p]; k < e->off[p + 1]; k++) {
        LitheIndex sample = e->sample[k];
        if (s->sample_slot[sample] >= 0) continue;
        s->sample_slot[sample] = s->n_touched;
        s->touched[s->n_touched++] = sample;
      }
    }
  }
}

/// Count (`fill` false) or enter what hangs on each sample, and on what samples each active touch; slot_off is one place ahead while
/// filling.
static void enter(const LthContact *c, int side, LthContactSide *s, bool fill) {
  const LthEmbedding *e = s->points;
  LitheCount n = 0;
  for (LitheIndex i = 0; i < c->n_active; i++) {
    const LthTouch *touch = &c->touch[c->active[i]];
    for (int l = 0; l < touch->n_legs; l++) {
      if (touch->leg[l].side != side) continue;
      LitheIndex p = touch->leg[l].point;
      for (LitheCount k = e->off[p]; k < e->off[p + 1]; k++) {
        LitheIndex slot = s->sample_slot[e->sample[k]];
        if (!fill) {
          s->slot_off[slot + 2]++;
          continue;
        }
        LitheCount at = s->slot_off[slot + 1]++;
        s->slot_active[at] = i;
        s->slot_weight[at] = touch->leg[l].weight * e->weight[k];
        s->active_sample[n] = e->sample[k];
        s->active_weight[n++] = s->slot_weight[at];
      }
    }
    if (fill) s->active_off[i + 1] = n;
  }
}

static void index_side(const LthContact *c, int side, LthContactSide *s) {
  list_samples(c, side, s);
  for (LitheIndex i = 0; s->active_off && i <= c->n_active; i++) s->active_off[i] = 0;
  if (s->n_touched == 0) return;
  memset(s->slot_off, 0, sizeof *s->slot_off * ((size_t)s->n_touched + 2));
  enter(c, side, s, false);
  for (LitheIndex i = 0; i < s->n_touched; i++) s->slot_off[i + 2] += s->slot_off[i + 1];
  enter(c, side, s, true);
}

void lth_contact_index(LthContact *c) {
  c->n_active = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    if (c->touch[i].active) {
      memcpy(c->active_D + 9 * (size_t)c->n_active, c->touch[i].D, sizeof c->touch[i].D);
      c->active[c->n_active++] = i;
    }
  for (int s = 0; s < c->n_sides; s++) index_side(c, s, &c->side[s]);
}

void lth_touch_value(const LthContact *c, const LthTouch *touch, double value[3]) {
  value[0] = value[1] = value[2] = 0;
  for (int l = 0; l < touch->n_legs; l++) {
    const LthContactSide *s = &c->side[touch->leg[l].side];
    double of_point[3];
    lth_embedding_from_samples(s->points, touch->leg[l].point, s->sample_value, of_point);
    lth_v3_axpy(touch->leg[l].weight, of_point, value);
  }
}

/// Averages of v at the touched samples into sample_value.
static void gather(const LthContact *c, const LthContactSide *side, const double *v) {
  const LthEmbedding *e = side->points;
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(side->n_touched))
  for (LitheIndex i = 0; i < side->n_touched; i++) {
    LitheIndex s = side->touched[i];
    double sum[3] = {0, 0, 0};
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_sample_add(e, k, v + 3 * (size_t)e->sample_func[k], sum);
    lth_v3_copy(sum, side->sample_value + 4 * (size_t)s);
  }
}

/// y += W^T of the forces on active points.
static void scatter(const LthContact *c, const LthContactSide *side, double *y) {
  const LthEmbedding *e = side->points;
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(c->n_active))
  for (LitheIndex i = 0; i < side->n_touched; i++) {
    double sum[3] = {0, 0, 0};
    for (LitheCount k = side->slot_off[i]; k < side->slot_off[i + 1]; k++)
      lth_v3_axpy(side->slot_weight[k], c->force_of + 3 * (size_t)side->slot_active[k], sum);
    lth_v3_copy(sum, side->sample_force + 4 * (size_t)side->touched[i]);
  }
  // samples share functions: one thread, in order, so that the sums have the same bits always
  for (LitheIndex i = 0; i < side->n_touched; i++) {
    LitheIndex s = side->touched[i];
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_sample_add(e, k, side->sample_force + 4 * (size_t)s, y + 3 * (size_t)e->sample_func[k]);
  }
}

void lth_contact_apply(const LthContact *c, const double *v, double *y) {
  for (int s = 0; s < c->n_sides; s++) gather(c, &c->side[s], v + c->side[s].first_dof);
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(c->n_active))
  for (LitheIndex i = 0; i < c->n_active; i++) {
    double value[3] = {0};
    for (int s = 0; s < c->n_sides; s++) {
      const LthContactSide *side = &c->side[s];
      for (LitheCount k = side->active_off[i]; k < side->active_off[i + 1]; k++)
        lth_v3_axpy(side->active_weight[k], side->sample_value + 4 * (size_t)side->active_sample[k],
                    value);
    }
    lth_m3_apply(c->active_D + 9 * (size_t)i, value, c->force_of + 3 * (size_t)i);
  }
  for (int s = 0; s < c->n_sides; s++) scatter(c, &c->side[s], y + c->side[s].first_dof);
}

void lth_contact_add_rhs(const LthContact *c, double *rhs) {
  for (LitheIndex i = 0; i < c->n_active; i++)
    lth_v3_copy(c->touch[c->active[i]].r, c->force_of + 3 * (size_t)i);
  for (int s = 0; s < c->n_sides; s++) scatter(c, &c->side[s], rhs + c->side[s].first_dof);
}

/// Block of a row += (sum of D over a sample) x phi phi^T / n: what a sample that averages n rows gives
/// each of them, at most.
static void add_block(const LthContactSide *side, LitheIndex s, const double D[9], double *extra) {
  const LthEmbedding *e = side->points;
  LitheCount at = e->sample_off[s];
  double n = (double)(e->sample_row_off[s + 1] - e->sample_row_off[s]);
  for (LitheCount k = e->sample_row_off[s]; k < e->sample_row_off[s + 1]; k++) {
    LitheIndex row = e->sample_row[k];
    int nb = e->row_func[row + 1] - e->row_func[row];
    const double *w = e->sample_weight + at * e->sample_width; // phi / n
    const int width = e->sample_width, step = width == 3;
    double *block = extra + side->first_block + side->block_off[row];
    for (int a = 0; a < nb; a++)
      for (int b = 0; b < nb; b++)
        for (int i = 0; i < 9; i++)
          block[(3 * a + i / 3) * 3 * nb + 3 * b + i % 3] +=
              n * w[a * width + step * (i / 3)] * w[b * width + step * (i % 3)] * D[i];
    at += nb;
  }
}

/// Sum of the absolute weights of a touch's legs: 1, or 2 between bodies.
static double leg_norm(const LthTouch *touch) {
  double sum = 0;
  for (int l = 0; l < touch->n_legs; l++) sum += fabs(touch->leg[l].weight);
  return sum;
}

void lth_contact_add_diagonal(const LthContact *c, double *extra) {
  for (int k = 0; k < c->n_sides; k++) {
    const LthContactSide *side = &c->side[k];
    for (LitheIndex i = 0; i < side->n_touched; i++) {
      double D[9] = {0};
      for (LitheCount e = side->slot_off[i]; e < side->slot_off[i + 1]; e++) {
        const LthTouch *touch = &c->touch[c->active[side->slot_active[e]]];
        double share = leg_norm(touch) * fabs(side->slot_weight[e]);
        for (int a = 0; a < 9; a++) D[a] += share * touch->D[a];
      }
      add_block(side, side->touched[i], D, extra);
    }
  }
}
