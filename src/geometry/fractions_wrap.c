/// Parts inside wrapped surfaces. Winding numbers change by one at triangles, and little else away from rims: one is enough for
/// all connected parts of a block that no triangle meets. Between two such parts in a column along x triangles give to
/// the parts that they meet as those of closed surfaces do; where that does not lead from one number to the other, parts are
/// asked one by one (docs/theory/winding.md).
#include "geometry/fractions_ledger.h"

#include "base/tensor.h"
#include "geometry/wrap_local.h"

#define OPENING 4.0 ///< of groups
#define POCKET                                                                                     \
  8 ///< parts of a block that are enclosed by met ones and not worth a number of their own
#define AGREED 1e-6 ///< of a part: sums along a column that lead from one number to the other
#define NEAR_BOX                                                                                   \
  4 ///< parts along boxes beside rims and in holes whose numbers are made ready together
#define NUMBER_MAX 100

/// What a part is, else the whole winding number all over it.
enum {
  PART_FREE = NUMBER_MAX + 1, ///< no triangle meets it, nothing else is known yet
  PART_LISTED,                ///< the same, in the list of a flood
  PART_CUT,
  PART_CROSSED, ///< cut by two triangles that cross others
  PART_EMPTY,   ///< the number is not nearly whole, but below one half all over
  PART_FULL,
  PART_DONE ///< asked by itself
};

typedef struct Filling {
  const LthProbe *probe;
  LthLedger ledger;
  int8_t *state;       ///< as ledger.touch
  int *list;           ///< parts of a flood                          (width^3)
  double *mean;        ///< along a column                            (n blocks x width)
  double *out;         ///< as row->part
  LthWindingNear near; ///< of a box that `is_near`
  bool is_near;
  LitheIndex m;        ///< block in question
  double low[3], h[3]; ///< its corner; size of parts
} Filling;

/// --- parts that no triangle meets ---

static int8_t *state_at(const Filling *f, int i, int j, int k) {
  return &f->state[lth_ledger_place(&f->ledger, f->m, i, j, k)];
}

static void part_box(const Filling *f, int i, int j, int k, double center[3], double half[3]) {
  int at[3] = {i, j, k};
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * f->h[a];
    center[a] = f->low[a] + f->h[a] * (at[a] + 0.5);
  }
}

static double number_at(const Filling *f, const double x[3], double *bound) {
  if (f->is_near) {
    *bound = LTH_WINDING_NEAR_ERROR;
    return lth_winding_near_number(&f->near, x);
  }
  return lth_winding_number(f->probe->shape->wrap->winding, x, OPENING, bound);
}

static void push(const Filling *f, int i, int j, int k, int *n) {
  int8_t *state = state_at(f, i, j, k);
  if (*state != PART_FREE) return;
  *state = PART_LISTED;
  f->list[(*n)++] = i + f->ledger.width * (j + f->ledger.width * k);
}

/// List the free parts connected with (i, j, k) within a box of parts; returns how many they are.
static int flood(const Filling *f, const int low[3], int size, int i, int j, int k) {
  int n = 0, w = f->ledger.width;
  push(f, i, j, k, &n);
  for (int next = 0; next < n; next++) {
    int p = f->list[next], at[3] = {p % w, p / w % w, p / (w * w)};
    for (int a = 0; a < 3; a++)
      for (int d = -1; d <= 1; d += 2) {
        int to[3] = {at[0], at[1], at[2]};
        to[a] += d;
        if (to[a] >= low[a] && to[a] < low[a] + size) push(f, to[0], to[1], to[2], &n);
      }
  }
  return n;
}

/// A part by itself.
static double ask(const Filling *f, const double center[3], const double half[3]) {
  const LthWindingNear *near = f->is_near ? &f->near : NULL;
  int samples = f->ledger.samples;
  return samples > 0 ? lth_wrap_local_samples(f->probe->map, near, center, half, samples / 2)
                     : lth_wrap_local_share(f->probe->map, near, center, half);
}

