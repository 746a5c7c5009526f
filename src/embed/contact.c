/// Contact's part in the linear system: apply, right-hand side, preconditioner, report.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define AUTO_MODULUS 10    ///< stiffness over that of a layer of cells
#define AUTO_WEIGHT 0.0025 ///< penetration over body size under the weight ...
#define AUTO_SPOT 0.004    ///< ... on this part of the size squared

/// Stiffer than the cells behind the surface by AUTO_MODULUS, and stiff enough to carry the weight on a
/// spot: equation (6).
static double auto_stiffness(const LthContactDef *d) {
  double size = d->body_size > 0 ? d->body_size : 1, cell = d->cell_size > 0 ? d->cell_size : size;
  double elastic = AUTO_MODULUS * d->modulus / cell;
  double weight = d->body_weight / (AUTO_WEIGHT * size * AUTO_SPOT * size * size);
  double per_area = fmax(elastic, weight);
  return d->points->area ? per_area : per_area * cell * cell;
}

static LitheStatus copy_colliders(LitheCtx *ctx, LthContact *c) {
  LTH_NEW(ctx, c->colliders, c->def.n_colliders);
  LTH_NEW(ctx, c->owns_bvh, c->def.n_colliders);
  for (LitheIndex i = 0; i < c->def.n_colliders; i++) {
    LthCollider *k = &c->colliders[i];
    *k = c->def.colliders[i];
    if (k->kind != LTH_COLLIDER_MESH || k->shape.bvh) continue;
    k->shape.kind = LTH_SHAPE_MESH;
    LITHE_TRY(lth_bvh_create_surface(ctx, k->shape.surface, &k->shape.bvh));
    c->owns_bvh[i] = true;
  }
  return LITHE_OK;
}

static LitheStatus lay_out_blocks(LitheCtx *ctx, LthContact *c) {
  const LthEmbedding *e = c->def.points;
  LTH_NEW(ctx, c->block_off, (LitheCount)e->n_rows + 1);
  for (LitheIndex k = 0; k < e->n_rows; k++) {
    LitheCount m = 3 * (LitheCount)(e->row_func[k + 1] - e->row_func[k]);
    c->block_off[k + 1] = c->block_off[k] + m * m;
  }
  return LITHE_OK;
}

static double largest_weight_sum(const LthEmbedding *e) {
  double largest = 1;
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double sum = 0;
    for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) sum += fabs(e->weight[i]);
    largest = fmax(largest, sum);
  }
  return largest;
}

LitheStatus lth_contact_create(LitheCtx *ctx, const LthContactDef *def, LthContact **contact) {
  LitheStatus status = LITHE_OK;
  LthContact *c = NULL;
  const LthEmbedding *e = def->points;
  *contact = NULL;
  LTH_NEW(ctx, c, 1);
  c->ctx = ctx;
  c->def = *def;
  LITHE_TRY_OR(done, copy_colliders(ctx, c));
  LITHE_TRY_OR(done, lay_out_blocks(ctx, c));
  LTH_NEW_OR(done, ctx, c->position, 3 * (LitheCount)e->n_points);
  LTH_NEW_OR(done, ctx, c->gap, e->n_points);
  LTH_NEW_OR(done, ctx, c->sample_value, 4 * (LitheCount)e->n_samples);
  LTH_NEW_OR(done, ctx, c->sample_force, 4 * (LitheCount)e->n_samples);
  LTH_NEW_OR(done, ctx, c->sample_slot, e->n_samples);
  for (LitheIndex s = 0; s < e->n_samples; s++) c->sample_slot[s] = -1;
  c->weight_norm = largest_weight_sum(e);
  c->growth = 1;
  c->is_auto = !(def->stiffness > 0);
  c->stiffness = c->is_auto ? auto_stiffness(def) : def->stiffness;
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, &c);
  *contact = c;
  return status;
}

void lth_contact_destroy(LitheCtx *ctx, LthContact **contact) {
  if (!contact || !*contact) return;
  LthContact *c = *contact;
  for (LitheIndex i = 0; c->owns_bvh && i < c->def.n_colliders; i++)
    if (c->owns_bvh[i]) lth_bvh_destroy(ctx, &c->colliders[i].shape.bvh);
  void *blocks[] = {c->colliders, c->owns_bvh,     c->block_off,    c->position,
                    c->gap,       c->sample_value, c->sample_force, c->touch,
                    c->before,    c->active,       c->touched,      c->sample_slot,
                    c->slot_off,  c->slot_active,  c->slot_weight,  c->force_of};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, c);
  *contact = NULL;
}

LitheStatus lth_contact_reserve(LitheCtx *ctx, LthContact *c) {
  const LthEmbedding *e = c->def.points;
  LitheCount total = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    total += e->off[c->touch[i].point + 1] - e->off[c->touch[i].point];
  LitheCount samples = total < e->n_samples ? total : e->n_samples;
  LTH_RESERVE(ctx, c->active, c->active_cap, c->n_touch);
  LTH_RESERVE(ctx, c->force_of, c->force_of_cap, 3 * (LitheCount)c->n_touch);
  LTH_RESERVE(ctx, c->touched, c->touched_cap, samples);
  LTH_RESERVE(ctx, c->slot_off, c->slot_off_cap, samples + 2);
  LTH_RESERVE(ctx, c->slot_active, c->slot_active_cap, total);
  LTH_RESERVE(ctx, c->slot_weight, c->slot_weight_cap, total);
  return LITHE_OK;
}

