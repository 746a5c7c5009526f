/// Contact of one body with colliders or of two with each other: memory, the start of a step, the report.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define AUTO_MODULUS 10    ///< stiffness over that of a layer of cells
#define AUTO_WEIGHT 0.0025 ///< penetration over body size under the weight ...
#define AUTO_SPOT 0.004    ///< ... on this part of the size squared
#define AUTO_DEPTH 0.003   ///< of the body's size: deeper rest makes an automatic stiffness grow
#define AUTO_GROWTH 1.25
#define AUTO_GROWTH_MAX 1e3 ///< over the stiffness at the start

double lth_contact_auto_stiffness(double modulus, double cell_size, double weight, double size) {
  if (!(size > 0)) size = 1;
  double cell = cell_size > 0 ? cell_size : size;
  return fmax(AUTO_MODULUS * modulus / cell,
              weight / (AUTO_WEIGHT * size * AUTO_SPOT * size * size));
}

double lth_contact_pair_stiffness(double soft, double cell_size, double weight, double size) {
  return fmax(soft, lth_contact_auto_stiffness(0, cell_size, weight, size));
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

static LitheStatus lay_out_side(LitheCtx *ctx, const LthEmbedding *e, LthContactSide *s) {
  s->points = e;
  LTH_NEW(ctx, s->block_off, (LitheCount)e->n_rows + 1);
  for (LitheIndex k = 0; k < e->n_rows; k++) {
    LitheCount m = 3 * (LitheCount)(e->row_func[k + 1] - e->row_func[k]);
    s->block_off[k + 1] = s->block_off[k] + m * m;
  }
  LTH_NEW(ctx, s->position, 3 * (LitheCount)e->n_points);
  LTH_NEW(ctx, s->sample_value, 4 * (LitheCount)e->n_samples);
  LTH_NEW(ctx, s->sample_force, 4 * (LitheCount)e->n_samples);
  LTH_NEW(ctx, s->sample_slot, e->n_samples);
  for (LitheIndex i = 0; i < e->n_samples; i++) s->sample_slot[i] = -1;
  s->weight_norm = largest_weight_sum(e);
  return LITHE_OK;
}

LitheStatus lth_contact_create_sides(LitheCtx *ctx, int n_sides, const LthEmbedding *const *points,
                                     double stiffness, LthContact **contact) {
  LitheStatus status = LITHE_OK;
  LthContact *c = NULL;
  *contact = NULL;
  LTH_NEW(ctx, c, 1);
  c->ctx = ctx;
  c->n_sides = n_sides;
  for (int s = 0; s < n_sides; s++) LITHE_TRY_OR(done, lay_out_side(ctx, points[s], &c->side[s]));
  c->growth = 1;
  c->weight = 1;
  c->is_auto = !(stiffness > 0);
  c->stiffness = stiffness;
done:
  if (status != LITHE_OK) lth_contact_destroy(ctx, &c);
  *contact = c;
  return status;
}

static void free_side(LitheCtx *ctx, LthContactSide *s) {
  void *blocks[] = {s->block_off,   s->position,   s->sample_value,  s->sample_force,
                    s->touched,     s->slot_off,   s->sample_slot,   s->slot_active,
                    s->slot_weight, s->active_off, s->active_sample, s->active_weight};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
}

void lth_contact_destroy(LitheCtx *ctx, LthContact **contact) {
  if (!contact || !*contact) return;
  LthContact *c = *contact;
  if (c->kind) c->kind->destroy(ctx, c);
  for (int s = 0; s < c->n_sides; s++) free_side(ctx, &c->side[s]);
  lth_free(ctx, c->touch);
  lth_free(ctx, c->before);
  lth_free(ctx, c->active);
  lth_free(ctx, c->force_of);
  lth_free(ctx, c->active_D);
  lth_free(ctx, c);
  *contact = NULL;
}

int lth_contact_sides(const LthContact *c) { return c->n_sides; }

void lth_contact_place(LthContact *c, int side, LitheIndex first_row, LitheCount first_dof,
                       LitheCount first_block) {
  c->side[side].first_row = first_row;
  c->side[side].first_dof = first_dof;
  c->side[side].first_block = first_block;
}

/// A body at rest too deep in another: a somewhat stiffer contact for the next step.
static void adapt_stiffness(LthContact *c) {
  bool rests = fabs(c->penetration - c->last_penetration) < 0.1 * c->penetration;
  c->last_penetration = c->penetration;
  // between bodies the softer one yields first: growing would only press a few points harder
  bool grows = c->is_auto && c->kind->may_grow && c->body_size > 0;
  if (!grows || !rests) return;
  if (c->penetration > AUTO_DEPTH * c->body_size && c->growth < AUTO_GROWTH_MAX) {
    c->stiffness *= AUTO_GROWTH;
    c->growth *= AUTO_GROWTH;
  }
}

void lth_touch_place(const LthContact *c, const LthTouch *touch, double x[3]) {
  const double *position = c->side[touch->side].position;
  x[0] = x[1] = x[2] = 0;
  for (int l = 0; l < touch->n_own; l++)
    lth_v3_axpy(touch->leg[l].weight, position + 3 * (size_t)touch->leg[l].point, x);
}

/// Points that slid take the anchor of their friction along: it ends where its pull is at the limit.
static void move_anchors(LthContact *c) {
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    LthTouch *touch = &c->touch[i];
    double x[3], pull = touch->stiffness * lth_v3_norm(touch->trial);
    if (!touch->active || !(pull > touch->limit)) continue;
    lth_touch_place(c, touch, x);
    lth_v3_axpy(-touch->limit / pull, touch->trial, x);
    c->kind->move_anchor(c, touch, x);
  }
}

