/// Ledgers: triangles cut at the planes between parts, or met by the lines of a lattice.
#include "geometry/fractions_ledger.h"

#include "base/tensor.h"
#include "geometry/predicates.h"

#define STACK_MAX 96
#define CORNERS_MAX 24 ///< of a triangle cut six times: nine, and some for rounding

/// --- what is given ---

/// To parts from `i` (counted from the row's start) on in column (j, k).
static void give_behind(LthLedger *l, LitheCount i, int j, int k, double value) {
  int w = l->width;
  if (i < 0) i = 0;
  if (i >= (LitheCount)l->frame->n_block[0] * w) return;
  LitheIndex block = (LitheIndex)(i / w), m = l->of[block];
  if (m >= l->row->n) return;
  if (l->row->at[m] == block)
    l->behind[(((LitheCount)m * w + k) * w + j) * w + i % w] += value;
  else
    l->carry[((LitheCount)m * w + k) * w + j] += value;
}

/// To part i alone.
static void give_part(LthLedger *l, LitheCount i, int j, int k, double value) {
  int w = l->width;
  if (i < 0 || i >= (LitheCount)l->frame->n_block[0] * w) return;
  LitheIndex block = (LitheIndex)(i / w), m = l->of[block];
  if (m >= l->row->n || l->row->at[m] != block) return;
  l->part[(LitheCount)m * l->frame->block_cells * l->frame->n_parts +
          lth_fraction_place(l->frame, (int)(i % w), j, k)] += value;
}

static void touch(LthLedger *l, LitheCount i, int j, int k) {
  int w = l->width;
  if (i < 0 || i >= (LitheCount)l->frame->n_block[0] * w) return;
  LitheIndex block = (LitheIndex)(i / w), m = l->of[block];
  if (m >= l->row->n || l->row->at[m] != block) return;
  uint8_t *bits = &l->touch[lth_ledger_place(l, m, (int)(i % w), j, k)];
  if (l->is_marked) *bits |= *bits & LTH_LEDGER_MARKED ? LTH_LEDGER_TWICE : LTH_LEDGER_MARKED;
  *bits |= LTH_LEDGER_TOUCHED;
}

/// --- volumes: triangles are cut at the planes between parts ---

typedef struct Polygon {
  int n;
  double p[CORNERS_MAX][3]; ///< counted in parts from the row's corner
} Polygon;

/// Cut at `place` along an axis into what lies below (may be `from` itself no more) and above.
static void split(const Polygon *from, int axis, double place, Polygon *below, Polygon *above) {
  below->n = above->n = 0;
  for (int i = 0; i < from->n; i++) {
    const double *p = from->p[i], *q = from->p[(i + 1) % from->n];
    double at_p = p[axis] - place, at_q = q[axis] - place;
    if (at_p <= 0) lth_v3_copy(p, below->p[below->n++]);
    if (at_p >= 0) lth_v3_copy(p, above->p[above->n++]);
    if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
      // from the lower end, so that both triangles at an edge find the same point
      const double *a = at_p < 0 ? p : q, *b = at_p < 0 ? q : p;
      double t = (place - a[axis]) / (b[axis] - a[axis]), x[3];
      for (int c = 0; c < 3; c++) x[c] = a[c] + t * (b[c] - a[c]);
      x[axis] = place;
      lth_v3_copy(x, below->p[below->n++]);
      lth_v3_copy(x, above->p[above->n++]);
    }
  }
}

static void range(const Polygon *g, int axis, double *low, double *high) {
  *low = INFINITY, *high = -INFINITY;
  for (int i = 0; i < g->n; i++) {
    *low = fmin(*low, g->p[i][axis]);
    *high = fmax(*high, g->p[i][axis]);
  }
}

/// A piece within one part (i, j, k): its shadow's area along x goes to all parts behind, what lies between
/// it and the end of the part to that.
static void give_piece(LthLedger *l, const Polygon *g, LitheCount i, int j, int k) {
  const double *a = g->p[0];
  double area = 0, first = 0;
  if (l->touch) touch(l, i, j, k);
  if (l->samples > 0) return;
  for (int c = 1; c + 1 < g->n; c++) {
    const double *p = g->p[c], *q = g->p[c + 1];
    double shadow = 0.5 * ((p[1] - a[1]) * (q[2] - a[2]) - (p[2] - a[2]) * (q[1] - a[1]));
    area += shadow;
    first += shadow * ((double)(i + 1) - (a[0] + p[0] + q[0]) / 3);
  }
  give_part(l, i, j, k, -first);
  give_behind(l, i + 1, j, k, -area);
}

