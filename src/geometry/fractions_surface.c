/// Parts inside closed triangle surfaces. Along a line in the direction of x a solid is the sum of all that begins where
/// the line enters it, less all that begins where it leaves. So every triangle takes from and gives to the parts
/// that it meets and all behind them, on its own: nothing needs to be known of its neighbours, and what is closed
/// sums up to 0 or 1 (docs/theory/fractions.md).
#include "geometry/fractions_fill.h"

#include "base/tensor.h"
#include "geometry/predicates.h"

#define STACK_MAX 96
#define CORNERS_MAX 24 ///< of a triangle cut six times: nine, and some for rounding

/// What triangles give to a row of blocks.
typedef struct Ledger {
  const LthFractionFrame *frame;
  const LthFractionRow *row;
  double *part;   ///< to a part alone                    (n blocks x block_cells x n_parts)
  double *behind; ///< to a part and all behind it         (same; x fastest by parts, then y, z)
  double *carry;  ///< to all parts from a block on        (n x width^2)
  int width;      ///< parts along a block
  LitheIndex
      *of; ///< place in the row's list of the first block at or behind a block  (n_block[0] + 1)
  double low[3]; ///< corner of the row
} Ledger;

/// --- what is given ---

/// To parts from `i` (counted from the row's start) on in column (j, k).
static void give_behind(Ledger *l, LitheCount i, int j, int k, double value) {
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
static void give_part(Ledger *l, LitheCount i, int j, int k, double value) {
  int w = l->width;
  if (i < 0 || i >= (LitheCount)l->frame->n_block[0] * w) return;
  LitheIndex block = (LitheIndex)(i / w), m = l->of[block];
  if (m >= l->row->n || l->row->at[m] != block) return;
  l->part[(LitheCount)m * l->frame->block_cells * l->frame->n_parts +
          lth_fraction_place(l->frame, (int)(i % w), j, k)] += value;
}

/// Sum up along x.
static void settle(const Ledger *l) {
  const LthFractionFrame *f = l->frame;
  int w = l->width;
  for (int k = 0; k < w; k++)
    for (int j = 0; j < w; j++) {
      double sum = 0;
      for (LitheIndex m = 0; m < l->row->n; m++) {
        const double *behind = l->behind + (((LitheCount)m * w + k) * w + j) * w;
        double *part = l->part + (LitheCount)m * f->block_cells * f->n_parts;
        sum += l->carry[((LitheCount)m * w + k) * w + j];
        for (int i = 0; i < w; i++) {
          sum += behind[i];
          double *p = &part[lth_fraction_place(f, i, j, k)];
          *p = fmin(fmax(*p + sum, 0), 1);
        }
      }
    }
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
static void give_piece(Ledger *l, const Polygon *g, LitheCount i, int j, int k) {
  const double *a = g->p[0];
  double area = 0, first = 0;
  for (int c = 1; c + 1 < g->n; c++) {
    const double *p = g->p[c], *q = g->p[c + 1];
    double shadow = 0.5 * ((p[1] - a[1]) * (q[2] - a[2]) - (p[2] - a[2]) * (q[1] - a[1]));
    area += shadow;
    first += shadow * ((double)(i + 1) - (a[0] + p[0] + q[0]) / 3);
  }
  give_part(l, i, j, k, -first);
  give_behind(l, i + 1, j, k, -area);
}

static void cut_along_x(Ledger *l, Polygon *g, int j, int k) {
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
static void cut_columns(Ledger *l, Polygon *g, int axis, int k) {
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

static void give_volume(Ledger *l, const double *const corner[3]) {
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
static double sample_place(const Ledger *l, int axis, double s, int samples) {
  return l->low[axis] + l->frame->h[axis] * (s + 0.5) / samples;
}

/// All samples behind x are entered or left: those of one part in part, of the next ones all.
static void give_line(Ledger *l, double x, int sign, int j, int k, int samples) {
  int n = samples / 2;
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

static void give_samples(Ledger *l, const double *const corner[3], int samples) {
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
      if ((sign = pierce(corner, at, &x)) != 0)
        give_line(l, x, sign, (int)(j / n), (int)(k / n), samples);
    }
}

/// --- rows ---

/// All triangles whose boxes meet the row, whatever their x.
static void visit_row(Ledger *l, const LthShape *shape, int samples) {
  const LthBvh *tree = shape->bvh;
  const LthSurface *s = shape->surface;
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
    for (LitheIndex i = tree->first[node]; i < tree->first[node] + tree->count[node]; i++) {
      const LitheIndex *p = s->tris + 3 * (size_t)tree->item[i];
      const double *corner[3];
      for (int c = 0; c < 3; c++) corner[c] = s->points + 3 * (size_t)p[c];
      if (samples > 0)
        give_samples(l, corner, samples);
      else
        give_volume(l, corner);
    }
  }
}

LitheStatus lth_fraction_fill_surface(LitheCtx *ctx, const LthShape *shape, int samples,
                                      const LthFractionFrame *f, const LthFractionRow *row,
                                      double *part) {
  LitheStatus status = LITHE_OK;
  Ledger l = {.frame = f, .row = row, .part = part, .width = 2 * f->side};
  LitheCount w2 = (LitheCount)l.width * l.width;
  LTH_NEW_OR(done, ctx, l.behind, row->n * w2 * l.width);
  LTH_NEW_OR(done, ctx, l.carry, row->n * w2);
  LTH_NEW_OR(done, ctx, l.of, (LitheCount)f->n_block[0] + 1);
  lth_fraction_corner(f, 0, row->j, row->k, l.low);
  for (LitheIndex i = 0, m = 0; i < f->n_block[0]; i++) {
    while (m < row->n && row->at[m] < i) m++;
    l.of[i] = m;
  }
  visit_row(&l, shape, samples);
  settle(&l);
done:
  lth_free(ctx, l.behind);
  lth_free(ctx, l.carry);
  lth_free(ctx, l.of);
  return status;
}