double lth_contact_fastest(const LthContactSide *s) {
  double v2 = 0;
  for (LitheIndex i = 0; i < s->points->n_samples; i++) {
    const double *v = s->sample_value + 4 * (size_t)i;
    v2 = fmax(v2, lth_v3_dot(v, v));
  }
  return sqrt(v2) * s->weight_norm;
}

void lth_contact_box(const LthContactSide *s, double box[6]) {
  for (int i = 0; i < 3; i++) box[i] = INFINITY, box[3 + i] = -INFINITY;
  for (LitheIndex p = 0; p < s->points->n_points; p++)
    for (int i = 0; i < 3; i++) {
      box[i] = fmin(box[i], s->position[3 * (size_t)p + (size_t)i]);
      box[3 + i] = fmax(box[3 + i], s->position[3 * (size_t)p + (size_t)i]);
    }
}

/// Order of two touches in the list.
static int compare(const LthTouch *a, const LthTouch *b) {
  if (a->side != b->side) return a->side < b->side ? -1 : 1;
  if (a->other != b->other) return a->other < b->other ? -1 : 1;
  return (a->point > b->point) - (a->point < b->point);
}

const LthTouch *lth_touch_before(LthContact *c, const LthTouch *touch) {
  while (c->before_at < c->n_before && compare(&c->before[c->before_at], touch) < 0) c->before_at++;
  if (c->before_at == c->n_before) return NULL;
  const LthTouch *old = &c->before[c->before_at];
  return compare(old, touch) == 0 ? old : NULL;
}

void lth_touch_remember(LthContact *c, LthTouch *touch, double v[3]) {
  const LthTouch *old = lth_touch_before(c, touch);
  if (!old) return;
  touch->anchored = old->active || (c->look > LTH_LOOK_FIRST && old->anchored);
  if (!touch->anchored) return;
  if (c->look == LTH_LOOK_STEP) {
    touch->limit = old->limit;
    for (int i = 0; i < 3; i++) v[i] = 2 * v[i] - old->start[i];
  }
  lth_v3_copy(old->anchor, touch->anchor);
  touch->anchor_tri = old->anchor_tri;
}

LitheStatus lth_touch_add(LitheCtx *ctx, LthContact *c, const LthTouch *touch) {
  LTH_RESERVE(ctx, c->touch, c->touch_cap, (LitheCount)c->n_touch + 1);
  c->touch[c->n_touch++] = *touch;
  return LITHE_OK;
}

static void swap_lists(LthContact *c) {
  LthTouch *list = c->before;
  LitheCount cap = c->before_cap;
  c->before = c->touch, c->before_cap = c->touch_cap, c->n_before = c->n_touch;
  c->touch = list, c->touch_cap = cap, c->n_touch = 0, c->before_at = 0;
}

/// What the step before leaves for the one that begins.
static void end_step(LthContact *c) {
  c->begin_penetration = c->penetration;
  lth_contact_end_account(c);
  adapt_stiffness(c);
  if (c->look <= LTH_LOOK_FIRST) move_anchors(c);
  swap_lists(c);
}

/// Forget the touches of a step that begins once more.
static void go_back(LthContact *c) {
  c->again = false;
  c->penetration = c->begin_penetration;
  c->n_touch = 0, c->before_at = 0;
}

/// Places of all points, from displacement u.
static void place_points(const LthContact *c, LthContactSide *s, const double *u) {
  const LthEmbedding *e = s->points;
  int threads = lth_threads(c->ctx);
  lth_embedding_sample(e, threads, u + s->first_dof, s->sample_value);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double *x = s->position + 3 * (size_t)p;
    lth_embedding_from_samples(e, p, s->sample_value, x);
    lth_v3_axpy(1, e->rest + 3 * (size_t)p, x);
  }
}

LitheStatus lth_contact_detect(LitheCtx *ctx, LthContact *c, double t, double dt, const double *u,
                               const double *v, LitheIndex *n_active) {
  for (int s = 0; s < c->n_sides; s++) {
    place_points(c, &c->side[s], u);
    lth_embedding_sample(c->side[s].points, lth_threads(ctx), v + c->side[s].first_dof,
                         c->side[s].sample_value);
  }
  // where colliders were at the end of the step before, for anchors: an equilibrium's own time, or now
  if (!c->is_search) c->t = t;
  c->is_search = c->look != LTH_LOOK_STEP;
  c->dt = dt, c->round = 0, c->friction_round = 0, c->n_acted = 0, c->drops = false;
  if (c->kind->begin) LITHE_TRY(c->kind->begin(ctx, c));
  if (c->again)
    go_back(c);
  else
    end_step(c);
  c->t = t;
  LITHE_TRY(c->kind->find_near(ctx, c));
  lth_contact_relax(c);
  LITHE_TRY(lth_contact_reserve(ctx, c));
  lth_contact_index(c);
  c->penetration = 0, c->force = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    c->penetration = fmax(c->penetration, c->touch[i].slack - c->touch[i].gap);
  c->started = true;
  *n_active = c->n_active;
  return LITHE_OK;
}

void lth_contact_report(const LthContact *c, LitheIndex *n, double *penetration, double *force) {
  *n = c->n_active;
  *penetration = c->penetration;
  *force = c->force;
}

bool lth_contact_acted(const LthContact *c) { return c->n_acted > 0; }

double lth_contact_stiffness(const LthContact *c) { return c->stiffness; }

void lth_contact_set_look(LthContact *c, LthContactLook look) { c->look = look; }

void lth_contact_join_run(LthContact *c) { c->started = true; }

void lth_contact_begin_again(LthContact *c) { c->again = true; }

void lth_contact_set_weight(LthContact *c, double weight, double ahead) {
  c->weight = weight;
  c->ahead = ahead;
}