static void cut_along_x(LthLedger *l, Polygon *g, int j, int k) {
  double low, high, end = (double)l->frame->n_block[0] * l->width;
  Polygon below, above;
  range(g, 0, &low, &high);
  if (low < 0) { // before the first part all shadows count in full
    split(g, 0, 0, &below, &above);
    give_piece(l, &below, -1, j, k);
    *g = above;
    low = 0;
  }
  for (LitheCount i = (LitheCount)floor(low); g->n > 2 && (double)i < end; i++) {
    if ((double)(i + 1) >= high) {
      give_piece(l, g, i, j, k);
      return;
    }
    split(g, 0, (double)(i + 1), &below, &above);
    if (below.n > 2) give_piece(l, &below, i, j, k);
    *g = above;
  }
}

/// Cut a polygon to the columns along an axis (2, then 1) that are in the row.
static void cut_columns(LthLedger *l, Polygon *g, int axis, int k) {
  double low, high;
  Polygon below, above;
  range(g, axis, &low, &high);
  if (high <= 0 || low >= l->width) return;
  if (low < 0) {
    split(g, axis, 0, &below, &above);
    *g = above;
    low = 0;
  }
  for (int i = (int)low; g->n > 2 && i < l->width; i++) {
    bool is_last = i + 1 >= high;
    if (is_last)
      below = *g;
    else
      split(g, axis, i + 1, &below, &above);
    if (below.n > 2 && axis == 2) cut_columns(l, &below, 1, i);
    if (below.n > 2 && axis == 1) cut_along_x(l, &below, i, k);
    if (is_last) return;
    *g = above;
  }
}

/// Also notes which parts the triangle meets.
static void cut(LthLedger *l, const double *const corner[3]) {
  Polygon g = {.n = 3};
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++) g.p[c][a] = (corner[c][a] - l->low[a]) / (0.5 * l->frame->h[a]);
  cut_columns(l, &g, 2, 0);
}

/// --- samples: lines through a lattice ---

/// Side of the edge pq, in the plane x = 0, on which the line through (y, z) lies; a line through an edge is moved by
/// nothing along y, and by nothing of that along z.
static int edge_side(const double *p, const double *q, const double at[2]) {
  int side = lth_orient2d((double[2]){p[1], p[2]}, (double[2]){q[1], q[2]}, at);
  if (side != 0) return side;
  if (q[2] != p[2]) return q[2] < p[2] ? 1 : -1;
  return q[1] > p[1] ? 1 : q[1] < p[1] ? -1 : 0;
}

/// 1 where the line goes in through the triangle, -1 where it comes out, 0 where it misses it; *x: there.
static int pierce(const double *const c[3], const double at[2], double *x) {
  int side = edge_side(c[0], c[1], at);
  if (side == 0 || edge_side(c[1], c[2], at) != side || edge_side(c[2], c[0], at) != side) return 0;
  double e[3], f[3], n[3];
  lth_v3_sub(c[1], c[0], e);
  lth_v3_sub(c[2], c[0], f);
  lth_v3_cross(e, f, n);
  *x = n[0] != 0 ? c[0][0] - (n[1] * (at[0] - c[0][1]) + n[2] * (at[1] - c[0][2])) / n[0] : c[0][0];
  *x = fmin(fmax(*x, fmin(c[0][0], fmin(c[1][0], c[2][0]))), fmax(c[0][0], fmax(c[1][0], c[2][0])));
  return -side;
}

/// Place of sample s along an axis, counted from the row's corner.
static double sample_place(const LthLedger *l, int axis, double s, int samples) {
  return l->low[axis] + l->frame->h[axis] * (s + 0.5) / samples;
}