static double *part_at(const Filling *f, int i, int j, int k) {
  const LthFractionFrame *frame = f->ledger.frame;
  return &f->out[(LitheCount)f->m * frame->block_cells * frame->n_parts +
                 lth_fraction_place(frame, i, j, k)];
}

static bool is_within(const double box[6], const double center[3], const double half[3]) {
  for (int a = 0; a < 3; a++)
    if (center[a] - half[a] < box[a] || center[a] + half[a] > box[3 + a]) return false;
  return true;
}

/// A free part gets its number. Nothing beyond the file's box is inside: there, a wound part goes by itself.
static void give_number(const Filling *f, int i, int j, int k, int number) {
  double center[3], half[3];
  int8_t *state = state_at(f, i, j, k);
  part_box(f, i, j, k, center, half);
  *state = (int8_t)(number > NUMBER_MAX ? NUMBER_MAX : number < -NUMBER_MAX ? -NUMBER_MAX : number);
  if (number <= 0 || is_within(f->probe->shape->wrap->box, center, half)) return;
  *state = PART_DONE;
  *part_at(f, i, j, k) = ask(f, center, half);
}

/// The number is nearly whole all over a box: one for each connected set of free parts.
static void number_box(const Filling *f, const int at[3], int size) {
  int w = f->ledger.width;
  for (int k = at[2]; k < at[2] + size; k++)
    for (int j = at[1]; j < at[1] + size; j++)
      for (int i = at[0]; i < at[0] + size; i++) {
        if (*state_at(f, i, j, k) != PART_FREE) continue;
        int n = flood(f, at, size, i, j, k), number = 0;
        bool is_pocket = n < POCKET && size == w;
        if (!is_pocket) {
          double center[3], half[3], bound;
          part_box(f, i, j, k, center, half);
          number = (int)lround(number_at(f, center, &bound));
        }
        for (int s = 0; s < n; s++) {
          int p = f->list[s], to[3] = {p % w, p / w % w, p / (w * w)};
          if (is_pocket)
            *state_at(f, to[0], to[1], to[2]) = PART_CUT;
          else
            give_number(f, to[0], to[1], to[2], number);
        }
      }
}

/// A part beside a rim or in a hole; `change`: of the number over it.
static void settle_part(const Filling *f, const int at[3], double change) {
  int8_t *state = state_at(f, at[0], at[1], at[2]);
  double center[3], half[3], bound;
  part_box(f, at[0], at[1], at[2], center, half);
  if (*state == PART_FREE && change < 0.5) {
    double from_half = number_at(f, center, &bound) - 0.5;
    bool is_sure = fabs(from_half) > bound + change;
    if (is_sure && (from_half < 0 || is_within(f->probe->shape->wrap->box, center, half))) {
      *state = from_half < 0 ? PART_EMPTY : PART_FULL;
      return;
    }
  }
  *state = PART_DONE;
  *part_at(f, at[0], at[1], at[2]) = ask(f, center, half);
}

static bool has_unsettled(const Filling *f, const int at[3], int size, double x[3]) {
  bool any = false;
  double half[3];
  for (int k = at[2]; k < at[2] + size; k++)
    for (int j = at[1]; j < at[1] + size; j++)
      for (int i = at[0]; i < at[0] + size; i++) {
        int8_t state = *state_at(f, i, j, k);
        if (state == PART_FREE) {
          part_box(f, i, j, k, x, half);
          return true;
        }
        any = any || state == PART_CUT || state == PART_CROSSED;
      }
  return any;
}