/// List active points and the samples that any of them hangs on.
static void list_active(LthContact *c) {
  const LthEmbedding *e = c->def.points;
  for (LitheIndex i = 0; i < c->n_touched; i++) c->sample_slot[c->touched[i]] = -1;
  c->n_touched = 0;
  c->n_active = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    if (!c->touch[i].active) continue;
    c->active[c->n_active++] = i;
    LitheIndex p = c->touch[i].point;
    for (LitheCount k = e->off[p]; k < e->off[p + 1]; k++) {
      LitheIndex s = e->sample[k];
      if (c->sample_slot[s] >= 0) continue;
      c->sample_slot[s] = c->n_touched;
      c->touched[c->n_touched++] = s;
    }
  }
}

void lth_contact_index(LthContact *c) {
  const LthEmbedding *e = c->def.points;
  list_active(c);
  if (c->n_active == 0) return;
  memset(c->slot_off, 0, sizeof *c->slot_off * ((size_t)c->n_touched + 2));
  for (LitheIndex i = 0; i < c->n_active; i++) {
    LitheIndex p = c->touch[c->active[i]].point;
    for (LitheCount k = e->off[p]; k < e->off[p + 1]; k++)
      c->slot_off[c->sample_slot[e->sample[k]] + 2]++;
  }
  for (LitheIndex s = 0; s < c->n_touched; s++) c->slot_off[s + 2] += c->slot_off[s + 1];
  for (LitheIndex i = 0; i < c->n_active; i++) {
    LitheIndex p = c->touch[c->active[i]].point;
    for (LitheCount k = e->off[p]; k < e->off[p + 1]; k++) {
      LitheCount at = c->slot_off[c->sample_slot[e->sample[k]] + 1]++;
      c->slot_active[at] = i;
      c->slot_weight[at] = e->weight[k];
    }
  }
}

/// Averages of v at the touched samples into sample_value.
static void gather(const LthContact *c, const double *v) {
  const LthEmbedding *e = c->def.points;
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(c->n_touched))
  for (LitheIndex i = 0; i < c->n_touched; i++) {
    LitheIndex s = c->touched[i];
    double sum[3] = {0, 0, 0};
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_v3_axpy(e->sample_weight[k], v + 3 * (size_t)e->sample_func[k], sum);
    lth_v3_copy(sum, c->sample_value + 4 * (size_t)s);
  }
}

/// y += W^T of the forces on active points.
static void scatter(const LthContact *c, double *y) {
  const LthEmbedding *e = c->def.points;
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(c->n_active))
  for (LitheIndex i = 0; i < c->n_touched; i++) {
    double sum[3] = {0, 0, 0};
    for (LitheCount k = c->slot_off[i]; k < c->slot_off[i + 1]; k++)
      lth_v3_axpy(c->slot_weight[k], c->force_of + 3 * (size_t)c->slot_active[k], sum);
    lth_v3_copy(sum, c->sample_force + 4 * (size_t)c->touched[i]);
  }
  // samples share functions: one thread, in order, so that the sums have the same bits always
  for (LitheIndex i = 0; i < c->n_touched; i++) {
    LitheIndex s = c->touched[i];
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_v3_axpy(e->sample_weight[k], c->sample_force + 4 * (size_t)s,
                  y + 3 * (size_t)e->sample_func[k]);
  }
}

void lth_contact_apply(const LthContact *c, const double *v, double *y) {
  gather(c, v);
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(c->ctx)) if (lth_contact_is_large(c->n_active))
  for (LitheIndex i = 0; i < c->n_active; i++) {
    const LthTouch *touch = &c->touch[c->active[i]];
    double value[3];
    lth_embedding_from_samples(c->def.points, touch->point, c->sample_value, value);
    lth_m3_apply(touch->D, value, c->force_of + 3 * (size_t)i);
  }
  scatter(c, y);
}

void lth_contact_add_rhs(const LthContact *c, double *rhs) {
  for (LitheIndex i = 0; i < c->n_active; i++)
    lth_v3_copy(c->touch[c->active[i]].r, c->force_of + 3 * (size_t)i);
  scatter(c, rhs);
}

/// Block of a row += (sum of D over a sample) x phi phi^T / n: what a sample that averages n cells gives
/// each of them, at most.
static void add_block(const LthContact *c, LitheIndex s, const double D[9],
                      double *extra) {
  const LthEmbedding *e = c->def.points;
  LitheCount at = e->sample_off[s];
  double n = (double)(e->sample_row_off[s + 1] - e->sample_row_off[s]);
  for (LitheCount k = e->sample_row_off[s]; k < e->sample_row_off[s + 1]; k++) {
    LitheIndex row = e->sample_row[k];
    int nb = e->row_func[row + 1] - e->row_func[row];
    const double *w = e->sample_weight + at; // phi / n
    double *block = extra + c->block_off[row];
    for (int a = 0; a < nb; a++)
      for (int b = 0; b < nb; b++)
        for (int i = 0; i < 9; i++)
          block[(3 * a + i / 3) * 3 * nb + 3 * b + i % 3] += n * w[a] * w[b] * D[i];
    at += nb;
  }
}

void lth_contact_add_diagonal(const LthContact *c, double *extra) {
  for (LitheIndex i = 0; i < c->n_touched; i++) {
    double D[9] = {0};
    for (LitheCount k = c->slot_off[i]; k < c->slot_off[i + 1]; k++) {
      const LthTouch *touch = &c->touch[c->active[c->slot_active[k]]];
      for (int a = 0; a < 9; a++) D[a] += fabs(c->slot_weight[k]) * touch->D[a];
    }
    add_block(c, c->touched[i], D, extra);
  }
}

void lth_contact_report(const LthContact *c, LitheIndex *n, double *penetration, double *force) {
  *n = c->n_active;
  *penetration = c->penetration;
  *force = c->force;
}

double lth_contact_stiffness(const LthContact *c) { return c->stiffness; }