/// All samples behind x are entered or left: those of one part in part, of the next ones all.
static void give_line(LthLedger *l, double x, int sign, int j, int k) {
  int samples = l->samples, n = samples / 2;
  double guess = floor((x - l->low[0]) / l->frame->h[0] * samples - 0.5);
  LitheCount s = (LitheCount)fmax(guess, 0);
  // the first sample that is behind x; one that is on the surface is inside
  while (sign > 0 ? sample_place(l, 0, (double)s, samples) < x
                  : sample_place(l, 0, (double)s, samples) <= x)
    s++;
  double one = (double)sign / ((double)n * n);
  give_part(l, s / n, j, k, one * (double)(n - s % n) / n);
  give_behind(l, s / n + 1, j, k, one);
}

static void give_samples(LthLedger *l, const double *const corner[3]) {
  int samples = l->samples;
  LitheCount first[3], last[3];
  for (int a = 1; a < 3; a++) {
    double low = fmin(corner[0][a], fmin(corner[1][a], corner[2][a])),
           high = fmax(corner[0][a], fmax(corner[1][a], corner[2][a])),
           step = l->frame->h[a] / samples;
    double top = (double)l->frame->side * samples - 1;
    first[a] = (LitheCount)fmin(fmax(floor((low - l->low[a]) / step - 0.5), 0), top);
    last[a] = (LitheCount)fmax(fmin(ceil((high - l->low[a]) / step - 0.5), top), 0);
  }
  int n = samples / 2, sign;
  for (LitheCount k = first[2]; k <= last[2]; k++)
    for (LitheCount j = first[1]; j <= last[1]; j++) {
      double x,
          at[2] = {sample_place(l, 1, (double)j, samples), sample_place(l, 2, (double)k, samples)};
      if ((sign = pierce(corner, at, &x)) != 0) give_line(l, x, sign, (int)(j / n), (int)(k / n));
    }
}

/// --- rows ---

LitheStatus lth_ledger_open(LitheCtx *ctx, const LthFractionFrame *f, const LthFractionRow *row,
                            int samples, bool touches, double *part, LthLedger *l) {
  *l = (LthLedger){.frame = f, .row = row, .samples = samples, .part = part, .width = 2 * f->side};
  LitheStatus status = LITHE_OK;
  LitheCount w2 = (LitheCount)l->width * l->width;
  LTH_NEW_OR(done, ctx, l->behind, row->n * w2 * l->width);
  LTH_NEW_OR(done, ctx, l->carry, row->n * w2);
  LTH_NEW_OR(done, ctx, l->of, (LitheCount)f->n_block[0] + 1);
  if (touches) LTH_NEW_OR(done, ctx, l->touch, row->n * w2 * l->width);
  lth_fraction_corner(f, 0, row->j, row->k, l->low);
  for (LitheIndex i = 0, m = 0; i < f->n_block[0]; i++) {
    while (m < row->n && row->at[m] < i) m++;
    l->of[i] = m;
  }
done:
  if (status != LITHE_OK) lth_ledger_close(ctx, l);
  return status;
}

void lth_ledger_close(LitheCtx *ctx, LthLedger *l) {
  lth_free(ctx, l->behind);
  lth_free(ctx, l->carry);
  lth_free(ctx, l->of);
  lth_free(ctx, l->touch);
  *l = (LthLedger){0};
}

static void take_triangle(LthLedger *l, const LthSurface *s, LitheIndex tri, const bool *marked) {
  const LitheIndex *p = s->tris + 3 * (size_t)tri;
  const double *corner[3];
  for (int c = 0; c < 3; c++) corner[c] = s->points + 3 * (size_t)p[c];
  l->is_marked = marked && marked[tri];
  if (l->samples > 0) give_samples(l, corner);
  if (l->samples == 0 || l->touch) cut(l, corner);
}

void lth_ledger_take(LthLedger *l, const LthBvh *tree, const bool *marked) {
  LitheIndex stack[STACK_MAX];
  double high[3];
  int top = 0;
  for (int a = 1; a < 3; a++) high[a] = l->low[a] + l->frame->h[a] * l->frame->side;
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    const double *box = tree->box + 6 * (size_t)node;
    if (box[1] > high[1] || box[4] < l->low[1] || box[2] > high[2] || box[5] < l->low[2]) continue;
    if (tree->right[node] >= 0) {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = tree->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = tree->first[node]; i < tree->first[node] + tree->count[node]; i++)
      take_triangle(l, tree->surface, tree->item[i], marked);
  }
}