/// The fractional part of the number does not see triangles: where it stays away from one half all over a box, its free
/// parts have whole numbers, and its cut ones jumps alone. Else the box is halved.
static void settle_box(Filling *f, const int at[3], int size) {
  const LthWrap *wrap = f->probe->shape->wrap;
  double center[3], half[3], x[3], bound;
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * f->h[a] * size;
    center[a] = x[a] = f->low[a] + f->h[a] * at[a] + half[a];
  }
  if (!has_unsettled(f, at, size, x)) return;
  double radius = lth_v3_norm(half), change = radius * lth_rim_slope(wrap->rim, center, radius);
  if (2 * change < 0.5) {
    double number = number_at(f, x, &bound);
    if (fabs(number - round(number)) + bound + 2 * change < 0.5) {
      number_box(f, at, size);
      return;
    }
  }
  if (size == 1) {
    settle_part(f, at, change);
    return;
  }
  if (size == NEAR_BOX) f->is_near = lth_winding_near(wrap->winding, NULL, center, half, &f->near);
  for (int q = 0; q < 8; q++) {
    int to[3];
    for (int a = 0; a < 3; a++) to[a] = at[a] + (q >> a & 1) * size / 2;
    settle_box(f, to, size / 2);
  }
  if (size == NEAR_BOX) f->is_near = false;
}

static void settle_block(Filling *f, LitheIndex m) {
  const LthLedger *l = &f->ledger;
  LitheCount n = (LitheCount)l->width * l->width * l->width,
             first = lth_ledger_place(l, m, 0, 0, 0);
  f->m = m;
  lth_fraction_corner(l->frame, l->row->at[m], l->row->j, l->row->k, f->low);
  for (LitheCount p = first; p < first + n; p++)
    f->state[p] = l->touch[p] & LTH_LEDGER_TWICE     ? PART_CROSSED
                  : l->touch[p] & LTH_LEDGER_TOUCHED ? PART_CUT
                                                     : PART_FREE;
  settle_box(f, (int[3]){0, 0, 0}, l->width);
}

/// --- columns ---

/// A column of parts through blocks side by side; parts are counted from the first of those.
typedef struct Column {
  LitheIndex first, n; ///< blocks of the row
  int j, k;
} Column;

static LitheCount column_place(const Filling *f, const Column *c, LitheCount i) {
  int w = f->ledger.width;
  return lth_ledger_place(&f->ledger, c->first + (LitheIndex)(i / w), (int)(i % w), c->j, c->k);
}

static double *column_part(const Filling *f, const Column *c, LitheCount i) {
  int w = f->ledger.width;
  const LthFractionFrame *frame = f->ledger.frame;
  return &f->out[(LitheCount)(c->first + i / w) * frame->block_cells * frame->n_parts +
                 lth_fraction_place(frame, (int)(i % w), c->j, c->k)];
}

static double ask_column(const Filling *f, const Column *c, LitheCount i) {
  const LthLedger *l = &f->ledger;
  double center[3], half[3];
  LitheIndex m = c->first + (LitheIndex)(i / l->width);
  int at[3] = {(int)(i % l->width), c->j, c->k};
  lth_fraction_corner(l->frame, l->row->at[m], l->row->j, l->row->k, center);
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * f->h[a];
    center[a] += f->h[a] * (at[a] + 0.5);
  }
  return ask(f, center, half);
}

/// Means of the number in the cut parts [from, to) of a column; false where the numbers on its two sides (`has` them) do
/// not agree, or triangles cross.
static bool sum_run(const Filling *f, const Column *c, LitheCount from, LitheCount to,
                    const bool has[2], const int number[2]) {
  double sum = 0;
  for (LitheCount i = from; i < to; i++) {
    LitheCount place = column_place(f, c, i);
    if (f->state[place] == PART_CROSSED) return false;
    sum += f->ledger.behind[place];
    f->mean[i] = sum + *column_part(f, c, i);
  }
  if (has[1]) sum += f->ledger.behind[column_place(f, c, to)];
  if (!has[0] && !has[1]) return false;
  if (has[0] && has[1] && fabs(number[0] + sum - number[1]) > AGREED) return false;
  double start = has[0] ? number[0] : number[1] - sum;
  for (LitheCount i = from; i < to; i++) f->mean[i] += start;
  return true;
}

/// From means of the number to shares of what is wound: where it is 0 and 1 alone, or nowhere or everywhere above.
static bool clamp_run(const Filling *f, LitheCount from, LitheCount to, const bool has[2],
                      const int number[2]) {
  double least = INFINITY, most = -INFINITY;
  for (int e = 0; e < 2; e++) {
    if (!has[e]) continue;
    least = fmin(least, number[e]);
    most = fmax(most, number[e]);
  }
  for (LitheCount i = from; i < to; i++) {
    least = fmin(least, f->mean[i]);
    most = fmax(most, f->mean[i]);
  }
  bool is_whole = least >= 1 - AGREED || most <= AGREED;
  if (!is_whole && (least < -AGREED || most > 1 + AGREED)) return false;
  for (LitheCount i = from; i < to; i++) f->mean[i] = fmin(fmax(f->mean[i], 0), 1);
  return true;
}

static void fill_run(const Filling *f, const Column *c, LitheCount from, LitheCount to) {
  LitheCount end = (LitheCount)c->n * f->ledger.width;
  bool has[2] = {false, false};
  int number[2] = {0, 0};
  for (int e = 0; e < 2; e++) {
    LitheCount i = e ? to : from - 1;
    if (i < 0 || i >= end) continue;
    number[e] = f->state[column_place(f, c, i)];
    has[e] = number[e] <= NUMBER_MAX;
  }
  bool is_summed = sum_run(f, c, from, to, has, number) && clamp_run(f, from, to, has, number);
  for (LitheCount i = from; i < to; i++)
    *column_part(f, c, i) = is_summed ? f->mean[i] : ask_column(f, c, i);
}

static void fill_column(const Filling *f, const Column *c) {
  LitheCount end = (LitheCount)c->n * f->ledger.width, to;
  for (LitheCount i = 0; i < end; i = to) {
    int state = f->state[column_place(f, c, i)];
    to = i + 1;
    if (state == PART_CUT || state == PART_CROSSED) {
      while (to < end) {
        state = f->state[column_place(f, c, to)];
        if (state != PART_CUT && state != PART_CROSSED) break;
        to++;
      }
      fill_run(f, c, i, to);
    } else if (state != PART_DONE) {
      *column_part(f, c, i) = state == PART_FULL || (state <= NUMBER_MAX && state > 0);
    }
  }
}

static void fill_columns(const Filling *f) {
  const LthFractionRow *row = f->ledger.row;
  Column c = {.n = 0};
  for (; c.first < row->n; c.first += c.n) {
    for (c.n = 1; c.first + c.n < row->n && row->at[c.first + c.n] == row->at[c.first] + c.n;)
      c.n++;
    for (c.k = 0; c.k < f->ledger.width; c.k++)
      for (c.j = 0; c.j < f->ledger.width; c.j++) fill_column(f, &c);
  }
}

LitheStatus lth_fraction_fill_wrap(LitheCtx *ctx, const LthProbe *probe, int samples,
                                   const LthFractionFrame *frame, const LthFractionRow *row,
                                   double *part) {
  LitheStatus status = LITHE_OK;
  const LthWrap *wrap = probe->shape->wrap;
  Filling f = {.probe = probe, .out = part};
  LITHE_TRY(lth_ledger_open(ctx, frame, row, samples, true, part, &f.ledger));
  LitheCount w = f.ledger.width;
  LTH_NEW_OR(done, ctx, f.state, row->n * w * w * w);
  LTH_NEW_OR(done, ctx, f.list, w * w * w);
  LTH_NEW_OR(done, ctx, f.mean, row->n * w);
  for (int a = 0; a < 3; a++) f.h[a] = 0.5 * frame->h[a];
  lth_ledger_take(&f.ledger, wrap->bvh, wrap->crosses);
  for (LitheIndex m = 0; m < row->n; m++) settle_block(&f, m);
  fill_columns(&f);
done:
  lth_ledger_close(ctx, &f.ledger);
  lth_free(ctx, f.state);
  lth_free(ctx, f.list);
  lth_free(ctx, f.mean);
  return status;
}
